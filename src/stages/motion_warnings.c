/* motion_warnings.c: warns, before the first step of a stage in time, of anything that makes its answer
   doubtful. */
#include "stages/stages.h"

/* Warns of the four models without a potential: they make or lose energy where contacts open and close. A
   contact pressed at one end alone carries its force by the row of its model: at c2/(c1 + c2) of its length
   from this end. */
static PetscErrorCode warn_models(const Problem *p)
{
  const Contacts *c = p->contacts;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (PetscInt i = c->model_start[STRESS_R2PT]; i < c->model_start[STRESS_TPTM]; i++) n += c->owned[i];
  for (PetscInt j = 0; j < p->scene->n_joints && ContactsVary(p->contacts, p->stage);
       j++) { // contacts that may come later
    const StressModelKind model = p->stage->joints[j].stress_model;
    n += p->stage->joints[j].k_n > 0. && model >= STRESS_R2PT && model < STRESS_TPTM;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPIU_INT, MPI_SUM, p->m->comm));
  if (n)
    PetscCall(
        WarnAll(p->m->comm,
                "stage %s: joints with stress model r2pt, r3pt, t2pt or t3pt create or "
                "destroy energy when they open and close, and pivot inside the base, a quarter, an "
                "eighth, a third or a sixth of a contact from its edge: a block on one contact rocks up "
                "to 3.7 times too slowly; use pt or tptm in dynamic stages",
                p->stage->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether blocks can slide on a joint that has no damping of its own. */
static PetscBool slides_undamped(const Joint *joint)
{
  return (PetscBool)(joint->k_n > 0. && joint->law != LAW_ELASTIC && !(joint->damping > 0.));
}

/* Warns of undamped sliding. Blocks that deform and slide on each other can flutter where nothing damps high
   frequencies: slip then does not converge with smaller steps. Rigid blocks on undamped joints vibrate for
   ever, and as the pressure swings the friction gives way again and again: a block of 6 x 4 m on a slope of
   25 degrees, friction 32, slides on at 0.06 m/s after the ground has stopped; with a damping of 1e-4 s it
   stops. */
static PetscErrorCode warn_undamped(const Problem *p)
{
  const Contacts *c = p->contacts;
  const Joint *joints = p->stage->joints;
  PetscInt first = PETSC_MAX_INT;
  PetscBool deforms = PETSC_FALSE, damped = PETSC_FALSE, rigid = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < p->scene->n_materials; g++) {
    const Material *material = p->scene->materials + g;
    rigid = (PetscBool)(rigid || material->rigid);
    deforms = (PetscBool)(deforms || !material->rigid);
    damped = (PetscBool)(damped || (!material->rigid && BetaOf(material, p->stage) > 0.));
  }
  if (damped) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->owned[i] && slides_undamped(joints + c->joint[i])) first = PetscMin(first, c->joint[i]);
  for (PetscInt j = 0; j < p->scene->n_joints && ContactsVary(p->contacts, p->stage);
       j++) // contacts that may come later
    if (slides_undamped(joints + j)) first = PetscMin(first, j);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPIU_INT, MPI_MIN, p->m->comm));
  if (first == PETSC_MAX_INT) PetscFunctionReturn(PETSC_SUCCESS);
  if (deforms)
    PetscCall(WarnAll(p->m->comm,
                      "stage %s: blocks that deform can slide on joint %s, and nothing damps "
                      "high frequencies: slip "
                      "can depend on the step then; give the stage a beta, or the joint a damping",
                      p->stage->name, p->scene->joints[first].name));
  else if (rigid)
    PetscCall(WarnAll(p->m->comm,
                      "stage %s: rigid blocks can slide on joint %s, whose vibrations nothing "
                      "damps: they can keep a block sliding after the shaking has ended; give the joint "
                      "a damping, such as joints.%s.damping: 1e-4",
                      p->stage->name, p->scene->joints[first].name, p->scene->joints[first].name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of blocks that a static stage has brought to rest in the middle of a record: the velocity of the
   ground hits them as an impact. */
static PetscErrorCode warn_midway(const Problem *p)
{
  const Stage *before = StageBefore(p->scene, p->scene->stages + p->number);
  const PetscReal t = p->state->time;
  const Support *worst = NULL;
  PetscReal fastest = 0.;
  PetscFunctionBeginUser;
  if (t <= 0. || p->result->cycles || (before && StageInTime(before))) PetscFunctionReturn(PETSC_SUCCESS);
  for (const Support *s = p->scene->supports; s < p->scene->supports + p->scene->n_supports; s++) {
    Motion motion;
    PetscReal v[2];
    if (!s->motion[0]) continue;
    PetscCall(MotionCreate(s, &motion));
    for (int k = 0; k < 2; k++) v[k] = GroundPart(s) * MotionVelocity(&motion, t, k);
    PetscCall(MotionDestroy(&motion));
    if (PetscHypotReal(v[0], v[1]) > fastest) fastest = PetscHypotReal(v[0], v[1]), worst = s;
  }
  if (fastest > 1e-3)
    PetscCall(WarnAll(p->m->comm,
                      "stage %s: it begins at t = %.6g s, in the middle of the motion of support "
                      "%s, which moves at %.3g m/s there, while the static stage before it has left the "
                      "blocks at rest: that velocity acts on them as an impact; shake them in one stage",
                      p->stage->name, (double)t, worst->name, (double)fastest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the hinge about which bodies turn over, and warns where it lies inside its edge (rocking.c). */
static PetscErrorCode warn_hinge(const Problem *p)
{
  const PetscReal least = 0.02;
  RockingHinge *hinge = &p->found->rocking;
  char what[160];
  PetscFunctionBeginUser;
  if (p->result->cycles) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RockingHingeFind(p, hinge));
  if (hinge->part < least) PetscFunctionReturn(PETSC_SUCCESS);
  const char *group = p->m->materials.names[p->found->bodies.group[hinge->body]];
  if (hinge->n > 1)
    PetscCall(PetscSNPrintf(what, sizeof(what),
                            "%" PetscInt_FMT " bodies stand on macroblock %" PetscInt_FMT
                            " (%s), itself included, and would turn over with it",
                            hinge->n, hinge->body, group));
  else
    PetscCall(PetscSNPrintf(what, sizeof(what), "macroblock %" PetscInt_FMT " (%s) would turn over",
                            hinge->body, group));
  PetscCall(WarnAll(
      p->m->comm,
      "stage %s: %s about the edge at (%.4g, %.4g) m: with tptm the hinge is pressed over a "
      "length, and %.2g of the arm of a rigid hinge is missing: it would overturn about that much earlier "
      "under a slow push, less under a blow; raise k_n, or use pt",
      p->stage->name, what, (double)hinge->point[0], (double)hinge->point[1], (double)hinge->part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MotionWarnings(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(warn_hinge(p));
  PetscCall(warn_models(p));
  PetscCall(warn_undamped(p));
  PetscCall(warn_midway(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}
