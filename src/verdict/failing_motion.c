/* failing_motion.c: finds the motion in which a trial or a static stage has collapsed, and how this motion
   opens and closes contacts. */
#include "verdict/judge.h"

/* Computes the motion v (n_vertices,2) of all local vertices when the degrees of freedom move by du
   (n_dof,). */
static PetscErrorCode vertex_motion(const Model *m, const State *state, const PetscReal *du, PetscReal *v)
{
  const PetscInt at = 3 * m->rigid.n;
  const PetscReal *u = state->u + at;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < 2 * m->mesh.n_deformable; i++) v[i] = du[at + i];
  for (PetscInt b = 0; b < m->rigid.n; b++)
    for (PetscInt i = m->rigid.start[b]; i < m->rigid.start[b + 1]; i++) {
      const PetscReal rx = m->mesh.X[2 * i] + u[2 * i] - m->rigid.X[2 * b] - state->u[3 * b],
                      ry = m->mesh.X[2 * i + 1] + u[2 * i + 1] - m->rigid.X[2 * b + 1] - state->u[3 * b + 1];
      v[2 * i] = du[3 * b] - ry * du[3 * b + 2];         // (21)
      v[2 * i + 1] = du[3 * b + 1] + rx * du[3 * b + 2]; // (22)
    }
  PetscCall(CondensedInner(m, NULL, v));
  PetscCall(GhostBegin(m, v));
  PetscCall(GhostEnd(m, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the motion of end k of contact i when vertices move by v: along the joint, and apart. */
static void end_motion(const Model *m, const State *state, const Contacts *c, PetscInt i, int k,
                       const PetscReal *v, PetscReal *along, PetscReal *apart)
{
  const PetscReal *X = m->mesh.X, *u = state->u + 3 * m->rigid.n, t = c->t[SUB(i, k)];
  PetscInt n[3]; // P A B
  PetscReal e[2], dv[2];
  ContactEndVertices(c, i, k, n);
  for (int x = 0; x < 2; x++) {
    e[x] = X[2 * n[2] + x] + u[2 * n[2] + x] - X[2 * n[1] + x] - u[2 * n[1] + x];
    dv[x] = v[2 * n[0] + x] - (1. - t) * v[2 * n[1] + x] - t * v[2 * n[2] + x];
  }
  const PetscReal length = PetscHypotReal(e[0], e[1]);
  *along = (dv[0] * e[0] + dv[1] * e[1]) / length;
  *apart = (dv[0] * e[1] - dv[1] * e[0]) / length; // the outward normal is (e_y, -e_x)
}

/* Finds the largest opening and sliding motion (n_joints,2) of each joint that can fail. */
static PetscErrorCode joint_motion(const Problem *p, const PetscReal *v, PetscReal *motion)
{
  const Contacts *c = p->contacts;
  const PetscInt n = 2 * p->scene->n_joints;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(motion, n));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || p->stage->joints[c->joint[i]].law == LAW_ELASTIC) continue;
    for (int k = 0; k < ContactEnds(c, i); k++) {
      const PetscBool open = (PetscBool)(c->state[SUB(i, k)] & CONTACT_OPEN);
      PetscReal *most = motion + 2 * c->joint[i], along, apart;
      end_motion(p->m, p->state, c, i, k, v, &along, &apart);
      if (open) most[JOINT_OPENS] = PetscMax(most[JOINT_OPENS], apart);
      if (!open) most[JOINT_SLIDES] = PetscMax(most[JOINT_SLIDES], PetscAbsReal(along));
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, motion, (PetscMPIInt)n, MPIU_REAL, MPI_MAX, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MechanismTake(const Problem *p, const PetscReal *from)
{
  const Model *m = p->m;
  const State *state = p->state;
  const Relaxation *r = p->relax;
  const PetscBool chunk_ended = (PetscBool)(r->evidence.chunk_start == state->cycle);
  Trials *trials = &p->found->trials;
  PetscReal most = 0., *v, *du;
  PetscFunctionBeginUser;
  if (p->found->joints_only) PetscFunctionReturn(PETSC_SUCCESS);
  // a rank that owns nothing has an array too: NULL means on all ranks that there is no mechanism
  if (!trials->mechanism) {
    PetscCall(PetscMalloc1(PetscMax(1, 2 * m->mesh.n_owned), &trials->mechanism));
    PetscCall(PetscMalloc1(2 * p->scene->n_joints, &trials->joint_motion));
  }
  PetscCall(PetscCalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), &v));
  PetscCall(PetscMalloc1(m->n_dof, &du));
  // the motion over the last chunk of cycles, because velocities also contain vibrations of blocks
  for (PetscInt d = 0; d < m->n_dof; d++) {
    if (from)
      du[d] = state->u[d] - from[d];
    else
      du[d] = chunk_ended ? r->evidence.du_chunk[d] : state->u[d] - r->evidence.u_chunk[d];
  }
  PetscCall(vertex_motion(m, state, du, v));
  PetscCall(PetscFree(du));
  for (PetscInt i = 0; i < m->mesh.n_owned; i++)
    most = PetscMax(most, PetscHypotReal(v[2 * i], v[2 * i + 1]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPI_MAX, m->comm));
  // only the shape of the motion means something: its time is fictitious
  for (PetscInt i = 0; most > 0. && i < 2 * m->mesh.n_vertices; i++) v[i] /= most;
  PetscCall(PetscArraycpy(trials->mechanism, v, 2 * m->mesh.n_owned));
  PetscCall(joint_motion(p, v, trials->joint_motion));
  PetscCall(PetscFree(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MotionCloses(const Model *m, const State *state, const Contacts *c, const PetscReal *du,
                            PetscReal times, PetscReal *gap)
{
  PetscReal *v, most = 0.;
  PetscFunctionBeginUser;
  *gap = 0.;
  PetscCall(PetscCalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), &v));
  PetscCall(vertex_motion(m, state, du, v));
  for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++) most = PetscMax(most, PetscAbsReal(v[i]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; c->key[2 * i] >= 0 && k < ContactEnds(c, i); k++) {
      const PetscReal open = c->u_n[SUB(i, k)];
      PetscReal along, apart;
      if (!(c->state[SUB(i, k)] & CONTACT_OPEN) || open <= *gap) continue;
      end_motion(m, state, c, i, k, v, &along, &apart);
      if (-apart > CLOSES_FROM * most && open < -apart * times) *gap = open;
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, gap, 1, MPIU_REAL, MPI_MAX, m->comm));
  PetscCall(PetscFree(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}
