/* The assembled tangent is the change of the forces of blocks and joints. That holds for elastic, slipping
   and open joints, with rigid bodies, for every stress model. The elastic tangent is symmetric, and no rigid
   motion costs energy. The pattern has no entry too many. Where all bodies are condensed, places that were
   kept give the bits of rows that are searched. ranks: 1 2 4 */
#include "scene_fixture.h"
#include "solve/stiffness.h"

static Sketch sketch;

/* Ground, a deformable wall of 4 by 3 blocks on it, a rigid block on top, deformable triangles on that. */
static PetscErrorCode OpenTower(const char *strain, const char *model, const char *law, PetscBool held,
                                Fixture *f)
{
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int ground = SketchGroup(&sketch, "ground", 1), stone = SketchGroup(&sketch, "stone", 0),
            hard = SketchGroup(&sketch, "hard", 1);
  const double wall[8] = {0, 0, 4, 0, 4.1, 2, 0.1, 2.2}, top[8] = {0.1, 3.2, 4.1, 3, 4, 5, 0, 5};
  SketchBox(&sketch, ground, -1, -1, 6, 1);
  SketchGrid(&sketch, stone, wall, 4, 3, QUADS);
  const double cap[8] = {0.1, 2.2, 4.1, 2, 4.1, 3, 0.1, 3.2};
  SketchGrid(&sketch, hard, cap, 1, 1, QUADS);
  SketchGrid(&sketch, stone, top, 3, 2, TRIANGLES);
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                        "strain: %s\nmaterials: {ground: {density: 0}, hard: {density: 2000},\n"
                        "  stone: {density: 2400, young: 2e9, poisson: 0.2}}\n"
                        "relaxation: {allow_floating: true}\n"
                        "joints: {default: {law: %s, stress_model: %s, k_n: 3e9, k_s: 1e9, friction: 25}}\n%s"
                        "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n",
                        strain, law, model, held ? "supports: {ground: {fix: xy}}\n" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A number in -1..1 that belongs to dof i of a vertex or body, the same on any number of ranks. */
static double Wobble(PetscInt gid, int i, double seed)
{
  return sin(12.9898 * (double)gid + 78.233 * i + seed);
}

/* value = amount * wobble on free dofs; bodies turn a tenth of it. */
static void Shake(const Model *m, double seed, double amount, PetscReal *value)
{
  for (PetscInt b = 0; b < m->rigid.n; b++)
    for (int i = 0; i < 3; i++)
      value[3 * b + i] = amount * (i == 2 ? 0.1 : 1) * Wobble(1000 + m->rigid.gid[b], i, seed);
  for (PetscInt v = 0; v < m->mesh.n_deformable; v++)
    for (int i = 0; i < 2; i++)
      value[3 * m->rigid.n + 2 * v + i] = amount * Wobble(m->mesh.vertex_gid[v], i, seed);
  for (PetscInt d = 0; d < m->n_dof; d++)
    if (Held(m, d)) value[d] = 0;
}

/* Resisting forces at u + part w, from a history without slip. */
static PetscErrorCode ForcesAt(Fixture *f, const PetscReal *u, double part, const PetscReal *w,
                               PetscReal *force)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(f->contacts->slip, 2 * f->contacts->n_padded));
  for (PetscInt d = 0; d < f->model->n_dof; d++) f->state->u[d] = u[d] + part * w[d];
  RigidMotion(f->model, f->state->u);
  PetscCall(Forces(f->scene, f->model, f->scene->stages[0].joints, f->contacts, f->state, NULL));
  for (PetscInt d = 0; d < f->model->n_dof; d++) force[d] = Held(f->model, d) ? 0 : f->state->f[d];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Largest difference between K w and the change of the forces along w, over the largest of K w. */
static PetscErrorCode TangentError(Fixture *f, PetscBool turns, const PetscReal *u, const PetscReal *w,
                                   PetscReal *error)
{
  const PetscInt n = f->model->n_dof;
  const double h = 1e-5;
  PetscReal *less, *more, *at, largest[2] = {0, 0};
  const PetscReal *kw;
  Stiffness s;
  Vec x, y;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc3(n, &less, n, &more, n, &at));
  PetscCall(ForcesAt(f, u, -h, w, less));
  PetscCall(ForcesAt(f, u, h, w, more));
  PetscCall(ForcesAt(f, u, 0., w, at));
  PetscCall(StiffnessCreate(f->model, f->state, f->contacts, &s));
  PetscCall(StiffnessBodies(f->model, f->state, turns, &s));
  PetscCall(StiffnessTangent(f->model, f->state, f->scene->stages[0].joints, f->contacts, PETSC_FALSE, &s));
  PetscCall(MatCreateVecs(s.tangent, &x, &y));
  PetscReal *x_of;
  PetscCall(VecGetArray(x, &x_of));
  PetscCall(PetscArraycpy(x_of, w, n));
  PetscCall(VecRestoreArray(x, &x_of));
  PetscCall(MatMult(s.tangent, x, y));
  PetscCall(VecGetArrayRead(y, &kw));
  for (PetscInt d = 0; d < n; d++) {
    if (Held(f->model, d)) continue;
    largest[0] = PetscMax(largest[0], fabs(kw[d] - (more[d] - less[d]) / (2 * h)));
    largest[1] = PetscMax(largest[1], fabs(kw[d]));
  }
  PetscCall(VecRestoreArrayRead(y, &kw));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD));
  *error = largest[0] / largest[1];
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&y));
  PetscCall(StiffnessDestroy(&s));
  PetscCall(PetscFree3(less, more, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Contacts whose ends are elastic, slipping and open, over all ranks. */
static PetscErrorCode CountStates(const Fixture *f, PetscInt count[3])
{
  PetscFunctionBeginUser;
  count[0] = count[1] = count[2] = 0;
  for (PetscInt i = 0; i < f->contacts->n_padded; i++)
    for (int k = 0; k < 2 && f->contacts->key[2 * i] >= 0; k++) {
      const PetscInt state = f->contacts->state[SUB(i, k)];
      count[state & CONTACT_OPEN ? 2 : state & CONTACT_SLIPPING ? 1 : 0]++;
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 3, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TangentIsTheChangeOfTheForces(void)
{
  PetscFunctionBeginUser;
  for (int model = 0; model < STRESS_MODELS; model++)
    for (int large = 0; large < 2; large++) {
      Fixture f;
      PetscReal *u, *w, error = 1;
      PetscInt count[3];
      PetscCall(OpenTower(large ? "large" : "small", StressModels[model], "mohr_coulomb", PETSC_TRUE, &f));
      PetscCall(PetscCalloc2(f.model->n_dof, &u, f.model->n_dof, &w));
      Shake(f.model, 0.7, 1e-5, u);
      Shake(f.model, 2.1, 1e-5, w);
      PetscCall(TangentError(&f, PETSC_FALSE, u, w, &error));
      PetscCall(CountStates(&f, count));
      ENSURE(count[0] > 0 && count[1] > 0 && count[2] > 0);
      ENSURE(error < (large ? 1e-4 : 1e-5)); // large: normals that turn are left out, u_n/L
      PetscCall(PetscFree2(u, w));
      PetscCall(FixtureClose(&f));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Blocks that have turned by up to 1e-3 of one, more than joints open: what comes of
   that, and only with it. */
static PetscErrorCode TangentOfWhatHasTurned(void)
{
  PetscFunctionBeginUser;
  for (int model = 0; model < STRESS_MODELS; model++) {
    Fixture f;
    PetscReal *u, *w, error[2] = {1, 0};
    PetscCall(OpenTower("large", StressModels[model], "elastic", PETSC_TRUE, &f));
    PetscCall(PetscCalloc2(f.model->n_dof, &u, f.model->n_dof, &w));
    Shake(f.model, 0.7, 1e-2, u);
    Shake(f.model, 2.1, 1e-3, w);
    for (int turns = 0; turns < 2; turns++)
      PetscCall(TangentError(&f, (PetscBool)turns, u, w, error + turns));
    ENSURE(error[0] > 1e-3 && error[1] < 1e-6);
    PetscCall(PetscFree2(u, w));
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of blocks in their reference state and elastic joints. */
static PetscErrorCode ElasticTangent(const Fixture *f, Stiffness *s)
{
  PetscFunctionBeginUser;
  PetscCall(StiffnessCreate(f->model, f->state, f->contacts, s));
  PetscCall(StiffnessBodies(f->model, f->state, PETSC_FALSE, s));
  PetscCall(StiffnessTangent(f->model, f->state, f->scene->stages[0].joints, f->contacts, PETSC_TRUE, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The elastic stiffness of a floating tower. */
static PetscErrorCode ElasticIsSymmetricAndFreeOfRigidMotions(void)
{
  const double motion[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}; // x, y, rotation about the origin
  Fixture f;
  Stiffness s;
  PetscBool symmetric;
  PetscReal size, largest;
  Vec x, y;

  PetscFunctionBeginUser;
  PetscCall(OpenTower("large", "t3pt", "elastic", PETSC_FALSE, &f));
  const Model *m = f.model;
  PetscCall(ElasticTangent(&f, &s));
  PetscCall(MatNorm(s.tangent, NORM_INFINITY, &size));
  PetscCall(MatIsSymmetric(s.tangent, 1e-9 * size, &symmetric));
  ENSURE(symmetric);
  PetscCall(MatCreateVecs(s.tangent, &x, &y));
  for (int k = 0; k < 3; k++) {
    PetscReal *u;
    PetscCall(VecGetArrayWrite(x, &u));
    for (PetscInt d = 0; d < m->n_dof; d++) {
      const PetscInt at = d - 3 * m->rigid.n, i = at < 0 ? d % 3 : at % 2;
      const PetscReal *X = at < 0 ? m->rigid.X + 2 * (d / 3) : m->mesh.X + 2 * (at / 2);
      u[d] = i == 2 ? motion[k][2] : motion[k][i] + motion[k][2] * (i ? X[0] : -X[1]);
    }
    PetscCall(VecRestoreArrayWrite(x, &u));
    PetscCall(MatMult(s.tangent, x, y));
    PetscCall(VecNorm(y, NORM_INFINITY, &largest));
    ENSURE(largest < 1e-8 * size);
  }
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&y));
  PetscCall(StiffnessDestroy(&s));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks in a dense table which rows n vertices couple. */
static void Meet(const Stiffness *s, int n, const PetscInt *vertex, PetscInt size, int *table)
{
  for (int i = 0; i < 9 * n * n; i++) {
    const PetscInt row = s->row[3 * vertex[(i / (9 * n)) * BATCH] + i / (3 * n) % 3],
                   column = s->row[3 * vertex[(i / 3 % n) * BATCH] + i % 3];
    if (row >= 0 && column >= 0) table[row * size + column] = 1;
  }
}

/* Neither an entry too few, which PETSc refuses, nor one too many: counted in a dense table of all ranks. */
static PetscErrorCode PatternIsExact(void)
{
  Fixture f;
  Stiffness s;
  MatInfo info;
  PetscInt size, count = 0;
  int *table;

  PetscFunctionBeginUser;
  PetscCall(OpenTower("large", "tptm", "mohr_coulomb", PETSC_TRUE, &f));
  const Model *m = f.model;
  PetscCall(ElasticTangent(&f, &s));
  PetscCall(MatGetSize(s.tangent, &size, NULL));
  PetscCall(PetscCalloc1(size * size, &table));
  for (PetscInt d = 0; d < m->n_dof; d++) table[(s.first + d) * (size + 1)] = 1;
  for (PetscInt e = 0; e < m->mesh.q4.n; e++)
    Meet(&s, 4, m->mesh.q4.vertex + (e / BATCH) * 4 * BATCH + e % BATCH, size, table);
  for (PetscInt e = 0; e < m->mesh.t3.n; e++)
    Meet(&s, 3, m->mesh.t3.vertex + (e / BATCH) * 3 * BATCH + e % BATCH, size, table);
  for (PetscInt i = 0; i < f.contacts->n_padded; i++)
    if (f.contacts->key[2 * i] >= 0)
      Meet(&s, CONTACT_ROWS, f.contacts->vertex + CONTACT_ROW(i, 0), size, table);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, table, (PetscMPIInt)(size * size), MPI_INT, MPI_MAX, m->comm));
  for (PetscInt i = 0; i < size * size; i++) count += table[i];
  PetscCall(MatGetInfo(s.tangent, MAT_GLOBAL_SUM, &info));
  ENSURE(count > 20 * 9 && count < size * size);
  ENSURE(info.nz_used == (double)count && info.nz_allocated == (double)count && info.mallocs == 0);
  PetscCall(PetscFree(table));
  PetscCall(StiffnessDestroy(&s));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The tangent at states that differ, of places kept since the first of them and of rows searched. */
static PetscErrorCode PlacesAreThoseOfRows(void)
{
  const double left[8] = {0, 0, 2, 0, 2, 2, 0, 2}, right[8] = {2, 0, 4, 0, 4, 2, 2, 2};
  Fixture f;
  Stiffness kept, searched;
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int stone = SketchGroup(&sketch, "stone", 0);
  SketchGrid(&sketch, stone, left, 3, 4, QUADS);
  SketchGrid(&sketch, stone, right, 3, 4, QUADS);
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, &f,
                  "strain: large\nmaterials: {stone: {density: 2400, young: 2e9, poisson: 0.2, condensed: "
                  "true}}\nrelaxation: {allow_floating: true}\n"
                  "joints: {default: {law: mohr_coulomb, k_n: 3e9, k_s: 1e9, friction: 25}}\n"
                  "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n"));
  const Model *m = f.model;
  PetscReal *u, *unused;
  PetscCall(PetscCalloc2(m->n_dof, &u, m->n_dof, &unused));
  PetscCall(StiffnessCreate(m, f.state, f.contacts, &kept));
  PetscCall(StiffnessCreate(m, f.state, f.contacts, &searched));
  ENSURE(kept.fixed);
  searched.fixed = PETSC_FALSE;
  for (int k = 0; k < 3; k++) {
    PetscBool same;
    PetscReal size;
    Shake(m, k, 1e-4, u);
    PetscCall(ForcesAt(&f, u, 0., u, unused));
    for (int i = 0; i < 2; i++) {
      Stiffness *s = i ? &searched : &kept;
      PetscCall(StiffnessBodies(m, f.state, k % 2, s));
      PetscCall(StiffnessTangent(m, f.state, f.scene->stages[0].joints, f.contacts, PETSC_FALSE, s));
    }
    PetscCall(MatEqual(kept.tangent, searched.tangent, &same));
    ENSURE(same);
    PetscCall(MatAXPY(searched.tangent, -1., searched.bodies, SAME_NONZERO_PATTERN));
    PetscCall(MatNorm(searched.tangent, NORM_FROBENIUS, &size));
    ENSURE(size > 1e9); // what joints add
  }
  ENSURE(m->size > 1 || (kept.places && !searched.places));
  PetscCall(StiffnessDestroy(&kept));
  PetscCall(StiffnessDestroy(&searched));
  PetscCall(PetscFree2(u, unused));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TangentIsTheChangeOfTheForces);
  RUN_TEST(TangentOfWhatHasTurned);
  RUN_TEST(ElasticIsSymmetricAndFreeOfRigidMotions);
  RUN_TEST(PatternIsExact);
  RUN_TEST(PlacesAreThoseOfRows);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}
