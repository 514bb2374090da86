/* boundary.h: supports and their motion. */
#pragma once
#include "forces/term/term.h"

/* ---- supports.c */
/* Collective. Writes model->support from the scene's supports. */
PetscErrorCode SupportsApply(const Scene *scene, Model *model);

/* ---- support_motion.c */
/* Supports that move in dynamic stages, as a force term. */
extern const TermKind Supports_term;
