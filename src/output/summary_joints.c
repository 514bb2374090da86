/* summary_joints.c: computes the resultants of each joint, in the terms of the gravity method. Rank 0 only.

   A joint whose contacts lie along one line has a direction e from its start to its end (to the right;
   upwards when it is upright), and an upper side, to the left of e. R is the force of the upper side on the
   lower one. N = -R.left (compression positive), T = R.e, and M is the moment of the normal forces about the
   middle of the line. So the gravity method's stress at the distance x from the middle is (-N/L + 12 M x /
   L^3) / thickness. A joint that is no line (a net of joints) has N = -sum of the normal forces, T = sum of
   |shear forces|, and no M. */
#include "output/output.h"
#include <math.h>
#include <stdio.h>

typedef struct {
  PetscInt n; /* number of contacts */
  PetscBool is_line;
  PetscReal start[2], end[2];     /* [m] ends of the chord */
  PetscReal e[2];                 /* [-] from start to end */
  PetscReal chord, length;        /* [m] length of the chord; sum over contacts */
  const ContactEnd *first, *last; /* the outermost contacts; without slivers, where there are others */
} JointLine;

typedef struct {
  PetscReal N, T, M;                  /* [N], [N m] */
  PetscReal R[2];                     /* [N] */
  PetscReal open, slipping, crushing; /* [m] */
  ContactEnd lowest, highest;         /* extremes of sigma over a control length */
  PetscInt ends;
} JointSums;

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
static PetscReal deviation(const StageFields *s, PetscInt joint, const JointLine *line)
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
static void outermost(const StageFields *s, PetscInt joint, PetscBool slivers, JointLine *line)
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

static void find_line(const StageFields *s, PetscInt joint, JointLine *line)
{
  *line = (JointLine){.n = 0};
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

static void add_end(const JointLine *line, const ContactEnd *end, JointSums *sums)
{
  const PetscReal *e = line->e, *n = end->normal, *F = end->force;
  const PetscReal side = n[1] * e[0] - n[0] * e[1] >= 0 ? 1 : -1; // 1: F acts on side b, the lower one
  const PetscReal R[2] = {side * (F[0] * n[0] - F[1] * n[1]), side * (F[0] * n[1] + F[1] * n[0])};
  const PetscReal dx = end->point[0] - 0.5 * (line->start[0] + line->end[0]);
  const PetscReal dy = end->point[1] - 0.5 * (line->start[1] + line->end[1]), up = R[1] * e[0] - R[0] * e[1];
  if (line->is_line) {
    sums->R[0] += R[0];
    sums->R[1] += R[1];
    sums->N -= up;
    sums->T += R[0] * e[0] + R[1] * e[1];
    sums->M += up * (dx * e[0] + dy * e[1]);
  } else {
    sums->N -= F[0];
    sums->T += fabs(F[1]);
  }
}

/* The stress of a contact over its control length: a shorter contact counts with what it bears over that
   length. Otherwise the stress of a joint would be that of a corner, or of a millimetre where blocks have
   slid; and without such contacts, a corner that bears everything would not count. sign: -1 for compression,
   1 for tension; stress of the other sign is no such peak. */
static ContactEnd over_control(const ContactRow *c, int k, int sign)
{
  ContactEnd end = c->end[k];
  if (end.sigma * sign > 0.) end.sigma *= c->control, end.tau *= c->control;
  return end;
}

static void keep_extremes(const ContactRow *c, int k, JointSums *sums)
{
  const ContactEnd low = over_control(c, k, -1), high = over_control(c, k, 1);
  if (!sums->ends || low.sigma < sums->lowest.sigma) sums->lowest = low;
  if (!sums->ends || high.sigma > sums->highest.sigma) sums->highest = high;
  sums->ends++;
}

static void add_contacts(const StageFields *s, PetscInt joint, const JointLine *line, JointSums *sums)
{
  *sums = (JointSums){.N = 0};
  for (PetscInt i = 0; i < s->n_contacts; i++) {
    const ContactRow *c = &s->contact[i];
    if (c->joint != joint) continue;
    sums->open += c->open;
    sums->crushing += c->crushing;
    for (int k = 0; k < 2; k++) {
      add_end(line, &c->end[k], sums);
      keep_extremes(c, k, sums);
      if (c->end[k].state & CONTACT_SLIPPING) sums->slipping += 0.5 * c->length;
    }
  }
}

static void put_end(FILE *f, const char *name, const PetscReal at[2], const ContactEnd *end, const char *tail)
{
  fprintf(f, "          \"%s\": {", name);
  // NOLINTBEGIN(clang-analyzer-core.NullDereference): called for joints with contacts only
  JsonNumber(f, "x", at[0], ", ");
  JsonNumber(f, "y", at[1], ", ");
  JsonNumber(f, "sigma", end->sigma, ", ");
  JsonNumber(f, "tau", end->tau, ", ");
  JsonNumber(f, "opening", end->opening, ", ");
  JsonNumber(f, "sliding", end->sliding, "}");
  fputs(tail, f);
  // NOLINTEND(clang-analyzer-core.NullDereference)
}

static void put_line(FILE *f, const JointLine *line, const JointSums *sums, PetscReal thickness)
{
  const PetscReal L = line->chord, N = sums->N, M = sums->M;
  JsonNumber(f, "M", M, ",\n          ");
  fprintf(f, "\"force\": {");
  JsonNumber(f, "x", sums->R[0], ", ");
  JsonNumber(f, "y", sums->R[1], "},\n          ");
  JsonNumber(f, "chord", L, ",\n          ");
  JsonNumber(f, "sigma_linear_start", (-N / L - 6 * M / (L * L)) / thickness, ",\n          ");
  JsonNumber(f, "sigma_linear_end", (-N / L + 6 * M / (L * L)) / thickness, ",\n");
  put_end(f, "start", line->start, line->first, ",\n");
  put_end(f, "end", line->end, line->last, ",\n");
}

static PetscReal closed_length(const JointLine *line, const JointSums *sums)
{
  return PetscMax(0., line->length - sums->open);
}

/* Returns (N tan phi + c L' thickness) / |T|. Cohesion acts on the closed length L' only. */
PetscReal SlidingFactor(const Joint *joint, PetscReal N, PetscReal T, PetscReal closed, PetscReal thickness,
                        int residual)
{
  const PetscReal strength = JointResultantStrength(joint, residual, N, closed * thickness);
  return joint->law == LAW_ELASTIC ? NAN : strength / fabs(T);
}

/* Writes the factors. Out of equilibrium the shear of a joint is only the rest that friction leaves, which
   gives no factor. */
static void put_factors(FILE *f, const Joint *joint, const JointLine *line, const JointSums *sums,
                        PetscReal thickness, PetscBool at_rest)
{
  const PetscReal needed = atan2(fabs(sums->T), sums->N) * 180. / PETSC_PI,
                  closed = closed_length(line, sums),
                  peak = SlidingFactor(joint, sums->N, sums->T, closed, thickness, 0),
                  residual = SlidingFactor(joint, sums->N, sums->T, closed, thickness, 1);
  JsonNumber(f, "friction_needed", at_rest ? needed : NAN, ",\n          ");
  JsonNumber(f, "sliding_factor_peak", at_rest ? peak : NAN, ",\n          ");
  JsonNumber(f, "sliding_factor_residual", at_rest ? residual : NAN, ",\n          ");
}

static void put_joint(FILE *f, const Joint *joint, const JointLine *line, const JointSums *sums,
                      PetscReal thickness, PetscBool at_rest)
{
  fprintf(f,
          "        \"%s\": {\n          \"line\": %s,\n          \"law\": \"%s\",\n          \"n_contacts\": "
          "%d,\n          ",
          joint->name, line->is_line ? "true" : "false",
          joint->law == LAW_ELASTIC ? "elastic" : "mohr_coulomb", (int)line->n);
  JsonNumber(f, "length", line->length, ",\n          ");
  JsonNumber(f, "open_length", sums->open, ",\n          ");
  JsonNumber(f, "closed_length", closed_length(line, sums), ",\n          ");
  JsonNumber(f, "slipping_length", sums->slipping, ",\n          ");
  JsonNumber(f, "crushing_length", sums->crushing, ",\n          ");
  JsonNumber(f, "N", sums->N, ",\n          ");
  JsonNumber(f, "T", sums->T, ",\n          ");
  put_factors(f, joint, line, sums, thickness, at_rest);
  if (line->is_line)
    put_line(f, line, sums, thickness);
  else
    fprintf(f, "\n");
  put_end(f, "sigma_min", sums->lowest.point, &sums->lowest, ",\n");
  put_end(f, "sigma_max", sums->highest.point, &sums->highest, "\n        }");
}

void JointDirections(PetscInt n_joints, const StageFields *fields, PetscReal *direction)
{
  JointLine line;
  for (PetscInt j = 0; j < n_joints; j++) {
    find_line(fields, j, &line);
    for (int x = 0; x < 2; x++) direction[2 * j + x] = line.is_line ? line.e[x] : 0.;
  }
}

PetscErrorCode SummaryJoints(FILE *f, const Problem *p, const StageFields *fields)
{
  const Verdict verdict = p->result->verdict;
  const PetscBool at_rest = (PetscBool)(verdict == VERDICT_CONVERGED || verdict == VERDICT_COMPLETED);
  PetscInt written = 0;
  JointLine line;
  JointSums sums;
  PetscFunctionBeginUser;
  fprintf(f, "      \"joints\": {");
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    find_line(fields, j, &line);
    if (!line.n) continue;
    add_contacts(fields, j, &line, &sums);
    fprintf(f, written++ ? ",\n" : "\n");
    put_joint(f, &p->stage->joints[j], &line, &sums, p->scene->thickness, at_rest);
  }
  fprintf(f, "\n      }\n");
  PetscFunctionReturn(PETSC_SUCCESS);
}
