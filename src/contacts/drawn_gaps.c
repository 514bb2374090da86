/* drawn_gaps.c: finds gaps and overlaps between faces in the mesh as drawn. Coordinates are rounded, so faces
   that should meet are a little apart or overlap a little. Within the tolerances, a contact carries no stress
   in the state as drawn. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* [-] of the shorter face: what the rounding of floating-point numbers leaves */
static const PetscReal EXACT = 1e-9;

PetscReal GapAsDrawn(const Scene *scene, const Model *m, PetscInt f, PetscInt g, PetscInt v)
{
  PetscReal a[4], b[4], t, gap;
  FacePair drawn;
  if (scene->initial_gaps == GAPS_REAL || m->lifts) return 0.;
  FaceCoordinates(m, NULL, f, a);
  FaceCoordinates(m, NULL, g, b);
  const PetscReal shorter = PetscMin(FaceLength(a), FaceLength(b)),
                  tolerance = scene->contact_tolerance * (scene->contact_relative ? shorter : 1.);
  if (FacePairClassify(a, b, tolerance, scene->overlap_tolerance, &drawn) == FACES_APART) return 0.;
  face_project(b, b + 2, m->mesh.X + 2 * v, &t, &gap);
  return gap > tolerance || gap < -scene->overlap_tolerance || PetscAbsReal(gap) <= EXACT * shorter ? 0.
                                                                                                    : gap;
}

void ContactRestAsDrawn(const Scene *scene, const Model *m, const Candidate *n, PetscInt at, Contacts *c)
{
  const PetscReal open = c->rest[SUB(at, 1)] - c->rest[SUB(at, 0)];
  if (n->pair.klass == VERTEX_FACE) {
    // it must not start under load; with tptm the second end keeps its distance from the first
    c->rest[SUB(at, 0)] = n->drawn > 0. ? PetscMin(n->drawn, PetscMax(0., n->pair.gap[0])) : n->drawn;
    if (n->model == STRESS_TPTM) c->rest[SUB(at, 1)] = c->rest[SUB(at, 0)] + open;
    return;
  }
  for (int k = 0; k < 2; k++) {
    const PetscInt f = n->face[n->pair.source[k]], g = n->face[1 - n->pair.source[k]];
    c->rest[SUB(at, k)] = GapAsDrawn(scene, m, f, g, m->faces.vertex[2 * f + n->pair.corner[k]]);
  }
}

/* ---- report of gaps */

enum { APART, INTO, SIDES };

/* The largest gap and the deepest overlap of a joint. */
typedef struct {
  PetscReal most[SIDES];     /* [m] */
  PetscReal place[SIDES][2]; /* [m] of the vertex */
  PetscInt key[SIDES];       /* gid of the vertex, so that all ranks choose the same one of equal gaps */
} Widest;

static void widen(Widest *w, PetscReal gap, const PetscReal P[2], PetscInt gid)
{
  const int side = gap > 0. ? APART : INTO;
  const PetscReal size = PetscAbsReal(gap);
  if (size < w->most[side] || (size == w->most[side] && gid >= w->key[side])) return;
  w->most[side] = size, w->key[side] = gid;
  w->place[side][0] = P[0], w->place[side][1] = P[1];
}

/* Collective. Finds the largest gap and the deepest overlap of each joint. widest: (n_joints,) over all
   ranks, the same on every rank. */
static PetscErrorCode find_widest(const Scene *scene, const Model *m, const Contacts *c, Widest *widest)
{
  Widest *all;
  PetscInt n;
  PetscFunctionBeginUser;
  for (PetscInt j = 0; j < scene->n_joints; j++) widest[j] = (Widest){.key = {PETSC_MAX_INT, PETSC_MAX_INT}};
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && c->key[2 * i] >= 0; k++) {
      PetscInt v[3];
      PetscReal t, gap;
      ContactEndVertices(c, i, k, v);
      face_project(m->mesh.X + 2 * v[1], m->mesh.X + 2 * v[2], m->mesh.X + 2 * v[0], &t, &gap);
      widen(widest + c->joint[i], gap, m->mesh.X + 2 * v[0], m->mesh.vertex_gid[v[0]]);
    }
  PetscCall(GatherToAll(m->comm, scene->n_joints, sizeof(Widest), widest, &n, (void **)&all));
  for (PetscInt i = 0; i < n; i++)
    for (int side = 0; side < SIDES; side++)
      if (all[i].most[side] > 0.)
        widen(widest + i % scene->n_joints, side == APART ? all[i].most[side] : -all[i].most[side],
              all[i].place[side], all[i].key[side]);
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactsReportGaps(const Scene *scene, const Model *m, const Contacts *c)
{
  const PetscReal worth = 1e-9 * m->mesh.diameter; // [m] less is the rounding of numbers
  const char *meaning = scene->initial_gaps == GAPS_CLOSED ? "they are in contact there, free of stress"
                                                           : "gaps are open, overlaps are free of stress";
  static const char *const words[SIDES] = {"are apart by up to", "overlap by up to"};
  Widest *widest;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(scene->n_joints, &widest));
  PetscCall(find_widest(scene, m, c, widest));
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    const Widest *w = widest + j;
    char text[MESSAGE_LENGTH] = "";
    for (int side = 0; side < SIDES; side++) {
      const size_t n = strlen(text);
      if (w->most[side] <= worth) continue;
      PetscCall(PetscSNPrintf(text + n, sizeof(text) - n, "%s %s %.3g m near (%.6g, %.6g) m", n ? " and" : "",
                              words[side], (double)w->most[side], (double)w->place[side][0],
                              (double)w->place[side][1]));
    }
    if (text[0])
      PetscCall(PetscPrintf(m->comm, "joints.%s: as drawn its faces%s: %s (contact.initial_gaps)\n",
                            scene->joints[j].name, text, meaning));
  }
  PetscCall(PetscFree(widest));
  PetscCall(NearMissesWarn(scene, m, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}
