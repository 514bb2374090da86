/* newton.h: what newton.c and creep.c share: the state of Newton's method and one iteration of it. */
#pragma once
#include "solve/solve.h"
#include "solve/stiffness.h"

struct _p_Newton {
  Stiffness stiffness;
  KSP elastic, worn;    /* flexible GMRES with the factor of K0; with that of a later tangent, NULL: none */
  PC pc;                /* of elastic */
  PetscInt n_dof;       /* of all ranks */
  PetscInt last_solves; /* that the last iteration took */
  Vec r, du;            /* unbalanced force, correction */
  Vec dragged;          /* drag times masses */
  Vec u, u_base;        /* displacements at the last committed equilibrium; before the line search */
  Vec u_creep;          /* where the step of creep began */
  PetscReal drag;       /* [1/cycle^2] of that step, the force is drag m (u - u_creep); 0: none, no creep */
  StageResult result;   /* committed with u, and so are effort and cycle */
  Effort effort;
  PetscInt64 cycle;
  PetscReal *contact_scale; /* (n_dof,) |force of contacts| */
  const Problem *problem;   /* of the iteration at work */
  char told[96];            /* where that is, for lines of progress */
  PetscBool fails;          /* K0 has no factor */
  PetscBool wants;          /* the last factor failed for want of memory */
  double memory[2];         /* [byte] that the factor was foreseen to take, and that there were */
  /* what the factor belongs to */
  PetscInt n_padded, n_joints;
  PetscInt *vertex; /* (6 n_padded,) of the contacts */
  PetscReal *k;     /* (n_joints, 2) k_n, k_s */
};

enum { NEWTON_MOST_SOLVES = 60 }; /* in one iteration */

/* ---- factor.c. Collective, all of them; newton is p->relax->newton. */
/* Flexible GMRES preconditioned with a factor of the tangent as it is now, which is then kept. fails: it has
   none; newton->wants: for want of memory. */
PetscErrorCode Factorise(const Problem *p, PCType type, MatSolverType package, KSP *ksp, PetscBool *fails);
/* newton->elastic: the factor of K0, of the undeformed scene with elastic joints; or newton->fails. */
PetscErrorCode FactorElastic(const Problem *p);
/* Says, once a stage, and keeps for its evidence that there is no memory for the factor; memory: of
   NewtonFits. */
PetscErrorCode FactorWants(const Problem *p, const double memory[2]);

/* ---- newton.c. Likewise. */
/* The present displacements, into u. */
PetscErrorCode NewtonKeep(const Problem *p, Vec u);
/* Displacements u become the present ones, on all ranks that read them. */
PetscErrorCode NewtonMove(const Problem *p, Vec u);
/* Forces at u_base + part du (du NULL: at the present u) from the committed history; newton->r: the
   unbalanced force less the drag, and its norm [N]. */
PetscErrorCode NewtonEvaluate(const Problem *p, PetscReal part, Vec du, PetscReal *norm);
/* Whether the way from the last equilibrium, or this stage (relax->most_work), has taken the work it may,
   alike on all ranks. */
PetscBool NewtonSpent(const Problem *p);
/* One iteration: the correction from the present tangent, to a relative residual `tolerance`, and the way
   along it. norm: of newton->r, before and after. */
PetscErrorCode NewtonIterate(const Problem *p, PetscReal tolerance, PetscReal *norm);
/* Forgets the factor of a later tangent. */
PetscErrorCode NewtonFresh(const Problem *p);
/* omega^2 [1/cycle^2] of the elastic answer du to newton->r: du.K0 du / du.m du = du.r / du.m du; 0: r is. */
PetscErrorCode NewtonElasticFrequency(const Problem *p, PetscReal *omega_2);

/* ---- creep.c */
/* Collective. From the last equilibrium, under the loads applied, to an equilibrium (found) or to
   the verdict "collapsed"; neither: nothing is known, and displacements are somewhere on the way.
   stop: as in newton.c. */
PetscErrorCode NewtonCreep(const Problem *p, PetscBool *found, PetscBool *stop);
