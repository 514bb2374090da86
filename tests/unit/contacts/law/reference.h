/* reference.h: the functions of reference.c, which the tests of the kernels call. */
#pragma once
#include "contacts/law/law.h"

/* A vertex P opposite the point (1-t) A + t B of a face. */
typedef struct {
  double s[2], n[2], length;  /* direction of the face, normal out of its block; length of the face */
  double u_n, u_s, t, moving; /* moving: 1 where s and n turn with the face (large strain), else 0 */
} FaceEnd;

/* Finds opening and slip of an end, (1)-(4), from positions X and displacements u of P, A, B. */
FaceEnd ReferenceEnd(const double *const X[3], const double *const u[3], double t, double moving);
/* f: forces on P, A, B of an end force, per metre of thickness. */
void ReferenceVertexForces(const FaceEnd *end, double F_n, double F_s, double f[3][2]);
/* Answers what stress_models.c: StressModelRespond answers. */
void ReferenceRespond(StressModelKind model, const Joint *joint, double L, ContactPoint *p);
/* Answers what stress_models.h: RespondFollowing answers. p: has the committed history; own: slip of the
   springs, in and out. */
void ReferenceFollow(StressModelKind model, const Joint *joint, double L, double pull, double own[2],
                     ContactPoint *p);
