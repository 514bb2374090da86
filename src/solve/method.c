/* method.c: chooses the method by which a stage finds its equilibrium (relaxation.method: auto), and when
   Newton's method hands over to explicit cycles. Every bound is from a measurement: docs/performance.md,
   "Which method a stage takes". */
#include "solve/solve.h"

/* A static stage with fewer degrees of freedom takes a tenth of a second of explicit cycles, and their bits
   do not depend on the number of ranks. A stage of trials relaxes some twenty times. */
enum { STATIC_DOFS = 2000, TRIALS_DOFS = 400 };
/* Where more bodies than this can slip, Newton's method often finds no end. */
enum { FEW_BODIES = 50 };
/* Numbers of rigid stones between which cycles with the stiffness as mass pay in a static stage: with 597,
   601, 2003 and 7776 they took a third to two thirds of the time, with 150 and 17 299 as long
   (docs/performance.md, "Many stones that slide"). */
enum { MANY_STONES = 500, MOST_STONES = 8000 };
/* Largest number of degrees of freedom of deformable stones with the stiffness as mass, in a strength
   reduction or where explicit cycles creep: what the dams had on which that was measured
   (docs/performance.md, "Stones for which auto takes stiffness_mass", "Explicit cycles that creep"). */
enum { MOST_DOFS = 24000 };
/* Number of elastic stones of rubble (RUBBLE_ORDER, thresholds.h) from which cycles with the stiffness as
   mass pay up to their first stall, and their most degrees of freedom: 7776 stones have 87 000, and took 0.6
   of the time. Walls of courses took 1.4 times as long so (docs/performance.md, "Rubble of elastic stones"). */
enum { LEAST_ELASTIC = 200, MOST_RUBBLE_DOFS = 90000 };
/* Numbers of stones, rigid or not, from which these cycles pay in trials: in strength reductions, in rubble
   also where a load is raised; and in a chain (an arch, a column) in both. Explicit cycles grow with the
   length of a chain, solves do not. A static stage of an arch that falls ends as diverged by them, where
   explicit cycles find the stones that fall. Measurements: docs/performance.md, "Stones for which auto takes
   stiffness_mass". */
enum { STONES_REDUCED = 50, CHAIN = 20 };
/* Number of times that Newton's method may hand over in a stage, or that blocks may jump by cycles with the
   stiffness as mass. A trial in which these find no end counts twice: it has taken as long as explicit
   cycles. The trials after that do without the method. */
enum { MOST_GIVEN_UP = 2 };
/* [periods of the slowest elastic motion] time that explicit cycles take after the ramp: in a static stage 4
   to 8 where little slips, 10 to 25 where much does; in a trial near its limit 60 to 300. */
static const PetscReal PERIODS_STATIC = 10., PERIODS_TRIAL = 100.;
/* [explicit cycles] cost of a solve, with its share of the tangent: at THIS_SIZE degrees of freedom, and its
   growth when they double. */
static const PetscReal SOLVE = 12., SOLVE_GROWS = 3.6, SOLVE_LEAST = 10., THIS_SIZE = 1500.;

/* Adds up the blocks of this rank that can yield. n: [0] those that crack, [1] all others. */
static void count_yielding(const Model *m, PetscInt64 n[2])
{
  for (const Elements *e = m->mesh.elements + ELASTIC_LISTS; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    n[e->law != MATERIAL_DAMAGE] += e->n;
}

/* The worst of the joints with contacts, in ascending order: one that loses strength or is crushed (the order
   in which such joints fail decides the answer), one whose strength falls as it opens. */
typedef enum { JOINTS_LAST, JOINTS_BREAK, JOINTS_SOFTEN } Worst;

/* Decides whether a joint loses strength or is crushed. */
static PetscBool breaks(const Joint *joint)
{
  const PetscBool weakens = (PetscBool)(joint->cohesion[0] > joint->cohesion[1] ||
                                        joint->tension[0] > joint->tension[1] ||
                                        joint->friction[0] > joint->friction[1]);
  return (PetscBool)(joint->law != LAW_ELASTIC && (weakens || joint->compression < PETSC_INFINITY));
}

/* Counts the bodies at contacts that can slip or open. A contact can if its joint has a strength, or if its
   faces met in motion and were never bonded. In a strength reduction only the joints that it reduces count as
   breaking: its trials bring them to that. */
static PetscErrorCode count_bodies(const Model *m, const Contacts *c, const Stage *stage, PetscInt64 *n,
                                   PetscInt64 *contacts, Worst *worst)
{
  const Joint *joints = stage->joints;
  PetscInt *at, most = JOINTS_LAST;
  PetscFunctionBeginUser;
  *n = *contacts = 0;
  PetscCall(PetscCalloc1(m->mesh.n_bodies_global, &at));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0) continue;
    if (joints[c->joint[i]].law == LAW_ELASTIC && !(c->broken[SUB(i, 0)] > 0. || c->broken[SUB(i, 1)] > 0.))
      continue;
    *contacts += c->owned[i] != 0; // ranks at whose border it lies both have it
    if (JointSoftens(joints + c->joint[i]))
      most = JOINTS_SOFTEN;
    else if ((stage->kind != STAGE_STRENGTH_REDUCTION || JointIsReduced(stage, joints + c->joint[i])) &&
             breaks(joints + c->joint[i]))
      most = PetscMax(most, (PetscInt)JOINTS_BREAK);
    for (int k = 0; k < CONTACT_ROWS; k++) at[m->mesh.vertex_body[c->vertex[CONTACT_ROW(i, k)]]] = 1;
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, at, (PetscMPIInt)m->mesh.n_bodies_global, MPIU_INT, MPI_MAX, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_INT, MPI_MAX, m->comm));
  *worst = (Worst)most;
  for (PetscInt b = 0; b < m->mesh.n_bodies_global; b++) *n += at[b];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, contacts, 1, MPIU_INT64, MPI_SUM, m->comm));
  PetscCall(PetscFree(at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the scene has nothing for which cycles with the stiffness as mass have not been measured:
   anchors, joints that are crushed or whose stress model has no potential, damping that is not adaptive. */
static PetscBool measured(const Scene *scene, const Stage *stage)
{
  PetscInt n_anchors;
  SceneEntries(scene, "anchors", &n_anchors);
  if (n_anchors || scene->damping != DAMPING_ADAPTIVE) return PETSC_FALSE;
  for (const Joint *j = stage->joints; j < stage->joints + scene->n_joints; j++)
    if (j->defined && (j->compression < PETSC_INFINITY ||
                       (j->stress_model >= STRESS_R2PT && j->stress_model < STRESS_TPTM)))
      return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns whether, further, no joint has cohesion or tension. */
static PetscBool friction_alone(const Scene *scene, const Stage *stage)
{
  for (const Joint *j = stage->joints; j < stage->joints + scene->n_joints; j++)
    if (j->defined && (j->cohesion[0] > 0. || j->tension[0] > 0.)) return PETSC_FALSE;
  return measured(scene, stage);
}

/* Returns whether the stones were found to be rubble. */
static PetscBool is_rubble(const MethodChoice *c)
{
  return (PetscBool)(c->order > 0. && c->order < RUBBLE_ORDER);
}

/* Returns whether cycles with the stiffness as mass pay: for many stones with friction alone, in a strength
   reduction, in rubble also where a load is raised, and, where all are rigid, in a static stage. stones:
   rigid ones. chain: no joint closes a ring of stones; there it pays also where a load is raised, and where
   joints have cohesion or tension. Walls of courses gain nothing where a load is raised. */
static PetscBool stiffness_mass_pays(const Scene *scene, const Stage *stage, PetscInt64 stones,
                                     PetscBool rigid, PetscBool chain, const MethodChoice *c)
{
  if (rigid ? stones > MOST_STONES : c->dofs > MOST_DOFS) return PETSC_FALSE;
  if (stage->kind != STAGE_STRENGTH_REDUCTION && !(rigid && stage->kind == STAGE_STATIC) &&
      !((chain || is_rubble(c)) && stage->kind == STAGE_LOAD_FACTOR))
    return PETSC_FALSE;
  return chain ? measured(scene, stage) : friction_alone(scene, stage);
}

/* Returns whether cycles with the stiffness as mass pay where blocks crack. Explicit cycles need a ramp of
   periods of the slowest motion there. */
static PetscBool cracks_pay(const Scene *scene, const Stage *stage, const MethodChoice *c)
{
  return (PetscBool)(c->bodies <= FEW_BODIES && c->dofs <= MOST_DOFS && friction_alone(scene, stage));
}

/* Returns whether the order of the stones decides: in a static stage of stones that deform on cycles with the
   stiffness as mass up to the first stall, where a load is raised on such cycles for all trials. */
static PetscBool order_decides(const Scene *scene, const Stage *stage, PetscInt64 stones,
                               const MethodChoice *c)
{
  if (!friction_alone(scene, stage)) return PETSC_FALSE;
  if (stage->kind == STAGE_LOAD_FACTOR) return (PetscBool)(c->bodies >= STONES_REDUCED);
  return (PetscBool)(stage->kind == STAGE_STATIC && c->dofs > 3 * stones && c->dofs <= MOST_RUBBLE_DOFS &&
                     c->bodies >= LEAST_ELASTIC);
}

/* Chooses the method for relaxation.method: auto, and stores the reason. */
static MethodKind choose(const Scene *scene, const Stage *stage, PetscInt64 stones, PetscBool chain,
                         PetscBool vary, const PetscInt64 yielding[2], Worst joints, MethodChoice *c)
{
  const PetscBool trials = (PetscBool)(stage->kind != STAGE_STATIC),
                  ramped = (PetscBool)(trials && stage->kind != STAGE_STRENGTH_REDUCTION && stage->ramp > 0);
  const PetscBool rigid = (PetscBool)(c->dofs <= 3 * stones);
  const PetscInt64 many = !trials ? MANY_STONES : chain ? CHAIN : STONES_REDUCED;
  c->limit = trials ? TRIALS_DOFS : STATIC_DOFS;
  if (stage->kind == STAGE_PUSHOVER)
    c->reason = CHOICE_PUSHED;
  else if (vary)
    c->reason = CHOICE_VARIABLE;
  else if (scene->damping != DAMPING_ADAPTIVE)
    c->reason = CHOICE_DAMPING;
  else if (stage->kind == STAGE_TRANSIENT)
    c->reason = CHOICE_WATER;
  else if (yielding[0] && !yielding[1] && cracks_pay(scene, stage, c)) {
    c->reason = CHOICE_CRACKS, c->limit = FEW_BODIES;
    return METHOD_STIFFNESS_MASS;
  } else if (yielding[0] + yielding[1])
    c->reason = CHOICE_YIELDS;
  else if (c->bodies >= many && stiffness_mass_pays(scene, stage, stones, rigid, chain, c)) {
    c->reason = CHOICE_MANY_STONES, c->limit = many;
    if (2 * c->left[LEFT_ENDLESS] + c->left[LEFT_JUMPED] < MOST_GIVEN_UP) return METHOD_STIFFNESS_MASS;
    c->reason = CHOICE_LEFT;
  } else if (joints == JOINTS_LAST && !trials && is_rubble(c)) {
    c->reason = CHOICE_RUBBLE, c->limit = LEAST_ELASTIC;
    return METHOD_STIFFNESS_MASS;
  } else if (c->dofs < c->limit)
    c->reason = CHOICE_SMALL;
  else if (joints == JOINTS_SOFTEN || (joints == JOINTS_BREAK && !ramped)) // a ramp breaks them one by one
    c->reason = CHOICE_BREAKS;
  else if (c->given_up >= MOST_GIVEN_UP)
    c->reason = CHOICE_HANDED_OVER;
  else if (c->bodies > FEW_BODIES) {
    c->reason = CHOICE_MANY_BODIES, c->limit = FEW_BODIES;
    return METHOD_EXPLICIT;
  } else {
    c->reason = c->bodies ? CHOICE_FEW_BODIES : CHOICE_ELASTIC, c->limit = FEW_BODIES;
    return METHOD_PRECONDITIONED;
  }
  return METHOD_EXPLICIT;
}

PetscErrorCode StageMethod(const Scene *scene, const Model *m, const Contacts *contacts, const Stage *stage,
                           MethodKind *method, MethodChoice *choice)
{
  // a body that the program has condensed by itself is as large as its blocks
  const PetscInt inner = m->condensed.chosen && !m->rank ? m->condensed.dofs[1] : 0;
  PetscInt64 sum[4] = {m->n_dof + inner, m->rigid.n}, n_contacts;
  Worst worst = JOINTS_LAST;
  PetscFunctionBeginUser;
  *method = scene->method;
  choice->reason = CHOICE_GIVEN;
  if (*method == METHOD_AUTO) {
    count_yielding(m, sum + 2);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 4, MPIU_INT64, MPI_SUM, m->comm));
    PetscCall(count_bodies(m, contacts, stage, &choice->bodies, &n_contacts, &worst));
    choice->dofs = sum[0];
    if (order_decides(scene, stage, sum[1], choice)) PetscCall(ContactsOrder(m, contacts, &choice->order));
    *method = choose(scene, stage, sum[1], (PetscBool)(n_contacts < choice->bodies),
                     ContactsVary(contacts, stage), sum + 2, worst, choice);
  }
  if (stage->kind == STAGE_PUSHOVER) *method = METHOD_EXPLICIT;
  // Newton's method keeps its contacts; local damping opposes each degree of freedom on its own
  if (*method == METHOD_STIFFNESS_MASS ? scene->damping == DAMPING_LOCAL : ContactsVary(contacts, stage))
    *method = METHOD_EXPLICIT;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the cost of one unit of EffortWork in explicit cycles. */
static PetscReal cycles_of_a_solve(PetscReal n_dof)
{
  return PetscMax(SOLVE_LEAST, SOLVE + SOLVE_GROWS * PetscLog2Real(n_dof / THIS_SIZE));
}

/* Returns the work of Newton's method in this static stage or trial [explicit cycles]. */
static PetscReal work_so_far(const Problem *p)
{
  const Relaxation *r = p->relax;
  return (EffortWork(&r->effort) - r->work_before) * cycles_of_a_solve((PetscReal)r->effort.choice.dofs);
}

PetscBool MethodSpent(const Problem *p)
{
  const PetscReal alpha = p->relax->evidence.settled_alpha; // twice the lowest frequency
  const PetscReal periods = p->stage->kind == STAGE_STATIC ? PERIODS_STATIC : PERIODS_TRIAL;
  if (p->relax->effort.choice.reason == CHOICE_GIVEN || !(alpha > 0.)) return PETSC_FALSE;
  return (PetscBool)(work_so_far(p) > (PetscReal)p->stage->ramp + periods * 4. * PETSC_PI / alpha);
}

PetscBool MethodCreeps(const Problem *p)
{
  const Relaxation *r = p->relax;
  const MethodChoice *c = &r->effort.choice;
  if (p->result->verdict != VERDICT_NONE || p->contacts->friction != FRICTION_SPRINGS) return PETSC_FALSE;
  if (p->state->stiffness_mass || r->begun || c->crept < 0) return PETSC_FALSE; // once
  if (c->reason != CHOICE_MANY_BODIES && c->reason != CHOICE_SMALL && c->reason != CHOICE_RUBBLE)
    return PETSC_FALSE;
  return (PetscBool)(p->stage->kind == STAGE_STATIC && c->bodies > FEW_BODIES && c->dofs <= MOST_DOFS &&
                     friction_alone(p->scene, p->stage));
}

PetscBool MethodStalls(const Problem *p)
{
  return (PetscBool)(p->relax->effort.choice.reason == CHOICE_RUBBLE && p->state->stiffness_mass &&
                     p->result->verdict == VERDICT_NONE && p->contacts->friction == FRICTION_PULLED &&
                     p->relax->follow.stalls > 0);
}

void MethodHandsOver(const Problem *p)
{
  MethodChoice *c = &p->relax->effort.choice;
  if (c->reason == CHOICE_GIVEN) return;
  c->given_up++, c->spent = p->relax->effort.preconditioned ? (PetscInt64)work_so_far(p) : 0;
}
