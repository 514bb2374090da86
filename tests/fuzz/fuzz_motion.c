/* fuzz_motion.c: the bytes are a record of motion; the first says of what, as a table or as a file of
   PEER, which support follows it, and how it is corrected. */
#include "fuzz.h"
#include "scene/record.h"
#include "stages/stages.h"

enum {
  VELOCITY = 1,
  NAMED = 2,
  PEER = 4,
  ALONG = 8,
  CORRECTED = 16,
  SCALED = 32
}; /* bits of the first byte */

static GroundMotion quake = {.entry = {.name = "quake"}};
static Support support = {.name = "base", .fix = {PETSC_TRUE, PETSC_TRUE}};
static Scene scene = {
    .file = "scene.yaml", .n_supports = 1, .supports = &support, .n_motions = 0, .motions = &quake};
static char PeerPath[2 * FUZZ_PATH]; /* another name of the same file */

static void leave(void)
{
  unlink(PeerPath);
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  (void)argc, (void)argv;
  FuzzStart("motion.csv");
  snprintf(PeerPath, sizeof PeerPath, "%s/motion.at2", FuzzFolder);
  if (link(FuzzPath, PeerPath)) abort();
  return atexit(leave);
}

/* As support_keys.c leaves a scene with a motion. */
static void make_scene(int bits)
{
  GroundMotion *m = bits & NAMED ? &quake : &support.own;
  scene.n_motions = m == &quake;
  support.own.file[0] = '\0';
  m->quantity = bits & VELOCITY ? MOTION_VELOCITY : MOTION_ACCELERATION;
  m->direction = m == &quake && bits & ALONG ? MOTION_ALONG_Y : MOTION_ALONG_XY;
  m->scale = 1.;
  m->baseline = m == &quake && bits & CORRECTED && !(bits & VELOCITY) ? BASELINE_LINEAR : BASELINE_NONE;
  m->pga = m == &quake && bits & SCALED && !(bits & VELOCITY) ? 2. : 0.;
  snprintf(m->file, sizeof m->file, "%s", bits & PEER ? PeerPath : FuzzPath);
  support.along[0] = m->direction == MOTION_ALONG_Y ? NULL : m;
  support.along[1] = m;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  const Model model = {.comm = PETSC_COMM_SELF, .size = 1};
  const TermView view = {.scene = &scene, .m = &model};
  void *motions = NULL;
  make_scene(size ? data[0] : 0);
  FuzzFile(NULL, 0, data + !!size, size - !!size);
  PetscErrorCode code = SceneReadMotions(PETSC_COMM_SELF, &scene);
  if (!code) code = Supports_term.create(&view, &motions);
  FuzzCheck(code);
  if (!code) {
    const Record *r = &support.along[1]->record;
    Motion motion;
    if (MotionCreate(&support, &motion)) abort();
    for (PetscInt i = 0; i < r->n && i < 9; i++) (void)MotionPlace(&motion, r->t[i], 1);
    (void)MotionSample(motion.along + 1);
    if (MotionDestroy(&motion)) abort();
  }
  if (Supports_term.destroy(&scene, &motions)) abort();
  if (RecordDestroy(&quake.record) || RecordDestroy(&support.own.record)) abort();
  return 0;
}
