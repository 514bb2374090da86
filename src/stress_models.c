/* stress_models.c: the table of the six stress models, and one contact on its own; the models themselves are
   in stress_models.h and tptm.h, for a batch of contacts. */
#include "internal.h"
#include "stress_models.h"

const char *const StressModels[] = {"pt",      "r2pt", "r3pt", "t2pt", "t3pt", "tptm", "StressModelKind",
                                    "STRESS_", NULL};

/* Share of end 0 in a stress s0, sm, s1: c1, cm, c2.
   pt:   forces s L/2 at the ends themselves.
   r2pt: s L/2 at L/4 and 3L/4, shared by the lever: 1/2 (3/4, 1/4).
   r3pt: s L/4, s L/2, s L/4 at L/8, L/2, 7L/8: (1/4 7/8, 1/2 1/2, 1/4 1/8).
   t2pt: integral of (1-x)(1-x) and x (1-x).
   t3pt: two trapezoids of L/2: integral of (1-2x)(1-x) over the first half, 1/4 by symmetry, and the rest of
   1/2. tptm: as t2pt where nothing is violated. */
const LanesModel LanesModels[STRESS_MODELS] = {
    [STRESS_PT] = {{1. / 2, 0, 0}, {1. / 2, 0}, 0},
    [STRESS_R2PT] = {{3. / 8, 0, 1. / 8}, {3. / 8, 1. / 8}, 0},
    [STRESS_R3PT] = {{7. / 32, 8. / 32, 1. / 32}, {11. / 32, 5. / 32}, 0},
    [STRESS_T2PT] = {{2. / 6, 0, 1. / 6}, {2. / 6, 1. / 6}, 0},
    [STRESS_T3PT] = {{5. / 24, 6. / 24, 1. / 24}, {5. / 24 + 3. / 24, 1. / 24 + 3. / 24}, 0},
    [STRESS_TPTM] = {{2. / 6, 0, 1. / 6}, {2. / 6, 1. / 6}, 1},
};

void StressModelElastic(StressModelKind model, PetscReal *a, PetscReal *b)
{
  *a = LanesModels[model].elastic[0];
  *b = LanesModels[model].elastic[1];
}

PetscBool JointIsElastic(const Joint *joint, const PetscReal sigma[2], const PetscReal tau[2],
                         const PetscReal broken[2])
{
  const PetscInt same[LANES] = {0};
  LanesContact c;
  LanesJoint J;

  LoadJoints(joint, same, &J);
  for (int k = 0; k < 2; k++)
    c.sigma[k] = LanesOf(sigma[k]), c.tau[k] = LanesOf(tau[k]), c.broken[k] = LanesOf(broken[k]);
  return (PetscBool)(IsElastic(&J, &c)[0] != 0);
}

/* One contact in all lanes: what a batch gives, bit for bit. */
void StressModelRespond(StressModelKind model, const Joint *joint, PetscReal length, ContactPoint *p)
{
  const PetscInt same[LANES] = {0};
  LanesJoint J;
  LanesContact c = {.length = LanesOf(length)};

  LoadJoints(joint, same, &J);
  for (int k = 0; k < 2; k++) {
    c.u_n[k] = LanesOf(p->u_n[k]), c.u_s[k] = LanesOf(p->u_s[k]);
    c.slip[k] = LanesOf(p->slip[k]), c.broken[k] = LanesOf(p->broken[k]);
  }
  RespondContacts(&J, LanesModels + model, p->in_time, &c);
  for (int k = 0; k < 2; k++) {
    p->slip[k] = c.slip[k][0], p->broken[k] = c.broken[k][0];
    p->sigma[k] = c.sigma[k][0], p->tau[k] = c.tau[k][0];
    p->F_n[k] = c.F_n[k][0], p->F_s[k] = c.F_s[k][0];
    p->state[k] = (PetscInt)c.state[k][0];
  }
}
