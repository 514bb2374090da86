/* reader.h: declares the description of a key, the reader, which asks for keys, and their completions. */
#pragma once
#include "scene/scene.h"
#include "scene/entries.h"

typedef enum {
  SECTION_TOP,
  SECTION_CONTACT,
  SECTION_RELAXATION,     /* fields of Scene */
  SECTION_CHECKPOINT,     /* fields of Scene */
  SECTION_FLOW,           /* fields of Scene */
  SECTION_STAGE_DEFAULTS, /* keys of `relaxation` that are fields of Stage: every stage starts from them */
  SECTION_MATERIALS,
  SECTION_JOINTS,
  SECTION_MOTIONS,
  SECTION_SUPPORTS,
  SECTION_LOADS,
  SECTION_STAGES, /* lists of names */
#define SECTION_OF_TERM(SECTION, word, type) SECTION_##SECTION,
  TERM_SECTIONS(SECTION_OF_TERM) /* likewise, of force terms */
  SECTIONS
} Section;

/* A section of the scene that belongs to a force term. The last row of the table has no word. */
typedef struct {
  const char *word;
  Section section;
  size_t size; /* [byte] of an entry */
} TermSection;
enum { TERM_SECTION_ROWS = SECTIONS - SECTION_STAGES };
extern const TermSection TermSections[TERM_SECTION_ROWS]; /* term_sections.c */

typedef enum {
  TYPE_TITLE,
  TYPE_PATH,
  TYPE_NAME, /* text */
  TYPE_REAL,
  TYPE_LIMIT, /* finite number; number or inf */
  TYPE_INT,
  TYPE_BOOL,
  TYPE_CHOICE,
  TYPE_TRISTATE, /* true or false in a PetscInt, which stays -1 when the key is not given */
  TYPE_PAIR,     /* two numbers, x and y */
  TYPE_NUMBERS,  /* list of numbers */
  TYPE_FIX,      /* x, y or xy */
  TYPE_MOTION,   /* path, or motions of the scene; see support_keys.c */
  TYPE_NAMES,    /* list of names */
  TYPE_LOADS,    /* list of loads of the scene */
  TYPE_CHANGES   /* any key of `joints`, see ReadStageJoints; of the scene, see ReadWhatIf */
} KeyType;

typedef struct {
  Section section;
  const char *name;
  KeyType type;
  size_t offset;
  const char *preset; /* default; NULL: the key is required; "= .." says in words what code does */
  const char *range;  /* such as ">= 0, < 90"; NULL: any */
  const char *unit;
  const char *help;
  const char *word;           /* word that may replace a number, which is NaN then; NULL: none */
  const char *const *choices; /* words, in the manner of PetscEnum lists */
  size_t count;               /* offset of the length of a list */
  int loads;                  /* bits: types of load that have the key; 0: all */
  int stages;                 /* bits: types of stage that have the key; 0: all */
} Key;

/* Functions that complete or refuse keys that depend on other keys. They stand in the rooms that own the
   keys, and completions.c lists them. read.c calls each right behind the keys, in the order of reading.
   NULL: nothing to complete. */
struct _p_Completions {
  PetscErrorCode (*material)(Reader *r, const char *path, Material *material);
  PetscErrorCode (*joint)(Reader *r, Joint *joint); /* a row of a table of joints, which the label names */
  PetscErrorCode (*motion)(Reader *r, const char *path, const GroundMotion *motion);
  PetscErrorCode (*support)(Reader *r, const char *path, Support *support);
  LoadCompletion *load[LOAD_KINDS];
  StageCompletion *any_stage;          /* sets stage->skips, without which the joints cannot be read */
  StageCompletion *stage[STAGE_KINDS]; /* behind the joints of the stage */
  PetscErrorCode (*term[SECTIONS])(Reader *r); /* of all entries of a force term, behind the stages */
};

struct _p_Reader {
  Scene *scene;
  const Completions *complete;
  Entries entries;
  Stage defaults;               /* what `relaxation` says about stages */
  PetscSegBuffer asked;         /* every key that was asked for, each followed by a zero: the known keys */
  PetscSegBuffer echo;          /* text of the keys read so far; see echo.c */
  int echo_indent;              /* of the keys of the section being read */
  char label[LABEL_LENGTH];     /* of the key being read, for messages */
  int line;                     /* line of that key, or of the section that should hold it */
  char message[MESSAGE_LENGTH]; /* first wrong value */
  char missing[MESSAGE_LENGTH]; /* first missing key; reported only if no unknown key explains it */
};

typedef struct {
  char name[NAME_LENGTH];
  int line;
} Name;

#define COMPLAIN(r, ...) Complain((r)->message, (r)->scene->file, (r)->line, (r)->label, __VA_ARGS__)
#define COMPLAIN_MISSING(r, ...) Complain((r)->missing, (r)->scene->file, (r)->line, (r)->label, __VA_ARGS__)

/* Finds the entry of a key, NULL if the user did not give it; sets label and line of the reader. */
PetscErrorCode Ask(Reader *r, const char *parent, const char *name, Entry **entry);
/* Finds the entry of a section of keys, such as `contact` or `materials.dam`. path: receives its path. */
PetscErrorCode AskSection(Reader *r, const char *parent, const char *name, char path[LABEL_LENGTH]);
/* Finds the names in a list section such as `materials`, in their order; free them with PetscFree. */
PetscErrorCode AskNames(Reader *r, const char *section, PetscInt *n, Name **names);
/* Adds the names that options -<section>_<name>_<key> give to a list, unless an option names the whole
   list. */
void AddOptionNames(Reader *r, const char *section, const char *key, PetscInt *n, Name *names);
/* Writes the value or default of the key last asked for into its field of the struct `base`. */
PetscErrorCode ReadKey(Reader *r, const Key *key, const Entry *entry, void *base);
/* ---- units.c: makes plain numbers, in the unit of the key, of an entry with units. */
PetscErrorCode TakeUnits(Reader *r, const Key *key, Entry *entry);
/* Returns unit number i that a value of the key may have; NULL: no more. */
const char *UnitOf(const Key *key, int i);
/* ---- echo.c: adds the head of a section, a key with its value (entry NULL: the default), a change of
   `what_if` to the echo; the whole text, once scene->model is found: free with PetscFree. */
PetscErrorCode EchoSection(Reader *r, int indent, const char *name);
PetscErrorCode EchoKey(Reader *r, const Key *key, const Entry *entry);
PetscErrorCode EchoChange(Reader *r, const char *key, const Entry *entry);
PetscErrorCode EchoEnd(Reader *r, char **text);
/* ---- what_if.c: reads the section `what_if`, behind all others. */
PetscErrorCode ReadWhatIf(Reader *r);
/* Finds whether the user gave the key `name`, and makes this key the subject of the next complaint. */
PetscErrorCode IsGiven(Reader *r, const char *path, const char *name, PetscBool *given);
/* Chooses the one message to show: wrong value, unknown key (an entry that nobody asked for) or missing
   key. */
PetscErrorCode ConcludeMessage(Reader *r);
/* Writes "a, b, c" for a list in the manner of PetscEnum. */
void DescribeChoices(const char *const *choices, char text[256]);
/* ---- scene_files.c. Collective. */
/* Reads the text of the file on all ranks, length bytes and a zero; NULL and a message where nobody can read
   it. Free it with PetscFree. */
PetscErrorCode SceneText(MPI_Comm comm, const char *path, char **text, PetscInt *length, char *message);
/* Finds scene->model in the working directory or beside the scene. */
PetscErrorCode SceneFindModel(MPI_Comm comm, Scene *scene);
