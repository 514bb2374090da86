/* contacts.h: contacts between faces: found, kept, inherited, their forces. */
#pragma once
#include "archive/archive.h"
#include "contacts/law/law.h"
#include "term/term.h"

/* ------------------------------------------------------------------------------------------- Contacts
   Face-to-face contacts that touch an owned vertex, ascending (stress model, lower face gid, higher face
   gid), padded per stress model to whole batches. Sub-contact k = 0,1 of contact c stands at index SUB(c,k)
   of every (.., 2, BATCH) array. A sub-contact is a vertex P of one face opposite the edge A-B of the other
   (its destination); sub-contacts 0 and 1 are the two ends of the contact, and stress runs linearly between
   them. Two faces have four vertices: P A B of sub-contact 0 and Q, the other vertex of P's face; which of
   them are P A B of sub-contact 1 follows from the class (ContactEndVertices). A vertex on a face has no end
   1: Q is A, and t = 0 there, so that nothing opens or slides. With tptm both ends stand at the vertex:
   Q is P, and `rest` makes of the two the diagram of a face. */

#define SUB(c, k) (((c) / BATCH) * 2 * BATCH + (k)*BATCH + (c) % BATCH)
enum { ROW_P, ROW_A, ROW_B, ROW_Q, CONTACT_ROWS };
#define CONTACT_ROW(c, row) (((c) / BATCH) * CONTACT_ROWS * BATCH + (row)*BATCH + (c) % BATCH)

typedef enum { FF1_21, FF1_12, FF2_I, FF2_F, VERTEX_FACE } ContactClass; /* Fig. 3 and 5b of the paper */

/* How many numbers an array has: one a contact, (n_padded,); one a face, (n_padded, 2); one a vertex of the
   faces, (n_padded/BATCH, 4, BATCH); one an end, (n_padded/BATCH, 2, BATCH). */
typedef enum { PER_CONTACT, PER_FACE, PER_ROW, PER_END } ContactShape;
/* What an array is. Bits, so that several kinds can be asked for at once. */
typedef enum {
  FIELD_IDENTITY = 1,      /* which contact it is; store.c */
  FIELD_GEOMETRY = 2,      /* where it is; store.c, verify.c */
  FIELD_DERIVED = 4,       /* follows from the others: ContactsSetTraits */
  FIELD_HISTORY = 8,       /* what the joint has suffered; force.c. In the checksum */
  FIELD_RESULT = 16,       /* last evaluation; force.c */
  FIELD_HELD = 32,         /* history of the last equilibrium, and where motion counts from */
  FIELD_CRUSHED = 64,      /* of what was crushed: in the checksum, and in checkpoints, only where that is */
  FIELD_CRUSHED_HELD = 128 /* the same of the last equilibrium; not in the checksum */
} ContactFieldKind;
enum { FIELD_CRUSHES = FIELD_CRUSHED | FIELD_CRUSHED_HELD, FIELD_ANY = 255 };
/* ROOM_ZEROS: stays zero where nothing has slipped, overlapped, been crushed or moved in time. Its pages take
   no memory until something else is written there. */
typedef enum { ROOM_FULL, ROOM_ZEROS } ContactRoom;

/* All arrays of Contacts. This list declares, allocates, copies, archives, checksums and frees them
   (contact_fields.c): a new array is one line here. A checkpoint has the reals of ends in this order, those
   of FIELD_CRUSHES last; another order is another version of checkpoints.

   key     a vertex on a face has the gid of the face and -2 - gid of the vertex; a padding lane -1 -1
   t       P projects on (1-t) A + t B
   rest    the gap (> 0) or overlap (< 0) of the faces as drawn, so that a contact starts stress-free
   length  L = L_i,0 + L_i,1; the two are equal
   broken  there the joint has residual strength; LOOSE: it has met in motion and never held together
   closure plastic part of u_n, <= 0: the lower envelope of 0 and two lines, one by each end; closure is this
           end's line here, closure_far the same line at the other end
   u_n_0   where the contact first bore; PETSC_MAX_REAL: it has not; contact_travel.c
   speed   over the step that led here; speed_old: over the step before that; speed_now: what dashpots act
           at now; dynamic stages
   sigma   and tau stand at the control points that are the two ends
   F_n     and F_s are per metre of thickness, with the signs of sigma and tau */
// clang-format off
#define CONTACT_FIELDS(X)                                                                                   \
  X(PetscInt,  key,           PER_FACE,    FIELD_IDENTITY,     ROOM_FULL)  /* gids, the lower first */      \
  X(uint8_t,   klass,         PER_CONTACT, FIELD_IDENTITY,     ROOM_FULL)  /* ContactClass */               \
  X(PetscInt,  joint,         PER_CONTACT, FIELD_IDENTITY,     ROOM_FULL)  /* row of the joints table */    \
  X(bool,      owned,         PER_CONTACT, FIELD_IDENTITY,     ROOM_FULL)  /* this rank writes it */        \
  X(PetscInt,  vertex,        PER_ROW,     FIELD_GEOMETRY,     ROOM_FULL)  /* local: rows P A B Q */        \
  X(PetscReal, length,        PER_CONTACT, FIELD_GEOMETRY,     ROOM_FULL)  /* [m] L */                      \
  X(uint16_t,  traits,        PER_CONTACT, FIELD_DERIVED,      ROOM_FULL)  /* what LANES contacts share */  \
  X(PetscReal, t,             PER_END,     FIELD_GEOMETRY,     ROOM_FULL)  /* [-] L_d over length of A-B */ \
  X(PetscReal, rest,          PER_END,     FIELD_GEOMETRY,     ROOM_ZEROS) /* [m] u_n where sigma = 0 */    \
  X(PetscReal, slip,          PER_END,     FIELD_HISTORY,      ROOM_ZEROS) /* [m] plastic part of u_s */    \
  X(PetscReal, broken,        PER_END,     FIELD_HISTORY,      ROOM_ZEROS) /* [-] failed part of L */       \
  X(PetscReal, u_n,           PER_END,     FIELD_RESULT,       ROOM_FULL)  /* [m] opening */                \
  X(PetscReal, u_s,           PER_END,     FIELD_RESULT,       ROOM_FULL)  /* [m] sliding */                \
  X(PetscReal, speed,         PER_END,     FIELD_RESULT,       ROOM_ZEROS) /* [m/s] of opening */           \
  X(PetscReal, speed_old,     PER_END,     FIELD_RESULT,       ROOM_ZEROS) /* [m/s] of it */                \
  X(PetscReal, speed_now,     PER_END,     FIELD_RESULT,       ROOM_ZEROS) /* [m/s] of it */                \
  X(PetscReal, sigma,         PER_END,     FIELD_RESULT,       ROOM_FULL)  /* [Pa] normal stress */         \
  X(PetscReal, tau,           PER_END,     FIELD_RESULT,       ROOM_FULL)  /* [Pa] shear stress */          \
  X(PetscReal, F_n,           PER_END,     FIELD_RESULT,       ROOM_FULL)  /* [N/m] normal end force */     \
  X(PetscReal, F_s,           PER_END,     FIELD_RESULT,       ROOM_FULL)  /* [N/m] shear end force */      \
  X(uint8_t,   state,         PER_END,     FIELD_RESULT,       ROOM_FULL)  /* ContactState bits */          \
  X(PetscReal, slip_0,        PER_END,     FIELD_HELD,         ROOM_ZEROS) /* [m] of the last equilibrium */\
  X(PetscReal, broken_0,      PER_END,     FIELD_HELD,         ROOM_ZEROS) /* [-] of it, too */             \
  X(PetscReal, u_n_0,         PER_END,     FIELD_HELD,         ROOM_ZEROS) /* [m] partings count from it */ \
  X(PetscReal, u_s_0,         PER_END,     FIELD_HELD,         ROOM_ZEROS) /* [m] slidings from this */     \
  X(PetscReal, moved,         PER_END,     FIELD_HELD,         ROOM_ZEROS) /* [-] over L, since a chunk */  \
  X(PetscReal, closure,       PER_END,     FIELD_CRUSHED,      ROOM_ZEROS) /* [m] what was crushed, here */ \
  X(PetscReal, closure_far,   PER_END,     FIELD_CRUSHED,      ROOM_ZEROS) /* [m] and at the other end */   \
  X(PetscReal, closure_0,     PER_END,     FIELD_CRUSHED_HELD, ROOM_ZEROS) /* [m] of the last equilibrium */\
  X(PetscReal, closure_far_0, PER_END,     FIELD_CRUSHED_HELD, ROOM_ZEROS) /* [m] and of it, too */
// clang-format on

/* Which history an evaluation starts from, and how friction follows the law; friction_mode.c changes it. */
typedef enum {
  FRICTION_KEPT,    /* from the evaluation before: stages in time, static ones with a damping of the paper */
  FRICTION_SPRINGS, /* likewise; with tptm the end forces of shear are springs that keep their slip */
  FRICTION_LAW,   /* from the committed history slip_0, broken_0, closure_0: friction is what the law gives */
  FRICTION_PULLED /* likewise, but springs keep their slip, and each evaluation draws them towards the law */
} FrictionMode;

typedef struct _p_Contacts {
  PetscInt n;                              /* real contacts: padding lanes are not counted */
  PetscInt n_padded;                       /* size of the arrays in contacts */
  PetscInt model_start[STRESS_MODELS + 1]; /* first contact (in the padded numbering) of each stress model */
#define DECLARE(type, name, shape, kind, room) type *name;
  CONTACT_FIELDS(DECLARE)
#undef DECLARE
  char *memory; /* of the arrays of ROOM_FULL */
  FrictionMode friction;
  PetscReal pull;    /* [-] part of the way to the law per evaluation in FRICTION_PULLED */
  PetscBool counted; /* u_n_0 and u_s_0 are those of now; a motion in time takes that away */
  PetscReal rate;    /* [1/s] 1/dt in a dynamic stage, -1 there with dashpots idle, 0 in a static one */
  PetscReal lead;    /* [-] the part of its change over two steps that takes the speed of half a step ago to
                        now: 1/4 where steps are equal */
  PetscReal margin;  /* [Pa] a stress must pass the peak strength by more than this to break a joint: what
                        rounding and the tolerance of the stage make of the stresses around; 0: none known */
  PetscBool repeats; /* the next evaluation is of the instant of the last: dashpots keep their speed */
} Contacts;

/* Whether evaluations start from the committed history. */
static inline PetscBool ContactsFromCommitted(const Contacts *c)
{
  return (PetscBool)(c->friction >= FRICTION_LAW);
}

/* Ends of contact i: one of a vertex on a face. */
static inline int ContactEnds(const Contacts *c, PetscInt i)
{
  return c->klass[i] == VERTEX_FACE ? 1 : 2;
}

/* Local vertices P A B of end k of contact i. */
static inline void ContactEndVertices(const Contacts *c, PetscInt i, int k, PetscInt vertex[3])
{
  static const int first[3] = {ROW_P, ROW_A, ROW_B}, second[][3] = {[FF1_21] = {ROW_Q, ROW_A, ROW_B},
                                                                    [FF1_12] = {ROW_Q, ROW_A, ROW_B},
                                                                    [FF2_I] = {ROW_A, ROW_P, ROW_Q},
                                                                    [FF2_F] = {ROW_B, ROW_Q, ROW_P},
                                                                    [VERTEX_FACE] = {ROW_Q, ROW_A, ROW_B}};
  const int *row = k ? second[c->klass[i]] : first;
  for (int v = 0; v < 3; v++) vertex[v] = c->vertex[CONTACT_ROW(i, row[v])];
}

/* By class: the face of the vertex at each end (0: a, 1: b), and which vertex of it; as FacePairClassify
   (geometry.h) sets them. */
static const int END_SOURCE[4][2] = {{1, 1}, {0, 0}, {0, 1}, {1, 0}};
static const int END_CORNER[4][2] = {{1, 0}, {0, 1}, {0, 0}, {1, 1}};
/* Which side the vertex P of end k is on, 0: the face of the lower gid, 1: the other; its destination is
   the other one. */
static inline int ContactSideOfVertex(const Contacts *c, PetscInt i, int k)
{
  return c->klass[i] == VERTEX_FACE ? 1 : END_SOURCE[c->klass[i]][k];
}

/* Direction from start to end of a joint, by the second moments of its ends about their mean: along the
   longest spread, to the right, upwards when it is upright. Start is where uplift has its heel. */
static inline void JointDirection(PetscReal xx, PetscReal xy, PetscReal yy, PetscReal e[2])
{
  const PetscReal angle = 0.5 * atan2(2. * xy, xx - yy);
  e[0] = cos(angle), e[1] = sin(angle);
  if (e[0] < -1e-6 || (e[0] < 1e-6 && e[1] < 0.)) e[0] = -e[0], e[1] = -e[1];
}

/* ---- contact_fields.c */
// NOLINTNEXTLINE(bugprone-macro-parentheses): the plus joins what the list counts
#define COUNT_ENDS(type, name, shape, kind, room) +((shape) == PER_END && sizeof(type) == sizeof(PetscReal))
// NOLINTNEXTLINE(bugprone-macro-parentheses): the plus joins what the list counts
#define COUNT_CRUSHES(type, name, shape, kind, room) +!!((kind)&FIELD_CRUSHES)
/* How many arrays of reals the ends have, and how many of them are of FIELD_CRUSHES. */
enum { END_ARRAYS = CONTACT_FIELDS(COUNT_ENDS), CRUSHES_ARRAYS = CONTACT_FIELDS(COUNT_CRUSHES) };
#undef COUNT_ENDS
#undef COUNT_CRUSHES
/* The arrays of n_padded contacts, zero. */
PetscErrorCode ContactsAllocate(Contacts *contacts);
PetscErrorCode ContactsDestroy(Contacts *contacts);
/* A deep copy; its vertices are local numbers, which hold until NeighboursUpdate. */
PetscErrorCode ContactsCopy(const Contacts *contacts, Contacts *copy);
/* Contact `from` to place `at` of other contacts, all but what is derived. */
void ContactsCopyOne(const Contacts *contacts, PetscInt from, Contacts *copy, PetscInt at);
/* Arrays of reals of the ends, of these kinds, in the order of the list; returns how many. */
int ContactsEndArrays(const Contacts *contacts, int kinds, PetscReal *array[END_ARRAYS]);

/* ---- store.c */
/* Collective. Finds all face-to-face contacts that touch an owned vertex, in the
   reference state (section 2.2). */
PetscErrorCode ContactsCreate(const Scene *scene, const Model *model, Contacts *contacts);
PetscErrorCode ContactsIsValid(const Model *model, const Contacts *contacts, PetscBool *valid);
/* ---- drawn_gaps.c */
/* Collective. Prints, for each joint, how far its faces are apart and how deep they overlap as drawn, in the
   contacts of the start. */
PetscErrorCode ContactsReportGaps(const Scene *scene, const Model *model, const Contacts *contacts);
/* ---- corner_touch.c */
/* Collective. Warns, once a run, of corners that touch a slanted face at the start of a scene with a stage of
   fixed connectivity. */
PetscErrorCode CornersReport(const Scene *scene, const Model *model);
/* ---- place.c */
/* Collective. New faces are there: finds contacts anew in the reference state. Those that were there keep
   all they have; new ones start closed, without slip and stress. joints: the stage's table; u: vertex
   array. */
PetscErrorCode ContactsPlace(const Scene *scene, const Model *model, const Joint *joints, const PetscReal *u,
                             Contacts *contacts);

/* ---- store.c */
/* Collective. Fails when macroblocks that touch are not held, together, in x, in y and against turning. */
PetscErrorCode ContactsCheckSupport(const Scene *scene, const Model *model, const Contacts *contacts);

/* ---- joint_rows.c */
/* Collective. Variable connectivity without a `default` row: contacts that come later between two groups, on
   faces without a named joint, have the weakest row of those that the groups have at the start. Refuses
   groups that have none and may meet. */
PetscErrorCode LaterJoints(const Scene *scene, const Contacts *contacts, Model *model);
/* Collective. Refuses a row of the joints table that no contact has, and that none can get where contacts are
   found anew or blocks are placed: its numbers would change nothing. */
PetscErrorCode JointRowsCheck(const Scene *scene, const Model *model, const Contacts *contacts);

/* ---- force.c */
/* Openings and slips from positions, stresses by each contact's model, forces added to f; updates history and
   the arrays of the last evaluation. joints: the stage's table. u, f: vertex arrays. */
PetscErrorCode ContactForces(const Model *model, const Joint *joints, Contacts *contacts, const PetscReal *u,
                             PetscReal *f);
/* The same forces and history; leaves the arrays of the last evaluation as they are: most cycles of a static
   stage ask for no more. */
PetscErrorCode ContactForcesOnly(const Model *model, const Joint *joints, Contacts *contacts,
                                 const PetscReal *u, PetscReal *f);

/* ---- traits.c */
/* After any other change of class, joint, rest or history: writes contacts->traits, by which the loop leaves
   out what a few contacts at a time do not need. */
void ContactsSetTraits(const Model *model, Contacts *contacts);
/* Collective. Sets contacts->margin, from the loads that act, the stresses of the last evaluation, the
   tolerance [-] of the stage and the digits of coordinates. */
PetscErrorCode ContactsSetMargin(const Model *model, const Joint *joints, const State *state,
                                 PetscReal tolerance, Contacts *contacts);
/* Commits the present history: evaluations start from it in FRICTION_LAW, which this sets unless friction is
   pulled. Call it at an equilibrium, with forces evaluated with results. */
void ContactsCommit(Contacts *contacts);
/* Takes the committed history as the present one. */
void ContactsGoBack(Contacts *contacts);

/* ---- verify.c */
/* Collective. Finds contacts anew in the present state and gives them the history of those before (variable
   connectivity). The last evaluation of forces must belong to the present displacements. joints: the stage's
   table. Counts go to result. */
PetscErrorCode ContactsVerify(const Scene *scene, const Joint *joints, Model *model, State *state,
                              Contacts *contacts, StageResult *result);
/* Collective. Whether blocks have moved enough since the last verification. */
PetscErrorCode ContactsNeedVerify(const Scene *scene, const Model *model, const State *state, PetscBool *need,
                                  PetscReal *far);

/* ---- bound.c */
/* Adds the contacts' part of the stiffness bound (29), corrected, to k [N/m] (n_vertices + dummies,). drag:
   that of their dashpots [N s/m] instead. */
PetscErrorCode ContactStiffness(const Joint *joints, const Contacts *contacts, PetscReal thickness,
                                PetscBool drag, PetscReal *k);
/* The same where contacts may come: along all faces of every vertex, of the stiffest joint of the table. */
PetscErrorCode ContactStiffnessAnywhere(const Scene *scene, const Model *model, const Joint *joints,
                                        PetscBool drag, PetscReal *k);

/* ---- stored.c */
/* Energy stored in owned contacts [J]. */
PetscReal EnergyInJoints(const Model *model, const Joint *joints, const Contacts *contacts);

/* ---- tangent.c */
/* Adds the stiffness of contacts: of the last evaluation from the history committed, see term.h. */
PetscErrorCode ContactsTangent(const Instant *at, TangentKind kind, TermAdd add, void *context);

/* ---- contacts_term.c */
/* Contacts as a force term. */
extern const TermKind Contacts_term;

/* ---- contact_archive.c */
/* Contacts with their history and last evaluation. Reading replaces those there are; model->faces must be
   those of the displacements where contacts were last verified (StateArchive of motion/ sees to it). */
PetscErrorCode ArchiveContacts(Archive *archive, const Scene *scene, const Model *model, const char *name,
                               Contacts *contacts);
