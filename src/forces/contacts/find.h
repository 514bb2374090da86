/* find.h: what store.c, vertices.c, verify.c and inherit.c share: faces as
   they stand now, contacts before they have their places, the contacts that were. */
#pragma once
#include "forces/contacts/contacts.h"
#include "forces/contacts/geometry.h"

static const PetscReal FLUSH = 0.1; /* of the contact tolerance: lower steps are not seen */

/* Of a pair of faces: they are a contact; they were one, and have not turned far since; they are the contact
 * that they were. */
enum FaceTouch { TOUCHES = 1, TOUCHED = 2, STAYS = 4 };

/* The faces of this rank as they stand, and which come within the contact margin of each other and may touch:
   of different blocks, not of one rigid body, one of the two at an owned vertex. */
typedef struct {
  PetscReal *x;                        /* [m] (n,4) ends */
  PetscReal *length;                   /* [m] (n,) */
  PetscInt *start, *near;              /* rows of near faces, see GridRows */
  char *touch;                         /* as near: FaceTouch bits */
  PetscInt *vertex_start, *vertex_row; /* (n_vertices + 1,), (2n,) rows of the faces at each vertex */
} FaceTable;
/* u: vertex array, NULL: reference state. verifying: pairs of groups that are not upgradeable are left out.
 */
PetscErrorCode FaceTableCreate(const Model *m, const PetscReal *u, PetscBool verifying, FaceTable *table);
PetscErrorCode FaceTableDestroy(FaceTable *table);

/* A contact before it has its place in the batches. */
typedef struct {
  StressModelKind model;
  PetscInt key[2], face[2], joint; /* face: rows of Model.faces, that of the lower gid first */
  PetscInt vertex;                 /* VERTEX_FACE: local vertex; face[1] is the face it stands on */
  PetscInt before;                 /* its place in the contacts that were, -1: it is new */
  PetscBool kept;                  /* stays as it was in everything; of face, that of key[0] is set */
  FacePair pair;
} Candidate;
typedef struct {
  PetscInt n, capacity;
  Candidate *item; /* free with PetscFree */
} CandidateList;
PetscErrorCode CandidatesPush(CandidateList *list, const Candidate *candidate);

/* The contacts that were, found by key. */
typedef struct {
  const Contacts *contacts;
  PetscInt *slot; /* (mask + 1, 3) key and place, -1: free */
  unsigned mask;
} OldContacts;
PetscErrorCode OldContactsCreate(const Contacts *contacts, OldContacts *old);
PetscErrorCode OldContactsDestroy(OldContacts *old);
/* Linear in the keys, which run along with the blocks in memory: neighbours in space are neighbours here. */
static inline unsigned OldContactsSlot(const OldContacts *old, PetscInt a, PetscInt b)
{
  return ((unsigned)a + 2654435769u * (unsigned)(b - a)) & old->mask;
}
/* Place of the contact with this key, -1: there was none. */
static inline PetscInt OldContactFind(const OldContacts *old, PetscInt a, PetscInt b)
{
  for (unsigned i = OldContactsSlot(old, a, b);; i = (i + 1) & old->mask) {
    const PetscInt *slot = old->slot + 3 * (size_t)i;
    if (slot[2] < 0 || (slot[0] == a && slot[1] == b)) return slot[2];
  }
}
static inline PetscInt OldFacesFind(const OldContacts *old, PetscInt a, PetscInt b)
{
  return OldContactFind(old, PetscMin(a, b), PetscMax(a, b));
}
/* Key of a vertex on a face: gid of the face, and this. */
static inline PetscInt VertexKey(PetscInt vertex_gid)
{
  return -2 - vertex_gid;
}

/* Row of the joints table for a pair of faces: the named joint of either face (first in the scene), the pair
   of groups, the default. */
PetscInt JointOfPair(const Scene *scene, const Model *m, PetscInt f, PetscInt g);
/* Adds the face-to-face contacts among the near faces and marks them in the table. old: NULL at set-up. */
PetscErrorCode ContactsFind(const Scene *scene, const Model *m, const OldContacts *old, FaceTable *table,
                            CandidateList *list);
/* Collective. Takes away the new contacts of corners that only seem to meet (corner.c); face-to-face
 * contacts must be marked. */
PetscErrorCode CornersHide(const Scene *scene, const Model *m, const FaceTable *table, CandidateList *list);
/* Whether the corner at the owned vertex v, now at P, is held by another face, with face g nowhere in front
   of it. f: the face of v that is to touch g, whose own contacts count only while they stay; -1: the vertex.
   */
PetscBool CornerIsHidden(const Scene *scene, const FaceTable *table, PetscInt v, const PetscReal P[2],
                         PetscInt f, PetscInt g);
/* Whether a contact that was stays as it was: it has slid less than its share of the tolerance. */
PetscBool ContactStays(const Scene *scene, const Contacts *before, PetscInt at);
/* [m] Both ends opened farther than this, a face contact has parted. */
PetscReal ContactParts(const Contacts *before, PetscInt at, PetscReal tolerance);
/* Collective. Adds the contacts of vertices on faces; face-to-face contacts must be marked. */
PetscErrorCode VerticesFind(const Scene *scene, const Model *m, const OldContacts *old,
                            const FaceTable *table, CandidateList *list);
/* Into the order of contacts: stress model, then key. */
PetscErrorCode CandidatesSort(const Model *m, CandidateList *list);
/* Collective. Makes contacts of the sorted candidates, without history but for the kept ones. before: NULL at
   set-up; vertex_now: local numbers of its vertices now. */
PetscErrorCode ContactsStore(const Scene *scene, const Model *m, const CandidateList *list,
                             const Contacts *before, const PetscInt *vertex_now, Contacts *c);
/* Collective. Gives the contacts just stored (in the order of list) the history of those before. joints: the
   stage's table. */
PetscErrorCode ContactsInherit(const Model *m, const Joint *joints, const FaceTable *table,
                               const OldContacts *old, PetscReal vertex_length, const CandidateList *list,
                               Contacts *c);
