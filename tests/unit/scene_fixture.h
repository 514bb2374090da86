/* scene_fixture.h: small models made at run time. A Sketch is a block mesh in memory; FixtureOpen writes it
   to a scratch folder, adds a scene and sets Quoin up; the insides are then open to the test. The same sketch
   on PETSC_COMM_SELF is the serial twin of a parallel model. */
#pragma once
#include "check.h"
#include "run/run.h"
#include <hdf5.h>
#include <stdarg.h>
#include <unistd.h>

/* ---- numbers */

/* uniform in [a,b], the same on every machine */
static inline double Uniform(double a, double b)
{
  static uint64_t state = 88172645463325252u;
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return a + (b - a) * (double)(state >> 11) * 0x1p-53;
}

/* ---- sketch */

enum { SKETCH_VERTICES = 2048, SKETCH_BLOCKS = 2048, SKETCH_NAMES = 8, SKETCH_SET = 64 };
typedef enum { QUADS, TRIANGLES } SketchShape;

typedef struct {
  PetscInt n_vertices, n_blocks, n_groups, n_sets, n_points;
  double X[2 * SKETCH_VERTICES];
  int blocks[4 * SKETCH_BLOCKS], group[SKETCH_BLOCKS];
  char group_names[SKETCH_NAMES][NAME_LENGTH];
  int rigid[SKETCH_NAMES];
  char set_names[SKETCH_NAMES][NAME_LENGTH], point_names[SKETCH_NAMES][NAME_LENGTH];
  int set_n[SKETCH_NAMES], set_faces[SKETCH_NAMES][2 * SKETCH_SET], point_vertex[SKETCH_NAMES];
} Sketch;

static inline int SketchGroup(Sketch *s, const char *name, int rigid)
{
  snprintf(s->group_names[s->n_groups], NAME_LENGTH, "%s", name);
  s->rigid[s->n_groups] = rigid;
  return (int)s->n_groups++;
}

static inline int SketchVertex(Sketch *s, double x, double y)
{
  s->X[2 * s->n_vertices] = x, s->X[2 * s->n_vertices + 1] = y;
  return (int)s->n_vertices++;
}

/* d = -1: a triangle */
static inline int SketchBlock(Sketch *s, int group, int a, int b, int c, int d)
{
  int *ring = s->blocks + 4 * s->n_blocks;
  ring[0] = a, ring[1] = b, ring[2] = c, ring[3] = d;
  s->group[s->n_blocks] = group;
  return (int)s->n_blocks++;
}

/* One macroblock of nx x ny cells over a quadrilateral (corners counter-clockwise), row by row; returns its
   first block. Vertex (i,j) is the first vertex of the macroblock + j (nx + 1) + i. */
static inline int SketchGrid(Sketch *s, int group, const double corner[8], int nx, int ny, SketchShape shape)
{
  const int first = (int)s->n_vertices, block = (int)s->n_blocks;
  for (int j = 0; j <= ny; j++)
    for (int i = 0; i <= nx; i++) {
      const double a = (double)i / nx, b = (double)j / ny;
      const double N[4] = {(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b};
      double x[2] = {0, 0};
      for (int k = 0; k < 8; k++) x[k % 2] += N[k / 2] * corner[k];
      SketchVertex(s, x[0], x[1]);
    }
  for (int j = 0; j < ny; j++)
    for (int i = 0; i < nx; i++) {
      const int v = first + j * (nx + 1) + i, w = v + nx + 1;
      if (shape == QUADS) SketchBlock(s, group, v, v + 1, w + 1, w);
      if (shape == TRIANGLES)
        SketchBlock(s, group, v, v + 1, w + 1, -1), SketchBlock(s, group, v, w + 1, w, -1);
    }
  return block;
}

static inline int SketchBox(Sketch *s, int group, double x, double y, double width, double height)
{
  const double corner[8] = {x, y, x + width, y, x + width, y + height, x, y + height};
  return SketchGrid(s, group, corner, 1, 1, QUADS);
}

/* Adds face k of a block to a set, which is made when it is new. */
static inline void SketchFace(Sketch *s, const char *set, int block, int k)
{
  int i = 0;
  while (i < s->n_sets && strcmp(s->set_names[i], set)) i++;
  if (i == s->n_sets) snprintf(s->set_names[s->n_sets++], NAME_LENGTH, "%s", set);
  int *face = s->set_faces[i] + 2 * s->set_n[i]++;
  face[0] = block, face[1] = k;
}

static inline void SketchPoint(Sketch *s, const char *name, int vertex)
{
  snprintf(s->point_names[s->n_points], NAME_LENGTH, "%s", name);
  s->point_vertex[s->n_points++] = vertex;
}

/* Turns the vertices from `first` on about (0,0), then moves them. */
static inline void SketchMove(Sketch *s, PetscInt first, double angle, double x, double y)
{
  for (double *X = s->X + 2 * first; X < s->X + 2 * s->n_vertices; X += 2) {
    const double X0 = X[0], X1 = X[1];
    X[0] = cos(angle) * X0 - sin(angle) * X1 + x;
    X[1] = sin(angle) * X0 + cos(angle) * X1 + y;
  }
}

static inline void SketchWriteOne(hid_t file, const char *path, hid_t type, hsize_t n, hsize_t width,
                                  const void *data)
{
  const hsize_t size[2] = {n, width};
  const hid_t links = H5Pcreate(H5P_LINK_CREATE), space = H5Screate_simple(width ? 2 : 1, size, NULL);
  H5Pset_create_intermediate_group(links, 1);
  const hid_t set = H5Dcreate2(file, path, type, space, links, H5P_DEFAULT, H5P_DEFAULT);
  H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
  H5Dclose(set);
  H5Sclose(space);
  H5Pclose(links);
}

static inline void SketchAttribute(hid_t file, const char *name, hid_t type, const void *value)
{
  const hid_t space = H5Screate(H5S_SCALAR),
              attribute = H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(attribute, type, value);
  H5Aclose(attribute);
  H5Sclose(space);
}

static inline void SketchWrite(const Sketch *s, const char *path)
{
  const hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t format = H5Tcopy(H5T_C_S1), name = H5Tcopy(H5T_C_S1);
  const int version = 1;
  char at[2 * NAME_LENGTH];
  H5Tset_size(format, strlen("quoin-mesh"));
  H5Tset_size(name, NAME_LENGTH);
  SketchAttribute(file, "format", format, "quoin-mesh");
  SketchAttribute(file, "version", H5T_NATIVE_INT, &version);
  SketchWriteOne(file, "/vertices", H5T_NATIVE_DOUBLE, (hsize_t)s->n_vertices, 2, s->X);
  SketchWriteOne(file, "/blocks", H5T_NATIVE_INT, (hsize_t)s->n_blocks, 4, s->blocks);
  SketchWriteOne(file, "/block_group", H5T_NATIVE_INT, (hsize_t)s->n_blocks, 0, s->group);
  SketchWriteOne(file, "/groups/name", name, (hsize_t)s->n_groups, 0, s->group_names);
  SketchWriteOne(file, "/groups/rigid", H5T_NATIVE_INT, (hsize_t)s->n_groups, 0, s->rigid);
  for (int i = 0; i < s->n_sets; i++) {
    snprintf(at, sizeof at, "/face_sets/%s", s->set_names[i]);
    SketchWriteOne(file, at, H5T_NATIVE_INT, (hsize_t)s->set_n[i], 2, s->set_faces[i]);
  }
  for (int i = 0; i < s->n_points; i++) {
    snprintf(at, sizeof at, "/points/%s", s->point_names[i]);
    SketchWriteOne(file, at, H5T_NATIVE_INT, 1, 0, s->point_vertex + i);
  }
  H5Tclose(format);
  H5Tclose(name);
  H5Fclose(file);
}

/* ---- fixture */

typedef struct {
  Quoin quoin;
  Scene *scene;
  Model *model;
  State *state;
  Contacts *contacts;
  struct _p_Relaxation *relax;
  PetscReal *u_vertex; /* the vertex part of state->u */
} Fixture;

static char fixture_message[MESSAGE_LENGTH]; /* why the set-up was refused */
static const char *fixture_refusal;          /* what EnsureRefused waits for */

static inline PetscErrorCode FixtureOnError(MPI_Comm comm, int line, const char *function, const char *file,
                                            PetscErrorCode code, PetscErrorType type, const char *message,
                                            void *context)
{
  if (code != PETSC_ERR_USER_INPUT && code != PETSC_ERR_MEM)
    return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, context);
  if (type == PETSC_ERROR_INITIAL) snprintf(fixture_message, sizeof fixture_message, "%s", message);
  return code;
}

/* Collective. yaml: printf format of the scene less its model. PETSC_ERR_USER_INPUT, or PETSC_ERR_MEM,
   with fixture_message, when Quoin refuses it. */
static inline PetscErrorCode FixtureOpen(MPI_Comm comm, const Sketch *s, Fixture *f, const char *yaml, ...)
    __attribute__((format(printf, 4, 5)));
static inline PetscErrorCode FixtureOpen(MPI_Comm comm, const Sketch *s, Fixture *f, const char *yaml, ...)
{
  char folder[] = "/tmp/quoin_scene_XXXXXX", model[64], scene[64];
  PetscMPIInt rank;
  va_list arguments;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) PetscCheck(mkdtemp(folder), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "no scratch folder");
  PetscCallMPI(MPI_Bcast(folder, sizeof folder, MPI_CHAR, 0, comm));
  snprintf(model, sizeof model, "%s/model.h5", folder);
  snprintf(scene, sizeof scene, "%s/scene.yaml", folder);
  if (rank == 0) {
    SketchWrite(s, model);
    FILE *file = fopen(scene, "w");
    PetscCheck(file, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "no scene");
    fprintf(file, "model: %s\n", model);
    va_start(arguments, yaml);
    vfprintf(file, yaml, arguments);
    va_end(arguments);
    fclose(file);
  }
  PetscCallMPI(MPI_Barrier(comm));
  fixture_message[0] = 0;
  PetscCall(PetscPushErrorHandler(FixtureOnError, NULL));
  PetscCall(QuoinCreate(comm, &f->quoin));
  PetscErrorCode code = QuoinSetFromOptions(f->quoin, scene, 0, NULL);
  if (!code) code = QuoinSetUp(f->quoin);
  PetscCall(PetscPopErrorHandler());
  PetscCallMPI(MPI_Barrier(comm));
  if (rank == 0) unlink(model), unlink(scene), rmdir(folder);
  if (code && !fixture_refusal) fprintf(stderr, "refused: %s\n", fixture_message);
  if (code) PetscFunctionReturn(code);
  PetscCall(QuoinGetParts(f->quoin, &f->scene, &f->model, &f->state, &f->contacts, &f->relax));
  f->u_vertex = f->state->u + 3 * f->model->rigid.n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline PetscErrorCode FixtureClose(Fixture *f)
{
  PetscFunctionBeginUser;
  PetscCall(QuoinDestroy(&f->quoin));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A scene that Quoin must refuse, in words with this fragment. */
static inline PetscErrorCode EnsureRefused(const Sketch *s, const char *yaml, const char *fragment)
{
  Fixture f;
  PetscFunctionBeginUser;
  fixture_refusal = fragment;
  LEAKS_ALLOWED();
  const PetscErrorCode code = FixtureOpen(PETSC_COMM_WORLD, s, &f, "%s", yaml);
  LEAKS_COUNT();
  fixture_refusal = NULL;
  ENSURE(code == PETSC_ERR_USER_INPUT);
  ENSURE(strstr(fixture_message, fragment) != NULL);
  if (!strstr(fixture_message, fragment)) fprintf(stderr, "the message was: %s\n", fixture_message);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- finding things again */

/* local vertex of a vertex of the sketch, -1: not here */
static inline PetscInt LocalOfFile(const Model *m, PetscInt file)
{
  for (PetscInt v = 0; v < m->mesh.n_vertices; v++)
    if (m->mesh.vertex_file[v] == file) return v;
  return -1;
}

/* first dof of the owned rigid body at a vertex of the sketch, or of the owned deformable vertex */
static inline PetscInt DofOf(const Model *m, PetscInt file)
{
  const PetscInt v = LocalOfFile(m, file);
  return v < m->mesh.n_deformable ? 3 * m->rigid.n + 2 * v : 3 * RigidOfVertex(m, v);
}

/* ---- running: stage `number` as StageRun does it, for so many cycles, without verdicts and output */

static inline PetscErrorCode StageStart(Fixture *f, PetscInt number)
{
  Stage *stage = f->scene->stages + number;
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(f->state->applied.start, f->state->f_ext, f->model->n_dof));
  PetscCall(LoadsTarget(f->scene, f->model, stage, f->state));
  PetscCall(ScaledMasses(f->scene, f->model, stage->joints, f->contacts, f->state));
  LoadsApply(f->model, f->state, stage->ramp ? 0. : 1.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline PetscErrorCode StageCycles(Fixture *f, PetscInt number, PetscInt n)
{
  const Stage *stage = f->scene->stages + number;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) {
    if (f->state->applied.ramp < 1.)
      LoadsApply(f->model, f->state, PetscMin(1., f->state->applied.ramp + 1. / stage->ramp));
    PetscCall(Step(f->scene, f->model, stage->joints, f->contacts, f->state, &f->relax->damping, NULL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
