/* contact_force.c: every cycle, for every contact: opening and slip of its two sub-contacts (1)-(4), stresses
   (5)-(6) by its stress model and joint law, forces to the vertices of both faces.

   Kinematics in total form. With q = (1-t) A + t B the point of the destination face under P (t = L_d /
   length) and d = P - q, u_n = d.n,  u_s = d.s,   s = (B - A)/|B - A|,  n = s turned clockwise: out of the
   destination block, in the present positions: the sum of the increments (3)-(4), but exact under rotation
   and free of drift. The forces are the derivatives of int sigma du_n + int tau du_s with respect to the
   vertices. n and s turn with A-B by d(theta) = -n.(dB - dA)/|B - A|, which adds a couple C = F_n u_s - F_s
   u_n on the destination face: with it contacts keep angular momentum and energy. (Small strain: n, s of the
   reference state, no couple.)

   All lanes of a batch take the elastic row of their stress model; lanes where the joint law does not hold
   elastically are done again by StressModelRespond. Both give the same bits where the law holds, so it does
   not matter which lane sits in which batch. */
#include "internal.h"

typedef struct {
  PetscReal n[2][2][BATCH], s[2][2][BATCH], inv_length[2][BATCH]; /* [sub][x,y][lane] */
  PetscReal d_n[2][BATCH], d_s[2][BATCH];                         /* d.n, d.s before `rest` */
  PetscReal sigma[2][BATCH], tau[2][BATCH], F_n[2][BATCH], F_s[2][BATCH];
} Lanes;

static void kinematics(const PetscInt *restrict vertex, const PetscReal *restrict X,
                       const PetscReal *restrict u, const PetscReal *restrict t,
                       const PetscReal *restrict gap, PetscReal moving, Lanes *L)
{
  for (int k = 0; k < 2; k++)
    for (int l = 0; l < BATCH; l++) {
      const PetscInt P = 2 * vertex[(3 * k) * BATCH + l], A = 2 * vertex[(3 * k + 1) * BATCH + l],
                     B = 2 * vertex[(3 * k + 2) * BATCH + l];
      const PetscReal tk = t[k * BATCH + l];
      const PetscReal dx = gap[(2 * k) * BATCH + l] + (u[P] - ((1. - tk) * u[A] + tk * u[B]));
      const PetscReal dy = gap[(2 * k + 1) * BATCH + l] + (u[P + 1] - ((1. - tk) * u[A + 1] + tk * u[B + 1]));
      const PetscReal ex = (X[B] - X[A]) + moving * (u[B] - u[A]),
                      ey = (X[B + 1] - X[A + 1]) + moving * (u[B + 1] - u[A + 1]);
      const PetscReal inv = 1. / PetscSqrtReal(ex * ex + ey * ey), sx = ex * inv, sy = ey * inv;
      L->inv_length[k][l] = inv;
      L->s[k][0][l] = sx, L->s[k][1][l] = sy;
      L->n[k][0][l] = sy, L->n[k][1][l] = -sx;
      L->d_n[k][l] = dx * sy - dy * sx; // (3)
      L->d_s[k][l] = dx * sx + dy * sy; // (4)
    }
}

/* Elastic stresses and end forces of all lanes; returns a bit per lane where the joint law does not hold
 * elastically. */
static unsigned elastic_row(const Contacts *c, const Joint *joints, PetscInt b, PetscReal a, PetscReal bb,
                            Lanes *L)
{
  unsigned inelastic = 0;
  for (int l = 0; l < BATCH; l++) {
    const PetscInt i = b * BATCH + l;
    const Joint *j = joints + c->joint[i];
    PetscReal broken[2], sigma[2], tau[2];
    for (int k = 0; k < 2; k++) {
      const PetscInt at = SUB(i, k);
      sigma[k] = j->k_n * (L->d_n[k][l] - c->rest[at]);
      tau[k] = j->k_s * (L->d_s[k][l] - c->slip[at]);
      broken[k] = c->broken[at];
    }
    for (int k = 0; k < 2; k++) {
      L->sigma[k][l] = sigma[k], L->tau[k][l] = tau[k];
      L->F_n[k][l] = c->length[i] * (a * sigma[k] + bb * sigma[1 - k]);
      L->F_s[k][l] = c->length[i] * (a * tau[k] + bb * tau[1 - k]);
    }
    inelastic |= (unsigned)!JointIsElastic(j, sigma, tau, broken) << l;
  }
  return inelastic;
}

/* The lanes where the joint opens, slips or crushes, by the stress model itself. */
static void inelastic_lanes(Contacts *c, const Joint *joints, StressModelKind model, PetscInt b,
                            unsigned lanes, Lanes *L)
{
  for (int l = 0; l < BATCH; l++) {
    if (!(lanes >> l & 1)) continue;
    const PetscInt i = b * BATCH + l;
    ContactPoint p = {.in_time = (PetscBool)(c->rate != 0.)};
    for (int k = 0; k < 2; k++) {
      const PetscInt at = SUB(i, k);
      p.u_n[k] = L->d_n[k][l] - c->rest[at], p.u_s[k] = L->d_s[k][l];
      p.slip[k] = c->slip[at], p.broken[k] = c->broken[at];
    }
    StressModelRespond(model, joints + c->joint[i], c->length[i], &p);
    for (int k = 0; k < 2; k++) {
      const PetscInt at = SUB(i, k);
      c->slip[at] = p.slip[k], c->broken[at] = p.broken[k], c->state[at] = p.state[k];
      L->sigma[k][l] = p.sigma[k], L->tau[k][l] = p.tau[k];
      L->F_n[k][l] = p.F_n[k], L->F_s[k][l] = p.F_s[k];
    }
  }
}

/* End forces to P and, by L_d, to A and B; lane after lane, so that sums at a vertex have one order. */
static void scatter(const PetscInt *restrict vertex, const PetscReal *restrict t, PetscReal thickness,
                    PetscReal moving, const Lanes *L, PetscReal *restrict f)
{
  for (int l = 0; l < BATCH; l++)
    for (int k = 0; k < 2; k++) {
      const PetscInt P = 2 * vertex[(3 * k) * BATCH + l], A = 2 * vertex[(3 * k + 1) * BATCH + l],
                     B = 2 * vertex[(3 * k + 2) * BATCH + l];
      const PetscReal F_n = thickness * L->F_n[k][l], F_s = thickness * L->F_s[k][l], tk = t[k * BATCH + l];
      const PetscReal couple = moving * (F_n * L->d_s[k][l] - F_s * L->d_n[k][l]) * L->inv_length[k][l];
      for (int i = 0; i < 2; i++) {
        const PetscReal F = F_n * L->n[k][i][l] + F_s * L->s[k][i][l], turn = couple * L->n[k][i][l];
        f[P + i] += F;
        f[A + i] += turn - (1. - tk) * F;
        f[B + i] += -turn - tk * F;
      }
    }
}

/* Dashpots of closed ends in time: damping * k_n * d(u_n)/dt over the end's half of the contact; a joint
 * never pulls. */
static void dashpots(PetscInt b, Contacts *c, const Joint *joints, Lanes *L)
{
  for (int l = 0; l < BATCH; l++) {
    const Joint *j = joints + c->joint[b * BATCH + l];
    for (int k = 0; k < 2 && j->damping > 0.; k++) {
      const PetscInt at = SUB(b * BATCH + l, k);
      c->speed[at] = (L->d_n[k][l] - c->rest[at] - c->u_n[at]) * c->rate;
      if (L->sigma[k][l] >= 0.) continue;
      L->F_n[k][l] = PetscMin(0., L->F_n[k][l] +
                                      0.5 * c->length[b * BATCH + l] * j->damping * j->k_n * c->speed[at]);
    }
  }
}

static void keep_results(PetscInt b, unsigned inelastic, const Lanes *L, Contacts *c)
{
  for (int k = 0; k < 2; k++)
    for (int l = 0; l < BATCH; l++) {
      const PetscInt at = (b * 2 + k) * BATCH + l;
      c->u_n[at] = L->d_n[k][l] - c->rest[at], c->u_s[at] = L->d_s[k][l];
      c->sigma[at] = L->sigma[k][l], c->tau[at] = L->tau[k][l];
      c->F_n[at] = L->F_n[k][l], c->F_s[at] = L->F_s[k][l];
      if (!(inelastic >> l & 1)) c->state[at] = CONTACT_ELASTIC;
    }
}

PetscErrorCode ContactForces(const Model *m, const Joint *joints, Contacts *c, const PetscReal *u,
                             PetscReal *f)
{
  const PetscReal moving = m->strain == STRAIN_LARGE ? 1. : 0.;
  PetscFunctionBeginUser;
  for (int s = 0; s < STRESS_MODELS; s++) {
    PetscReal a, bb;
    StressModelElastic((StressModelKind)s, &a, &bb);
    for (PetscInt b = c->model_start[s] / BATCH; b < c->model_start[s + 1] / BATCH; b++) {
      const PetscInt *vertex = c->vertex + b * 6 * BATCH;
      const PetscReal *t = c->t + b * 2 * BATCH;
      Lanes L;
      kinematics(vertex, m->X, u, t, c->gap + b * 4 * BATCH, moving, &L);
      const unsigned inelastic = elastic_row(c, joints, b, a, bb, &L);
      if (inelastic) inelastic_lanes(c, joints, (StressModelKind)s, b, inelastic, &L);
      if (c->rate > 0.) dashpots(b, c, joints, &L);
      keep_results(b, inelastic, &L, c);
      scatter(vertex, t, m->thickness, moving, &L, f);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
