/* coupled_inertia.h: declares inertia and dashpots that are matrices, for coupled_inertia.c and
   coupled_bodies.c. */
#pragma once
#include "motion/motion.h"
#include "base/lanes.h"

enum { DOFS = 3 };
typedef PetscReal Square[DOFS][DOFS];

/* A vertex of a deformable block, or a rigid body. */
typedef struct {
  PetscInt dof;                  /* its first degree of freedom */
  PetscBool rigid;               /* a rigid body: 3 of them; else 2 */
  PetscBool condensed;           /* a kept vertex of a condensed body, which moves the vertex */
  PetscBool heavy, damped, held; /* whether it has added mass; dashpots; a held degree of freedom */
  Square mass;                   /* [kg, kg m, kg m2] added */
  Square dashpot;                /* [N s/m]; 0 at rigid bodies */
  Square inverse;                /* of M + dt/2 D between free degrees of freedom; 0 at held ones */
} CoupledPoint;

/* Vectors of a condensed body. ..._BEHIND is at the end of the step. */
enum {
  V_BEFORE,
  V_BEHIND,
  CARRIED, /* [N s] of modes: H' v */
  CARRIED_BEHIND,
  MOMENTUM,
  MOMENTUM_BEHIND,
  FORCE,
  ACCELERATION, /* of rows */
  ROOM,
  BODY_VECTORS
};
/* Vectors of its slots. */
enum { SLOT_BEFORE, SLOT_BEHIND, SLOT_FORCE, SLOT_VECTORS };

/* A condensed body. Its slots and rows stand in the order of condense_rows.c: first the free ones, then each
   direction of each support that holds some of its vertices, because these move alike. */
typedef struct {
  const Condensed *of;
  const CondensedRows *rows;
  PetscInt n_free, n;           /* number of free rows; of all rows */
  PetscInt free_slots, n_slots; /* number of free slots; of all slots */
  PetscInt stride, width;       /* rows and modes, rounded up to whole batches */
  PetscInt n_points, *point;    /* (n_points,) rows of the points at its vertices */
  PetscInt *slot;               /* (n_points, 2) of each point */
  PetscReal *inertia;           /* [kg] (stride, stride) Psi' M Psi */
  PetscReal *couples;           /* [kg] (stride, width) Psi' M Phi by columns */
  PetscReal *coupled;           /* (width, stride) the same transposed */
  PetscReal *truncated;         /* [kg s2] (stride, stride) of the modes left out (blocks.h) */
  PetscReal *along;             /* [kg] (n, 2) mass that a motion of the ground along x, y moves along */
  PetscReal *yields;            /* [-] (width,) part of a force on a mode that its dashpot leaves */
  PetscReal *inverse;           /* [1/kg] (stride, stride) between the first n_free rows */
  PetscReal *kept[BODY_VECTORS], *modes[BODY_VECTORS]; /* (stride,), (width,) */
  PetscReal *slots[SLOT_VECTORS];                      /* (n_slots,) */
  PetscBool known;                                     /* the vectors after the step belong to the velocities
                                                          of the state */
} CoupledBody;

struct _p_CoupledInertia {
  const Model *m;
  PetscInt n, capacity; /* points, and rows of allocated room */
  CoupledPoint *point;  /* (n,) ascending dof */
  PetscInt n_bodies;
  CoupledBody *body;   /* (n_bodies,) condensed bodies */
  PetscReal dt, alpha; /* [s], [1/s] for which the inverses were made; 0: none yet */
  PetscInt *row;       /* (n_bodies + n_deformable,) point of a rigid body or vertex, -1: none */
  Incoming in;         /* (2 n_deformable,) each; NULL: no points */
};

/* Returns the entries of a point in a vertex array of deformable vertices; rigid bodies have none. */
static inline const PetscReal *CoupledEntries(const CoupledInertia *l, const CoupledPoint *p,
                                              const PetscReal *of_vertices)
{
  static const PetscReal none[DOFS] = {0.};
  return p->rigid ? none : of_vertices + (p->dof - 3 * l->m->rigid.n);
}

/* Computes y = a x. Here and below n is the size of the point: where it is a constant, loops are unrolled. */
KERNEL void CoupledTimes(int n, const Square a, const PetscReal *x, PetscReal *y)
{
  for (int i = 0; i < n; i++) {
    y[i] = 0.;
    for (int j = 0; j < n; j++) y[i] += a[i][j] * x[j];
  }
}

KERNEL PetscReal CoupledProduct(int n, const PetscReal *x, const PetscReal *y)
{
  PetscReal sum = 0.;
  for (int i = 0; i < n; i++) sum += x[i] * y[i];
  return sum;
}

/* Books the works of the step from velocity v_0 to v_1 at a point. The work of moving supports on held added
   mass counts as theirs, and so does the work of forces beside dashpots. */
KERNEL void CoupledBookWork(const CoupledInertia *l, const CoupledPoint *p, int n, PetscReal dt,
                            const PetscReal *v_0, const PetscReal *v_1, PetscReal works[COUPLED_WORKS])
{
  const PetscReal *w = CoupledEntries(l, p, l->in.w), *push = CoupledEntries(l, p, l->in.push);
  PetscReal dashpot[DOFS] = {0.}, inertia[DOFS];
  CoupledTimes(n, p->mass, v_0, inertia);
  works[COUPLED_KINETIC] += 0.5 * CoupledProduct(n, v_1, inertia);
  if (p->damped) {
    const PetscReal *wave = CoupledEntries(l, p, l->in.wave);
    PetscReal mean[DOFS], less[DOFS], rest[DOFS], out[DOFS];
    for (int i = 0; i < n; i++)
      mean[i] = 0.5 * (v_0[i] + v_1[i]), less[i] = w[i] - mean[i], rest[i] = mean[i] - wave[i];
    CoupledTimes(n, p->dashpot, less, dashpot);
    CoupledTimes(n, p->dashpot, rest, out);
    works[COUPLED_INCOMING] += dt * (CoupledProduct(n, dashpot, mean) + CoupledProduct(n, rest, out));
  }
  if (p->held) {
    PetscReal change[DOFS];
    for (int i = 0; i < n; i++) change[i] = (v_1[i] - v_0[i]) / dt;
    CoupledTimes(n, p->mass, change, inertia);
  }
  for (int i = 0; i < n; i++) {
    const PetscBool held = (PetscBool)(p->held && Held(l->m, p->dof + i)); // its support carries the dashpot
    const PetscReal of_dashpot = held ? 0. : dashpot[i], of_support = held ? inertia[i] : push[i],
                    way = 0.5 * dt * (v_0[i] + v_1[i]), ahead = 0.5 * dt * v_1[i];
    works[COUPLED_DASHPOTS] += of_dashpot * way, works[COUPLED_DASHPOTS_AHEAD] += of_dashpot * ahead;
    works[COUPLED_SUPPORTS] += of_support * way, works[COUPLED_SUPPORTS_AHEAD] += of_support * ahead;
  }
}

/* ---- coupled_bodies.c */
/* Creates the condensed bodies, when the points are known. */
PetscErrorCode CoupledBodiesCreate(const TermView *view, const PetscReal *u_start, CoupledInertia *local);
PetscErrorCode CoupledBodiesDestroy(CoupledInertia *local);
PetscErrorCode CoupledBodiesInvert(CoupledInertia *local, const State *state);
/* Does the same for bodies as CoupledStep; CoupledBodiesHalfStep does the same as CoupledHalfStep. */
void CoupledBodiesStep(CoupledInertia *local, State *state, const PetscReal *v_before,
                       const PetscReal ground[2], PetscReal works[COUPLED_WORKS]);
PetscErrorCode CoupledBodiesHalfStep(CoupledInertia *local, State *state, const PetscReal *v_before,
                                     const PetscReal ground[2], PetscReal sign);
