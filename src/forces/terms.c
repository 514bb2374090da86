/* terms.c: the table of force terms, and the walks over it. */
#include "forces/forces.h"

/* In the order in which their resisting forces are summed at a vertex: another order changes bits. */
static const TermKind *const Terms[] = {&Loads_term, &Reservoir_term, &Uplift_term, &Condensed_term};
enum { TERMS = sizeof(Terms) / sizeof(Terms[0]) };

/* Calls row->FUNCTION(&v, ...) of every row that has it. */
#define EACH(FUNCTION, ...)                                                                                  \
  for (int t = 0; t < TERMS; t++) {                                                                          \
    v.memory = state->terms[t];                                                                              \
    if (Terms[t]->FUNCTION) PetscCall(Terms[t]->FUNCTION(__VA_ARGS__));                                      \
  }

PetscErrorCode TermsCreate(const Scene *scene, const Model *m, const Contacts *contacts, State *state)
{
  const TermView v = {.scene = scene, .m = m, .contacts = contacts, .state = state};
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(TERMS, &state->terms));
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->create) PetscCall(Terms[t]->create(&v, state->terms + t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsDestroy(const Scene *scene, State *state)
{
  PetscFunctionBeginUser;
  for (int t = 0; t < TERMS && state->terms; t++)
    if (Terms[t]->destroy) PetscCall(Terms[t]->destroy(scene, state->terms + t));
  PetscCall(PetscFree(state->terms));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- each evaluation */

void TermsForces(const Model *m, const State *state, const PetscReal *u, PetscReal *f)
{
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->forces) Terms[t]->forces(state->terms[t], m, u, f);
}

void TermsBound(const Model *m, const State *state, PetscReal *k)
{
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->bound) Terms[t]->bound(state->terms[t], m, k);
}

PetscReal TermsEnergy(const Model *m, const State *state, const PetscReal *u)
{
  PetscReal sum = 0.;
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->energy) sum += Terms[t]->energy(state->terms[t], m, u);
  return sum;
}

PetscErrorCode TermsTangent(const Model *m, const State *state, const PetscReal *u, TermAdd add,
                            void *context)
{
  PetscFunctionBeginUser;
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->tangent) PetscCall(Terms[t]->tangent(state->terms[t], m, u, add, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- loads */

static int term_of(LoadKind kind)
{
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->loads & 1u << kind) return t;
  return -1;
}

PetscBool TermPresses(const Scene *scene, const Load *load)
{
  const int t = term_of(load->kind);
  return (PetscBool)(t >= 0 && Terms[t]->presses && scene->strain == STRAIN_LARGE);
}

PetscErrorCode TermApplied(const Scene *scene, const Model *m, const Stage *stage, const State *state,
                           PetscInt load, PetscReal *f)
{
  const int t = term_of(scene->loads[load].kind);
  PetscFunctionBeginUser;
  PetscCheck(t >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "no force term has loads of kind %d",
             (int)scene->loads[load].kind);
  const TermView v = {.scene = scene, .stage = stage, .m = m, .state = state, .memory = state->terms[t]};
  PetscCall(Terms[t]->applied(&v, load, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- stages */

PetscErrorCode TermsBegin(const Scene *scene, const Stage *stage, const Model *m, const Contacts *contacts,
                          const State *state)
{
  TermView v = {.scene = scene, .stage = stage, .m = m, .contacts = contacts, .state = state};
  PetscFunctionBeginUser;
  EACH(begin, &v);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsSettle(const Scene *scene, const Stage *stage, const Model *m, const Contacts *contacts,
                           const State *state, StageResult *result, PetscBool *again)
{
  TermView v = {.scene = scene, .stage = stage, .m = m, .contacts = contacts, .state = state};
  PetscFunctionBeginUser;
  *again = PETSC_FALSE;
  for (int t = 0; t < TERMS; t++) {
    const Verdict before = result->verdict;
    PetscBool one = PETSC_FALSE;
    if (!Terms[t]->settle) continue;
    v.memory = state->terms[t];
    PetscCall(Terms[t]->settle(&v, result, &one));
    *again = (PetscBool)(*again || one);
    if (result->verdict == before) continue;
    *again = PETSC_FALSE; // it has ended the stage
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsSurvey(const Scene *scene, const Stage *stage, const Model *m, const Contacts *contacts,
                           const State *state, PetscBool tell)
{
  TermView v = {.scene = scene, .stage = stage, .m = m, .contacts = contacts, .state = state};
  PetscFunctionBeginUser;
  EACH(survey, &v, tell);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void TermsHistory(const Scene *scene, const State *state, TermHistory what)
{
  TermView v = {.scene = scene, .state = state};
  for (int t = 0; t < TERMS; t++) {
    v.memory = state->terms[t];
    if (Terms[t]->history) Terms[t]->history(&v, what);
  }
}

/* ---- memory and answers */

PetscErrorCode TermsArchive(Archive *a, const Scene *scene, const Model *m, const State *state)
{
  TermView v = {.scene = scene, .m = m, .state = state};
  PetscFunctionBeginUser;
  EACH(archive, a, &v);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsArchiveStable(Archive *a, const Scene *scene, const Model *m, const State *state)
{
  TermView v = {.scene = scene, .m = m, .state = state};
  PetscFunctionBeginUser;
  EACH(archive_stable, a, &v);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void TermsSummary(FILE *f, const Scene *scene, const Stage *stage, const Model *m, const State *state)
{
  TermView v = {.scene = scene, .stage = stage, .m = m, .state = state};
  for (int t = 0; t < TERMS; t++) {
    v.memory = state->terms[t];
    if (Terms[t]->summary) Terms[t]->summary(f, &v);
  }
}
