/* rest_point.c: estimates how far ahead of a moving body a place lies where nothing drives its motion any
   more.

   Vibrations inside bodies and in joints change the unbalanced force R of a single cycle by much more than a
   slow motion does. So R and u are averaged over the checks of a chunk of cycles (judge.c). From one mean to
   the next, by du and dR, the driving force falls by -dR.du/|du|, because resistance grows, and R.du/|du| is
   left. A straight line is fitted through the driving force at the last means, over the way. Its slope is
   made steeper by its standard error. Where the line is zero, the motion may come to rest. Unlike the pace of
   the motion, these forces do not depend on its damping, which may change tenfold from chunk to chunk.

   Means of forces under different rules of friction (friction_mode.c) must not be compared: RestPointForget
   drops them. */
#include "verdict/judge.h"
#include "base/reproducible.h"

PetscBool SceneCanFail(const Scene *scene)
{
  for (const Material *g = scene->materials; g < scene->materials + scene->n_materials; g++)
    if (g->law != MATERIAL_ELASTIC) return PETSC_TRUE;
  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++)
    for (PetscInt j = 0; j < scene->n_joints; j++)
      if (s->joints[j].k_n > 0. && s->joints[j].law != LAW_ELASTIC) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode RestPointCreate(const Scene *scene, const Model *m, RestPoint *r)
{
  PetscFunctionBeginUser;
  // a rank without degrees of freedom has no arrays, and takes part all the same
  r->kept = SceneCanFail(scene);
  if (!r->kept) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      PetscCalloc4(m->n_dof, &r->u_sum, m->n_dof, &r->r_sum, m->n_dof, &r->u_mean, m->n_dof, &r->r_mean));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RestPointDestroy(RestPoint *r)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(r->u_sum, r->r_sum, r->u_mean, r->r_mean));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RestPointForget(const Model *m, RestPoint *r)
{
  PetscFunctionBeginUser;
  if (!r->kept) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArrayzero(r->u_sum, m->n_dof));
  PetscCall(PetscArrayzero(r->r_sum, m->n_dof));
  r->checks = 0, r->has_mean = PETSC_FALSE;
  for (int i = 0; i < REST_STEPS; i++) r->way[i] = r->loss[i] = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void RestPointAdd(const Model *m, const State *state, RestPoint *r)
{
  if (!r->kept) return;
  for (PetscInt d = 0; d < m->n_dof; d++) r->u_sum[d] += state->u[d];
  for (PetscInt d = 0; d < m->n_dof; d++) r->r_sum[d] += state->f_ext[d] - state->f[d];
  r->checks++;
}

/* Computes way, loss and drive of the step from the mean of the chunk before to the mean of this chunk, which
   u_sum and r_sum (n_dof,) have. */
static PetscErrorCode take_step(const Model *m, const State *state, RestPoint *r)
{
  PetscReal top[3] = {0., 0., 0.}, sum[4] = {0., 0., 0., 0.};
  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) { // largest terms, then the binned sums
    const Bins bins[2] = {BinsFor(PetscMax(top[0], 1e-290)), BinsFor(PetscMax(top[1], 1e-290))};
    for (PetscInt d = 0; d < m->n_dof; d++) {
      const PetscReal du = r->u_sum[d] - r->u_mean[d], R = r->r_sum[d],
                      term[2] = {R * du, (r->r_mean[d] - R) * du};
      if (Held(m, d)) continue;
      for (int i = 0; i < 2 && pass; i++) BinAdd(bins + i, term[i], sum + 2 * i);
      for (int i = 0; i < 2 && !pass; i++) top[i] = PetscMax(top[i], PetscAbsReal(term[i]));
      top[2] = PetscMax(top[2], PetscAbsReal(du) * DofLength(m, state, d));
    }
    if (pass)
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 4, MPIU_REAL, MPI_SUM, m->comm));
    else
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, 3, MPIU_REAL, MPI_MAX, m->comm));
  }
  for (int i = REST_STEPS - 1; i > 0; i--) r->way[i] = r->way[i - 1], r->loss[i] = r->loss[i - 1];
  r->way[0] = top[2];
  r->drive = top[2] > 0. ? (sum[0] + sum[1]) / top[2] : 0.;
  r->loss[0] = top[2] > 0. ? (sum[2] + sum[3]) / top[2] : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RestPointOfChunk(const Model *m, const State *state, RestPoint *r)
{
  PetscFunctionBeginUser;
  if (!r->checks) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt d = 0; d < m->n_dof; d++) r->u_sum[d] /= r->checks, r->r_sum[d] /= r->checks;
  if (r->has_mean) PetscCall(take_step(m, state, r));
  PetscCall(PetscArraycpy(r->u_mean, r->u_sum, m->n_dof));
  PetscCall(PetscArraycpy(r->r_mean, r->r_sum, m->n_dof));
  PetscCall(PetscArrayzero(r->u_sum, m->n_dof));
  PetscCall(PetscArrayzero(r->r_sum, m->n_dof));
  r->checks = 0, r->has_mean = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal RestPointAhead(const RestPoint *r)
{
  PetscReal s[REST_STEPS + 1] = {0.}, drive[REST_STEPS + 1] = {r->drive}, mean[2] = {0., 0.};
  PetscReal ss = 0., sd = 0., dd = 0.;
  int n = 1;                           // means, the last first
  if (!r->kept) return PETSC_INFINITY; // nothing can fail, so no means are kept: what moves on floats
  for (; n <= REST_STEPS && r->way[n - 1] > 0.; n++)
    s[n] = s[n - 1] - r->way[n - 1], drive[n] = drive[n - 1] + r->loss[n - 1];
  if (n < 3) return 0.;
  for (int i = 0; i < n; i++) mean[0] += s[i] / n, mean[1] += drive[i] / n;
  for (int i = 0; i < n; i++) {
    const PetscReal x = s[i] - mean[0], y = drive[i] - mean[1];
    ss += x * x, sd += x * y, dd += y * y;
  }
  const PetscReal slope = sd / ss, scatter = PetscMax(0., dd - slope * sd) / (n - 2),
                  fall = PetscSqrtReal(scatter / ss) * SCATTER - slope;
  if (r->drive <= 0.) return 0.;
  return fall > 0. ? r->drive / fall : PETSC_INFINITY;
}

PetscErrorCode RestPointArchive(Archive *a, const Model *m, RestPoint *r)
{
  PetscFunctionBeginUser;
  PetscCall(ArchiveReals(a, "rest_drive", 1, &r->drive));
  PetscCall(ArchiveReals(a, "rest_way", REST_STEPS, r->way));
  PetscCall(ArchiveReals(a, "rest_loss", REST_STEPS, r->loss));
  PetscCall(ArchiveIntMembers(a, "rest_counts", INT_MEMBER(r->checks), INT_MEMBER(r->has_mean)));
  if (!r->kept) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveDofs(a, m, "rest_u_sum", r->u_sum));
  PetscCall(ArchiveDofs(a, m, "rest_r_sum", r->r_sum));
  PetscCall(ArchiveDofs(a, m, "rest_u_mean", r->u_mean));
  PetscCall(ArchiveDofs(a, m, "rest_r_mean", r->r_mean));
  PetscFunctionReturn(PETSC_SUCCESS);
}
