/* summary_joints.c: writes the resultants of each joint into summary.json. Rank 0 only. */
#include "output/output.h"
#include <math.h>

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

static void put_line(FILE *f, const JointResultants *r, PetscReal thickness)
{
  const PetscReal L = r->chord, N = r->N, M = r->M;
  JsonNumber(f, "M", M, ",\n          ");
  fprintf(f, "\"force\": {");
  JsonNumber(f, "x", r->R[0], ", ");
  JsonNumber(f, "y", r->R[1], "},\n          ");
  JsonNumber(f, "chord", L, ",\n          ");
  JsonNumber(f, "sigma_linear_start", (-N / L - 6 * M / (L * L)) / thickness, ",\n          ");
  JsonNumber(f, "sigma_linear_end", (-N / L + 6 * M / (L * L)) / thickness, ",\n");
  put_end(f, "start", r->start, r->first, ",\n");
  put_end(f, "end", r->end, r->last, ",\n");
}

/* Writes the factors. Out of equilibrium the shear of a joint is only the rest that friction leaves, which
   gives no factor. */
static void put_factors(FILE *f, const Joint *joint, const JointResultants *r, PetscReal thickness,
                        PetscBool at_rest)
{
  const PetscReal needed = atan2(fabs(r->T), r->N) * 180. / PETSC_PI,
                  peak = SlidingFactor(joint, r->N, r->T, r->closed, thickness, 0),
                  residual = SlidingFactor(joint, r->N, r->T, r->closed, thickness, 1);
  JsonNumber(f, "friction_needed", at_rest ? needed : NAN, ",\n          ");
  JsonNumber(f, "sliding_factor_peak", at_rest ? peak : NAN, ",\n          ");
  JsonNumber(f, "sliding_factor_residual", at_rest ? residual : NAN, ",\n          ");
}

static void put_joint(FILE *f, const Joint *joint, const JointResultants *r, PetscReal thickness,
                      PetscBool at_rest)
{
  fprintf(f,
          "        \"%s\": {\n          \"line\": %s,\n          \"law\": \"%s\",\n          \"n_contacts\": "
          "%d,\n          ",
          joint->name, r->is_line ? "true" : "false", joint->law == LAW_ELASTIC ? "elastic" : "mohr_coulomb",
          (int)r->n);
  JsonNumber(f, "length", r->length, ",\n          ");
  JsonNumber(f, "open_length", r->open, ",\n          ");
  JsonNumber(f, "closed_length", r->closed, ",\n          ");
  JsonNumber(f, "slipping_length", r->slipping, ",\n          ");
  JsonNumber(f, "crushing_length", r->crushing, ",\n          ");
  JsonNumber(f, "N", r->N, ",\n          ");
  JsonNumber(f, "T", r->T, ",\n          ");
  put_factors(f, joint, r, thickness, at_rest);
  if (r->is_line)
    put_line(f, r, thickness);
  else
    fprintf(f, "\n");
  put_end(f, "sigma_min", r->lowest.point, &r->lowest, ",\n");
  put_end(f, "sigma_max", r->highest.point, &r->highest, "\n        }");
}

void SummaryJoints(FILE *f, const Problem *p, const StageFields *fields)
{
  const Verdict verdict = p->result->verdict;
  const PetscBool at_rest = (PetscBool)(verdict == VERDICT_CONVERGED || verdict == VERDICT_COMPLETED);
  PetscInt written = 0;
  fprintf(f, "      \"joints\": {");
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    const JointResultants r = JointResultantsOf(fields, j);
    if (!r.n) continue;
    fprintf(f, written++ ? ",\n" : "\n");
    put_joint(f, &p->stage->joints[j], &r, p->scene->thickness, at_rest);
  }
  fprintf(f, "\n      }\n");
}
