/* newton.h: declares what the files of Newton's method share: memory, factor, one iteration, creep. */
#pragma once
#include "solve/solve.h"
#include "solve/nested.h"
#include "solve/stiffness.h"

struct _p_Newton {
  Stiffness stiffness;
  KSP elastic,
      worn;       /* flexible GMRES with the factor of K0; with the factor of a later tangent (NULL: none) */
  PC pc;          /* of elastic */
  Nested nested;  /* K0 and its factor for a solve every cycle, instead of all matrices; NULL: not used */
  PetscInt n_dof; /* degrees of freedom of all ranks */
  PetscInt last_solves; /* number of solves that the last iteration took */
  Vec r, du;            /* unbalanced force, correction */
  Vec dragged;          /* work array: added to the diagonal of the tangent */
  Vec u, u_base;        /* displacements at the last committed equilibrium; before the line search */
  Vec u_creep;          /* displacements where the step of creep began */
  PetscReal drag;       /* [1/cycle^2] drag of that step, with the force drag m (u - u_creep); 0: no creep */
  StageResult result;   /* result, effort and cycle: committed with u */
  Effort effort;
  PetscInt64 cycle;
  PetscReal *contact_scale; /* (n_dof,) |force of contacts| */
  const Problem *problem;   /* the problem that the running iteration works on */
  char progress[96];        /* name of that iteration, for lines of progress */
  PetscBool fails;          /* K0 has no factor */
  PetscBool wants;          /* the last factor failed for lack of memory */
  double memory[2];         /* [byte] expected size of the factor, and available memory */
  /* the contacts and joints that the factor belongs to */
  PetscInt n_padded, n_joints;
  PetscInt *vertex; /* (CONTACT_ROWS n_padded,) vertices of the contacts */
  PetscReal *k;     /* (n_joints, 2) k_n, k_s */
};

enum { NEWTON_MOST_SOLVES = 60 }; /* solves in one iteration */

/* All functions below but NewtonSpent are collective. Their `newton` is p->relax->newton. */

/* ---- newton.c */
/* Provides K0 and its factor for the contacts and joints of the stage. every_cycle: newton->nested, for a
   solve every cycle. works: FALSE: there is no memory for the factor, or K0 has none. */
PetscErrorCode NewtonFactor(const Problem *p, PetscBool every_cycle, PetscBool *works);

/* ---- factor.c */
/* Makes *ksp flexible GMRES, preconditioned with a factor of the present tangent; the factor stays when the
   tangent changes. fails: the tangent has no factor; newton->wants: for lack of memory. */
PetscErrorCode Factorise(const Problem *p, PCType type, MatSolverType package, KSP *ksp, PetscBool *fails);
/* Assembles K0 into newton->stiffness.tangent. */
PetscErrorCode AssembleElastic(const Problem *p);
/* Makes newton->elastic with the factor of K0, the stiffness of the undeformed scene with elastic joints; or
   sets newton->fails. */
PetscErrorCode FactorElastic(const Problem *p);
/* Does the same for newton->nested, which serves a solve every cycle. */
PetscErrorCode FactorNested(const Problem *p);
/* Warns once a stage that there is no memory for the factor, and notes that for the evidence. memory: as from
   NewtonFits. */
PetscErrorCode FactorWants(const Problem *p, const double memory[2]);

/* ---- newton_step.c */
/* Copies the present displacements into u. */
PetscErrorCode NewtonKeep(const Problem *p, Vec u);
/* Makes u the present displacements, on all ranks that read them. */
PetscErrorCode NewtonMove(const Problem *p, Vec u);
/* Evaluates forces at u_base + part du (du NULL: at the present u) from the committed history. Sets
   newton->r to the unbalanced force less the drag, and norm [N] to its norm. */
PetscErrorCode NewtonEvaluate(const Problem *p, PetscReal part, Vec du, PetscReal *norm);
/* Returns whether the work since the last equilibrium, or of the stage (relax->most_work), has reached its
   limit. The answer is the same on all ranks. */
PetscBool NewtonSpent(const Problem *p);
/* Does one iteration: the correction by the present tangent, to a relative residual `tolerance`, and the
   line search along it. norm [N]: norm of newton->r, before and after. */
PetscErrorCode NewtonIterate(const Problem *p, PetscReal tolerance, PetscReal *norm);
/* Drops the factor of a later tangent. */
PetscErrorCode NewtonFresh(const Problem *p);
/* Computes omega^2 [1/cycle^2] of the elastic answer du to newton->r: du.K0 du / du.m du = du.r / du.m du;
   0 where r is zero. */
PetscErrorCode NewtonElasticFrequency(const Problem *p, PetscReal *omega_2);

/* ---- creep.c */
/* Creeps from the last equilibrium, under the loads applied, to an equilibrium (found) or to the verdict
   "collapsed". Where it reaches neither, nothing is known, and the displacements are somewhere between. stop:
   a signal or the limit of wall time has ended it. */
PetscErrorCode NewtonCreep(const Problem *p, PetscBool *found, PetscBool *stop);
