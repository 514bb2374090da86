/* Finding contacts: the classes of two faces (Fig. 3), the limits of what touches, and random assemblies, on
   which the search finds the contacts that brute force finds, the same on any number of ranks.
   ranks: 1 2 4 */
#include "scene_fixture.h"
#include "validity.h"
#include "contacts/geometry.h"

static const double TOLERANCE = 5e-3, DEPTH = 5e-3;
static Sketch sketch;

/* ---- two faces: a runs along +x below its block, b back along -x above its own */

static int Classify(double b0x, double b0y, double b1x, double b1y, FacePair *pair)
{
  const PetscReal a[4] = {0, 0, 1, 0}, b[4] = {b0x, b0y, b1x, b1y};
  return FacePairClassify(a, b, TOLERANCE, DEPTH, pair);
}

static void ClassesFollowFig3(void)
{
  static const struct {
    double b0, b1;
    ContactClass klass;
    int source[2], corner[2];
    double t[2], length;
  } table[] = {
      {1, 0, FF1_12, {0, 0}, {0, 1}, {1, 0}, 1},            // equal faces: a tie
      {2, -1, FF1_12, {0, 0}, {0, 1}, {2. / 3, 1. / 3}, 1}, // a inside b
      {.7, .3, FF1_21, {1, 1}, {1, 0}, {.3, .7}, .4},       // b inside a
      {.5, -.5, FF2_I, {0, 1}, {0, 0}, {.5, .5}, .5},       // shifted back: first vertices of both
      {1.5, .5, FF2_F, {1, 0}, {1, 1}, {.5, .5}, .5},       // shifted on: second vertices
      {1, -.5, FF1_12, {0, 0}, {0, 1}, {2. / 3, 0}, 1},     // one end in common
      {.5, 0, FF1_21, {1, 1}, {1, 0}, {0, .5}, .5},
      {1, .5, FF1_21, {1, 1}, {1, 0}, {.5, 1}, .5},
      {1 + 1e-10, 1e-10, FF1_12, {0, 0}, {0, 1}, {1, 0}, 1}, // nearer than a tie
  };
  for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
    FacePair p = {0};
    ENSURE(Classify(table[i].b0, 0, table[i].b1, 0, &p) == FACES_TOUCH);
    ENSURE(p.klass == table[i].klass);
    ENSURE_NEAR(p.length, table[i].length, 2e-10);
    for (int k = 0; k < 2; k++) {
      ENSURE(p.source[k] == table[i].source[k] && p.corner[k] == table[i].corner[k]);
      ENSURE_NEAR(p.t[k], table[i].t[k], 2e-10);
      ENSURE_NEAR(p.gap[k], 0, 0);
    }
  }
}

/* Exchanging the two faces exchanges FF1-12 and FF1-21 and the two ends, and nothing else. */
static void ExchangingTheFacesMirrorsTheContact(void)
{
  static const ContactClass mirror[] = {FF1_12, FF1_21, FF2_I, FF2_F};
  int seen[4] = {0};
  for (int i = 0; i < 2000; i++) {
    const double angle = Uniform(0, 7), c = cos(angle), s = sin(angle), low = Uniform(-2, 1),
                 high = Uniform(low, 2);
    const double tilt = Uniform(-1e-3, 1e-3),
                 e[2][2] = {{high, tilt * high + 2e-3}, {low, tilt * low + 2e-3}};
    PetscReal a[4] = {0, 0, c, s}, b[4];
    FacePair p = {0}, q = {0};
    for (int k = 0; k < 2; k++)
      b[2 * k] = c * e[k][0] + s * e[k][1], b[2 * k + 1] = s * e[k][0] - c * e[k][1];
    const int touch = FacePairClassify(a, b, TOLERANCE, DEPTH, &p);
    ENSURE(touch == FacePairClassify(b, a, TOLERANCE, DEPTH, &q));
    if (touch == FACES_APART) continue;
    seen[p.klass]++;
    ENSURE(q.klass == mirror[p.klass]);
    ENSURE_NEAR(q.length / p.length, 1, 2e-3 / p.length);
    for (int k = 0; k < 2; k++) {
      ENSURE(q.source[k] == 1 - p.source[1 - k] && q.corner[k] == p.corner[1 - k]);
      ENSURE_NEAR(q.t[k], p.t[1 - k], 1e-12);
      ENSURE_NEAR(q.gap[k], p.gap[1 - k], 1e-12);
    }
  }
  for (int k = 0; k < 4; k++) ENSURE(seen[k] > 50);
}

static void GapsUpToTheToleranceTouch(void)
{
  const double in = 1 - 1e-9, out = 1 + 1e-9;
  FacePair p = {0};
  ENSURE(Classify(1, -TOLERANCE * in, 0, -TOLERANCE * in, &p) == FACES_TOUCH); // below a: apart
  ENSURE_NEAR(p.gap[0], TOLERANCE, 1e-9 * TOLERANCE);
  ENSURE(Classify(1, -TOLERANCE * out, 0, -TOLERANCE * out, &p) == FACES_APART);
  ENSURE(Classify(1, DEPTH * in, 0, DEPTH * in, &p) == FACES_TOUCH); // inside a's block: overlap
  ENSURE_NEAR(p.gap[1], -DEPTH, 1e-9 * DEPTH);
  ENSURE(Classify(1, DEPTH * out, 0, DEPTH * out, &p) == FACES_APART);
  ENSURE(Classify(1, 0, 0, -TOLERANCE * 1.001, &p) == FACES_APART); // one end is enough to part them
  ENSURE(Classify(1, 0, 0, -TOLERANCE * 0.99, &p) == FACES_TOUCH);
}

static void OnlyNearlyOppositeFacesTouch(void)
{
  FacePair p = {0};
  const PetscReal a[4] = {0, 0, 1, 0};
  for (int degree = 0; degree < 360; degree++) {
    const double angle = degree * PETSC_PI / 180, c = cos(angle), s = sin(angle);
    const PetscReal b[4] = {.5 - .5 * c, -.5 * s, .5 + .5 * c, .5 * s};
    ENSURE(FacePairClassify(a, b, 1, 1, &p) == (degree >= 160 && degree <= 200 ? FACES_TOUCH : FACES_APART));
  }
  ENSURE(Classify(0, 0, 0, -1, &p) == FACES_APART); // the corner of two bricks
  ENSURE(Classify(0, 0, 1, 0, &p) == FACES_APART);  // side by side
}

static void OverlapsBelowTheMinimumDoNotTouch(void)
{
  FacePair p = {0};
  ENSURE(Classify(0, 0, -1, 0, &p) == FACES_APART);
  ENSURE(Classify(.9e-6, 0, -1, 0, &p) == FACES_APART);
  ENSURE(Classify(1.1e-6, 0, -1, 0, &p) == FACES_TOUCH);
  ENSURE_NEAR(p.length, 1.1e-6, 1e-12);
  ENSURE(Classify(1.1e-9, 0, -1e-3, 0, &p) == FACES_TOUCH); // relative to the shorter face
}

/* ---- assemblies */

/* A format: rows of joints beside the default. */
static const char scene[] = "materials: {soft: {density: 2000, young: 1e9, poisson: 0.2},"
                            " hard: {density: 3000, rigid: true}}\n"
                            "joints: {default: {k_n: 1e9, k_s: 3e8, friction: 30}%s}\n"
                            "relaxation: {allow_floating: true}\n"
                            "loads: {weight: {type: self_weight}}\n"
                            "stages: [all: {loads: [weight]}]\n";
static const char row_of_pair[] = ", soft+hard: {k_n: 2e9, k_s: 1e9, friction: 20, stress_model: pt}";

typedef struct {
  PetscInt face[2]; // 4 file id + k, lower first
  PetscInt klass, joint;
  PetscReal length;
} Found;

static int FoundOrder(const void *a, const void *b)
{
  const Found *f = a, *g = b;
  const int first = (f->face[0] > g->face[0]) - (f->face[0] < g->face[0]);
  return first ? first : (f->face[1] > g->face[1]) - (f->face[1] < g->face[1]);
}

/* The contacts of all ranks in file numbers, ascending; each must be owned once. Free with free(). */
static PetscErrorCode Gather(const Fixture *f, int *n_found, Found **found)
{
  const Model *m = f->model;
  const Contacts *c = f->contacts;
  PetscInt *file;
  int n = 0, counts[16], starts[16], bytes;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->mesh.n_blocks_global, &file));
  for (PetscInt b = 0; b < m->mesh.n_blocks_global; b++) file[b] = -1;
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + MOVING_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++) file[list->gid[e]] = list->file[e];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, file, (int)m->mesh.n_blocks_global, MPIU_INT, MPI_MAX, m->comm));
  Found *mine = calloc((size_t)c->n + 1, sizeof *mine);
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (!c->owned[i]) continue;
    Found *row = mine + n++;
    for (int k = 0; k < 2; k++) row->face[k] = 4 * file[c->key[2 * i + k] / 4] + c->key[2 * i + k] % 4;
    if (row->face[0] > row->face[1]) {
      const PetscInt swap = row->face[0];
      row->face[0] = row->face[1], row->face[1] = swap;
    }
    row->klass = c->klass[i], row->joint = c->joint[i], row->length = c->length[i];
  }
  bytes = n * (int)sizeof *mine;
  PetscCallMPI(MPI_Allgather(&bytes, 1, MPI_INT, counts, 1, MPI_INT, m->comm));
  starts[0] = 0;
  for (PetscMPIInt r = 1; r < m->size; r++) starts[r] = starts[r - 1] + counts[r - 1];
  const int total = starts[m->size - 1] + counts[m->size - 1];
  *n_found = total / (int)sizeof *mine;
  *found = malloc((size_t)total + 1);
  PetscCallMPI(MPI_Allgatherv(mine, bytes, MPI_BYTE, *found, counts, starts, MPI_BYTE, m->comm));
  qsort(*found, (size_t)*n_found, sizeof **found, FoundOrder);
  free(mine);
  PetscCall(PetscFree(file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int Corners(int block)
{
  return sketch.blocks[4 * block + 3] < 0 ? 3 : 4;
}

/* A face is outer when no other block has its edge. */
static int IsOuter(int block, int k)
{
  const int *ring = sketch.blocks + 4 * block, a = ring[k], b = ring[(k + 1) % Corners(block)];
  for (int other = 0; other < sketch.n_blocks; other++)
    for (int j = 0; other != block && j < Corners(other); j++) {
      const int *o = sketch.blocks + 4 * other;
      if (o[j] == b && o[(j + 1) % Corners(other)] == a) return 0;
    }
  return 1;
}

static void FaceEnds(int block, int k, PetscReal x[4])
{
  const int *ring = sketch.blocks + 4 * block;
  for (int i = 0; i < 4; i++) x[i] = sketch.X[2 * ring[(k + i / 2) % Corners(block)] + i % 2];
}

/* All pairs of outer faces; body_of: macroblock of each block. */
static int BruteForce(const int *body_of, Found *found)
{
  int n = 0;
  for (int f = 0; f < 4 * sketch.n_blocks; f++) {
    if (f % 4 >= Corners(f / 4) || !IsOuter(f / 4, f % 4)) continue;
    for (int g = f + 1; g < 4 * sketch.n_blocks; g++) {
      PetscReal a[4], b[4];
      FacePair pair;
      if (body_of[f / 4] == body_of[g / 4] || g % 4 >= Corners(g / 4) || !IsOuter(g / 4, g % 4)) continue;
      FaceEnds(f / 4, f % 4, a);
      FaceEnds(g / 4, g % 4, b);
      if (FacePairClassify(a, b, TOLERANCE, DEPTH, &pair) == FACES_APART) continue;
      found[n++] = (Found){{f, g}, pair.klass, 0, pair.length};
    }
  }
  qsort(found, (size_t)n, sizeof *found, FoundOrder);
  return n;
}

/* Courses of bricks of random length, cells and kind, with joints of 0 to 8 mm, in any direction; beside them
   one soft box touches a hard one, for the row of this pair must have a contact. */
static void RandomAssembly(int *body_of)
{
  memset(&sketch, 0, sizeof sketch);
  const int group[2] = {SketchGroup(&sketch, "soft", 0), SketchGroup(&sketch, "hard", 1)};
  int body = 0;
  for (double y = 0; y < 3; y += 1 + Uniform(0, 8e-3))
    for (double x = Uniform(-1, 0), width; x < 5; x += width + Uniform(0, 8e-3)) {
      width = Uniform(0.6, 2);
      const double corner[8] = {x, y, x + width, y, x + width, y + 1, x, y + 1};
      const int nx = 1 + (int)Uniform(0, 3), ny = 1 + (int)Uniform(0, 2);
      SketchGrid(&sketch, group[Uniform(0, 1) < .3], corner, nx, ny, Uniform(0, 1) < .5 ? QUADS : TRIANGLES);
      for (int b = sketch.n_blocks - 1; b >= 0 && body_of[b] < 0; b--) body_of[b] = body;
      body++;
    }
  for (int i = 0; i < 2; i++, body++) {
    body_of[sketch.n_blocks] = body;
    SketchBox(&sketch, group[i], 9 + i, 0, 1, 1);
  }
  SketchMove(&sketch, 0, Uniform(0, 6), Uniform(-50, 50), Uniform(-50, 50));
}

static PetscErrorCode FoundContactsAreThoseOfBruteForce(void)
{
  static Found expected[16 * SKETCH_BLOCKS];
  static int body_of[SKETCH_BLOCKS];

  PetscFunctionBeginUser;
  for (int trial = 0; trial < 12; trial++) {
    Fixture f;
    Found *found;
    int n;
    PetscBool valid;
    memset(body_of, -1, sizeof body_of);
    RandomAssembly(body_of);
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, scene, row_of_pair));
    PetscCall(ContactsIsValid(f.model, f.contacts, &valid));
    ENSURE(valid);
    PetscCall(Gather(&f, &n, &found));
    ENSURE(n == BruteForce(body_of, expected) && n > 10);
    for (int i = 0; i < n; i++) {
      ENSURE(found[i].face[0] == expected[i].face[0] && found[i].face[1] == expected[i].face[1]);
      ENSURE_NEAR(found[i].length, expected[i].length, 1e-9);
    }
    free(found);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ContactsAreTheSameOnAnyNumberOfRanks(void)
{
  static int body_of[SKETCH_BLOCKS];

  PetscFunctionBeginUser;
  for (int trial = 0; trial < 8; trial++) {
    Fixture f[2];
    Found *found[2];
    int n[2];
    memset(body_of, -1, sizeof body_of);
    RandomAssembly(body_of);
    for (int i = 0; i < 2; i++) {
      PetscCall(FixtureOpen(i ? PETSC_COMM_SELF : PETSC_COMM_WORLD, &sketch, &f[i], scene, row_of_pair));
      PetscCall(Gather(&f[i], &n[i], &found[i]));
    }
    ENSURE(n[0] == n[1]);
    for (int i = 0; i < PetscMin(n[0], n[1]); i++) ENSURE(!memcmp(&found[0][i], &found[1][i], sizeof(Found)));
    for (int i = 0; i < 2; i++) {
      free(found[i]);
      PetscCall(FixtureClose(&f[i]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 7 faces on 5, of equal width: 11 contacts whose lengths make up the joint; both halves L_i of each are
 * equal */
static PetscErrorCode LengthsOfANonMatchingJointAddUp(void)
{
  const double low[8] = {0, 0, 3, 0, 3, 1, 0, 1}, high[8] = {0.5, 1, 4, 1, 4, 2, 0.5, 2};
  Fixture f;
  Found *found;
  PetscReal sum = 0;
  int n;

  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0);
  SketchGroup(&sketch, "hard", 1);
  SketchGrid(&sketch, soft, low, 7, 1, QUADS);
  SketchGrid(&sketch, soft, high, 5, 1, QUADS);
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, scene, ""));
  PetscCall(Gather(&f, &n, &found));
  for (int i = 0; i < n; i++) sum += found[i].length;
  ENSURE_NEAR(sum, 2.5, 1e-12);
  free(found);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Contacts stand in the order of their faces, whatever their joints: two exchanged ones are found, and so is
   one that is there twice. */
static PetscErrorCode ContactsOutOfOrderAreInvalid(void)
{
  PetscFunctionBeginUser;
  for (int twice = 0; twice < 2; twice++) {
    Fixture f;
    PetscBool valid;
    memset(&sketch, 0, sizeof sketch);
    const int group[2] = {SketchGroup(&sketch, "soft", 0), SketchGroup(&sketch, "hard", 1)};
    for (int i = 0; i < 6; i++) SketchBox(&sketch, group[i / 2 % 2], i, 0, 1, 1);
    PetscCall(FixtureOpen(
        PETSC_COMM_WORLD, &sketch, &f,
        "materials: {soft: {density: 1, young: 1e9, poisson: 0}, hard: {density: 1, rigid: true}}\n"
        "joints: {default: {k_n: 1, k_s: 1, friction: 1}, hard+soft: {k_n: 2, k_s: 1, friction: 1}}\n"
        "relaxation: {allow_floating: true}\n"
        "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n"));
    Contacts *c = f.contacts;
    PetscInt at = c->model_start[STRESS_TPTM] + 1, changed = 0;
    while (at < c->n_padded && c->key[2 * at] >= 0 && c->joint[at] == c->joint[at - 1]) at++;
    PetscCall(ContactsIsValid(f.model, c, &valid));
    ENSURE(valid);
    if (at < c->n_padded && c->key[2 * at] >= 0) {
      const PetscInt before[2] = {c->key[2 * at - 2], c->key[2 * at - 1]};
      for (int k = 0; k < 2; k++) {
        if (!twice) c->key[2 * at - 2 + k] = c->key[2 * at + k];
        c->key[2 * at + k] = before[k];
      }
      changed = 1;
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPIU_INT, MPI_SUM, f.model->comm));
    PetscCall(ContactsIsValid(f.model, c, &valid));
    ENSURE(changed > 0 && !valid);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A pair of groups finds its joint; a face set on one side goes before it. */
static PetscErrorCode JointsAreFoundByFaceSetThenByGroups(void)
{
  static const char yaml[] =
      "materials: {soft: {density: 1, young: 1e9, poisson: 0}, hard: {density: 1, rigid: true}}\n"
      "joints: {seam: {k_n: 1, k_s: 1, friction: 1}, hard+soft: {k_n: 2, k_s: 1, friction: 1},"
      " default: {k_n: 3, k_s: 1, friction: 1}}\n"
      "relaxation: {allow_floating: true}\n"
      "loads: {weight: {type: self_weight}}\n"
      "stages: [all: {loads: [weight]}]\n";
  Fixture f;
  Found *found;
  int n;

  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0), hard = SketchGroup(&sketch, "hard", 1);
  const int group[4] = {soft, hard, soft, soft};
  for (int i = 0; i < 4; i++) SketchBox(&sketch, group[i], i, 0, 1, 1); // 0|1 set, 1|2 groups, 2|3 default
  SketchFace(&sketch, "seam", 0, 1);
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", yaml));
  PetscCall(Gather(&f, &n, &found));
  ENSURE(n == 3);
  for (int i = 0; i < n; i++) ENSURE_NEAR(f.scene->joints[found[i].joint].k_n, i + 1, 0);
  free(found);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Two legs of one body meet along a slit: a contact. The two sides of a body thinner than the tolerance:
 * none. */
static PetscErrorCode SlitsTouchAndThinBodiesDoNotTouchThemselves(void)
{
  Fixture f;
  Found *found;
  int n;

  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0);
  SketchGroup(&sketch, "hard", 1);
  const double X[10][2] = {{0, 0}, {1, 0}, {2, 0}, {0, 1}, {1, 1}, {2, 1}, {0, 2}, {1, 2}, {1, 2}, {2, 2}};
  for (int i = 0; i < 10; i++) SketchVertex(&sketch, X[i][0], X[i][1]);
  SketchBlock(&sketch, soft, 0, 1, 4, 3);
  SketchBlock(&sketch, soft, 1, 2, 5, 4);
  SketchBlock(&sketch, soft, 3, 4, 7, 6); // left leg, its right face is 1
  SketchBlock(&sketch, soft, 4, 5, 9, 8); // right leg, its left face is 3
  const double thin[8] = {5, 0, 6, 0, 6, 1e-3, 5, 1e-3};
  SketchGrid(&sketch, soft, thin, 1, 2, QUADS);
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, scene, ""));
  PetscCall(Gather(&f, &n, &found));
  ENSURE(n == 1);
  if (n == 1) ENSURE(found[0].face[0] == 4 * 2 + 1 && found[0].face[1] == 4 * 3 + 3);
  free(found);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Courses of other meshes over each other, each a body, of which all but the first and the last are thinner
   than the tolerance: contacts join neighbours only, and each joint is as long as the courses. */
static PetscErrorCode ContactsReachThroughNoLayer(void)
{
  static const int columns[] = {3, 5, 4, 7};
  PetscFunctionBeginUser;
  for (int trial = 0; trial < 12; trial++) {
    const int courses = 3 + trial % 2, kind = trial / 2 % 2 ? QUADS : TRIANGLES;
    int body_of[SKETCH_BLOCKS], n;
    double y = 0, sum = 0;
    Fixture f;
    Found *found;
    memset(&sketch, 0, sizeof sketch);
    const int soft = SketchGroup(&sketch, "soft", 0);
    SketchGroup(&sketch, "hard", 1);
    for (int i = 0; i < courses; i++) {
      const double thick = i == 0 || i == courses - 1 ? 1 : Uniform(1e-4, 2.4e-3) * (courses == 3 ? 2 : 1);
      const double end = i == 0 || i == courses - 1 ? 0 : Uniform(-5e-5, 5e-5); // a layer may taper
      const double corner[8] = {0, y, 2, y, 2, y + thick, 0, y + thick + end};
      const int before = sketch.n_blocks;
      SketchGrid(&sketch, soft, corner, columns[i], 1, i == 0 || i == courses - 1 ? kind : QUADS);
      for (int b = before; b < sketch.n_blocks; b++) body_of[b] = i;
      y += thick;
    }
    SketchMove(&sketch, 0, Uniform(0, 6), Uniform(-50, 50), Uniform(-50, 50));
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, scene, ""));
    PetscCall(Gather(&f, &n, &found));
    for (int i = 0; i < n; i++) {
      ENSURE(abs(body_of[found[i].face[0] / 4] - body_of[found[i].face[1] / 4]) == 1);
      sum += found[i].length;
    }
    ENSURE_NEAR(sum, 2. * (courses - 1), 1e-6);
    free(found);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(ClassesFollowFig3);
  RUN_TEST(ExchangingTheFacesMirrorsTheContact);
  RUN_TEST(GapsUpToTheToleranceTouch);
  RUN_TEST(OnlyNearlyOppositeFacesTouch);
  RUN_TEST(OverlapsBelowTheMinimumDoNotTouch);
  RUN_TEST(ContactsReachThroughNoLayer);
  RUN_TEST(FoundContactsAreThoseOfBruteForce);
  RUN_TEST(ContactsAreTheSameOnAnyNumberOfRanks);
  RUN_TEST(LengthsOfANonMatchingJointAddUp);
  RUN_TEST(ContactsOutOfOrderAreInvalid);
  RUN_TEST(JointsAreFoundByFaceSetThenByGroups);
  RUN_TEST(SlitsTouchAndThinBodiesDoNotTouchThemselves);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}
