/* near_miss.c: warns of faces of different bodies that lie opposite each other at a gap a little wider than
   contact.tolerance. They are no contact at the start. Coordinates rounded to 1 cm leave gaps of up to 14 mm,
   and nothing else in a run shows that such a pair carries nothing.

   Each rank lists the stretches of its outer faces that no contact covers. Rank 0 pairs the stretches of all
   ranks in the order of their faces, so the text is the same on any number of ranks. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* [-] in tolerances; a wider gap is drawn on purpose. The default of 5 mm reaches all gaps that rounding to 1
   cm leaves (14 mm), and no expansion joint of 20 mm. */
static const PetscReal WIDEST = 3.;
/* BY_ROUNDING [-]: largest gap in units of rounding; rounding leaves at most 1.42. COARSEST [m]: coarsest
   unit of a drawing. */
static const PetscReal BY_ROUNDING = 1.5, COARSEST = 0.01;
/* [-] largest gap, as a part of the length over which two stretches lie opposite each other */
static const PetscReal SLENDER = 0.2;
/* [-] largest slope of one stretch against the other, 3 degrees: rounded coordinates tilt a face by less. A
   block that is drawn on its corner leans more. */
static const PetscReal TILT = 0.05;
/* [-] of a face; a shorter stretch between two contacts is no opening */
static const PetscReal SHORTEST = 1e-3;

/* A part of a face, from one place on it to another. */
typedef struct {
  PetscInt face;
  PetscReal from, to; /* [-] places along the face */
} Cover;

/* A part of a face without a contact. */
typedef struct {
  PetscInt gid, group, body, rigid, joint; /* as in Faces */
  PetscReal x[4], length, from;            /* [m] ends; [m] of the whole face; [-] its place on the face */
} Stretch;

static int cover_order(const void *a, const void *b)
{
  const Cover *p = a, *q = b;
  if (p->face != q->face) return p->face < q->face ? -1 : 1;
  return (p->from > q->from) - (p->from < q->from);
}

static int stretch_order(const void *a, const void *b)
{
  const Stretch *p = a, *q = b;
  if (p->gid != q->gid) return p->gid < q->gid ? -1 : 1;
  return (p->from > q->from) - (p->from < q->from);
}

/* Decides whether this rank reports face f: it owns the first vertex, and so knows all contacts of f. */
static PetscBool is_mine(const Model *m, PetscInt f)
{
  return (PetscBool)(f >= 0 && f < m->faces.n_local && m->faces.vertex[2 * f] < m->mesh.n_owned);
}

/* Lists the stretches of own faces that face-to-face contacts cover, sorted; free with PetscFree. */
static PetscErrorCode find_covers(const Model *m, const Contacts *c, PetscInt *n, Cover **covers)
{
  PetscFunctionBeginUser;
  *n = 0;
  PetscCall(PetscMalloc1(2 * (size_t)c->n_padded, covers));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || c->klass[i] == VERTEX_FACE) continue;
    const PetscInt face[2] = {FaceRow(m, c->key[2 * i]), FaceRow(m, c->key[2 * i + 1])};
    for (int k = 0; k < 2; k++) {
      PetscReal a[4], b[4], from, to, gap;
      if (face[1 - k] < 0 || !is_mine(m, face[k])) continue;
      FaceCoordinates(m, NULL, face[k], a);
      FaceCoordinates(m, NULL, face[1 - k], b);
      face_project(a, a + 2, b + 2, &from, &gap); // the other face runs backwards along this one
      face_project(a, a + 2, b, &to, &gap);
      (*covers)[(*n)++] = (Cover){face[k], from, to};
    }
  }
  if (*n) qsort(*covers, (size_t)*n, sizeof(Cover), cover_order);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the part of face f between two places, unless it is short. */
static void add_stretch(const Model *m, PetscInt f, PetscReal from, PetscReal to, PetscInt *n,
                        Stretch *stretch)
{
  const Faces *faces = &m->faces;
  PetscReal a[4];
  if (!(to - from > SHORTEST)) return;
  FaceCoordinates(m, NULL, f, a);
  Stretch s = {
      faces->gid[f], faces->group[f], faces->body[f], faces->rigid[f], faces->joint[f], {0.}, FaceLength(a),
      from};
  for (int i = 0; i < 2; i++) {
    s.x[i] = a[i] + from * (a[2 + i] - a[i]);
    s.x[2 + i] = a[i] + to * (a[2 + i] - a[i]);
  }
  stretch[(*n)++] = s;
}

/* Collective. Lists the stretches of all ranks that no contact covers, in the order of the faces. */
static PetscErrorCode find_stretches(const Model *m, const Contacts *c, PetscInt *n, Stretch **stretch)
{
  PetscInt n_covers, n_mine = 0, next = 0;
  Cover *cover;
  Stretch *mine;
  PetscFunctionBeginUser;
  PetscCall(find_covers(m, c, &n_covers, &cover));
  PetscCall(PetscMalloc1((size_t)m->faces.n_local + (size_t)n_covers, &mine));
  for (PetscInt f = 0; f < m->faces.n_local; f++) {
    PetscReal from = 0.;
    if (!is_mine(m, f)) continue;
    for (; next < n_covers && cover[next].face == f; next++) {
      add_stretch(m, f, from, PetscMin(1., cover[next].from), &n_mine, mine);
      from = PetscMax(from, cover[next].to);
    }
    add_stretch(m, f, from, 1., &n_mine, mine);
  }
  PetscCall(GatherSorted(m->comm, n_mine, sizeof(Stretch), mine, stretch_order, n, (void **)stretch));
  PetscCall(PetscFree(cover));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds the unit [m] to which all coordinates of the mesh are rounded: COARSEST or a tenth of it,
   0: neither. */
static PetscErrorCode find_unit(const Model *m, PetscReal *unit)
{
  PetscReal of[2] = {COARSEST, 0.1 * COARSEST};
  PetscFunctionBeginUser;
  for (int k = 0; k < 2; k++)
    for (PetscInt i = 0; i < 2 * m->mesh.n_owned && of[k] > 0.; i++) {
      const PetscReal x = m->mesh.X[i] / of[k];
      if (PetscAbsReal(x - round((double)x)) > 1e-6 + 1e-12 * PetscAbsReal(x)) of[k] = 0.;
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, of, 2, MPIU_REAL, MPI_MIN, m->comm));
  *unit = of[0] > 0. ? of[0] : of[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pairs, on rank 0 */

/* The part of a stretch that lies opposite another one. */
typedef struct {
  PetscReal from, to; /* [-] places along the other stretch */
  PetscReal gap[2];   /* [m] at `from` and at `to` */
} Opposite;

/* Finds where b lies opposite a. Returns PETSC_FALSE if nowhere, or if they face the same way. */
static PetscBool opposite(const Stretch *a, const Stretch *b, Opposite *o)
{
  const PetscReal *x = a->x, *y = b->x;
  const PetscReal cosine = ((x[2] - x[0]) * (y[2] - y[0]) + (x[3] - x[1]) * (y[3] - y[1])) /
                           (FaceLength(x) * FaceLength(y));
  PetscReal t[2], gap[2];
  if (cosine > -FACE_COS_LIMIT) return PETSC_FALSE;
  face_project(x, x + 2, y + 2, t, gap);
  face_project(x, x + 2, y, t + 1, gap + 1);
  o->from = PetscMax(0., t[0]), o->to = PetscMin(1., t[1]);
  if (!(o->to > o->from)) return PETSC_FALSE;
  for (int k = 0; k < 2; k++)
    o->gap[k] = gap[0] + (gap[1] - gap[0]) * ((k ? o->to : o->from) - t[0]) / (t[1] - t[0]);
  return PETSC_TRUE;
}

static PetscReal gap_at(const Opposite *o, PetscReal t)
{
  return o->gap[0] + (o->gap[1] - o->gap[0]) * (t - o->from) / (o->to - o->from);
}

/* Leaves out slits between faces of one body, which are drawn on purpose. */
static PetscBool of_two_bodies(PetscInt i, PetscInt j, const void *context)
{
  const Stretch *s = context;
  return (PetscBool)(s[i].body != s[j].body && (s[i].rigid < 0 || s[i].rigid != s[j].rigid));
}

/* Near misses of one row of the joints table. */
typedef struct {
  PetscInt n, group[2]; /* number of pairs; groups of the pair with the widest gap */
  PetscReal length;     /* [m] sum over all pairs */
  PetscReal gap, P[2];  /* [m] widest gap and its place */
  PetscReal needed;     /* [m], or [-] when it is relative: the tolerance at which all pairs are contacts */
} Misses;

/* Decides whether another face stands between a and b, over half of their common length. near: the stretches
   near a. */
static PetscBool is_screened(const Stretch *all, const Stretch *a, const Stretch *b, const Opposite *far,
                             PetscInt n_near, const PetscInt *near)
{
  PetscReal front = 0.;
  for (PetscInt p = 0; p < n_near; p++) {
    const Stretch *h = all + near[p];
    Opposite o;
    if (h == b || h->gid / 4 == b->gid / 4 || !opposite(a, h, &o)) continue;
    const PetscReal from = PetscMax(o.from, far->from), to = PetscMin(o.to, far->to), t = 0.5 * (from + to);
    if (to > from && PetscAbsReal(gap_at(&o, t)) < gap_at(far, t)) front += to - from;
  }
  return (PetscBool)(front > 0.5 * (far->to - far->from));
}

/* Collects the near misses of each row. rounding: [m] gaps that the rounding of coordinates may leave. of:
   (n_joints,). */
static PetscErrorCode find_misses(const Scene *scene, const Model *m, PetscReal rounding, PetscInt n,
                                  const Stretch *all, Misses *of)
{
  const PetscReal reach = 0.5 * PetscMax(WIDEST * m->contact_margin, rounding);
  PetscInt *start, *near;
  PetscReal *box;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(4 * (size_t)n, &box));
  for (PetscInt i = 0; i < n; i++) FaceBox(all[i].x, all[i].x + 2, reach, box + 4 * (size_t)i);
  PetscCall(GridRows(n, box, of_two_bodies, all, &start, &near));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt p = start[i]; p < start[i + 1]; p++) {
      const Stretch *a = all + i, *b = all + near[p];
      const PetscReal unit = scene->contact_relative ? PetscMin(a->length, b->length) : 1.,
                      tolerance = scene->contact_tolerance * unit;
      Opposite o;
      if (near[p] < i || !opposite(a, b, &o)) continue;
      const int end = o.gap[1] > o.gap[0];
      const PetscReal gap = o.gap[end], length = (o.to - o.from) * FaceLength(a->x);
      if (gap <= tolerance || gap > PetscMax(WIDEST * tolerance, rounding) || gap > SLENDER * length)
        continue;
      if (o.gap[1 - end] < -tolerance || gap - o.gap[1 - end] > TILT * length) continue;
      if (is_screened(all, a, b, &o, start[i + 1] - start[i], near + start[i])) continue;
      const PetscInt row = JointBetween(scene, m, a->joint, a->group, b->joint, b->group);
      Misses *misses = of + row;
      if (!(scene->joints[row].k_n > 0.)) continue; // no joint has properties for them
      misses->n++, misses->length += length;
      misses->needed = PetscMax(misses->needed, gap / unit);
      if (gap <= misses->gap) continue;
      const PetscReal t = end ? o.to : o.from;
      misses->gap = gap, misses->group[0] = a->group, misses->group[1] = b->group;
      for (int k = 0; k < 2; k++) misses->P[k] = a->x[k] + t * (a->x[2 + k] - a->x[k]);
    }
  PetscCall(PetscFree(box));
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(near));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rounds up to two digits, to a number above the value by a thousandth at least. */
static double rounded_up(PetscReal value)
{
  const double step = pow(10., floor(log10((double)value)) - 1.);
  return step * ceil((double)value / step * 1.001);
}

static void warn(const Scene *scene, const Model *m, const char *joint, const Misses *miss)
{
  const char *unit = scene->contact_relative ? " of the shorter face" : " m";
  if (scene->initial_gaps == GAPS_REAL) { // gaps are drawn on purpose
    printf("joints.%s: %" PetscInt_FMT " pair%s of faces, %.4g m, with gaps of up to %.3g m: wider than "
           "contact.tolerance %.3g%s, no contact at the start\n",
           joint, miss->n, Plural(miss->n), (double)miss->length, (double)miss->gap,
           (double)scene->contact_tolerance, unit);
    fflush(stdout);
    return;
  }
  Warn("%s: joints.%s: %" PetscInt_FMT " pair%s of faces, %.4g m long in all, %s a small gap "
       "wider than contact.tolerance %.3g%s, the widest %.3g m near (%.6g, %.6g) m between groups "
       "%s and %s: no contact at the start, so nothing is borne there: expected contact.tolerance %.2g%s "
       "if they should touch, or a mesh that meets there",
       scene->file, joint, miss->n, Plural(miss->n), (double)miss->length, miss->n == 1 ? "has" : "have",
       (double)scene->contact_tolerance, unit, (double)miss->gap, (double)miss->P[0], (double)miss->P[1],
       m->materials.names[miss->group[0]], m->materials.names[miss->group[1]], rounded_up(miss->needed),
       unit);
}

PetscErrorCode NearMissesWarn(const Scene *scene, const Model *m, const Contacts *c)
{
  static PetscInt warned;
  PetscReal unit;
  Misses *miss;
  Stretch *all;
  PetscInt n;
  PetscFunctionBeginUser;
  if (AlreadyWarned(&warned) || !(scene->contact_tolerance > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(find_stretches(m, c, &n, &all));
  PetscCall(find_unit(m, &unit));
  PetscCall(PetscCalloc1(scene->n_joints, &miss));
  if (!m->rank && n) PetscCall(find_misses(scene, m, BY_ROUNDING * unit, n, all, miss));
  for (PetscInt j = 0; j < scene->n_joints; j++)
    if (miss[j].n) warn(scene, m, scene->joints[j].name, miss + j);
  PetscCall(PetscFree(miss));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}
