/* bench_cycle: what one cycle of a scene costs, part by part, beside plain loops compiled here:

     textbook   element forces as a textbook has them: one element at a time, Jacobian, B and D matrices at
                every Gauss point of every step, small strain
     update     the rest of a textbook's cycle: one degree of freedom at a time, unbalanced force, velocity,
                displacement, sums of the damping, forces cleared
     plain      contacts reduced to moving their data: gather the four vertices, read the record, add to the
                forces of the four vertices; no law

     bench_cycle <scene.yaml>[,<scene.yaml> ...] <seconds per measurement> [shake] [-key value ...]

   measures one scene after the other, with keys of each overridden as on quoin's command line
   (-relaxation_damping paper), after some cycles, and with every vertex displaced at random by up to `shake`
   [m] (so that joints open and close in no order), and prints a line of JSON for each on rank 0: how many
   blocks, contacts, ... there are, median and least nanoseconds of one call of each part. Joints start from
   the history before the shake at every evaluation, as in a static stage with adaptive damping; contacts of a
   scene whose first stage is dynamic are those in time, results included. With 0 seconds every part runs
   once, inside its own Measure<Part> function, for
   valgrind --tool=callgrind with --toggle-collect (run.py does that). On several ranks every rank also has
   the whole scene to itself, and "speed_up" is the median of what a cycle takes the slower one of them
   alone over what it takes them together, one directly after the other. */
#include "run/run.h"
#include <time.h>

typedef struct _Bench Bench;
struct _Bench {
  Quoin quoin;
  Bench *alone; /* the whole scene on this rank; NULL on one rank */
  Scene *scene;
  Model *model;
  State *state;
  Contacts *contacts;
  Relaxation *relax;
  const Stage *stage;
  PetscReal *u, *f;             /* vertex part of the state's */
  PetscReal *trash;             /* (2 n_vertices + dummies) forces of the plain loops */
  PetscReal *v, *moved, *f_old; /* (n_dof,) velocities, displacements, forces of their update */
  PetscReal sums[2];            /* of the update */
};

/* ---- the textbook loop */

/* f = int B' D B u dA, 2x2 Gauss points, small strain. */
static void textbook_element(const PetscReal X[4][2], const PetscReal u[8], const PetscReal D[3][3],
                             PetscReal thickness, PetscReal f[8])
{
  static const PetscReal corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  const PetscReal gauss = 1. / PetscSqrtReal(3.);
  for (int i = 0; i < 8; i++) f[i] = 0.;
  for (int p = 0; p < 4; p++) {
    const PetscReal xi = gauss * corner[p][0], eta = gauss * corner[p][1];
    PetscReal dN[4][2], J[2][2] = {{0., 0.}, {0., 0.}}, B[3][8] = {{0.}}, strain[3], stress[3];
    for (int i = 0; i < 4; i++) {
      dN[i][0] = 0.25 * corner[i][0] * (1. + corner[i][1] * eta);
      dN[i][1] = 0.25 * corner[i][1] * (1. + corner[i][0] * xi);
      for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2; b++) J[a][b] += dN[i][a] * X[i][b];
    }
    const PetscReal det = J[0][0] * J[1][1] - J[0][1] * J[1][0];
    const PetscReal inverse[2][2] = {{J[1][1] / det, -J[0][1] / det}, {-J[1][0] / det, J[0][0] / det}};
    for (int i = 0; i < 4; i++) {
      const PetscReal dx = inverse[0][0] * dN[i][0] + inverse[0][1] * dN[i][1],
                      dy = inverse[1][0] * dN[i][0] + inverse[1][1] * dN[i][1];
      B[0][2 * i] = dx, B[1][2 * i + 1] = dy, B[2][2 * i] = dy, B[2][2 * i + 1] = dx;
    }
    for (int r = 0; r < 3; r++) {
      strain[r] = 0.;
      for (int i = 0; i < 8; i++) strain[r] += B[r][i] * u[i];
    }
    for (int r = 0; r < 3; r++) stress[r] = D[r][0] * strain[0] + D[r][1] * strain[1] + D[r][2] * strain[2];
    for (int i = 0; i < 8; i++)
      f[i] += (B[0][i] * stress[0] + B[1][i] * stress[1] + B[2][i] * stress[2]) * det * thickness;
  }
}

__attribute__((noinline)) static PetscErrorCode MeasureTextbook(Bench *b)
{
  const Model *m = b->model;
  PetscFunctionBeginUser;
  for (PetscInt e = 0; e < m->mesh.q4.n; e++) {
    const PetscInt *vertex = m->mesh.q4.vertex + (e / BATCH) * 4 * BATCH + e % BATCH, g = m->mesh.q4.group[e];
    const PetscReal lambda = m->materials.lame[g].lambda, mu = m->materials.lame[g].mu,
                    sum = lambda + 2. * mu;
    const PetscReal D[3][3] = {{sum, lambda, 0.}, {lambda, sum, 0.}, {0., 0., mu}};
    PetscReal X[4][2], u[8], f[8];
    for (int i = 0; i < 8; i++) {
      X[i / 2][i % 2] = m->mesh.X[2 * vertex[(i / 2) * BATCH] + i % 2];
      u[i] = b->u[2 * vertex[(i / 2) * BATCH] + i % 2];
    }
    textbook_element(X, u, D, m->materials.thickness, f);
    for (int i = 0; i < 8; i++) b->trash[2 * vertex[(i / 2) * BATCH] + i % 2] += f[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By the central difference (11)-(20); sums of (37). */
__attribute__((noinline)) static PetscErrorCode MeasureUpdate(Bench *b)
{
  const State *s = b->state;
  const PetscReal half = 0.5 * s->alpha * s->dt;
  PetscReal num = 0., den = 0.;
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < b->model->n_dof; d++) {
    const PetscReal f = b->trash[d], v = b->v[d];
    num += v * (f - b->f_old[d]);
    den += s->m[d] * v * v;
    b->v[d] = ((1. - half) * v + s->m_inv[d] * (s->f_ext[d] - f) * s->dt) / (1. + half);
    b->moved[d] += b->v[d] * s->dt;
    b->f_old[d] = f;
    b->trash[d] = 0.;
  }
  b->sums[0] = num, b->sums[1] = den;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- gather, add, scatter of the contacts' data */

__attribute__((noinline)) static PetscErrorCode MeasurePlain(Bench *b)
{
  const Model *m = b->model;
  const Contacts *c = b->contacts;
  const PetscReal *X = m->mesh.X, *u = b->u;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const PetscInt *vertex = c->vertex + CONTACT_ROW(i, 0);
    const PetscReal own = c->length[i] + c->t[SUB(i, 0)] + c->t[SUB(i, 1)];
    PetscReal F[2] = {own, own};
    for (int row = 0; row < CONTACT_ROWS; row++)
      for (int d = 0; d < 2; d++) F[d] += u[2 * vertex[row * BATCH] + d] + X[2 * vertex[row * BATCH] + d];
    for (int row = 0; row < CONTACT_ROWS; row++)
      for (int d = 0; d < 2; d++) b->trash[2 * vertex[row * BATCH] + d] += F[d];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- Quoin's own */

/* Into arrays of the bench: what the others measure stays where it is. */
__attribute__((noinline)) static PetscErrorCode MeasureMotion(Bench *b)
{
  State own = *b->state;
  QuotientSums sums = {{0., 0.}, {0., 0.}, 0., 0.};
  PetscFunctionBeginUser;
  own.u = b->moved, own.v = b->v, own.f = b->trash, own.f_old = b->f_old;
  IntegrateRange(b->model, &own, &b->relax->damping.sums, 0, b->model->n_dof, &sums);
  PetscFunctionReturn(PETSC_SUCCESS);
}

__attribute__((noinline)) static PetscErrorCode MeasureElements(Bench *b)
{
  PetscFunctionBeginUser;
  PetscCall(ElementForces(b->model, b->u, b->trash));
  PetscFunctionReturn(PETSC_SUCCESS);
}

__attribute__((noinline)) static PetscErrorCode MeasureContacts(Bench *b)
{
  PetscFunctionBeginUser;
  if (b->contacts->rate != 0.)
    PetscCall(ContactForces(b->model, b->stage->joints, b->contacts, b->u, b->trash));
  else
    PetscCall(ContactForcesOnly(b->model, b->stage->joints, b->contacts, b->u, b->trash));
  PetscFunctionReturn(PETSC_SUCCESS);
}

__attribute__((noinline)) static PetscErrorCode MeasureRigid(Bench *b)
{
  PetscFunctionBeginUser;
  RigidForces(b->model, b->state->u, b->trash);
  RigidMotion(b->model, b->state->u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

__attribute__((noinline)) static PetscErrorCode MeasureCondensed(Bench *b)
{
  PetscFunctionBeginUser;
  PetscCall(Condensed_term.forces(NULL, &(Instant){.m = b->model, .u = b->u}, b->trash));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* As in a cycle that no check follows. */
__attribute__((noinline)) static PetscErrorCode MeasureLaws(Bench *b)
{
  PetscFunctionBeginUser;
  PetscCall(Laws_term.forces(NULL, &(Instant){.m = b->model, .u = b->u}, b->trash));
  PetscFunctionReturn(PETSC_SUCCESS);
}

__attribute__((noinline)) static PetscErrorCode MeasureCycle(Bench *b)
{
  PetscFunctionBeginUser;
  PetscCall(Step(b->scene, b->model, b->stage->joints, b->contacts, b->state, &b->relax->damping, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What ranks tell each other in a cycle. */
__attribute__((noinline)) static PetscErrorCode MeasureExchange(Bench *b)
{
  PetscFunctionBeginUser;
  PetscCall(GhostBegin(b->model, b->u));
  PetscCall(GhostEnd(b->model, b->u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

__attribute__((noinline)) static PetscErrorCode MeasureSums(Bench *b)
{
  QuotientSums sums = {{0., 0.}, {0., 0.}, 0., 0.};
  PetscFunctionBeginUser;
  DampingSumsBegin(b->model, b->relax->damping.over_ranks, &sums);
  PetscCall(DampingSumsEnd(b->model, b->relax->damping.over_ranks, &sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the clock */

typedef PetscErrorCode (*Measured)(Bench *);

static int by_size(const void *a, const void *b)
{
  const double p = *(const double *)a, q = *(const double *)b;
  return (p > q) - (p < q);
}

/* Time of this process on its processor: what other programs take in between is not counted, waiting for
   another rank is. */
static double processor_time(void)
{
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

/* as limits.json names it */
#ifdef __clang__
#define COMPILER "clang " STRING_OF(__clang_major__)
#else
#define COMPILER "gcc " STRING_OF(__GNUC__)
#endif
#define STRING_OF(number) STRING(number)
#define STRING(text) #text

enum { CYCLE = 9, MEASURED = 12, MOST = 4001 };

static const struct {
  const char *name;
  Measured run;
} parts[MEASURED] = {{"textbook", MeasureTextbook}, {"update", MeasureUpdate},
                     {"motion", MeasureMotion},     {"elements", MeasureElements},
                     {"plain", MeasurePlain},       {"contacts", MeasureContacts},
                     {"rigid", MeasureRigid},       {"condensed", MeasureCondensed},
                     {"laws", MeasureLaws},         [CYCLE] = {"cycle", MeasureCycle},
                     {"exchange", MeasureExchange}, {"sums", MeasureSums}};

/* Seconds of one of `calls` calls; the call before them is not counted: it brings the part's own data into
   the caches. */
static PetscErrorCode seconds_of(Bench *b, Measured measured, int calls, double *took)
{
  PetscFunctionBeginUser;
  PetscCall(measured(b));
  PetscCallMPI(MPI_Barrier(b->model->comm));
  const double from = processor_time();
  for (int i = 0; i < calls; i++) PetscCall(measured(b));
  *took = (processor_time() - from) / calls;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On the slowest rank. */
static PetscErrorCode together(Bench *b, Measured measured, int calls, double *took)
{
  PetscFunctionBeginUser;
  PetscCall(seconds_of(b, measured, calls, took));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, took, 1, MPI_DOUBLE, MPI_MAX, b->model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The slower one of the ranks, each with a cycle of the whole scene, one rank after the other. */
static PetscErrorCode in_turn(Bench *b, int calls, double *took)
{
  PetscFunctionBeginUser;
  for (int rank = 0; rank < b->model->size; rank++) {
    PetscCallMPI(MPI_Barrier(b->model->comm));
    if (rank == b->model->rank) PetscCall(seconds_of(b->alone, MeasureCycle, calls, took));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, took, 1, MPI_DOUBLE, MPI_MAX, b->model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static double median_of(double *sample, int n)
{
  qsort(sample, n, sizeof *sample, by_size);
  return sample[n / 2];
}

typedef struct {
  double median[MEASURED], least[MEASURED]; /* [s] */
  double speed_up;                          /* 0 on one rank */
} Times;

/* All parts take turns, in samples of at least 0.3 ms: a processor's clock goes up and down by a third with
   what neighbours do, for seconds at a time, and what is compared must see the same: the least are of the
   fastest turns. */
static PetscErrorCode measure(Bench *b, double seconds, Times *times)
{
  static double sample[MEASURED][MOST], total[MOST], speed_up[MOST];
  double fastest = PETSC_MAX_REAL;
  int calls[MEASURED], n = 0, go_on = 1;
  PetscFunctionBeginUser;
  for (int p = 0; p < MEASURED; p++) {
    double took;
    for (calls[p] = 1;; calls[p] *= 2) {
      PetscCall(together(b, parts[p].run, calls[p], &took));
      if (took * calls[p] >= 3e-4) break;
    }
  }
  const double start = MPI_Wtime();
  for (; go_on && n < MOST; n++) {
    total[n] = 0.;
    for (int p = 0; p < MEASURED; p++) {
      PetscCall(together(b, parts[p].run, calls[p], &sample[p][n]));
      total[n] += calls[p] * sample[p][n];
      if (p != CYCLE || !b->alone) continue;
      PetscCall(in_turn(b, calls[p], &speed_up[n]));
      speed_up[n] /= sample[p][n];
    }
    fastest = PetscMin(fastest, total[n]);
    go_on = n < 4 || MPI_Wtime() - start < seconds * MEASURED;
    PetscCallMPI(MPI_Bcast(&go_on, 1, MPI_INT, 0, b->model->comm));
  }
  for (int p = 0; p < MEASURED; p++) {
    times->least[p] = PETSC_MAX_REAL;
    for (int i = 0; i < n; i++)
      if (total[i] < 1.05 * fastest) times->least[p] = PetscMin(times->least[p], sample[p][i]);
    times->median[p] = median_of(sample[p], n);
  }
  times->speed_up = b->alone ? median_of(speed_up, n) : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode report(Bench *b, double seconds)
{
  enum { BLOCKS, CONTACTS, VERTICES, INELASTIC, BODIES, ENTRIES, COUNTS };
  const Model *m = b->model;
  const Contacts *c = b->contacts;
  Times times = {{0.}, {0.}, 0.};
  PetscInt n[COUNTS] = {[VERTICES] = m->mesh.n_owned, [BODIES] = m->rigid.n};
  PetscFunctionBeginUser;
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++) n[BLOCKS] += list->owned[e];
  for (PetscInt i = 0; i < c->n_padded; i++) {
    n[CONTACTS] += c->owned[i];
    n[INELASTIC] += c->owned[i] && (c->state[SUB(i, 0)] || c->state[SUB(i, 1)]);
  }
  for (PetscInt i = 0; i < m->condensed.n; i++)
    n[ENTRIES] += m->condensed.body[i].n_kept * m->condensed.body[i].n_kept;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, COUNTS, MPIU_INT, MPI_SUM, m->comm));
  PetscCall(PetscPrintf(m->comm,
                        "{\"compiler\": \"" COMPILER
                        "\", \"ranks\": %d, \"n_elements\": %d, \"n_contacts\": %d, \"n_vertices\": %d, "
                        "\"inelastic\": %d, \"n_bodies\": %d, \"n_entries\": %d",
                        m->size, (int)n[BLOCKS], (int)n[CONTACTS], (int)n[VERTICES], (int)n[INELASTIC],
                        (int)n[BODIES], (int)n[ENTRIES]));
  if (seconds > 0.) PetscCall(measure(b, seconds, &times));
  for (int p = 0; p < MEASURED; p++) {
    if (seconds <= 0.) PetscCall(parts[p].run(b));
    PetscCall(PetscPrintf(b->model->comm, ", \"%s\": %.6g, \"%s_least\": %.6g", parts[p].name,
                          1e9 * times.median[p], parts[p].name, 1e9 * times.least[p]));
  }
  if (b->alone) PetscCall(PetscPrintf(b->model->comm, ", \"speed_up\": %.4g", times.speed_up));
  PetscCall(PetscPrintf(b->model->comm, "}\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a scene, its first stage under full load, some cycles on */

enum { WARM_UP = 20 };

static void shake_vertices(Bench *b, double size)
{
  srand(1); // the same in every scene
  for (PetscInt i = 0; i < 2 * b->model->mesh.n_deformable; i++)
    b->u[i] += size * (2. * rand() / RAND_MAX - 1.);
}

/* argv: "-key value" of the scene behind its first word. */
static PetscErrorCode prepare(MPI_Comm comm, const char *scene, double shake, int argc, char **argv, Bench *b)
{
  PetscFunctionBeginUser;
  PetscCall(QuoinCreate(comm, &b->quoin));
  PetscCall(QuoinSetFromOptions(b->quoin, scene, argc, argv));
  PetscCall(QuoinSetUp(b->quoin));
  PetscCall(QuoinGetParts(b->quoin, &b->scene, &b->model, &b->state, &b->contacts, &b->relax));
  b->stage = b->scene->stages;
  PetscCall(LoadsTarget(b->scene, b->model, b->stage, b->state));
  PetscCall(ScaledMasses(b->scene, b->model, b->stage->joints, b->contacts, b->state));
  LoadsApply(b->model, b->state, 1.);
  ContactsCommit(b->contacts);
  b->u = b->state->u + 3 * b->model->rigid.n, b->f = b->state->f + 3 * b->model->rigid.n;
  PetscCall(
      PetscCalloc1(3 * b->model->rigid.n + 2 * (b->model->mesh.n_vertices + DUMMY_VERTICES), &b->trash));
  PetscCall(PetscCalloc3(b->model->n_dof, &b->v, b->model->n_dof, &b->moved, b->model->n_dof, &b->f_old));
  for (int i = 0; i < WARM_UP; i++)
    PetscCall(Step(b->scene, b->model, b->stage->joints, b->contacts, b->state, &b->relax->damping, NULL));
  if (b->stage->kind == STAGE_DYNAMIC) b->contacts->rate = 1. / b->state->dt;
  shake_vertices(b, shake);
  PetscCall(GhostBegin(b->model, b->u));
  PetscCall(GhostEnd(b->model, b->u));
  PetscCall(ContactForces(b->model, b->stage->joints, b->contacts, b->u, b->trash));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(Bench *b)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(b->trash));
  PetscCall(PetscFree3(b->v, b->moved, b->f_old));
  PetscCall(QuoinDestroy(&b->quoin));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode run(const char *scene, double seconds, double shake, int argc, char **argv)
{
  Bench b = {0}, alone = {0};
  PetscMPIInt size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(prepare(PETSC_COMM_WORLD, scene, shake, argc, argv, &b));
  if (size > 1 && seconds > 0.) {
    b.alone = &alone;
    PetscCall(prepare(PETSC_COMM_SELF, scene, shake, argc, argv, &alone));
  }
  PetscCall(report(&b, seconds));
  if (b.alone) PetscCall(destroy(&alone));
  PetscCall(destroy(&b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  if (argc < 3) {
    fprintf(stderr,
            "use: bench_cycle <scene.yaml>[,...] <seconds per measurement> [shake] [-key value ...]\n");
    return 2;
  }
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(QuoinErrorHandlerPush());
  const int last = argc > 3 && argv[3][0] != '-' ? 3 : 2; // before the keys
  PetscErrorCode code = PETSC_SUCCESS;
  for (char *scene = strtok(argv[1], ","); scene && !code; scene = strtok(NULL, ","))
    code = run(scene, atof(argv[2]), last == 3 ? atof(argv[3]) : 0., argc - last, argv + last);
  PetscCall(PetscPopErrorHandler());
  if (code) MPI_Abort(MPI_COMM_WORLD, 1);
  return PetscFinalize();
}
