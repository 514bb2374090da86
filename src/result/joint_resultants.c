/* joint_resultants.c: computes the resultants of each joint, in the terms of the gravity method. Rank 0 only.

   A joint whose contacts lie along one line has a direction e from its start to its end (to the right;
   upwards when it is upright), and an upper side, to the left of e. R is the force of the upper side on the
   lower one. N = -R.left (compression positive), T = R.e, and M is the moment of the normal forces about the
   middle of the line. So the gravity method's stress at the distance x from the middle is (-N/L + 12 M x /
   L^3) / thickness. A joint that is no line (a net of joints) has N = -sum of the normal forces, T = sum of
   |shear forces|, and no M. */
#include "result/result.h"
#include <math.h>

/* Finds the main direction of the contacts' end points, weighted by contact length. */
static void main_direction(const StageFields *s, PetscInt joint, PetscReal e[2])
{
  PetscReal weight = 0, mean[2] = {0, 0}, xx = 0, xy = 0, yy = 0;
  for (PetscInt i = 0; i < 2 * s->n_contacts; i++) {
    const ContactRow *c = &s->contact[i / 2];
    if (c->joint != joint) continue;
    weight += c->length;
    for (int x = 0; x < 2; x++) mean[x] += c->length * c->end[i % 2].point[x];
  }
  for (PetscInt i = 0; i < 2 * s->n_contacts; i++) {
    const ContactRow *c = &s->contact[i / 2];
    if (c->joint != joint) continue;
    const PetscReal *p = c->end[i % 2].point, dx = p[0] - mean[0] / weight, dy = p[1] - mean[1] / weight;
    xx += c->length * dx * dx;
    xy += c->length * dx * dy;
    yy += c->length * dy * dy;
  }
  JointDirection(xx, xy, yy, e);
}

/* Returns the largest distance of an end point from the chord. */
static PetscReal deviation(const StageFields *s, PetscInt joint, const JointResultants *line)
{
  PetscReal most = 0;
  for (PetscInt i = 0; i < 2 * s->n_contacts; i++) {
    const PetscReal *p = s->contact[i / 2].end[i % 2].point;
    if (s->contact[i / 2].joint != joint) continue;
    most = PetscMax(most, fabs(line->e[0] * (p[1] - line->start[1]) - line->e[1] * (p[0] - line->start[0])));
  }
  return most;
}

/* Finds the outermost ends along e. Where blocks have slid, the outermost contacts may be slivers, with a
   stress from their own past; so values come from the outermost contact that is no sliver. */
static void outermost(const StageFields *s, PetscInt joint, PetscBool slivers, JointResultants *line)
{
  PetscReal low = INFINITY, high = -INFINITY;
  for (PetscInt i = 0; i < 2 * s->n_contacts; i++) {
    const ContactRow *c = &s->contact[i / 2];
    const ContactEnd *end = &c->end[i % 2];
    if (c->joint != joint || (!slivers && (c->klass == VERTEX_FACE || c->control < 1.))) continue;
    const PetscReal at = end->point[0] * line->e[0] + end->point[1] * line->e[1];
    if (at < low) low = at, line->first = end;
    if (at > high) high = at, line->last = end;
  }
}

static void find_line(const StageFields *s, PetscInt joint, JointResultants *line)
{
  *line = (JointResultants){.n = 0};
  main_direction(s, joint, line->e);
  for (PetscInt i = 0; i < s->n_contacts; i++)
    if (s->contact[i].joint == joint) line->n++, line->length += s->contact[i].length;
  if (!line->n) return;
  outermost(s, joint, PETSC_TRUE, line);

  // the chord joins the outermost points
  for (int x = 0; x < 2; x++) {
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): a joint with contacts has outermost ones
    line->start[x] = line->first->point[x];
    line->end[x] = line->last->point[x];
  }
  outermost(s, joint, PETSC_FALSE, line);
  line->chord = hypot(line->end[0] - line->start[0], line->end[1] - line->start[1]);
  if (!(line->chord > 0)) return;
  for (int x = 0; x < 2; x++) line->e[x] = (line->end[x] - line->start[x]) / line->chord;
  line->is_line = (PetscBool)(deviation(s, joint, line) <= 0.1 * line->chord &&
                              line->length <= 1.25 * line->chord);
}

static void add_end(const ContactEnd *end, JointResultants *r)
{
  const PetscReal *e = r->e, *n = end->normal, *F = end->force;
  const PetscReal side = n[1] * e[0] - n[0] * e[1] >= 0 ? 1 : -1; // 1: F acts on side b, the lower one
  const PetscReal R[2] = {side * (F[0] * n[0] - F[1] * n[1]), side * (F[0] * n[1] + F[1] * n[0])};
  const PetscReal dx = end->point[0] - 0.5 * (r->start[0] + r->end[0]);
  const PetscReal dy = end->point[1] - 0.5 * (r->start[1] + r->end[1]), up = R[1] * e[0] - R[0] * e[1];
  if (r->is_line) {
    r->R[0] += R[0];
    r->R[1] += R[1];
    r->N -= up;
    r->T += R[0] * e[0] + R[1] * e[1];
    r->M += up * (dx * e[0] + dy * e[1]);
  } else {
    r->N -= F[0];
    r->T += fabs(F[1]);
  }
}

/* Returns the stress of an end over the control length: a shorter contact counts with the stress that its
   force gives over this length. Otherwise a corner, or a millimetre where blocks have slid, would decide the
   largest stress of a joint; and if such contacts were left out, a corner that bears everything would not
   count. sign: -1 for compression, 1 for tension; stress of the other sign is no such peak. */
static ContactEnd over_control(const ContactRow *c, int k, int sign)
{
  ContactEnd end = c->end[k];
  if (end.sigma * sign > 0.) end.sigma *= c->control, end.tau *= c->control;
  return end;
}

static void keep_extremes(const ContactRow *c, int k, JointResultants *r)
{
  const ContactEnd low = over_control(c, k, -1), high = over_control(c, k, 1);
  if (!r->ends || low.sigma < r->lowest.sigma) r->lowest = low;
  if (!r->ends || high.sigma > r->highest.sigma) r->highest = high;
  r->ends++;
}

static void add_contacts(const StageFields *s, PetscInt joint, JointResultants *r)
{
  for (PetscInt i = 0; i < s->n_contacts; i++) {
    const ContactRow *c = &s->contact[i];
    if (c->joint != joint) continue;
    r->open += c->open;
    r->crushing += c->crushing;
    for (int k = 0; k < 2; k++) {
      add_end(&c->end[k], r);
      keep_extremes(c, k, r);
      if (c->end[k].state & CONTACT_SLIPPING) r->slipping += 0.5 * c->length;
    }
  }
}

JointResultants JointResultantsOf(const StageFields *fields, PetscInt joint)
{
  JointResultants r;
  find_line(fields, joint, &r);
  if (r.n) add_contacts(fields, joint, &r);
  r.closed = PetscMax(0., r.length - r.open);
  return r;
}

/* Returns (N tan phi + c L' thickness) / |T|. Cohesion acts on the closed length L' only. */
PetscReal SlidingFactor(const Joint *joint, PetscReal N, PetscReal T, PetscReal closed, PetscReal thickness,
                        int residual)
{
  const PetscReal strength = JointResultantStrength(joint, residual, N, closed * thickness);
  return joint->law == LAW_ELASTIC ? NAN : strength / fabs(T);
}

void JointDirections(PetscInt n_joints, const StageFields *fields, PetscReal *direction)
{
  JointResultants line;
  for (PetscInt j = 0; j < n_joints; j++) {
    find_line(fields, j, &line);
    for (int x = 0; x < 2; x++) direction[2 * j + x] = line.is_line ? line.e[x] : 0.;
  }
}
