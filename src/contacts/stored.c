/* stored.c: computes the energy that joints store. */
#include "contacts/contacts.h"

/* Returns the normal force of the springs of an end: F_n without its dashpot, by the row of its stress
   model. */
static PetscReal spring_force(const Contacts *c, const Joint *j, PetscInt i, int k)
{
  PetscReal a, b;
  int model = 0;
  if (j->damping == 0. || c->rate <= 0.) return c->F_n[SUB(i, k)];
  while (i >= c->model_start[model + 1]) model++;
  StressModelElastic((StressModelKind)model, &a, &b);
  return c->length[i] * (a * c->sigma[SUB(i, k)] + b * c->sigma[SUB(i, 1 - k)]);
}

/* Returns the energy of the normal springs of a tptm contact that crushes or was crushed, per metre. */
static PetscReal stored_in_crushed(const Contacts *c, const Joint *j, PetscInt i)
{
  ContactPoint p = {.in_time = PETSC_TRUE};
  for (int k = 0; k < 2; k++) {
    const PetscInt at = SUB(i, k);
    p.u_n[k] = c->u_n[at], p.broken[k] = c->broken[at];
    p.closure[k] = c->closure[at], p.closure_far[k] = c->closure_far[at];
  }
  return StressModelStored(j, c->length[i], &p);
}

/* Returns the energy stored in one contact [J/m]. sigma runs linearly to where the joint opens, tau as far as
   the contact is closed. */
static PetscReal stored_in(const Contacts *c, const Joint *j, PetscInt i)
{
  const PetscInt at[2] = {SUB(i, 0), SUB(i, 1)};
  PetscReal stored = 0.;
  const PetscReal s[2] = {j->k_n * c->u_n[at[0]], j->k_n * c->u_n[at[1]]};
  const PetscBool open[2] = {(PetscBool)(c->sigma[at[0]] == 0. && s[0] > 0.),
                             (PetscBool)(c->sigma[at[1]] == 0. && s[1] > 0.)};
  if (i >= c->model_start[STRESS_TPTM] && (c->closure[at[0]] < 0. || c->closure[at[1]] < 0.)) {
    stored += stored_in_crushed(c, j, i);
  } else if (i >= c->model_start[STRESS_TPTM] && open[0] != open[1]) {
    const PetscReal closed = open[0] ? s[1] : s[0], other = open[0] ? s[0] : s[1];
    stored += closed * closed * (closed / (closed - other)) * c->length[i] / (6. * j->k_n);
  } else {
    for (int k = 0; k < 2; k++) stored += 0.5 * spring_force(c, j, i, k) * c->sigma[at[k]] / j->k_n;
  }
  if (JointSoftens(j)) // a crack that still pulls closes along the line to the origin
    for (int k = 0; k < 2; k++)
      if (c->sigma[at[k]] > 0.)
        stored += 0.5 * c->F_n[at[k]] * (c->u_n[at[k]] - c->closure[at[k]] - c->sigma[at[k]] / j->k_n);
  for (int k = 0; k < 2; k++) stored += 0.5 * c->F_s[at[k]] * (c->u_s[at[k]] - c->slip[at[k]]);
  return stored;
}

PetscReal EnergyInJoints(const Model *m, const Joint *joints, const Contacts *c)
{
  PetscReal sum = 0.;
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->owned[i]) sum += stored_in(c, joints + c->joint[i], i);
  return m->materials.thickness * sum;
}
