/* heirs.h: declares what new contacts can inherit from old ones, and which of several sources counts. */
#pragma once
#include "contacts/find.h"

/* The present history and the committed one (traits.c: ContactsCommit) are carried over alike. */
enum { NOW, COMMITTED, HISTORIES };
enum { SPEEDS = 3 }; /* speeds of opening that an end keeps for its dashpot */

typedef struct {
  PetscInt model, key[2];   /* identity of the new contact */
  PetscInt kind, source[2]; /* kind: 0: from faces that were in contact, or a vertex that lands; 1: from the
                               vertex on another face. source: key of the old contact */
  PetscReal length;         /* [m]; 0: the new contact keeps its own length */
  PetscReal stored;         /* [m3] stored by the vertex that lands, see stored_in */
  PetscReal rest[2], u_e[HISTORIES][2], speed[SPEEDS][2]; /* values at both ends of the new contact */
  PetscReal broken[HISTORIES][2], closure[HISTORIES][2], far[HISTORIES][2];
} Heir;

typedef struct {
  PetscInt n, capacity;
  Heir *item; /* (n,) */
} HeirList;

/* ---- heirs.c */
PetscErrorCode HeirsPush(HeirList *list, const Heir *heir);
/* Compares heirs by new contact, then kind, then source. */
int HeirOrder(const void *a, const void *b);
/* Collective. Gives every rank the heirs of all, sorted: the first heir of each contact is the one that
   counts. */
PetscErrorCode HeirsShare(MPI_Comm comm, HeirList *heirs);
/* Returns the first heir of a contact, NULL: none. */
const Heir *HeirOf(const HeirList *list, const Candidate *now);
