/* find.h: what the files that find contacts share: faces as they stand now, contacts before they have their
   places, and the old contacts, those before the search. */
#pragma once
#include "contacts/contacts.h"
#include "contacts/geometry.h"

static const PetscReal FLUSH = 0.1; /* fraction of the contact tolerance; a lower step counts as none */

/* Of a pair of faces. TOUCHES: they are a contact; TOUCHED: they were one, and have not turned far since;
   STAYS: their contact stays as it was. */
enum FaceTouch { TOUCHES = 1, TOUCHED = 2, STAYS = 4 };

/* The faces of this rank as they stand, and which of them are near each other: within the contact margin, and
   able to touch. Faces of one block or one rigid body cannot touch; one of the two must be at an owned
   vertex. */
typedef struct {
  PetscReal *x;                        /* [m] (n,4) ends */
  PetscReal *length;                   /* [m] (n,) */
  PetscInt *start, *near;              /* rows of near faces, see GridRows */
  char *touch;                         /* FaceTouch bits of each entry of `near` */
  PetscInt *vertex_start, *vertex_row; /* (n_vertices + 1,), (2n,) rows of the faces at each vertex */
} FaceTable;
/* u: vertex array; NULL: the reference state. verifying: leaves out pairs of faces both of whose groups are
   not upgradeable. */
PetscErrorCode FaceTableCreate(const Model *m, const PetscReal *u, PetscBool verifying, FaceTable *table);
PetscErrorCode FaceTableDestroy(FaceTable *table);

/* A contact before it has its place in the batches. */
typedef struct {
  StressModelKind model;
  PetscInt key[2], face[2], joint; /* face: rows of Model.faces, that of the lower gid first */
  PetscInt vertex;                 /* VERTEX_FACE: local vertex; face[1] is the face it stands on */
  PetscInt before;                 /* its place in the old contacts, -1: it is new */
  PetscReal drawn;                 /* VERTEX_FACE, new: [m] gap in the mesh, see GapAsDrawn; 0: none */
  PetscBool kept;                  /* it stays as it was in everything; face[1] may be unset (-1) */
  FacePair pair;
} Candidate;
typedef struct {
  PetscInt n, capacity;
  Candidate *item; /* free with PetscFree */
} CandidateList;
PetscErrorCode CandidatesPush(CandidateList *list, const Candidate *candidate);

/* The old contacts, found by key. */
typedef struct {
  const Contacts *contacts;
  PetscReal moved; /* [m] that a vertex has moved since they were found, at most */
  PetscInt *slot;  /* (mask + 1, 3) key and place, -1: free */
  unsigned mask;
} OldContacts;
PetscErrorCode OldContactsCreate(const Contacts *contacts, OldContacts *old);
PetscErrorCode OldContactsDestroy(OldContacts *old);
/* The slot where the search for a key begins. It is linear in the keys, which run along with the blocks in
   memory, so that contacts near each other in space are near each other here. */
static inline unsigned OldContactsSlot(const OldContacts *old, PetscInt a, PetscInt b)
{
  return ((unsigned)a + 2654435769u * (unsigned)(b - a)) & old->mask;
}
/* Place of the old contact with this key, -1: there was none. */
static inline PetscInt OldContactFind(const OldContacts *old, PetscInt a, PetscInt b)
{
  for (unsigned i = OldContactsSlot(old, a, b);; i = (i + 1) & old->mask) {
    const PetscInt *slot = old->slot + 3 * (size_t)i;
    if (slot[2] < 0 || (slot[0] == a && slot[1] == b)) return slot[2];
  }
}
/* Second number of the key of a vertex on a face; the first is the gid of the face. */
static inline PetscInt VertexKey(PetscInt vertex_gid)
{
  return -2 - vertex_gid;
}

/* Row of the joints table for a pair of faces: the named joint of either face (the first in the scene), else
   that of the pair of groups, else the default or the row of later contacts (LaterJoints). */
PetscInt JointOfPair(const Scene *scene, const Model *m, PetscInt f, PetscInt g);
/* The same from what is known of the two faces: their rows Faces.joint and their groups. */
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
/* Whether the corner at the owned vertex v, now at P, is carried by another face, in front of which face g
   does not stand. f: the face of v that is to touch g; contacts of f count only while they stay as they were.
   f is -1 when the vertex itself is to touch g. */
PetscBool CornerIsHidden(const Scene *scene, const FaceTable *table, PetscInt v, const PetscReal P[2],
                         PetscInt f, PetscInt g);
/* layers.c: whether other faces stand between face f, which is at an owned vertex, and face g opposite. */
PetscBool FaceIsScreened(const Model *m, const FaceTable *table, PetscInt f, PetscInt g);
/* Whether face h stands between P and face g, which it runs along. */
PetscBool PointIsScreened(const FaceTable *table, const PetscReal P[2], PetscInt g, PetscInt h);
/* Whether an old contact stays as it was, because it has slid little. */
PetscBool ContactStays(const Scene *scene, const Contacts *before, PetscInt at);
/* [m] A face contact whose ends are both open by more than this has parted. One that was whole at the last
   equilibrium stays the same contact on the way of a static stage, until it is open by half its length. */
PetscReal ContactParts(const Scene *scene, const Contacts *before, PetscInt at, PetscReal tolerance);
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
/* drawn_gaps.c: [m] gap (> 0) or overlap of vertex v of face f over face g as drawn, where the two faces
   were in contact so; 0 where they were not, where they met exactly, and where gaps are real. */
PetscReal GapAsDrawn(const Scene *scene, const Model *m, PetscInt f, PetscInt g, PetscInt v);
/* Gives a new contact of what was in contact as drawn the gap or overlap of then as the state in which it
   bears nothing. Others keep what they have. */
void ContactRestAsDrawn(const Scene *scene, const Model *m, const Candidate *n, PetscInt at, Contacts *c);
/* near_miss.c: collective. Warns, once a run and joint, of faces of different bodies that lie opposite each
   other at a gap a little wider than contact.tolerance. c: the contacts of the start. */
PetscErrorCode NearMissesTell(const Scene *scene, const Model *m, const Contacts *c);
