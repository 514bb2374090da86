/* free_field.c: applies the force of free ground beside the sides of the model, for supports with boundary
   free_field.

   In static stages these supports hold; quiet.c releases them and adds the dashpots. In a dynamic stage
   the ground beside the model moves as a column under the same earthquake (column.c). A vertex of the side
   gets the force that its half of this ground needs for the motion, and its dashpots C act relative to it:

   f = m (a_ff + alpha (v_ff - v_ground)) + F(u_ff) + C (v_ff - v),

   where m and F are the mass and the resisting force of the vertex itself. So ground without a structure
   moves as its column, and only the difference radiates outwards. At the foot of a side only this force
   acts, also along the base. coupled_inertia.c gets it as dashpots relative to w = v_ff + C^-1 (m ... +
   F). */
#include "base/lanes.h"
#include "boundary/boundary.h"

typedef struct {
  PetscInt vertex, column, level;
  PetscReal mass;      /* [kg] */
  Pair below, above;   /* [m2] factors of the stress in the layers below and above in the resisting force of
                        the vertex: B' of blocks */
  Pair flexibility[2]; /* [m/N/s] C^-1 by columns */
} SideVertex;

typedef struct {
  PetscInt n_columns;
  Column *column;
  Motion *base; /* (n_columns,) */
  /* of the current dynamic stage */
  PetscReal alpha;
  Ground ground;
  PetscInt n;
  SideVertex *at; /* (n,) vertices of this rank */
} FreeField;

/* ---- set-up */

static PetscErrorCode create(const TermView *v, void **memory)
{
  const Scene *scene = v->scene;
  PetscBool any = PETSC_FALSE;
  FreeField *f;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < scene->n_supports; i++)
    if (scene->supports[i].boundary == BOUNDARY_FREE_FIELD) any = PETSC_TRUE;
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&f));
  PetscCall(ColumnsFind(scene, v->m, &f->n_columns, &f->column));
  PetscCall(PetscCalloc1(f->n_columns, &f->base));
  for (PetscInt i = 0; i < f->n_columns; i++)
    PetscCall(MotionCreate(scene->supports + f->column[i].base, f->base + i));
  *memory = f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  FreeField *f = *memory;
  PetscFunctionBeginUser;
  (void)scene;
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < f->n_columns; i++) {
    PetscCall(ColumnDestroy(f->column + i));
    PetscCall(MotionDestroy(f->base + i));
  }
  PetscCall(GroundDestroy(&f->ground));
  PetscCall(PetscFree(f->column));
  PetscCall(PetscFree(f->base));
  PetscCall(PetscFree(f->at));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- stages */

/* Adds the factors of a block for the stresses below and above its vertices of a side. For a uniform
   stress the force of a vertex is half the chord between its neighbours, rotated, whatever the shape of
   the block. row: (n_deformable,) rows of f->at, -1: none. */
static void add_block(const Model *m, const Elements *e, PetscInt block, const PetscInt *row, FreeField *f)
{
  for (int k = 0; k < e->n_nodes; k++) {
    const PetscInt v = VertexOf(e, block, k);
    SideVertex *side = v < m->mesh.n_deformable && row[v] >= 0 ? f->at + row[v] : NULL;
    if (!side) continue;
    const PetscReal *next = m->mesh.X + 2 * VertexOf(e, block, (k + 1) % e->n_nodes),
                    *before = m->mesh.X + 2 * VertexOf(e, block, (k + e->n_nodes - 1) % e->n_nodes);
    const PetscReal half = 0.5 * m->materials.thickness;
    const Pair share = {half * (next[1] - before[1]), half * (before[0] - next[0])};
    if (next[1] + before[1] > 2. * m->mesh.X[2 * v + 1])
      side->above += share;
    else
      side->below += share;
  }
}

static void invert(PetscReal (*C)[2], Pair inverse[2])
{
  const PetscReal det = C[0][0] * C[1][1] - C[0][1] * C[1][0];
  inverse[0] = (Pair){C[1][1] / det, -C[1][0] / det};
  inverse[1] = (Pair){-C[0][1] / det, C[0][0] / det};
}

/* Lists the vertices of sides in the order of owned vertices. */
static PetscErrorCode find_vertices(const TermView *view, FreeField *f)
{
  const Model *m = view->m;
  PetscReal(*C)[2];
  PetscInt most = 0, *row;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < f->n_columns; i++) most += f->column[i].n;
  PetscCall(PetscFree(f->at));
  PetscCall(PetscMalloc1(most, &f->at));
  PetscCall(PetscCalloc1(2 * m->mesh.n_deformable, &C));
  PetscCall(PetscMalloc1(m->mesh.n_deformable, &row));
  QuietDashpots(view->scene, m, NULL, C);
  f->n = 0;
  for (PetscInt v = 0; v < m->mesh.n_deformable; v++) {
    row[v] = -1;
    for (PetscInt i = 0; i < f->n_columns; i++) {
      const PetscInt level = ColumnLevel(m, f->column + i, v), d = 3 * m->rigid.n + 2 * v;
      if (level < 0 || (Held(m, d) && Held(m, d + 1))) continue;
      f->at[f->n] = (SideVertex){.vertex = v, .column = i, .level = level, .mass = m->vertex_mass[v]};
      invert(C + 2 * v, f->at[f->n].flexibility);
      row[v] = f->n++;
    }
  }
  for (const Elements *e = m->mesh.elements; e < m->mesh.elements + ELEMENT_LISTS; e++)
    for (PetscInt block = 0; block < e->n && !ListIsRigid(m, e); block++) add_block(m, e, block, row, f);
  PetscCall(PetscFree(row));
  PetscCall(PetscFree(C));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares the vertices of sides. Their dashpots are added by quiet.c. */
static PetscErrorCode inertia(const TermView *view, TermInertia add, void *context)
{
  FreeField *f = view->memory;
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  (void)add, (void)context;
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  f->alpha = view->stage->alpha;
  for (PetscInt i = 0; i < f->n_columns; i++) f->column[i].beta = view->stage->beta;
  PetscCall(GroundDestroy(&f->ground));
  if (f->alpha != 0. && view->stage->frame != FRAME_ABSOLUTE)
    PetscCall(GroundCreate(view->scene, &f->ground, message)); // dynamic.c refuses the stage
  PetscCall(find_vertices(view, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the columns of a dynamic stage. Sets columns to rest before a dynamic stage that follows a static
   one. */
static PetscErrorCode begin(const TermView *v)
{
  FreeField *f = v->memory;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; f && i < f->n_columns; i++) {
    Column *c = f->column + i;
    c->peak[0] = c->peak[1] = 0., c->moved = 0;
    if (StageInTime(v->stage)) {
      PetscCall(PetscPrintf(v->m->comm,
                            "supports.%s: free ground beside x = %.6g m: %" PetscInt_FMT
                            " layers from y = %.6g to %.6g m on %s\n",
                            v->scene->supports[c->support].name, (double)c->x, c->n - 1, (double)c->y[0],
                            (double)c->y[c->n - 1], v->scene->supports[c->base].name));
      continue;
    }
    PetscCall(PetscArrayzero(c->u, 2 * c->n));
    PetscCall(PetscArrayzero(c->v, 2 * c->n));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves all columns, in the same way on every rank. */
static void move_columns(FreeField *f, const State *s, PetscReal part)
{
  ColumnStep step = {.dt = s->dt, .part = part, .alpha = f->alpha};
  GroundVelocity(&f->ground, s->time, step.ground);
  for (PetscInt i = 0; i < f->n_columns; i++) {
    Column *c = f->column + i;
    const PetscReal half = c->quiet ? 0.5 * s->dt : 0.; // as in quiet.c and support_motion.c
    const PetscReal from = s->time - half, to = c->quiet ? s->time + half : s->time + s->dt;
    for (int k = 0; k < 2; k++) step.base[k] = c->times * MotionMean(f->base + i, from, to, s->dt, k);
    ColumnMove(c, &step);
  }
}

/* Returns the resisting force [N] of a vertex under the stress of a layer (xx, yy, xy). */
KERNEL Pair resist(const PetscReal *stress, Pair share)
{
  return (Pair){stress[0] * share[0] + stress[2] * share[1], stress[2] * share[0] + stress[1] * share[1]};
}

static void incoming(void *memory, const Model *m, const State *s, Incoming *in)
{
  FreeField *f = memory;
  (void)m;
  if (!f) return;
  move_columns(f, s, in->part);
  for (const SideVertex *at = f->at; at < f->at + f->n; at++) {
    const Column *c = f->column + at->column;
    const Pair mean = LoadPair(c->mean + 2 * at->level), drive = LoadPair(c->drive + 2 * at->level);
    const PetscReal *below = c->stress + 3 * (at->level - 1), *above = c->stress + 3 * at->level;
    Pair force = at->mass * drive;
    if (at->level > 0) force += resist(below, at->below);
    if (at->level + 1 < c->n) force += resist(above, at->above);
    StorePair(in->w + 2 * at->vertex, mean + at->flexibility[0] * force[0] + at->flexibility[1] * force[1]);
    StorePair(in->wave + 2 * at->vertex, mean);
  }
}

/* ---- archive and results */

static PetscErrorCode archive(Archive *a, const TermView *v)
{
  FreeField *f = v->memory;
  char name[NAME_LENGTH];
  PetscFunctionBeginUser;
  for (PetscInt i = 0; f && i < f->n_columns; i++) {
    Column *c = f->column + i;
    PetscCall(PetscSNPrintf(name, sizeof(name), "free_field_%" PetscInt_FMT "_displacement", i));
    PetscCall(ArchiveReals(a, name, 2 * c->n, c->u));
    PetscCall(PetscSNPrintf(name, sizeof(name), "free_field_%" PetscInt_FMT "_velocity", i));
    PetscCall(ArchiveReals(a, name, 2 * c->n, c->v));
    PetscCall(PetscSNPrintf(name, sizeof(name), "free_field_%" PetscInt_FMT "_peak", i));
    PetscCall(ArchiveReals(a, name, 2, c->peak));
    PetscCall(PetscSNPrintf(name, sizeof(name), "free_field_%" PetscInt_FMT "_moved", i));
    PetscCall(ArchiveInts(a, name, 1, &c->moved));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the motion of the surface of the free ground. */
static void summary(Json *json, const TermView *v)
{
  const FreeField *field = v->memory;
  if (!field || !StageInTime(v->stage)) return;
  JsonList(json, "free_field");
  for (PetscInt i = 0; i < field->n_columns; i++) {
    const Column *c = field->column + i;
    JsonOpen(json, NULL);
    JsonText(json, "support", v->scene->supports[c->support].name);
    JsonNumbers(json, {"x", c->x}, {"bottom", c->y[0]}, {"top", c->y[c->n - 1]},
                {"largest_velocity_x", c->peak[0]}, {"largest_velocity_y", c->peak[1]},
                {"end_displacement_x", c->u[2 * c->n - 2]}, {"end_displacement_y", c->u[2 * c->n - 1]});
    JsonClose(json);
  }
  JsonClose(json);
}

const TermKind Free_field_term = {.name = "free_field",
                                  .create = create,
                                  .destroy = destroy,
                                  .inertia = inertia,
                                  .incoming = incoming,
                                  .begin = begin,
                                  .archive = archive,
                                  .summary = summary};
