/* find.h: declares what the files that find contacts share: the faces in the present state, candidates for
   contacts, and the old contacts, which existed before the search. */
#pragma once
#include "contacts/contacts.h"
#include "contacts/geometry.h"

static const PetscReal FLUSH = 0.1; /* [-] in contact tolerances; a lower step between faces counts as none */

/* State of a pair of faces. TOUCHES: they are a contact; TOUCHED: they were one before the search; STAYS:
   their contact stays as it was. */
enum FaceTouch { TOUCHES = 1, TOUCHED = 2, STAYS = 4 };

/* The faces of this rank in the present state, and which of them are near each other. Near faces lie within
   the contact margin, belong to different blocks and rigid bodies, and one of them is at an owned vertex. */
typedef struct {
  PetscReal *x;                        /* [m] (n,4) ends */
  PetscReal *length;                   /* [m] (n,) */
  PetscInt *start, *near;              /* rows of near faces, see GridRows */
  char *touch;                         /* FaceTouch bits of each entry of `near` */
  PetscInt *vertex_start, *vertex_row; /* (n_vertices + 1,), (2n,) rows of the faces at each vertex */
} FaceTable;
/* Lists the faces and their near faces. u: vertex array; NULL: the reference state. verifying: leaves out
   pairs whose groups are both not upgradeable. */
PetscErrorCode FaceTableCreate(const Model *m, const PetscReal *u, PetscBool verifying, FaceTable *table);
PetscErrorCode FaceTableDestroy(FaceTable *table);

/* A candidate: a contact that has no place in the batches yet. */
typedef struct {
  StressModelKind model;
  PetscInt key[2], face[2], joint; /* face: rows of Model.faces, the face of the lower gid first */
  PetscInt vertex;                 /* VERTEX_FACE: local vertex; face[1] is the face it stands on */
  PetscInt before;                 /* its place in the old contacts, -1: it is new */
  PetscReal drawn;                 /* VERTEX_FACE, new: [m] gap in the mesh, see GapAsDrawn; 0: none */
  PetscBool kept;                  /* the contact stays as it was in everything; face[1] may be unset (-1) */
  FacePair pair;
} Candidate;
typedef struct {
  PetscInt n, capacity;
  Candidate *item; /* free with PetscFree */
} CandidateList;
PetscErrorCode CandidatesPush(CandidateList *list, const Candidate *candidate);

/* The old contacts, in a hash table by key. */
typedef struct {
  const Contacts *contacts;
  PetscReal moved; /* [m] largest distance that a vertex has moved since they were found */
  PetscInt *slot;  /* (mask + 1, 3) key and place, -1: free */
  unsigned mask;
} OldContacts;
PetscErrorCode OldContactsCreate(const Contacts *contacts, OldContacts *old);
PetscErrorCode OldContactsDestroy(OldContacts *old);
/* Returns the slot where the search for a key begins. It is linear in the keys, which follow the blocks in
   memory. So contacts near each other in space have slots near each other. */
static inline unsigned OldContactsSlot(const OldContacts *old, PetscInt a, PetscInt b)
{
  return ((unsigned)a + 2654435769u * (unsigned)(b - a)) & old->mask;
}
/* Returns the place of the old contact with this key, -1: none. */
static inline PetscInt OldContactFind(const OldContacts *old, PetscInt a, PetscInt b)
{
  for (unsigned i = OldContactsSlot(old, a, b);; i = (i + 1) & old->mask) {
    const PetscInt *slot = old->slot + 3 * (size_t)i;
    if (slot[2] < 0 || (slot[0] == a && slot[1] == b)) return slot[2];
  }
}
/* Returns the second number of the key of a vertex on a face; the first is the gid of the face. */
static inline PetscInt VertexKey(PetscInt vertex_gid)
{
  return -2 - vertex_gid;
}

/* Returns the row of the joints table for a pair of faces: the named joint of either face (the first in
   the scene), else the joint of the pair of groups, else the default or the row of later contacts
   (LaterJoints). */
PetscInt JointOfPair(const Scene *scene, const Model *m, PetscInt f, PetscInt g);
/* Does the same as JointOfPair, from the rows Faces.joint of the two faces and their groups. */
PetscInt JointBetween(const Scene *scene, const Model *m, PetscInt joint_f, PetscInt group_f,
                      PetscInt joint_g, PetscInt group_g);
/* Adds the face-to-face contacts among the near faces, and marks them in table->touch. old: NULL at
   set-up. */
PetscErrorCode ContactsFind(const Scene *scene, const Model *m, const OldContacts *old, FaceTable *table,
                            CandidateList *list);
/* Collective. Removes the new contacts of faces across a thin block (layers.c) and of corners that only seem
   to meet (corner.c). Face-to-face contacts must be marked, and stay so, so that no vertex takes their
   place. */
PetscErrorCode CornersHide(const Scene *scene, const Model *m, const FaceTable *table, CandidateList *list);
/* Decides whether the corner at the owned vertex v, now at P, is carried by another face, in front of which
   face g does not stand. f: the face of v that is to touch g; contacts of f count only while they stay as
   they were. -1: the vertex itself is to touch g. */
PetscBool CornerIsHidden(const Scene *scene, const FaceTable *table, PetscInt v, const PetscReal P[2],
                         PetscInt f, PetscInt g);
/* Decides whether other faces stand between face f, which is at an owned vertex, and the opposite face g;
   layers.c. */
PetscBool FaceIsScreened(const Model *m, const FaceTable *table, PetscInt f, PetscInt g);
/* Decides whether face h stands between P and face g, and runs along g. */
PetscBool PointIsScreened(const FaceTable *table, const PetscReal P[2], PetscInt g, PetscInt h);
/* Returns the opening [m] of both ends at which a face contact is lost. A contact that was not broken in the
   committed history lasts, within a static stage, until it is open by half its length. */
PetscReal ContactLossGap(const Scene *scene, const Contacts *before, PetscInt at, PetscReal tolerance);
/* Collective. Adds the contacts of vertices on faces; face-to-face contacts must be marked. */
PetscErrorCode VerticesFind(const Scene *scene, const Model *m, const OldContacts *old,
                            const FaceTable *table, CandidateList *list);
/* Sorts into the order of contacts: stress model, then key. */
PetscErrorCode CandidatesSort(const Model *m, CandidateList *list);
/* Collective. Makes contacts of the sorted candidates; only the kept ones have a history. before: old
   contacts, NULL at set-up; vertex_now: present local numbers of the vertices of `before`. */
PetscErrorCode ContactsStore(const Scene *scene, const Model *m, const CandidateList *list,
                             const Contacts *before, const PetscInt *vertex_now, Contacts *c);
/* Collective. Gives the contacts just stored (in the order of list) the history of the old contacts. joints:
   the stage's table. */
PetscErrorCode ContactsInherit(const Scene *scene, const Model *m, const Joint *joints,
                               const FaceTable *table, const OldContacts *old, const CandidateList *list,
                               Contacts *c);
/* Returns the gap (> 0) or overlap [m] of vertex v of face f over face g as drawn, if the two faces were in
   contact as drawn. Returns 0 if not, if they met exactly, or if gaps are real; drawn_gaps.c. */
PetscReal GapAsDrawn(const Scene *scene, const Model *m, PetscInt f, PetscInt g, PetscInt v);
/* Sets the rest of a new contact, the gap or overlap at which it carries nothing, to the value as drawn, if
   its faces were in contact as drawn. Others keep their rest. */
void ContactRestAsDrawn(const Scene *scene, const Model *m, const Candidate *n, PetscInt at, Contacts *c);
/* Collective. Warns, once a run and joint, of faces of different bodies that lie opposite each other at a gap
   a little wider than contact.tolerance. c: the contacts at the start; near_miss.c. */
PetscErrorCode NearMissesWarn(const Scene *scene, const Model *m, const Contacts *c);
