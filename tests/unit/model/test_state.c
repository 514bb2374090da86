/* The Vecs of the state are the state: what the loop writes is what PETSc sees, whatever has grown or changed
   places since, and what PETSc changes the loop reads.
   ranks: 1 2 4 */
#include "scene_fixture.h"

static Sketch sketch;

/* A wall of deformable and rigid blocks. */
static PetscErrorCode OpenWall(Fixture *f)
{
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0), hard = SketchGroup(&sketch, "hard", 1);
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 2; i++) {
      const double x = 2 * i, corner[8] = {x, j, x + 2, j, x + 2, j + 1, x, j + 1};
      const int first = SketchGrid(&sketch, (i + j) % 2 ? hard : soft, corner, 2, 1, QUADS);
      if (j == 0) SketchFace(&sketch, "base", first, 0), SketchFace(&sketch, "base", first + 1, 0);
    }
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                  "materials: {soft: {density: 2000, young: 1e9, poisson: 0.2}, hard: {density: 2000}}\n"
                  "joints: {default: {law: elastic, k_n: 1e9, k_s: 3e8}}\nsupports: {base: {fix: xy}}\n"
                  "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight], ramp: 0}]\n"));
  PetscCall(StageStart(f, 0));
  PetscCall(StageCycles(f, 0, 10));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { VIEWS = 5 };

/* Vecs and arrays in one order, while the loop holds the arrays. */
static void Pairs(const State *s, Vec vec[VIEWS], const PetscReal *array[VIEWS])
{
  const Vec vecs[VIEWS] = {s->displacement, s->velocity, s->force, s->load, s->mass};
  const PetscReal *const arrays[VIEWS] = {s->u, s->v, s->f, s->f_ext, s->m};
  for (int i = 0; i < VIEWS; i++) vec[i] = vecs[i], array[i] = arrays[i];
}

/* Sizes, addresses and norms of all Vecs; norm: receives those by hand. */
static PetscErrorCode TheVecsAreTheState(Fixture *f, PetscReal norm[VIEWS])
{
  const PetscInt n = f->model->n_dof;
  State *s = f->state;
  Vec vec[VIEWS];
  const PetscReal *array[VIEWS], *now;
  PetscInt size, all = n;
  PetscReal sum[VIEWS] = {0};
  PetscFunctionBeginUser;
  Pairs(s, vec, array);
  for (int i = 0; i < VIEWS; i++)
    for (PetscInt d = 0; d < n; d++) sum[i] += PetscSqr(array[i][d]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, VIEWS, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  PetscCall(StateGive(s));
  ENSURE(!s->u && !s->v && !s->f && !s->f_old && !s->f_ext && !s->m); // nobody writes behind PETSc's back
  for (int i = 0; i < VIEWS; i++) {
    PetscReal seen;
    norm[i] = PetscSqrtReal(sum[i]);
    PetscCall(VecNorm(vec[i], NORM_2, &seen)); // PETSc keeps it until StateTake marks a change
    ENSURE_NEAR(seen, norm[i], 1e-12 * norm[i]);
    PetscCall(VecGetLocalSize(vec[i], &size));
    ENSURE(size == n);
    PetscCall(VecGetSize(vec[i], &size));
    ENSURE(size == all);
    PetscCall(VecGetArrayRead(vec[i], &now));
    ENSURE(now == array[i]); // no copy
    PetscCall(VecRestoreArrayRead(vec[i], &now));
  }
  PetscCall(StateTake(s));
  f->u_vertex = s->u + 3 * f->model->rigid.n;
  ENSURE(s->u == array[0] && s->f == array[2]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A cycle swaps the forces: after an odd number of them, and after an even one. */
static PetscErrorCode EachCycleIsSeen(void)
{
  Fixture f;
  PetscReal before[VIEWS], after[VIEWS];
  PetscFunctionBeginUser;
  PetscCall(OpenWall(&f));
  PetscCall(TheVecsAreTheState(&f, before));
  for (int cycle = 0; cycle < 3; cycle++) {
    const Vec force = f.state->force, old = f.state->force_old;
    const PetscReal *f_now = f.state->f;
    const char *name;
    PetscCall(StageCycles(&f, 0, 1));
    ENSURE(f.state->force == old && f.state->force_old == force && f.state->f_old == f_now);
    PetscCall(PetscObjectGetName((PetscObject)f.state->force, &name));
    ENSURE(!strcmp(name, "force"));
    PetscCall(TheVecsAreTheState(&f, after));
    for (int i = 0; i < 3; i++) ENSURE(after[i] > 0. && after[i] != before[i]);
    ENSURE(after[3] == before[3] && after[4] == before[4]); // load and mass
    memcpy(before, after, sizeof before);
  }
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The arrays of the last rank grow, the others stay. */
static PetscErrorCode ArraysThatGrow(void)
{
  Fixture f;
  PetscReal before[VIEWS], after[VIEWS], *u;
  PetscFunctionBeginUser;
  PetscCall(OpenWall(&f));
  PetscCall(TheVecsAreTheState(&f, before));
  Model *m = f.model;
  State *s = f.state;
  const PetscInt used = 3 * m->rigid.n + 2 * (m->mesh.n_vertices + DUMMY_VERTICES), room = s->capacity;
  const PetscBool grows = (PetscBool)(m->rank == m->size - 1);
  PetscCall(PetscMalloc1(used, &u));
  PetscCall(PetscArraycpy(u, s->u, used));
  Model larger = *m;
  larger.mesh.vertex_capacity += grows ? 1000 : 0;
  PetscCall(StateResize(&larger, s));
  ENSURE(s->capacity == room + (grows ? 2000 : 0));
  ENSURE(!memcmp(u, s->u, used * sizeof *u)); // ghosts behind the Vec too
  for (PetscInt d = room; d < s->capacity; d++) ENSURE(s->u[d] == 0. && s->f[d] == 0. && s->f_ext[d] == 0.);
  PetscCall(TheVecsAreTheState(&f, after));
  ENSURE(!memcmp(before, after, sizeof before));
  PetscCall(NeighboursUpdate(m, s));
  ENSURE(!memcmp(u, s->u, used * sizeof *u));
  PetscCall(StageCycles(&f, 0, 1));
  PetscCall(TheVecsAreTheState(&f, after));
  ENSURE(after[0] != before[0] && after[2] != before[2]);
  PetscCall(PetscFree(u));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What PETSc does to a Vec the loop goes on from. */
static PetscErrorCode PETScChangesTheState(void)
{
  Fixture f;
  PetscReal norm[VIEWS], half[VIEWS], work;
  PetscFunctionBeginUser;
  PetscCall(OpenWall(&f));
  State *s = f.state;
  PetscCall(TheVecsAreTheState(&f, norm));
  PetscCall(StateGive(s));
  PetscCall(VecScale(s->velocity, 0.5));
  PetscCall(VecAXPY(s->displacement, s->dt, s->velocity));
  PetscCall(VecDot(s->displacement, s->load, &work));
  PetscCall(StateTake(s));
  PetscCall(TheVecsAreTheState(&f, half));
  ENSURE_NEAR(half[1], 0.5 * norm[1], 1e-12 * norm[1]);
  ENSURE(half[0] > norm[0] && half[2] == norm[2]); // it goes on down
  ENSURE(work > 0.);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(EachCycleIsSeen);
  RUN_TEST(ArraysThatGrow);
  RUN_TEST(PETScChangesTheState);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}
