/* ground.c: computes the motion of the ground as a whole, relative to which mass-proportional damping
   acts. */
#include "boundary/boundary.h"

PetscReal GroundPart(const Support *s)
{
  return s->boundary == BOUNDARY_QUIET && s->input == INPUT_INCIDENT ? 2. : 1.;
}

static PetscBool is_alike(const Support *a, const Support *b)
{
  if (GroundPart(a) != GroundPart(b)) return PETSC_FALSE;
  if (a->along[0] == b->along[0] && a->along[1] == b->along[1]) return PETSC_TRUE;
  return (PetscBool)(!strcmp(a->motion, b->motion) && a->own.quantity == b->own.quantity);
}

PetscErrorCode GroundCreate(const Scene *scene, Ground *ground, char message[MESSAGE_LENGTH])
{
  const Support *first = NULL;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(ground, sizeof(*ground)));
  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports; s++) {
    if (!s->motion[0]) continue;
    if (first && !is_alike(first, s) && !message[0])
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                              "the supports %s and %s move differently, so there is no one ground: expected "
                              "absolute",
                              first->name, s->name));
    if (!first) first = s;
  }
  if (!first) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MotionCreate(first, &ground->motion));
  ground->part = GroundPart(first);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GroundDestroy(Ground *ground)
{
  PetscFunctionBeginUser;
  PetscCall(MotionDestroy(&ground->motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void GroundVelocity(const Ground *ground, PetscReal t, PetscReal v[2])
{
  for (int k = 0; k < 2; k++)
    v[k] = ground->motion.along[k].n ? ground->part * MotionVelocity(&ground->motion, t, k) : 0.;
}

void GroundPlace(const Ground *ground, PetscReal t, PetscReal u[2])
{
  for (int k = 0; k < 2; k++)
    u[k] = ground->motion.along[k].n ? ground->part * MotionPlace(&ground->motion, t, k) : 0.;
}
