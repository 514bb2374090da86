/* side.c: builds the columns of free ground beside a model. Each vertical line of faces whose support is a
   free field gets one, built from these faces on all ranks, so that every rank has the same columns. Sides
   that a column cannot represent are refused. */
#include "boundary/boundary.h"

/* A face of a side, lower end first. */
typedef struct {
  PetscInt gid, group, support, column;
  PetscInt vertex[2]; /* gids */
  PetscReal x[2], y[2];
} SideFace;

/* Returns the distance [m] below which points coincide. */
static PetscReal near_by(const Model *m)
{
  return 1e-7 * m->mesh.diameter;
}

static PetscBool is_side(const Support *s)
{
  return (PetscBool)(s->boundary == BOUNDARY_FREE_FIELD);
}

/* ---- faces */

static SideFace face_of(const Model *m, PetscInt face, PetscInt support)
{
  const PetscInt *v = m->faces.vertex + 2 * face;
  const int low = m->mesh.X[2 * v[0] + 1] > m->mesh.X[2 * v[1] + 1];
  SideFace side = {.gid = m->faces.gid[face], .group = m->faces.group[face], .support = support};
  for (int k = 0; k < 2; k++) {
    const PetscInt end = v[k ? !low : low];
    side.vertex[k] = m->mesh.vertex_gid[end], side.x[k] = m->mesh.X[2 * end],
    side.y[k] = m->mesh.X[2 * end + 1];
  }
  return side;
}

static int by_gid(const void *a, const void *b)
{
  const SideFace *p = a, *q = b;
  return p->gid != q->gid ? (p->gid > q->gid) - (p->gid < q->gid)
                          : (p->support > q->support) - (p->support < q->support);
}

static int by_place(const void *a, const void *b)
{
  const SideFace *p = a, *q = b;
  return p->x[0] != q->x[0] ? (p->x[0] > q->x[0]) - (p->x[0] < q->x[0]) : by_gid(a, b);
}

static int by_height(const void *a, const void *b)
{
  const SideFace *p = a, *q = b;
  if (p->column != q->column) return (p->column > q->column) - (p->column < q->column);
  return (p->y[0] > q->y[0]) - (p->y[0] < q->y[0]);
}

/* Gathers the side faces of all ranks, each once, in the order of gids. */
static PetscErrorCode gather_faces(const Scene *scene, const Model *m, PetscInt *n, SideFace **all)
{
  SideFace *mine;
  PetscInt n_mine = 0, n_all, n_known = m->mesh.n_face_sets ? m->mesh.face_set_start[m->mesh.n_face_sets] : 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n_known * scene->n_supports, &mine));
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    PetscInt n_set;
    const PetscInt *faces = FacesOfSet(m, scene->supports[i].target, &n_set);
    for (PetscInt f = 0; f < n_set && is_side(scene->supports + i); f++)
      mine[n_mine++] = face_of(m, faces[f], i);
  }
  PetscCall(GatherSorted(m->comm, n_mine, sizeof(SideFace), mine, by_gid, &n_all, (void **)all));
  *n = 0;
  for (PetscInt i = 0; i < n_all; i++)
    if (!*n || by_gid(*all + *n - 1, *all + i)) (*all)[(*n)++] = (*all)[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers the columns from left to right, and sorts the faces by column and height. Returns the number of
   columns. */
static PetscInt number_columns(const Model *m, PetscInt n, SideFace *face)
{
  PetscInt n_columns = 0;
  qsort(face, n, sizeof(SideFace), by_place);
  for (PetscInt i = 0; i < n; i++) {
    if (!i || face[i].x[0] - face[i - 1].x[0] > near_by(m)) n_columns++;
    face[i].column = n_columns - 1;
  }
  qsort(face, n, sizeof(SideFace), by_height);
  return n_columns;
}

/* ---- refusals. Each function writes one line into an empty message. */

#define REFUSE(support, ...)                                                                                 \
  do {                                                                                                       \
    char reason[MESSAGE_LENGTH];                                                                             \
    PetscCall(PetscSNPrintf(reason, sizeof(reason), __VA_ARGS__));                                           \
    if (!message[0])                                                                                         \
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s: supports.%s.boundary: free_field: %s",           \
                              scene->file, scene->supports[support].name, reason));                          \
  } while (0)

/* Refuses faces that are not vertical, or not joined to the face below. */
static PetscErrorCode check_faces(const Scene *scene, const Model *m, PetscInt n, const SideFace *face,
                                  char *message)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) {
    const SideFace *above = face + i,
                   *below = i && face[i - 1].column == face[i].column ? face + i - 1 : NULL;
    const double x = (double)above->x[0], y = (double)above->y[0];
    if (PetscAbsReal(above->x[1] - above->x[0]) > near_by(m))
      REFUSE(above->support,
             "the face from (%.6g, %.6g) to (%.6g, %.6g) is not vertical: expected vertical sides, beside "
             "which ground goes on as it is",
             x, y, (double)above->x[1], (double)above->y[1]);
    if (!below) continue;
    if (PetscAbsReal(below->y[1] - above->y[0]) > near_by(m))
      REFUSE(above->support,
             "faces at x = %.6g end at y = %.6g and go on at %.6g: expected one line from the base up", x,
             (double)below->y[1], y);
    if (below->vertex[1] != above->vertex[0])
      REFUSE(above->support,
             "a joint meets the side at (%.6g, %.6g), and free ground has none: expected blocks of one "
             "macroblock along the side",
             x, y);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool shakes(const Support *s)
{
  return (PetscBool)(!is_side(s) && s->motion[0]);
}

/* Finds the base of a column on this rank: the support with a motion that contains the corner; -1: none. */
static PetscInt find_base(const Scene *scene, const Model *m, const Column *c)
{
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    PetscInt n;
    const PetscInt *faces = FacesOfSet(m, scene->supports[i].target, &n);
    for (PetscInt f = 0; f < n && shakes(scene->supports + i); f++)
      for (int k = 0; k < 2; k++)
        if (m->mesh.vertex_gid[m->faces.vertex[2 * faces[f] + k]] == c->gid[0]) return i;
  }
  return -1;
}

static Layer layer_of(const Scene *scene, const Model *m, PetscInt group)
{
  return (Layer){.density = m->materials.density[group],
                 .lame = m->materials.lame[group],
                 .beta = scene->materials[group].beta};
}

static PetscErrorCode check_base(const Scene *scene, const Model *m, Column *c, char *message)
{
  const Support *base;
  const PetscInt *faces;
  PetscInt n;
  PetscFunctionBeginUser;
  c->base = find_base(scene, m, c);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &c->base, 1, MPIU_INT, MPI_MAX, m->comm));
  if (c->base < 0)
    REFUSE(c->support,
           "at (%.6g, %.6g) it meets no base with a motion: expected a support of faces there that has "
           "one, quiet or fixed (without a motion: boundary: quiet)",
           (double)c->x, (double)c->y[0]);
  if (c->base < 0) PetscFunctionReturn(PETSC_SUCCESS);
  base = scene->supports + c->base;
  c->quiet = (PetscBool)(base->boundary == BOUNDARY_QUIET);
  c->times = GroundPart(base);
  const PetscInt behind = HalfSpaceOf(m, base);
  if (behind >= 0) c->half_space = layer_of(scene, m, behind);
  if (base->boundary == BOUNDARY_FIXED && !(base->fix[0] && base->fix[1]))
    REFUSE(c->support, "its base %s is fixed along one axis only: expected fix: xy", base->name);
  faces = FacesOfSet(m, base->target, &n);
  for (PetscInt f = 0; f < n; f++)
    for (int k = 0; k < 2; k++) {
      const PetscReal *X = m->mesh.X + 2 * m->faces.vertex[2 * faces[f] + k];
      if (PetscAbsReal(X[1] - c->y[0]) > near_by(m))
        REFUSE(c->support, "its base %s is not flat: it has (%.6g, %.6g), and the side ends at y = %.6g",
               base->name, (double)X[0], (double)X[1], (double)c->y[0]);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool are_alike(const Layer *a, const Layer *b)
{
  return (PetscBool)(a->density == b->density && a->lame.lambda == b->lame.lambda &&
                     a->lame.mu == b->lame.mu &&
                     (a->beta == b->beta || (PetscIsNanReal(a->beta) && PetscIsNanReal(b->beta))));
}

PetscInt ColumnLevel(const Model *m, const Column *c, PetscInt v)
{
  if (PetscAbsReal(m->mesh.X[2 * v] - c->x) > 2. * near_by(m)) return -1; // most vertices
  for (PetscInt j = 0; j < c->n; j++)
    if (c->gid[j] == m->mesh.vertex_gid[v]) return j;
  return -1;
}

/* Returns the layer of a block whose vertices are all at two successive levels; -1: they are not. */
static PetscInt layer_at(const Model *m, const Column *c, const Elements *e, PetscInt block)
{
  PetscReal low = PETSC_MAX_REAL, high = -PETSC_MAX_REAL;
  for (PetscInt k = 0; k < e->n_nodes; k++) {
    const PetscReal y = m->mesh.X[2 * VertexOf(e, block, k) + 1];
    low = PetscMin(low, y), high = PetscMax(high, y);
  }
  for (PetscInt j = 0; j + 1 < c->n; j++) {
    PetscBool fits = PETSC_TRUE;
    if (PetscAbsReal(low - c->y[j]) > near_by(m) || PetscAbsReal(high - c->y[j + 1]) > near_by(m)) continue;
    for (PetscInt k = 0; k < e->n_nodes; k++) {
      const PetscReal y = m->mesh.X[2 * VertexOf(e, block, k) + 1];
      if (PetscMin(PetscAbsReal(y - c->y[j]), PetscAbsReal(y - c->y[j + 1])) > near_by(m)) fits = PETSC_FALSE;
    }
    if (fits) return j;
  }
  return -1;
}

/* Refuses blocks at the side that do not fit between its levels, are not elastic, or have another
   material. */
static PetscErrorCode check_blocks(const Scene *scene, const Model *m, const Column *c, char *message)
{
  PetscFunctionBeginUser;
  for (const Elements *e = m->mesh.elements; e < m->mesh.elements + ELEMENT_LISTS; e++)
    for (PetscInt b = 0; b < e->n && !ListIsRigid(m, e); b++) {
      const Layer own = layer_of(scene, m, e->group[b]);
      PetscInt level = -1, layer;
      for (PetscInt k = 0; k < e->n_nodes && level < 0; k++) level = ColumnLevel(m, c, VertexOf(e, b, k));
      if (level < 0) continue;
      layer = layer_at(m, c, e, b);
      if (layer < 0)
        REFUSE(c->support,
               "block %" PetscInt_FMT " at (%.6g, %.6g) has vertices between the levels of the side, or "
               "beyond the next: expected blocks with level tops and bottoms beside it",
               e->file[b], (double)c->x, (double)c->y[level]);
      else if (e->law != MATERIAL_ELASTIC)
        REFUSE(c->support,
               "block %" PetscInt_FMT " at (%.6g, %.6g) can yield or crack, and free ground beside a side is "
               "elastic: expected law: elastic there",
               e->file[b], (double)c->x, (double)c->y[level]);
      else if (!are_alike(&own, c->layer + layer))
        REFUSE(c->support,
               "block %" PetscInt_FMT " at (%.6g, %.6g) is of other ground than the face of its layer: "
               "expected level layers beside the side",
               e->file[b], (double)c->x, (double)c->y[level]);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- columns */

/* Creates a column from its n faces, lowest first. */
static PetscErrorCode create_column(const Scene *scene, const Model *m, PetscInt n, const SideFace *face,
                                    Column *c)
{
  PetscFunctionBeginUser;
  PetscCall(ColumnCreate(n + 1, c));
  c->x = face->x[0], c->support = face->support;
  for (PetscInt j = 0; j <= n; j++) {
    const SideFace *at = face + PetscMin(j, n - 1);
    c->y[j] = at->y[j == n], c->gid[j] = at->vertex[j == n];
    if (j < n) c->layer[j] = layer_of(scene, m, at->group);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ColumnsFind(const Scene *scene, const Model *m, PetscInt *n_columns, Column **columns)
{
  char message[MESSAGE_LENGTH] = "";
  SideFace *face;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  PetscCall(gather_faces(scene, m, &n, &face));
  *n_columns = number_columns(m, n, face);
  PetscCall(check_faces(scene, m, n, face, message));
  PetscCall(CheckMessage(m->comm, message));
  PetscCall(PetscCalloc1(*n_columns, columns));
  for (PetscInt i = 0, first = 0; i < *n_columns; i++) {
    PetscInt end = first;
    while (end < n && face[end].column == i) end++;
    PetscCall(create_column(scene, m, end - first, face + first, *columns + i));
    PetscCall(check_base(scene, m, *columns + i, message));
    PetscCall(check_blocks(scene, m, *columns + i, message));
    first = end;
  }
  PetscCall(PetscFree(face));
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}
