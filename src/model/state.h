/* state.h: declares the state of a rank: what a step changes. */
#pragma once
#include "mesh/mesh.h"

/* The numbers of a state belong to Vecs on the model's communicator. A Vec has the n_dof entries of this
   rank's degrees of freedom. Behind them in the Vec's memory u, f, f_old and f_ext have those of the other
   vertices (see Model). The loop holds the arrays: u, v, f, f_old, f_ext and m point into the Vecs. Code
   that works on a Vec itself (a norm, a viewer, an operation of PETSc) calls StateGive first and StateTake
   afterwards. That tells PETSc that the numbers may have changed, so it drops the norms that it has kept. */

enum { SHARE_START, SHARE_TARGET, SHARE_NOW, SHARES };
/* The loads of a stage: f_ext = (1 - ramp) start + ramp target; applied.c. */
typedef struct {
  PetscReal *start, *target; /* [N, N m] applied force at the start of the ramp and at its end. target has the
                                forces at vertices of rigid bodies behind its dofs. In a dynamic stage with
                                water on faces start has the loads that keep their direction */
  PetscReal ramp;            /* [-] 0..1 */
  PetscInt n_loads;          /* of the scene where one is a temperature, else 0 */
  PetscReal *share[SHARES]; /* [-] (n_loads,) part of each load at the start of the ramp, at its end, and now:
                         blocks that expand need it beside their forces */
  PetscBool turn;           /* a rigid body has loads whose moment changes as the body turns */
} Applied;

/* State of each mode inside a condensed body; its modal mass is 1 kg. */
enum {
  MODE_PLACE, /* [m] distance from the equilibrium of the loads inside */
  MODE_SPEED, /* [m/s] at the half step */
  MODE_LOAD,  /* [N] loads inside for this equilibrium */
  MODE_ARRAYS
};

typedef struct {
  PetscReal *u;          /* [m, rad] (3 rigid.n + 2 (n_vertices + DUMMY_VERTICES),) displacement;
                            integrate.c, rigid.c, ghost.c, newton_step.c; at inner vertices condense.c */
  PetscReal *v;          /* [m/s, rad/s] (n_dof,) velocity at the half step; integrate.c */
  PetscReal *f;          /* [N, N m] resisting force; element.c, force.c, rigid.c, force terms */
  PetscReal *f_old;      /* [N, N m] resisting force of the last cycle (StateSwapForces); integrate.c clears
                            it */
  PetscBool f_old_clear; /* f_old is zero at all degrees of freedom */
  PetscReal *f_ext;      /* [N, N m] applied force. Kept vertices of condensed bodies also have the part that
                            they take over from inner vertices; applied.c, condense.c */
  PetscReal *passed;     /* [N, N m] (3 rigid.n + 2 n_owned,) f_ext plus this is the force that acts at a
                            kept vertex itself; NULL: no condensed bodies; condense.c, at the end of a
                            stage */
  PetscReal
      *nonlinear; /* [N] (3 rigid.n + 2 n_owned,) part of the forces of condensed blocks that is not linear
                            in u, at the last correction; NULL: small strain; condense_large.c */
  PetscReal *corrected; /* [m, rad] (3 rigid.n + 2 n_owned,) u at the last correction; NULL: small strain */
  PetscReal *m;         /* [kg, kg m2] (n_dof,) scaled mass (33)-(34), in time the true mass; masses.c */
  PetscReal *m_inv;     /* (n_dof,) 1/m, 0 where held */
  struct _p_StiffnessMass *stiffness_mass; /* mass of the present cycles instead of m (stiffness_mass.c);
                                              NULL: m is the mass */
  PetscInt capacity; /* numbers that u, f, f_old, f_ext and the arrays of applied have room for */
  PetscReal dt;      /* [s] 1 in a static stage: time is fictitious */
  PetscReal alpha;   /* [1/s] Rayleigh damping (38) */
  PetscReal beta;    /* [-] stiffness-proportional damping over dt, in static stages; friction_mode.c */
  PetscReal local;   /* [-] local non-viscous damping, in static stages; cycle.c */
  PetscReal *modes[MODE_ARRAYS]; /* (n_modes,) each: vibrations inside condensed bodies; condense_in_time.c */
  PetscReal *inertial;    /* [N] (n_dof,) resisting force that these vibrations add at kept vertices, at the
                            last check or recovery; not in f. NULL: no condensed bodies; condense_in_time.c */
  PetscInt lifts_stage;   /* the present stage: its groups are placed; lifts.c */
  PetscReal *reset;       /* [m, rad] as u: displacements that output counts from; NULL: from 0; lifts.c */
  PetscReal step_divisor; /* [-] factor by which the step of a static stage is shortened; energy_check.c */
  PetscInt64 cycle;       /* cycles since the start of the run */
  PetscReal time;         /* [s] since the start of the first dynamic stage */
  PetscReal *u_verified; /* (n_dof,) u at the last verification of contacts; NULL: never verified; verify.c */
  Applied applied;       /* the parts of f_ext */
  void **terms;          /* memory of each force term; terms.c */
  Vec displacement, velocity; /* (n_dof,) own the memory of u, v */
  Vec force, force_old;       /* own that of f, f_old, and change places with them */
  Vec load, mass;             /* own that of f_ext, m */
} State;

/* ---- state.c */
/* Returns the displacement [m, rad] that is written. */
static inline PetscReal Shown(const State *state, PetscInt d)
{
  return state->reset ? state->u[d] - state->reset[d] : state->u[d];
}
/* Gives the arrays back to the Vecs, which may then be read and changed; u, v, ... are NULL. */
PetscErrorCode StateGive(State *state);
/* Takes the arrays of the Vecs for the loop. */
PetscErrorCode StateTake(State *state);
/* Collective. Shows by PETSc's viewers the Vecs that the user's options name (-displacement_view and so
   on). */
PetscErrorCode StateView(State *state);
/* Makes the present force the force of the last cycle; the next force takes its memory. */
static inline void StateSwapForces(State *s)
{
  PetscReal *const f = s->f;
  const Vec force = s->force;
  s->f = s->f_old, s->f_old = f;
  s->force = s->force_old, s->force_old = force;
}
