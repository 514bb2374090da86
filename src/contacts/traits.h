/* traits.h: declares what traits.c and force.c share: the traits of LANES contacts, and the history from
   which an evaluation starts. */
#pragma once
#include "contacts/contacts.h"
#include "base/lanes.h"

/* Traits of LANES contacts. CROSSED and LAST have a bit for each lane. MATCH is set when it holds for all
   lanes, the others when they hold for any lane. */
enum {
  CROSSED = 1,      /* << lane: end 1 does not stand on the face of end 0 (FF2) */
  LAST = 1 << 4,    /* << lane: the ends are the last vertices of both faces (FF2_F) */
  RESTS = 1 << 8,   /* rest is not zero */
  HISTORY = 1 << 9, /* slip or broken, present or committed, is not zero; the force loop adds this trait */
  JOINTS = 1 << 10, /* joints differ from those of the LANES contacts before */
  MATCH = 1 << 11,  /* in the reference state P is where B is, Q where A is */
  CRUSHED = 1 << 12 /* closure, present or committed, is not zero; the force loop adds this trait together
                       with HISTORY */
};
static const int IS_CROSSED = CROSSED * 15;

/* History of joints: the present one, which the last evaluation left, or the committed one. */
typedef struct {
  PetscReal *slip, *broken, *closure, *far;
} History;

static inline History HistoryNow(const Contacts *c)
{
  return (History){c->slip, c->broken, c->closure, c->closure_far};
}

static inline History HistoryCommitted(const Contacts *c)
{
  return (History){c->slip_0, c->broken_0, c->closure_0, c->closure_far_0};
}
