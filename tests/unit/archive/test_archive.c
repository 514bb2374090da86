/* ranks: 1 2 4
   Archive: what is written on these ranks and read on one goes on with the same bits, contacts with history
   and damping included; an entry that is missing or of another size is reported. */
#include "scene_fixture.h"
#include "validity.h"
#include "archive/archive.h"
#include <hdf5.h>
#include <unistd.h>

static Sketch sketch;

static const char *const yaml =
    "materials: {ground: {density: 2000}, wall: {density: 2000, young: 1e9, poisson: 0.2}, "
    "stone: {density: 2500}}\n"
    "joints: {default: {k_n: 1e9, k_s: 5e8, friction: 20, cohesion: 1e3}}\n"
    "contact: {connectivity: variable}\n"
    "supports: {ground: {fix: xy}}\n"
    "loads: {weight: {type: self_weight}, push: {type: point_force, point: top, value: [1e4, 0]}}\n"
    "stages: [all: {loads: [weight, push], ramp: 50}]\n";

/* A rigid ground, three deformable walls on it, a row of rigid stones on these, staggered. */
static void make_sketch(void)
{
  memset(&sketch, 0, sizeof sketch);
  const int ground = SketchGroup(&sketch, "ground", 1), wall = SketchGroup(&sketch, "wall", 0),
            stone = SketchGroup(&sketch, "stone", 1);
  SketchBox(&sketch, ground, -1, -1, 8, 1);
  for (int i = 0; i < 3; i++) {
    const double x = 2. * i, corner[8] = {x, 0, x + 2, 0, x + 2, 2, x, 2};
    SketchGrid(&sketch, wall, corner, 4, 4, i % 2 ? TRIANGLES : QUADS);
  }
  for (int i = 0; i < 5; i++) SketchBox(&sketch, stone, 0.5 + i, 2, 1, 0.5);
  SketchPoint(&sketch, "top", sketch.n_vertices - 1);
}

static PetscErrorCode cycles(Fixture *f, int n)
{
  StageResult result;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(&result, sizeof(result)));
  const Stage *stage = f->scene->stages;
  for (int i = 0; i < n; i++) {
    LoadsApply(f->model, f->state, PetscMin(1., (PetscReal)(f->state->cycle + 1) / stage->ramp));
    PetscCall(Step(f->scene, f->model, stage->joints, f->contacts, f->state, &f->relax->damping, NULL));
    if (f->state->cycle % 40) continue; // contacts change while the wall slides
    PetscCall(Secant(f->model, f->state, 1., PETSC_FALSE, &f->relax->damping));
    PetscCall(Forces(f->scene, f->model, stage->joints, f->contacts, f->state, NULL));
    PetscCall(ContactsVerify(f->scene, stage->joints, f->model, f->state, f->contacts, &result));
    PetscCall(ScaledMasses(f->scene, f->model, stage->joints, f->contacts, f->state));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode start(Fixture *f)
{
  PetscFunctionBeginUser;
  PetscCall(LoadsTarget(f->scene, f->model, f->scene->stages, f->state));
  PetscCall(ScaledMasses(f->scene, f->model, f->scene->stages->joints, f->contacts, f->state));
  PetscCall(RelaxationStart(f->model, f->contacts, f->state, f->relax));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode all_parts(Archive *a, Fixture *f)
{
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(a->part, "state", sizeof(a->part)));
  PetscCall(StateArchive(a, f->scene, f->model, f->state, f->contacts));
  PetscCall(PetscStrncpy(a->part, "relaxation", sizeof(a->part)));
  PetscCall(RelaxationArchive(a, f->model, f->relax));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadOnOneRankGoesOnWithTheSameBits(void)
{
  Fixture f, twin;
  Archive archive;
  uint64_t before, after, now;
  PetscMPIInt rank;
  PetscBool valid;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", yaml));
  PetscCall(start(&f));
  PetscCall(cycles(&f, 333));
  PetscCall(ArchiveCreate(PETSC_COMM_WORLD, &archive));
  PetscCall(all_parts(&archive, &f));
  PetscCall(StateChecksum(f.model, f.state, f.contacts, &before));
  PetscCall(cycles(&f, 400));
  PetscCall(StateChecksum(f.model, f.state, f.contacts, &after));
  PetscReal slipped = 0.;
  for (PetscInt i = 0; i < 2 * f.contacts->n_padded; i++)
    slipped = PetscMax(slipped, PetscAbsReal(f.contacts->slip[i]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &slipped, 1, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD));
  ENSURE(slipped > 1e-4); // there is a history to keep
  ENSURE(before != after);

  // the same ranks again, from a state that has gone on
  archive.reading = PETSC_TRUE;
  PetscCall(all_parts(&archive, &f));
  PetscCall(ContactsIsValid(f.model, f.contacts, &valid));
  ENSURE(valid);
  PetscCall(StateChecksum(f.model, f.state, f.contacts, &now));
  ENSURE(now == before);
  PetscCall(cycles(&f, 400));
  PetscCall(StateChecksum(f.model, f.state, f.contacts, &now));
  ENSURE(now == after);
  if (!rank) { // one rank, from the start
    PetscCall(FixtureOpen(PETSC_COMM_SELF, &sketch, &twin, "%s", yaml));
    PetscCall(start(&twin));
    archive.comm = PETSC_COMM_SELF;
    PetscCall(all_parts(&archive, &twin));
    ENSURE(!archive.message[0]);
    PetscCall(StateChecksum(twin.model, twin.state, twin.contacts, &now));
    ENSURE(now == before);
    PetscCall(cycles(&twin, 400));
    PetscCall(StateChecksum(twin.model, twin.state, twin.contacts, &now));
    ENSURE(now == after);
    PetscCall(FixtureClose(&twin));
  }
  PetscCall(ArchiveDestroy(&archive));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MissingEntriesAreReported(void)
{
  Archive a;
  PetscReal x[3] = {1., 2., 3.};
  PetscBool has;
  char *text = NULL;
  PetscFunctionBeginUser;
  PetscCall(ArchiveCreate(PETSC_COMM_WORLD, &a));
  PetscCall(PetscStrncpy(a.part, "part", sizeof(a.part)));
  PetscCall(ArchiveReals(&a, "x", 3, x));
  PetscCall(ArchiveText(&a, "text", &text));
  a.reading = PETSC_TRUE;
  PetscCall(ArchiveHasPart(&a, "part", &has));
  ENSURE(has);
  PetscCall(ArchiveHasPart(&a, "par", &has));
  ENSURE(!has);
  PetscCall(ArchiveText(&a, "text", &text));
  ENSURE(!text && !a.message[0]);
  PetscCall(ArchiveReals(&a, "x", 2, x));
  ENSURE(a.rank || strstr(a.message, "part/x is of another size"));
  a.message[0] = 0;
  PetscCall(ArchiveReals(&a, "y", 3, x));
  ENSURE(a.rank || strstr(a.message, "part/y is missing"));
  PetscCall(ArchiveDestroy(&a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One number of the contacts in the archive becomes another: refused, and no other memory is touched. */
static PetscErrorCode forged(Archive *archive, Fixture *f, PetscInt row, int column, PetscInt64 other,
                             const char *wanted)
{
  PetscInt64 kept = 0, *at = NULL;
  PetscFunctionBeginUser;
  ArchiveEntry *e = archive->rank ? NULL : ArchiveFind(archive, "state/contacts_key");
  if (e) {
    at = (PetscInt64 *)e->data + e->columns * (size_t)(row < 0 ? (PetscInt)e->rows + row : row) + column;
    kept = *at, *at = other;
  }
  archive->message[0] = 0;
  PetscCall(all_parts(archive, f));
  ENSURE(archive->rank || strstr(archive->message, wanted));
  if (!archive->rank && !strstr(archive->message, wanted))
    printf("wanted '%s', not '%s'\n", wanted, archive->message);
  if (at) *at = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Behind a checksum that fits: whoever wrote the file may have been another program, or meant no good. */
static PetscErrorCode ContactsOfNoModelAreRefused(void)
{
  static const struct {
    PetscInt row;
    int column;
    PetscInt64 other;
    const char *wanted;
  } cases[] = {
      {0, 0, STRESS_MODELS, "state/contacts_key: the stress model of row 0 is none of this model"},
      {0, 0, -1, "the stress model of row 0"},
      {1, 1, -1, "the face of row 1"},
      {1, 1, (PetscInt64)1 << 40, "the face of row 1"},
      {-1, 2, (PetscInt64)1 << 33, "the face of row"}, // its lower half is 0
      {1, 2, -1, "the face of row 1"},
      {1, 2, -1000000, "the face of row 1"},
      {2, 3, VERTEX_FACE, "the class of row 2"},
      {2, 3, 5, "the class of row 2"},
      {2, 3, -1, "the class of row 2"},
      {3, 4, 1, "the joint of row 3"},
      {3, 4, 1000000, "the joint of row 3"},
      {3, 4, -1, "the joint of row 3"},
      {3, 5, 8, "the state of row 3"},
      {3, 6, 256, "the state of row 3"},
      {2, 1, 0, "the place of row 2"},
      {-1, 2, 1, "1 of its "}, // another side of a block, which is no face that contacts have
  };
  Fixture f;
  Archive archive;
  uint64_t before, now;
  PetscFunctionBeginUser;
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", yaml));
  PetscCall(start(&f));
  PetscCall(cycles(&f, 333));
  PetscCall(ArchiveCreate(PETSC_COMM_WORLD, &archive));
  PetscCall(all_parts(&archive, &f));
  PetscCall(StateChecksum(f.model, f.state, f.contacts, &before));
  archive.reading = PETSC_TRUE;
  for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++)
    PetscCall(forged(&archive, &f, cases[i].row, cases[i].column, cases[i].other, cases[i].wanted));
  archive.message[0] = 0;
  PetscCall(all_parts(&archive, &f));
  ENSURE(!archive.message[0]);
  PetscCall(StateChecksum(f.model, f.state, f.contacts, &now));
  ENSURE(now == before);
  PetscCall(ArchiveDestroy(&archive));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers that others are counted by. */
static PetscErrorCode NumbersOutOfRangeAreRefused(void)
{
  Archive a;
  StageResult result = {.verdict = VERDICT_CONVERGED};
  PetscFunctionBeginUser;
  PetscCall(ArchiveCreate(PETSC_COMM_WORLD, &a));
  PetscCall(PetscStrncpy(a.part, "part", sizeof(a.part)));
  ENSURE(ArchiveWithin(&a, "n", 3, 0, 3) == 3 && !a.message[0]);
  ENSURE(ArchiveWithin(&a, "n", 4, 1, 3) == 1);
  ENSURE(a.rank || !strcmp(a.message, "part/n: 4 is not from 1 to 3"));
  ENSURE(ArchiveWithin(&a, "other", -1, 0, 3) == 0);
  ENSURE(a.rank || strstr(a.message, "part/n")); // the first one stands
  a.message[0] = 0;
  PetscCall(ArchiveResult(&a, "last", &result));
  a.reading = PETSC_TRUE;
  if (!a.rank) *(PetscInt64 *)ArchiveFind(&a, "part/last_counts")->data = 99;
  PetscCall(ArchiveResult(&a, "last", &result));
  ENSURE(result.verdict == VERDICT_NONE);
  ENSURE(a.rank || !strcmp(a.message, "part/verdict: 99 is not from 0 to 6"));
  PetscCall(ArchiveDestroy(&a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a dataset of one column, of which the first chunk is stored. */
static void put_rows(hid_t file, const char *name, hid_t type, hsize_t rows, const void *row, hsize_t chunk)
{
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE),
              all = H5Screate_simple(2, (hsize_t[]){rows, 1}, NULL),
              some = H5Screate_simple(2, (hsize_t[]){chunk, 1}, NULL);
  H5Pset_chunk(properties, 2, (hsize_t[]){chunk, 1});
  const hid_t set = H5Dcreate2(file, name, type, all, H5P_DEFAULT, properties, H5P_DEFAULT);
  H5Sselect_hyperslab(all, H5S_SELECT_SET, (hsize_t[]){0, 0}, NULL, (hsize_t[]){chunk, 1}, NULL);
  ENSURE(set >= 0 && H5Dwrite(set, type, some, all, H5P_DEFAULT, row) >= 0);
  H5Dclose(set);
  H5Sclose(some);
  H5Sclose(all);
  H5Pclose(properties);
}

/* A file whose checksum fits and whose sizes, in bytes, are more than a computer counts: 2^61 + 1 numbers
   of 8 bytes are 8 bytes. Refused before memory for them is taken. */
static PetscErrorCode SizesThatOverflowAreRefused(void)
{
  static const char contents[] = "x 0 2305843009213693953 1\n";
  const double x = 1.;
  char path[] = "/tmp/quoin_archive_XXXXXX", header[ARCHIVE_HEADER], message[MESSAGE_LENGTH] = "";
  Archive a;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, 1 << 20, 0);
  const hid_t file = H5Fcreate("forged", H5F_ACC_TRUNC, H5P_DEFAULT, access);
  put_rows(file, "contents", H5T_STD_U8LE, sizeof contents - 1, contents, sizeof contents - 1);
  put_rows(file, "x", H5T_IEEE_F64LE, ((hsize_t)1 << 61) + 1, &x, 1);
  H5Fflush(file, H5F_SCOPE_GLOBAL);
  const size_t bytes = (size_t)H5Fget_file_image(file, NULL, 0);
  char *image = malloc(bytes);
  H5Fget_file_image(file, image, bytes);
  H5Fclose(file);
  H5Pclose(access);
  ArchiveHeader(bytes, HashBytes(0, image, bytes), QUOIN_VERSION, header);
  const int descriptor = mkstemp(path);
  ENSURE(write(descriptor, header, ARCHIVE_HEADER) == ARCHIVE_HEADER);
  ENSURE(write(descriptor, image, bytes) == (ssize_t)bytes);
  close(descriptor);
  free(image);
  PetscCall(ArchiveCreate(PETSC_COMM_SELF, &a));
  PetscCall(ArchiveReadFile(&a, path, message));
  ENSURE(!strcmp(message, "HDF5 cannot read it") && !ArchiveFind(&a, "x"));
  PetscCall(ArchiveDestroy(&a));
  unlink(path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  make_sketch();
  RUN_TEST(ReadOnOneRankGoesOnWithTheSameBits);
  RUN_TEST(MissingEntriesAreReported);
  RUN_TEST(ContactsOfNoModelAreRefused);
  RUN_TEST(NumbersOutOfRangeAreRefused);
  RUN_TEST(SizesThatOverflowAreRefused);
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}
