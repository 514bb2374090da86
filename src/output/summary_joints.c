/* summary_joints.c: writes the resultants of each joint into summary.json. Rank 0 only. */
#include "output/output.h"
#include <math.h>

static void put_end(Json *json, const char *name, const PetscReal at[2], const ContactEnd *end)
{
  JsonOpen(json, name);
  // NOLINTBEGIN(clang-analyzer-core.NullDereference): called for joints with contacts only
  JsonNumbers(json, {"x", at[0]}, {"y", at[1]}, {"sigma", end->sigma}, {"tau", end->tau},
              {"opening", end->opening}, {"sliding", end->sliding});
  JsonClose(json);
  // NOLINTEND(clang-analyzer-core.NullDereference)
}

static void put_line(Json *json, const JointResultants *r, PetscReal thickness)
{
  const PetscReal L = r->chord, N = r->N, M = r->M;
  JsonNumber(json, "M", M);
  JsonObject(json, "force", {"x", r->R[0]}, {"y", r->R[1]});
  JsonNumbers(json, {"chord", L}, {"sigma_linear_start", (-N / L - 6 * M / (L * L)) / thickness},
              {"sigma_linear_end", (-N / L + 6 * M / (L * L)) / thickness});
  put_end(json, "start", r->start, r->first);
  put_end(json, "end", r->end, r->last);
}

/* Writes the factors. Out of equilibrium the shear of a joint is only the rest that friction leaves, which
   gives no factor. */
static void put_factors(Json *json, const Joint *joint, const JointResultants *r, PetscReal thickness,
                        PetscBool at_rest)
{
  const PetscReal needed = atan2(fabs(r->T), r->N) * 180. / PETSC_PI,
                  peak = SlidingFactor(joint, r->N, r->T, r->closed, thickness, 0),
                  residual = SlidingFactor(joint, r->N, r->T, r->closed, thickness, 1);
  JsonNumbers(json, {"friction_needed", at_rest ? needed : NAN},
              {"sliding_factor_peak", at_rest ? peak : NAN},
              {"sliding_factor_residual", at_rest ? residual : NAN});
}

static void put_joint(Json *json, const Joint *joint, const JointResultants *r, PetscReal thickness,
                      PetscBool at_rest)
{
  JsonOpen(json, joint->name);
  JsonValue(json, "line", r->is_line ? "true" : "false");
  JsonText(json, "law", joint->law == LAW_ELASTIC ? "elastic" : "mohr_coulomb");
  JsonNumbers(json, {"n_contacts", r->n}, {"length", r->length}, {"open_length", r->open},
              {"closed_length", r->closed}, {"slipping_length", r->slipping},
              {"crushing_length", r->crushing}, {"N", r->N}, {"T", r->T});
  put_factors(json, joint, r, thickness, at_rest);
  if (r->is_line) put_line(json, r, thickness);
  put_end(json, "sigma_min", r->lowest.point, &r->lowest);
  put_end(json, "sigma_max", r->highest.point, &r->highest);
  JsonClose(json);
}

void SummaryJoints(Json *json, const Problem *p, const StageFields *fields)
{
  const Verdict verdict = p->result->verdict;
  const PetscBool at_rest = (PetscBool)(verdict == VERDICT_CONVERGED || verdict == VERDICT_COMPLETED);
  JsonOpen(json, "joints");
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    const JointResultants r = JointResultantsOf(fields, j);
    if (r.n) put_joint(json, &p->stage->joints[j], &r, p->scene->thickness, at_rest);
  }
  JsonClose(json);
}
