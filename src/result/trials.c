/* trials.c: finds what the trials of a strength reduction, a flood, a load factor or a search for the force
   of anchors say together: the factors of joints, and the joints that move in the mechanism. */
#include "result/result.h"
#include <math.h>

/* ---- mechanism */

static const PetscReal TAKES_PART = 0.05; /* [-] of the fastest joint: slower joints only follow the others */

PetscBool MechanismHas(const Scene *scene, const Trials *trials, PetscInt joint, enum JointMotion motion)
{
  PetscReal most = 0.;
  if (!trials->joint_motion) return PETSC_FALSE;
  for (PetscInt j = 0; j < 2 * scene->n_joints; j++) most = PetscMax(most, trials->joint_motion[j]);
  return (PetscBool)(trials->joint_motion[2 * joint + (PetscInt)motion] > TAKES_PART * most);
}

PetscErrorCode TrialsReset(Trials *trials)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(trials->mechanism));
  PetscCall(PetscFree(trials->joint_motion));
  PetscCall(PetscFree(trials->joints));
  for (PetscInt c = 0; c < trials->loads.n_columns; c++)
    PetscCall(PetscFree(trials->loads.columns[c].values));
  *trials = (Trials){.n = 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- factors of a reduction of friction

   A trial leaves every joint an angle of at most its value, so each joint has a factor of its own. The factor
   of the stage is the factor of the joints that slide in the mechanism: a joint that stands still, or one
   that is open, has no part in the limit. Where these joints had different angles, friction has no single
   factor. Before anything fails all joints that are reduced count. */

/* Returns the factor by which a trial at `value` [degree] reduces the friction of a joint; value NaN: NaN. */
static PetscReal joint_factor(const Joint *joint, PetscReal value)
{
  Joint reduced = *joint;
  if (PetscIsNanReal(value)) return NAN;
  JointCapFriction(&reduced, value);
  return joint->tan_phi[0] / reduced.tan_phi[0];
}

/* Decides whether two joints have the same angles of friction, or one joint before and after it has
   failed. */
static PetscBool one_angle(const Joint *a, const Joint *b)
{
  const PetscReal far = PetscMax(PetscAbsReal(a->friction[0] - b->friction[0]),
                                 PetscAbsReal(a->friction[0] - b->friction[1]));
  return (PetscBool)(far < 1e-9);
}

PetscErrorCode TrialsFactors(const Problem *p, const Joint *full, const PetscInt *has)
{
  Trials *t = &p->found->trials;
  PetscBool slides = PETSC_FALSE, alike = PETSC_TRUE;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(p->scene->n_joints, &t->joints));
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    t->joints[j] = (JointFactor){full[j].friction[0], joint_factor(full + j, t->stable),
                                 joint_factor(full + j, t->failing),
                                 (PetscBool)(has[j] && full[j].friction[0] > 0.)};
    slides = (PetscBool)(slides || (t->joints[j].reduced && MechanismHas(p->scene, t, j, JOINT_SLIDES)));
  }
  t->one = -1;
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    if (!t->joints[j].reduced || (slides && !MechanismHas(p->scene, t, j, JOINT_SLIDES))) continue;
    if (t->one < 0) t->one = j;
    alike = (PetscBool)(alike && one_angle(full + t->one, full + j));
  }
  if (!alike) t->one = -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Describes the coefficients of the first pseudo-static load that is raised. */
static void describe_coefficient(const Problem *p, size_t size, char *text)
{
  const Trials *t = &p->found->trials;
  for (PetscInt i = 0; i < p->stage->n_rises; i++) {
    const Load *load = p->scene->loads + p->stage->rises[i];
    if (load->kind != LOAD_PSEUDO_STATIC || PetscIsNanReal(t->failing)) continue;
    const int x = load->coefficient[0] == 0.;
    const double k = (double)load->coefficient[x];
    snprintf(text, size, "; k_%c of %s %.6g to %.6g", x ? 'v' : 'h', load->name, k * (double)t->stable,
             k * (double)t->failing);
    return;
  }
}

/* Describes the two forces between which each anchor is needed, as far as the text has room. */
static void describe_forces(const Problem *p, size_t size, char *text)
{
  const Trials *t = &p->found->trials;
  for (PetscInt i = 0; i < p->stage->n_anchors; i++) {
    const Anchor *a = AnchorNamed(p->scene, p->stage->anchors[i]);
    const double full = 1e-3 * (double)AnchorPrestress(p->scene, p->stage, a);
    const size_t used = strlen(text);
    char more[LABEL_LENGTH];
    if (PetscIsNanReal(t->failing))
      snprintf(more, sizeof(more), "; %s needs no more than %.6g kN", a->entry.name,
               full * (double)t->stable);
    else
      snprintf(more, sizeof(more), "; %s needs %.6g to %.6g kN", a->entry.name, full * (double)t->failing,
               full * (double)t->stable);
    if (used + strlen(more) < size) snprintf(text + used, size - used, "%s", more);
  }
}

void TrialsReport(const Problem *p, size_t size, char *text)
{
  const Trials *t = &p->found->trials;
  text[0] = '\0';
  if (p->stage->kind == STAGE_LOAD_FACTOR) describe_coefficient(p, size, text);
  if (p->stage->kind == STAGE_ANCHOR_FORCE) describe_forces(p, size, text);
  if (!t->joints || PetscIsNanReal(t->failing)) return;
  if (t->one < 0)
    snprintf(text, size,
             "; no single factor: the joints that slide had different angles, use what: strengths");
  else
    snprintf(text, size, "; factor %.4g to %.4g", t->joints[t->one].stable, t->joints[t->one].failing);
}
