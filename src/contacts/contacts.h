/* contacts.h: declares the contacts between faces: how they are stored, found, inherited, and which forces
   they give. */
#pragma once
#include "archive/archive.h"
#include "contacts/law/law.h"
#include "term/term.h"

/* ---- joint_keys.c */
/* Completes the keys of a joint of the scene or of a stage, see reader.h. */
PetscErrorCode CompleteJoint(Reader *r, Joint *joint);

/* ------------------------------------------------------------------------------------------- Contacts
   Face-to-face contacts that touch an owned vertex, ascending (stress model, lower face gid, higher face
   gid), padded per stress model to whole batches. Sub-contact k = 0,1 of contact c stands at index SUB(c,k)
   of every (.., 2, BATCH) array. A sub-contact is a vertex P of one face opposite the edge A-B of the other
   (its destination); sub-contacts 0 and 1 are the two ends of the contact, and stress runs linearly between
   them. Two faces have four vertices: P A B of sub-contact 0 and Q, the other vertex of P's face; which of
   them are P A B of sub-contact 1 follows from the class (ContactEndVertices). A vertex on a face has no end
   1: Q is A, and t = 0 there, so that nothing opens or slides. With tptm both ends stand at the vertex: Q is
   P, and `rest` makes of the two the diagram of a face. */

#define SUB(c, k) (((c) / BATCH) * 2 * BATCH + (k)*BATCH + (c) % BATCH)
enum { ROW_P, ROW_A, ROW_B, ROW_Q, CONTACT_ROWS };
#define CONTACT_ROW(c, row) (((c) / BATCH) * CONTACT_ROWS * BATCH + (row)*BATCH + (c) % BATCH)

typedef enum { FF1_21, FF1_12, FF2_I, FF2_F, VERTEX_FACE } ContactClass; /* Fig. 3 and 5b of the paper */

/* Size of an array. PER_CONTACT: (n_padded,); PER_FACE, one number for each face: (n_padded, 2); PER_ROW, one
   for each vertex of the faces: (n_padded/BATCH, 4, BATCH); PER_END, one for each end: (n_padded/BATCH, 2,
   BATCH). */
typedef enum { PER_CONTACT, PER_FACE, PER_ROW, PER_END } ContactShape;
/* What an array describes. The kinds are bits, so that a caller can ask for several at once. */
typedef enum {
  FIELD_IDENTITY = 1,   /* which contact it is; set in store.c */
  FIELD_GEOMETRY = 2,   /* where it is; set in store.c and verify.c */
  FIELD_DERIVED = 4,    /* follows from the other arrays: ContactsSetTraits */
  FIELD_HISTORY = 8,    /* history of the joint; set in force.c, part of the checksum */
  FIELD_RESULT = 16,    /* results of the last evaluation; set in force.c */
  FIELD_COMMITTED = 32, /* committed history, and the positions from which travel is counted */
  FIELD_CRUSHED = 64,   /* plastic closure; in the checksum and in checkpoints only if some contact is
                              crushed */
  FIELD_CRUSHED_0 = 128 /* committed plastic closure; not in the checksum */
} ContactFieldKind;
enum { FIELD_CRUSHES = FIELD_CRUSHED | FIELD_CRUSHED_0, FIELD_ANY = 255 };
/* ROOM_ZEROS: the array stays zero where nothing has slipped, overlapped, been crushed or moved in time. Its
   pages take no memory until a value other than zero is written there. */
typedef enum { ROOM_FULL, ROOM_ZEROS } ContactRoom;

/* All arrays of Contacts. This list declares, allocates, copies, archives, checksums and frees them
   (contact_fields.c): a new array is one line here. A checkpoint has the reals of ends in this order, the
   arrays of FIELD_CRUSHES last; another order needs another version of checkpoints.

   key     a vertex on a face has the gid of the face and -2 - gid of the vertex; a padding lane -1 -1
   t       P projects on (1-t) A + t B
   rest    the gap (> 0) or overlap (< 0) of the faces as drawn, so that a contact starts stress-free
   length  L = L_i,0 + L_i,1; the two are equal
   broken  failed part of the end, which has residual strength; kappa/2 of a joint that softens (softening.h);
           LOOSE: the contact was made by an impact and never had peak strength
   closure plastic part of u_n, <= 0: the lower envelope of 0 and two lines, one for each end; closure is the
           line of this end here, closure_far the same line at the other end
   u_n_0   u_n when the contact first carried a force; PETSC_MAX_REAL: it has not yet; contact_travel.c
   speed   mean over the last step; speed_old: over the step before it; speed_now: the speed at which
           dashpots act; dynamic stages only
   sigma   and tau stand at the control points that are the two ends
   F_n     and F_s are per metre of thickness, with the signs of sigma and tau */
// clang-format off
#define CONTACT_FIELDS(X)                                                                                   \
  X(PetscInt,  key,           PER_FACE,    FIELD_IDENTITY,    ROOM_FULL)  /* gids, the lower first */       \
  X(uint8_t,   klass,         PER_CONTACT, FIELD_IDENTITY,    ROOM_FULL)  /* ContactClass */                \
  X(PetscInt,  joint,         PER_CONTACT, FIELD_IDENTITY,    ROOM_FULL)  /* row of the joints table */     \
  X(bool,      owned,         PER_CONTACT, FIELD_IDENTITY,    ROOM_FULL)  /* this rank writes it */        \
  X(PetscInt,  vertex,        PER_ROW,     FIELD_GEOMETRY,    ROOM_FULL)  /* local: rows P A B Q */         \
  X(PetscReal, length,        PER_CONTACT, FIELD_GEOMETRY,    ROOM_FULL)  /* [m] L */                       \
  X(uint16_t,  traits,        PER_CONTACT, FIELD_DERIVED,     ROOM_FULL)  /* what LANES contacts share */   \
  X(PetscReal, t,             PER_END,     FIELD_GEOMETRY,    ROOM_FULL)  /* [-] L_d over length of A-B */  \
  X(PetscReal, rest,          PER_END,     FIELD_GEOMETRY,    ROOM_ZEROS) /* [m] u_n where sigma = 0 */     \
  X(PetscReal, slip,          PER_END,     FIELD_HISTORY,     ROOM_ZEROS) /* [m] plastic part of u_s */     \
  X(PetscReal, broken,        PER_END,     FIELD_HISTORY,     ROOM_ZEROS) /* [-] failed part of L */        \
  X(PetscReal, u_n,           PER_END,     FIELD_RESULT,      ROOM_FULL)  /* [m] opening */                 \
  X(PetscReal, u_s,           PER_END,     FIELD_RESULT,      ROOM_FULL)  /* [m] sliding */                 \
  X(PetscReal, speed,         PER_END,     FIELD_RESULT,      ROOM_ZEROS) /* [m/s] of opening */            \
  X(PetscReal, speed_old,     PER_END,     FIELD_RESULT,      ROOM_ZEROS) /* [m/s] see above */             \
  X(PetscReal, speed_now,     PER_END,     FIELD_RESULT,      ROOM_ZEROS) /* [m/s] see above */             \
  X(PetscReal, sigma,         PER_END,     FIELD_RESULT,      ROOM_FULL)  /* [Pa] normal stress */          \
  X(PetscReal, tau,           PER_END,     FIELD_RESULT,      ROOM_FULL)  /* [Pa] shear stress */           \
  X(PetscReal, F_n,           PER_END,     FIELD_RESULT,      ROOM_FULL)  /* [N/m] normal end force */      \
  X(PetscReal, F_s,           PER_END,     FIELD_RESULT,      ROOM_FULL)  /* [N/m] shear end force */       \
  X(uint8_t,   state,         PER_END,     FIELD_RESULT,      ROOM_FULL)  /* ContactState bits */           \
  X(PetscReal, slip_0,        PER_END,     FIELD_COMMITTED,   ROOM_ZEROS) /* [m] committed slip */          \
  X(PetscReal, broken_0,      PER_END,     FIELD_COMMITTED,   ROOM_ZEROS) /* [-] committed broken */        \
  X(PetscReal, u_n_0,         PER_END,     FIELD_COMMITTED,   ROOM_ZEROS) /* [m] origin of opening travel */\
  X(PetscReal, u_s_0,         PER_END,     FIELD_COMMITTED,   ROOM_ZEROS) /* [m] origin of sliding travel */\
  X(PetscReal, moved,         PER_END,     FIELD_COMMITTED,   ROOM_ZEROS) /* [-] travel of a chunk over L */\
  X(PetscReal, closure,       PER_END,     FIELD_CRUSHED,     ROOM_ZEROS) /* [m] plastic closure, here */   \
  X(PetscReal, closure_far,   PER_END,     FIELD_CRUSHED,     ROOM_ZEROS) /* [m] at the other end */        \
  X(PetscReal, closure_0,     PER_END,     FIELD_CRUSHED_0,   ROOM_ZEROS) /* [m] committed closure */       \
  X(PetscReal, closure_far_0, PER_END,     FIELD_CRUSHED_0,   ROOM_ZEROS) /* [m] at the other end */
// clang-format on

/* How friction follows the law, and from which history an evaluation starts; friction_mode.c changes it. */
typedef enum {
  FRICTION_KEPT,    /* from the last evaluation: stages in time, static stages with a damping of the paper */
  FRICTION_SPRINGS, /* as FRICTION_KEPT; with tptm the shear forces of the ends are springs that keep their
                       slip */
  FRICTION_LAW,   /* from the committed history slip_0, broken_0, closure_0: friction is what the law gives */
  FRICTION_PULLED /* as FRICTION_LAW, but springs keep their slip, and each evaluation draws them towards the
                     law */
} FrictionMode;

typedef struct _p_Contacts {
  PetscInt n;                              /* real contacts: padding lanes are not counted */
  PetscInt n_padded;                       /* size of the arrays in contacts */
  PetscInt model_start[STRESS_MODELS + 1]; /* first contact (in the padded numbering) of each stress model */
#define DECLARE(type, name, shape, kind, room) type *name;
  CONTACT_FIELDS(DECLARE)
#undef DECLARE
  char *memory; /* memory of all arrays of ROOM_FULL */
  FrictionMode friction;
  PetscReal pull;     /* [-] FRICTION_PULLED: part of the difference to the law that one evaluation takes
                        away */
  PetscBool outgrown; /* a contact has left the range in which it may stay as it is, so the present stage, of
                         CONNECTIVITY_AUTO, finds contacts again; contact_travel.c */
  PetscBool counted;  /* u_n_0 and u_s_0 are up to date; a stage in time clears this */
  PetscReal rate;     /* [1/s] 1/dt in a dynamic stage, -1 there with dashpots idle, 0 in a static one */
  PetscReal lead;    /* [-] factor on the change of speed over two steps that extrapolates the speed of half a
                        step ago to now: 1/4 where steps are equal */
  PetscReal margin;  /* [Pa] a joint breaks only when a stress exceeds the peak strength by more than this,
                        the error that rounding and the tolerance of the stage leave in stresses; 0: not known
                        yet */
  PetscBool repeats; /* the next evaluation is at the same instant as the last one: dashpots keep their
                        speed */
} Contacts;

/* Returns whether contacts are found again in the stage as blocks move. */
static inline PetscBool ContactsVary(const Contacts *c, const Stage *stage)
{
  return (PetscBool)(stage->connectivity == CONNECTIVITY_VARIABLE ||
                     (stage->connectivity == CONNECTIVITY_AUTO && c->outgrown));
}

/* Returns whether evaluations start from the committed history. */
static inline PetscBool ContactsFromCommitted(const Contacts *c)
{
  return (PetscBool)(c->friction >= FRICTION_LAW);
}

/* Decides whether the opening of an end is rounding: the bodies touch there, without any pressure. */
static inline PetscBool ContactTouches(const Contacts *c, PetscInt i, int k)
{
  return (PetscBool)(PetscAbsReal(c->u_n[SUB(i, k)]) <= 1e-12 * c->length[i]);
}

/* Returns the number of ends of contact i: one for a vertex on a face, else two. */
static inline int ContactEnds(const Contacts *c, PetscInt i)
{
  return c->klass[i] == VERTEX_FACE ? 1 : 2;
}

/* Finds the local vertices P A B of end k of contact i. */
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

/* For each class, as FacePairClassify (geometry.h) sets them: the face of the vertex at each end (0: a, 1:
   b), and which vertex of this face it is. */
static const int END_SOURCE[4][2] = {{1, 1}, {0, 0}, {0, 1}, {1, 0}};
static const int END_CORNER[4][2] = {{1, 0}, {0, 1}, {0, 0}, {1, 1}};
/* Returns the side of the vertex P of end k. 0: the face of the lower gid, 1: the other face. Its destination
   is the opposite face. */
static inline int ContactSideOfVertex(const Contacts *c, PetscInt i, int k)
{
  return c->klass[i] == VERTEX_FACE ? 1 : END_SOURCE[c->klass[i]][k];
}

/* Computes the unit vector from start to end of a joint, from the second moments of its ends about their
   mean. It points along the longest spread, to the right, or upwards where the joint is upright. Uplift has
   its heel at the start. */
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
/* Numbers of arrays of reals per end: all of them, and the arrays of FIELD_CRUSHES. */
enum { END_ARRAYS = CONTACT_FIELDS(COUNT_ENDS), CRUSHES_ARRAYS = CONTACT_FIELDS(COUNT_CRUSHES) };
#undef COUNT_ENDS
#undef COUNT_CRUSHES
/* Allocates the arrays of n_padded contacts and sets them to zero. */
PetscErrorCode ContactsAllocate(Contacts *contacts);
PetscErrorCode ContactsDestroy(Contacts *contacts);
/* Makes a deep copy. Its vertices are local numbers, which are valid until NeighboursUpdate. */
PetscErrorCode ContactsCopy(const Contacts *contacts, Contacts *copy);
/* Copies contact `from` to place `at` of other contacts, except the derived arrays. */
void ContactsCopyOne(const Contacts *contacts, PetscInt from, Contacts *copy, PetscInt at);
/* Lists the arrays of reals per end of these kinds, in the order of CONTACT_FIELDS; returns their number. */
int ContactsEndArrays(const Contacts *contacts, int kinds, PetscReal *array[END_ARRAYS]);

/* ---- store.c */
/* Collective. Finds all face-to-face contacts that touch an owned vertex, in the
   reference state (section 2.2). */
PetscErrorCode ContactsCreate(const Scene *scene, const Model *model, Contacts *contacts);
/* ---- drawn_gaps.c */
/* Collective. Prints, for each joint, the largest gap and the deepest overlap of its faces as drawn, in the
   contacts at the start. */
PetscErrorCode ContactsReportGaps(const Scene *scene, const Model *model, const Contacts *contacts);
/* ---- corner_touch.c */
/* Collective. Warns, once a run, of corners that touch a slanted face at the start, if a stage has fixed
   connectivity. */
PetscErrorCode CornersReport(const Scene *scene, const Model *model);
/* ---- place.c */
/* Collective. Finds the contacts again in the reference state, after blocks were placed. Old contacts keep
   all they have; new contacts start closed, without slip and stress. joints: the stage's table; u: vertex
   array. */
PetscErrorCode ContactsPlace(const Scene *scene, const Model *model, const Joint *joints, const PetscReal *u,
                             Contacts *contacts);

/* ---- store.c */
/* Collective. Fails if the supports of macroblocks that touch leave them free, together, to move in x or y or
   to turn. */
PetscErrorCode ContactsCheckSupport(const Scene *scene, const Model *model, const Contacts *contacts);

/* ---- joint_rows.c */
/* Collective. Chooses rows for contacts that come later, where no `default` row is given. A later contact
   between two groups, on faces without a named joint, has the weakest row that contacts of the two groups
   have at the start. missing: names groups that have none and may meet; no row is chosen then; "": none. */
PetscErrorCode LaterJoints(const Scene *scene, const Contacts *contacts, Model *model,
                           char missing[MESSAGE_LENGTH]);
/* Collective. Refuses a row of the joints table that no contact has and that no later contact can get: its
   numbers would change nothing. */
PetscErrorCode JointRowsCheck(const Scene *scene, const Model *model, const Contacts *contacts);

/* ---- stone_order.c */
/* Collective. Finds the mean of the four-fold order [-] of all stones, weighted by the length of their
   joints: 1 for courses of blocks, less than 0.7 for rubble. The same bits on any number of ranks. */
PetscErrorCode ContactsOrder(const Model *model, const Contacts *contacts, PetscReal *order);

/* ---- force.c */
/* Computes openings and slips from positions, and stresses by the model of each contact; adds the forces to
   f; updates the history and the arrays of the last evaluation. joints: the stage's table. u, f: vertex
   arrays. */
PetscErrorCode ContactForces(const Model *model, const Joint *joints, Contacts *contacts, const PetscReal *u,
                             PetscReal *f);
/* Does the same as ContactForces, but leaves the arrays of the last evaluation as they are: most cycles of a
   static stage need no more. */
PetscErrorCode ContactForcesOnly(const Model *model, const Joint *joints, Contacts *contacts,
                                 const PetscReal *u, PetscReal *f);

/* ---- traits.c */
/* Sets contacts->traits, by which the force loop leaves out what a few contacts at a time do not need. To be
   called after any other change of class, joint, rest or history. */
void ContactsSetTraits(const Model *model, Contacts *contacts);
/* Collective. Sets contacts->margin, from the loads that act, the stresses of the last evaluation, the
   tolerance [-] of the stage and the digits of coordinates. */
PetscErrorCode ContactsSetMargin(const Model *model, const Joint *joints, const State *state,
                                 PetscReal tolerance, Contacts *contacts);
/* Commits the present history. Evaluations then start from it: friction becomes FRICTION_LAW unless it is
   pulled. To be called at an equilibrium, after an evaluation with results. */
void ContactsCommit(Contacts *contacts);
/* Takes the committed history as the present one. */
void ContactsGoBack(Contacts *contacts);

/* ---- verify.c */
/* Collective. Finds the contacts again in the present state and gives them the history of the old contacts
   (variable connectivity). The last evaluation of forces must belong to the present displacements. joints:
   the stage's table. Adds the numbers of contacts made and lost to result. */
PetscErrorCode ContactsVerify(const Scene *scene, const Joint *joints, Model *model, State *state,
                              Contacts *contacts, StageResult *result);
/* Collective. From here on stages of CONNECTIVITY_AUTO find contacts again. contacts: those of the start. */
PetscErrorCode ContactsOutgrow(const Scene *scene, Model *model, State *state, Contacts *contacts);
static const PetscReal VERIFY_AFTER = 0.2; /* [-] motion of a vertex over the margin: deviations.md, t */
/* Collective. Decides whether blocks have moved enough since the last verification to need another one. */
PetscErrorCode ContactsNeedVerify(const Model *model, const State *state, PetscBool *need, PetscReal *far);

/* ---- bound.c */
/* Adds the contacts' part of the corrected stiffness bound (29) to k [N/m] (n_vertices + dummies,). drag:
   adds the bound of their dashpots [N s/m] instead. */
PetscErrorCode ContactStiffness(const Joint *joints, const Contacts *contacts, PetscReal thickness,
                                PetscBool drag, PetscReal *k);
/* Does the same as ContactStiffness where contacts may come later: along all faces of every vertex, with the
   stiffest joint of the table. */
PetscErrorCode ContactStiffnessAnywhere(const Scene *scene, const Model *model, const Joint *joints,
                                        PetscBool drag, PetscReal *k);

/* ---- stored.c */
/* Returns the energy stored in owned contacts [J]. */
PetscReal EnergyInJoints(const Model *model, const Joint *joints, const Contacts *contacts);

/* ---- tangent.c */
/* Adds the tangent stiffness of contacts: of the last evaluation, or from the committed history; see
   term.h. */
PetscErrorCode ContactsTangent(const Instant *at, TangentKind kind, TermAdd add, void *context);

/* ---- contacts_term.c */
/* Contacts as a force term. */
extern const TermKind Contacts_term;

/* ---- contact_archive.c */
/* Writes or reads contacts with their history and last evaluation. Reading replaces the present contacts.
   model->faces must belong to the displacements at which contacts were last verified (StateArchive of motion/
   sees to it). */
PetscErrorCode ArchiveContacts(Archive *archive, const Scene *scene, const Model *model, const char *name,
                               Contacts *contacts);
