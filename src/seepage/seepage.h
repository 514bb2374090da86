/* seepage.h: declares water that flows in joints, and open joints that no water reaches. */
#pragma once
#include "water/water.h"

/* Rows of the table of force terms. */
extern const TermKind Flow_term, Dry_term;

/* Complete the keys of loads, see reader.h. */
LoadCompletion CompleteDrain, CompleteCurtain;

/* Returns whether the stage is a trial of the flow: until water and openings agree, opening and slip of a
   round are not committed. Otherwise the answer would depend on the number of rounds. */
PetscBool FlowIsTrial(const TermView *v);
/* Collective. Ends a time step of the water, and checks its volume error: the stage goes on unless `result`
   gets another verdict. grow receives the factor [-] by which the next step may be longer; it stays where
   no water flows. v: of Flow_term. */
PetscErrorCode FlowStepDone(const TermView *v, StageResult *result, PetscReal *grow);
