/* kinematics.h: finds openings and slips at the ends of LANES contacts from the vertices of their faces,
   (1)-(4) (head of force.c). */
#pragma once
#include "contacts/contacts.h"
#include "contacts/traits.h"

/* Masks of lanes. one: both ends stand on one face; first, where not `one`: FF2_I. All other lanes are
   FF2_F. */
typedef struct {
  Mask one, first;
} Classes;

KERNEL Classes ClassesOf(int traits)
{
  const Mask bit = {1, 2, 4, 8}, all = {traits, traits, traits, traits};
  const Mask crossed = (all & bit) != 0, last = (all & (bit * LAST)) != 0;
  return (Classes){~crossed, ~last};
}

/* Selects in each lane the vector of its class. */
KERNEL LanesVector VectorByClass(const Classes *is, LanesVector one, LanesVector first, LanesVector last)
{
  return (LanesVector){Select(is->one, one.x, Select(is->first, first.x, last.x)),
                       Select(is->one, one.y, Select(is->first, first.y, last.y))};
}

/* A vector between vertices of LANES contacts. X: in the reference state; u: its change since. */
typedef struct {
  LanesVector X, u;
} Reach;

KERNEL Reach ReachSubtract(Reach p, Reach q)
{
  return (Reach){VectorSubtract(p.X, q.X), VectorSubtract(p.u, q.u)};
}

/* Selects in each lane the reach of its class. */
KERNEL Reach ReachByClass(const Classes *is, Reach one, Reach first, Reach last)
{
  return (Reach){VectorByClass(is, one.X, first.X, last.X), VectorByClass(is, one.u, first.u, last.u)};
}

/* A destination face of LANES contacts. */
typedef struct {
  LanesVector s; /* unit vector along the face */
  Lanes turns;   /* rotation of the face per displacement of an end across it: 1/length; 0 in small strain */
} LanesFace;

/* Finds the direction of a face. AB: B - A. moving: 1 with large strain, 0 with small strain. */
KERNEL LanesFace FaceAlong(Reach AB, PetscReal moving)
{
  const LanesVector e = VectorAdd(AB.X, VectorScale(moving, AB.u));
  const Lanes inv = 1. / SquareRoot(VectorDot(e, e));
  return (LanesFace){{e.x * inv, e.y * inv}, moving * inv};
}

/* Returns the unit normal out of the destination block. */
KERNEL LanesVector NormalTo(LanesVector s)
{
  return (LanesVector){s.y, -s.x};
}

/* Positions of LANES contacts: all that forces need to know of the vertices. d_n, d_s: opening and slip of
   both ends, before `rest` is subtracted. */
typedef struct {
  LanesFace face[2]; /* [1] is set only where some lane is crossed */
  Lanes d_n[2], d_s[2];
} Place;

/* Sets d_n and d_s of end k. d: vector from the point of the face under the end to the end. */
KERNEL void PlaceEnd(int k, const LanesFace *face, LanesVector d, Place *p)
{
  p->d_n[k] = VectorDot(d, NormalTo(face->s)), p->d_s[k] = VectorDot(d, face->s); /* (3), (4) */
}

/* Returns the vector d, computed from the end of the face as BP + (1 - t) AB, or from its start as AQ - t AB.
   P and Q start at end and start when faces match, so that d is exact there. */
KERNEL LanesVector FromEnd(Reach BP, Reach AB, Lanes t)
{
  const Lanes back = 1. - t;
  return (LanesVector){(BP.X.x + back * AB.X.x) + (BP.u.x + back * AB.u.x),
                       (BP.X.y + back * AB.X.y) + (BP.u.y + back * AB.u.y)};
}

KERNEL LanesVector FromStart(Reach AQ, Reach AB, Lanes t)
{
  return (LanesVector){(AQ.X.x - t * AB.X.x) + (AQ.u.x - t * AB.u.x),
                       (AQ.X.y - t * AB.X.y) + (AQ.u.y - t * AB.u.y)};
}

KERNEL Reach GatherReach(const PetscReal *X, const PetscReal *u, const PetscInt *vertex, int row)
{
  return (Reach){GatherVertex(X, vertex + row * BATCH), GatherVertex(u, vertex + row * BATCH)};
}

/* Finds the positions of LANES contacts. vertex: rows P A B Q; t: place of end 0 on the face, followed after
   BATCH numbers by the place of end 1; traits: 0 where no lane is crossed. */
KERNEL Place PlaceOf(const PetscReal *X, const PetscReal *u, const PetscInt *vertex, const PetscReal *t,
                     PetscReal moving, int traits)
{
  const Reach P = GatherReach(X, u, vertex, ROW_P), A = GatherReach(X, u, vertex, ROW_A),
              B = GatherReach(X, u, vertex, ROW_B), Q = GatherReach(X, u, vertex, ROW_Q),
              AB = ReachSubtract(B, A);
  const Lanes t_1 = LoadLanes(t + BATCH);
  Place p;
  p.face[0] = FaceAlong(AB, moving);
  PlaceEnd(0, p.face, FromEnd(ReachSubtract(P, B), AB, LoadLanes(t)), &p);
  if (!(traits & IS_CROSSED)) {
    PlaceEnd(1, p.face, FromStart(ReachSubtract(Q, A), AB, t_1), &p);
  } else {
    const Classes is = ClassesOf(traits);
    const Reach from = ReachByClass(&is, A, P, Q), to = ReachByClass(&is, B, Q, P),
                end = ReachByClass(&is, Q, A, B), along = ReachSubtract(to, from);
    p.face[1] = FaceAlong(along, moving);
    PlaceEnd(1, p.face + 1, FromStart(ReachSubtract(end, from), along, t_1), &p);
  }
  return p;
}

/* Does the same as PlaceOf where faces match: d is the relative displacement of the ends. The difference is
   added to the zero that PlaceOf has there, so that a zero result has the same sign. */
KERNEL Place PlaceOfMatch(const PetscReal *X, const PetscReal *u, const PetscInt *vertex, PetscReal moving)
{
  const Reach A = GatherReach(X, u, vertex, ROW_A), B = GatherReach(X, u, vertex, ROW_B);
  const LanesVector zero = {{0.}, {0.}}, u_P = GatherVertex(u, vertex + ROW_P * BATCH),
                    u_Q = GatherVertex(u, vertex + ROW_Q * BATCH);
  Place p;
  p.face[0] = FaceAlong(ReachSubtract(B, A), moving);
  PlaceEnd(0, p.face, VectorAdd(zero, VectorSubtract(u_P, B.u)), &p);
  PlaceEnd(1, p.face, VectorAdd(zero, VectorSubtract(u_Q, A.u)), &p);
  return p;
}

/* Copies p to *place, face[1] only where it is used. p is made complete before it is copied, because the
   compiler does not know that *place is not among what PlaceOf reads. */
KERNEL void StorePlace(const Place *p, int crossed, Place *place)
{
  for (int k = 0; k < 1 + crossed; k++) place->face[k] = p->face[k];
  for (int k = 0; k < 2; k++) place->d_n[k] = p->d_n[k], place->d_s[k] = p->d_s[k];
}
