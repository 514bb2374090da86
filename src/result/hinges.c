/* hinges.c: finds joints between two bodies that are closed over less than half of their face. With tptm the
   compressed part of a joint has a length, and the centre of its force lies a third of that length inside the
   edge. The limit of rigid blocks falls short by about that part (docs/rigid_blocks.md). A joint with a very
   small force may be pressed over a very short length. The limit does not depend on it, so it is no hinge
   here. Where a mechanism is known, the hinges that turn in it count by the moment that they lose. Rank 0
   only. */
#include "result/result.h"
#include <math.h>
#include <stdlib.h>

static const PetscReal BEARS = 0.1; /* [-] least force of a hinge, over the force of the largest one */

static const PetscReal TURNS = 1e-3; /* [-] of the fastest motion: a face that turns less only slides */

/* A contact between two bodies, or the sum of all contacts between them. */
typedef struct {
  PetscInt body[2];
  PetscReal turn;            /* [1/m] relative rotation of the bodies, at the end that is pressed most */
  PetscReal length, closed;  /* [m] */
  PetscReal point[2], sigma; /* of the end that is pressed most */
} Pair;

/* Returns the rotation [1/m] of a face, 4 times block plus number, when the vertices move by v, largest 1. */
static PetscReal face_turn(const MeshFields *mesh, const PetscReal *v, PetscInt face)
{
  const PetscInt *vertex = mesh->blocks + 4 * (face / 4), n = vertex[3] < 0 ? 3 : 4, a = vertex[face % 4],
                 b = vertex[(face % 4 + 1) % n];
  PetscReal e[2], dv[2];
  for (int x = 0; x < 2; x++) {
    e[x] = mesh->X[2 * b + x] - mesh->X[2 * a + x];
    dv[x] = v[2 * b + x] - v[2 * a + x];
  }
  return (e[0] * dv[1] - e[1] * dv[0]) / (e[0] * e[0] + e[1] * e[1]);
}

static Pair pair_of(const MeshFields *mesh, const PetscReal *v, const ContactRow *c)
{
  const int turned = c->body[0] > c->body[1], most = c->end[1].sigma < c->end[0].sigma;
  const ContactEnd *end = c->end + most;
  return (Pair){.body = {c->body[turned], c->body[!turned]},
                .turn = v ? PetscAbsReal(face_turn(mesh, v, c->face[0]) - face_turn(mesh, v, c->face[1]))
                          : 0.,
                .length = c->length,
                .closed = c->length - c->open,
                .point = {end->point[0], end->point[1]},
                .sigma = end->sigma};
}

static void add(Pair *sum, const Pair *p)
{
  sum->length += p->length, sum->closed += p->closed;
  if (p->sigma >= sum->sigma) return;
  sum->sigma = p->sigma, sum->turn = p->turn;
  sum->point[0] = p->point[0], sum->point[1] = p->point[1];
}

/* Returns the force [N/m] of a joint with a triangle of stress, 0: it is closed over half of its face or
   more. */
static PetscReal hinge_force(const Pair *p)
{
  const PetscReal part = p->closed / p->length;
  return part > 0. && part < 0.5 ? -0.5 * p->sigma * p->closed : 0.;
}

static void count(const Pair *p, PetscReal least_force, Hinges *h)
{
  const PetscReal part = p->closed / p->length;
  if (!(hinge_force(p) > least_force)) return;
  h->n++;
  if (part >= h->least) return;
  h->least = part;
  h->point[0] = p->point[0], h->point[1] = p->point[1];
}

/* Returns the mean part of their faces over which the hinges of a mechanism are pressed, weighted by the
   share of each in its work: force times rotation. NaN: none turns. */
static PetscReal governing(const Pair *pairs, PetscInt n)
{
  PetscReal sum = 0., weights = 0.;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal weight = hinge_force(pairs + i) * pairs[i].turn;
    if (pairs[i].turn * pairs[i].length < TURNS) continue;
    sum += weight * pairs[i].closed / pairs[i].length, weights += weight;
  }
  return weights > 0. ? sum / weights : NAN;
}

Hinges HingesOf(const Problem *p, const StageFields *fields)
{
  Hinges h = {.n = 0, .least = INFINITY};
  PetscInt n = 0, joints = 0;
  PetscReal most = 0.;
  Pair *pairs = malloc((size_t)(fields->n_contacts + 1) * sizeof(*pairs));
  for (PetscInt i = 0; pairs && i < fields->n_contacts; i++) {
    const ContactRow *c = fields->contact + i;
    if (p->stage->joints[c->joint].stress_model == STRESS_TPTM && c->klass != VERTEX_FACE)
      pairs[n++] = pair_of(&p->found->mesh, fields->mechanism, c);
  }
  if (n) qsort(pairs, n, sizeof(*pairs), OrderByPair);
  for (PetscInt i = 0; i < n;) {
    Pair sum = pairs[i++];
    while (i < n && !OrderByPair(&sum, pairs + i)) add(&sum, pairs + i++);
    pairs[joints++] = sum;
    most = PetscMax(most, hinge_force(&sum));
  }
  for (PetscInt i = 0; i < joints; i++) count(pairs + i, BEARS * most, &h);
  h.governing = governing(pairs, joints);
  free(pairs);
  return h;
}
