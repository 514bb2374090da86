/* geometry.h: classifies two faces that may touch (sections 2.1-2.2, Fig. 3-4). It knows coordinates only,
   not the model. */
#pragma once
#include "contacts/contacts.h"

/* Two faces a and b that touch, and which vertex of which face stands opposite the other face at each end.
   Ends 0 and 1 follow each other along the direction of face a. */
typedef struct {
  ContactClass klass;
  int source[2];    /* 0: the vertex belongs to face a (destination b), 1: to face b (destination a) */
  int corner[2];    /* 0: first vertex of its face, 1: second */
  PetscReal t[2];   /* L_d / length of the destination face */
  PetscReal gap[2]; /* [m] opening, positive where the faces are apart */
  PetscReal length; /* [m] L = L_i,0 + L_i,1 */
} FacePair;

enum { FACES_APART = 0, FACES_TOUCH = 1 };
static const PetscReal FACE_COS_LIMIT = 0.93969262; /* faces within 20 degrees of anti-parallel may touch */
static const PetscReal TAN_LIMIT = 0.36397023;      /* tan 20 degrees */
static const PetscReal SIN_LIMIT = 0.34202014;      /* sin 20 degrees */
static const PetscReal FACE_TIE = 1e-9;             /* [-] ends nearer than this part of a face count as one
                                                       place */
/* [-] of the reach of the block behind a face: a deeper overlap is no contact of this face */
static const PetscReal FACE_DEPTH = 0.4;
static const PetscReal FACE_MIN_OVERLAP = 1e-6; /* [-] of the shorter face */

/* Projects P on the line A-B. t: place along it, 0 at A and 1 at B; gap: [m] distance of P on the outward
   side, the right of A-B. */
static inline void face_project(const PetscReal A[2], const PetscReal B[2], const PetscReal P[2],
                                PetscReal *t, PetscReal *gap)
{
  const PetscReal ex = B[0] - A[0], ey = B[1] - A[1], dx = P[0] - A[0], dy = P[1] - A[1],
                  l2 = ex * ex + ey * ey;
  *t = (dx * ex + dy * ey) / l2;
  *gap = (dx * ey - dy * ex) / PetscSqrtReal(l2);
}

/* Finds the class of the contact of faces a and b, and its two sub-contacts. a, b: (4) x0 y0 x1 y1 of the
   faces in ring order. tolerance: [m] largest opening allowed at either end; depth: [m] deepest overlap
   allowed. Returns FACES_TOUCH, or FACES_APART when they are no contact. */
static inline int FacePairClassify(const PetscReal *a, const PetscReal *b, PetscReal tolerance,
                                   PetscReal depth, FacePair *pair)
{
  const PetscReal *face[2] = {a, b};
  const PetscReal la = PetscSqrtReal((a[2] - a[0]) * (a[2] - a[0]) + (a[3] - a[1]) * (a[3] - a[1]));
  const PetscReal lb = PetscSqrtReal((b[2] - b[0]) * (b[2] - b[0]) + (b[3] - b[1]) * (b[3] - b[1]));
  const PetscReal cosine = ((a[2] - a[0]) * (b[2] - b[0]) + (a[3] - a[1]) * (b[3] - b[1])) / (la * lb);
  PetscReal tb0, tb1, gap;
  if (cosine > -FACE_COS_LIMIT) return FACES_APART;

  // b runs backwards along a: its second vertex is nearer to the start of a
  face_project(a, a + 2, b, &tb0, &gap);
  face_project(a, a + 2, b + 2, &tb1, &gap);
  const PetscReal low = PetscMax(0., tb1), high = PetscMin(1., tb0), tie = FACE_TIE;
  if ((high - low) * la <= FACE_MIN_OVERLAP * PetscMin(la, lb)) return FACES_APART;

  // each end is the vertex of one face that lies opposite the other; at a tie both ends are kept on one face
  // (FF1)
  const int low_a = tb1 <= tie, low_b = tb1 >= -tie, high_a = tb0 >= 1. - tie, high_b = tb0 <= 1. + tie;
  if (low_a && high_a) {
    pair->klass = FF1_12;
    pair->source[0] = pair->source[1] = 0;
    pair->corner[0] = 0, pair->corner[1] = 1;
  } else if (low_b && high_b) {
    pair->klass = FF1_21;
    pair->source[0] = pair->source[1] = 1;
    pair->corner[0] = 1, pair->corner[1] = 0;
  } else if (low_a) {
    pair->klass = FF2_I; // the starting vertices of both faces
    pair->source[0] = 0, pair->source[1] = 1;
    pair->corner[0] = pair->corner[1] = 0;
  } else {
    pair->klass = FF2_F; // the end vertices of both faces
    pair->source[0] = 1, pair->source[1] = 0;
    pair->corner[0] = pair->corner[1] = 1;
  }
  pair->length = (high - low) * la;
  for (int k = 0; k < 2; k++) {
    const PetscReal *P = face[pair->source[k]] + 2 * pair->corner[k],
                    *destination = face[1 - pair->source[k]];
    face_project(destination, destination + 2, P, &pair->t[k], &pair->gap[k]);
    if (pair->gap[k] > tolerance || pair->gap[k] < -depth) return FACES_APART;
  }
  return FACES_TOUCH;
}

static inline PetscReal FaceLength(const PetscReal x[4])
{
  return PetscHypotReal(x[2] - x[0], x[3] - x[1]);
}
