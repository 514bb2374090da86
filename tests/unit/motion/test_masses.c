/* Scaled masses (V09). The largest frequency of blocks and closed joints stays below 2 safety / dt for any
   stiffness of the joints, and undamped motion does not grow. The paper's own masses (29) exceed that
   limit. */
#include "scene_fixture.h"

enum { MAX_DOF = 64 };
typedef enum { TWO_RIGID, TWO_DEFORMABLE, MIXED, MACROBLOCK, OBLIQUE, HANGING, ASSEMBLIES } Assembly;
static const double k_n[] = {1e8, 1e9, 1e10, 1e11, 1e12, 1e13}, ratio[] = {0, 0.3, 1};

static Sketch sketch;

static void Assemble(Assembly kind)
{
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0), hard = SketchGroup(&sketch, "hard", 1);
  if (kind <= MIXED) {
    SketchBox(&sketch, kind == TWO_DEFORMABLE ? soft : hard, 0, 0, 1, 1);
    SketchBox(&sketch, kind == TWO_RIGID ? hard : soft, 0, 1, 1, 1);
  } else if (kind == MACROBLOCK) { // an L of three rigid blocks, blocks of both kinds on all its sides
    const double foot[8] = {0, 0, 2, 0, 2, 1, 0, 1};
    SketchGrid(&sketch, hard, foot, 2, 1, QUADS);
    const int first = SketchVertex(&sketch, 0, 2.5);
    SketchVertex(&sketch, 1, 2);
    SketchBlock(&sketch, hard, 3, 4, first + 1, first); // on vertices 3 and 4 of the foot
    SketchBox(&sketch, soft, 1, 1, 1, 1);
    SketchBox(&sketch, hard, -.7, -1, 1.4, 1);
    SketchBox(&sketch, soft, .7, -1, 3, 1);
    SketchBox(&sketch, hard, -1, .2, 1, .5);
  } else if (kind == OBLIQUE) { // non-matching, triangles, any direction
    const double low[8] = {0, 0, 2, 0, 2, 1, 0, 1}, high[8] = {-.3, 1, 1.6, 1, 1.7, 1.5, 0, 1.7};
    SketchGrid(&sketch, soft, low, 3, 1, TRIANGLES);
    SketchGrid(&sketch, soft, high, 2, 1, QUADS);
    SketchBox(&sketch, hard, 2, -.5, .3, 1.2);
    SketchMove(&sketch, 0, 0.6, 10, -3);
  } else { // a macroblock that is rigid below and deformable above, on a rigid block
    const double body[8] = {0, 0, 1, 0, 1, 2, 0, 2};
    sketch.group[SketchGrid(&sketch, soft, body, 1, 2, QUADS)] = hard;
    SketchBox(&sketch, hard, -.2, -1, .9, 1);
    SketchBox(&sketch, soft, 1, .5, 1, 1);
  }
}

static PetscErrorCode OpenAssembly(Assembly kind, const char *strain, const char *model, double kn, double ks,
                                   Fixture *f)
{
  PetscFunctionBeginUser;
  Assemble(kind);
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                  "strain: %s\nthickness: 1.5\nmaterials: {soft: {density: 2400, young: 1e10, poisson: 0.2}, "
                  "hard: {density: 2400, rigid: true}}\n"
                  "relaxation: {damping: none, allow_floating: true}\n"
                  "joints: {default: {law: elastic, stress_model: %s, k_n: %.17g, k_s: %.17g}}\n"
                  "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n",
                  strain, model, kn, ks));
  PetscCall(ScaledMasses(f->scene, f->model, f->scene->joints, f->contacts, f->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* K by central differences of the resisting forces at rest: (n_dof, n_dof) [N/m, N, N m]. */
static PetscErrorCode Stiffness(Fixture *f, PetscReal K[MAX_DOF][MAX_DOF])
{
  const PetscInt n = f->model->n_dof;
  const PetscReal h = 1e-6;

  PetscFunctionBeginUser;
  PetscCheck(n <= MAX_DOF, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ, "%" PetscInt_FMT " dofs", n);
  for (PetscInt d = 0; d < n; d++)
    for (int side = -1; side <= 1; side += 2) {
      for (PetscInt i = 0; i < n; i++) f->state->u[i] = i == d ? side * h : 0;
      RigidMotion(f->model, f->state->u);
      PetscCall(Forces(f->scene, f->model, f->scene->joints, f->contacts, f->state, NULL));
      for (PetscInt i = 0; i < n; i++) K[i][d] = (side < 0 ? 0 : K[i][d]) + side * f->state->f[i] / (2 * h);
    }
  for (PetscInt i = 0; i < n; i++) f->state->u[i] = 0;
  RigidMotion(f->model, f->state->u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Largest eigenvalue of M^-1 K by power iteration (the Rayleigh quotient, from below). */
static PetscReal LargestEigenvalue(PetscInt n, PetscReal K[MAX_DOF][MAX_DOF], const PetscReal *m)
{
  PetscReal x[MAX_DOF], y[MAX_DOF], lambda = 0;
  for (PetscInt i = 0; i < n; i++) x[i] = Uniform(-1, 1);
  for (int step = 0; step < 600; step++) {
    PetscReal norm = 0;
    lambda = 0;
    for (PetscInt i = 0; i < n; i++) norm += x[i] * x[i];
    for (PetscInt i = 0; i < n; i++) x[i] /= sqrt(norm);
    for (PetscInt i = 0; i < n; i++) {
      y[i] = 0;
      for (PetscInt j = 0; j < n; j++) y[i] += 0.5 * (K[i][j] + K[j][i]) * x[j] / sqrt(m[i] * m[j]);
      lambda += x[i] * y[i];
    }
    memcpy(x, y, sizeof x);
  }
  return lambda;
}

static PetscErrorCode SetJoint(Fixture *f, double kn, double ks)
{
  PetscFunctionBeginUser;
  f->scene->joints[0].k_n = kn, f->scene->joints[0].k_s = ks;
  PetscCall(ScaledMasses(f->scene, f->model, f->scene->joints, f->contacts, f->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The bound holds, and is not loose: omega dt between 0.65 and 1 times 2 safety. */
static PetscErrorCode LargestFrequencyIsBelowTheLimit(void)
{
  static PetscReal K[MAX_DOF][MAX_DOF];

  PetscFunctionBeginUser;
  for (Assembly kind = 0; kind < ASSEMBLIES; kind++)
    for (int model = 0; model < 2; model++) {
      Fixture f;
      PetscCall(OpenAssembly(kind, "small", model ? "pt" : "tptm", 1, 1, &f));
      for (int i = 0; i < 18; i++) {
        PetscCall(SetJoint(&f, k_n[i / 3], ratio[i % 3] * k_n[i / 3]));
        PetscCall(Stiffness(&f, K));
        const PetscReal top = LargestEigenvalue(f.model->n_dof, K, f.state->m) * f.state->dt * f.state->dt;
        const PetscReal sharp = sqrt(top) / (2 * f.scene->safety);
        ENSURE(top <= 4 * f.scene->safety * f.scene->safety * (1 + 1e-9));
        ENSURE(sharp > 0.65);
      }
      PetscCall(FixtureClose(&f));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 1/2 v.m v and its largest value over undamped steps from a random small velocity */
static PetscErrorCode Growth(Fixture *f, int n_steps, PetscReal *growth)
{
  State *s = f->state;
  const PetscInt n = f->model->n_dof;
  PetscReal first = 0;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < n; d++) {
    s->u[d] = s->f_ext[d] = 0;
    s->v[d] = 1e-9 * Uniform(-1, 1);
    first += s->m[d] * s->v[d] * s->v[d];
  }
  RigidMotion(f->model, s->u);
  *growth = 0;
  for (int step = 0; step < n_steps; step++) {
    PetscReal now = 0;
    PetscCall(Step(f->scene, f->model, f->scene->joints, f->contacts, s, &f->relax->damping, NULL));
    for (PetscInt d = 0; d < n; d++) now += s->m[d] * s->v[d] * s->v[d];
    *growth = PetscMax(*growth, now / first);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* With lambda dt2 <= 4 safety2 the scheme conserves a quantity that bounds the kinetic energy by the first
   one over 1 - safety2. */
static PetscErrorCode UndampedMotionDoesNotGrow(void)
{
  PetscFunctionBeginUser;
  for (Assembly kind = 0; kind < ASSEMBLIES; kind++) {
    Fixture f;
    PetscCall(OpenAssembly(kind, "large", "tptm", 1, 1, &f));
    for (int n = 0; n < 6; n++) {
      PetscReal growth;
      PetscCall(SetJoint(&f, k_n[n], ratio[(n + kind) % 3] * k_n[n]));
      PetscCall(Growth(&f, 2000, &growth));
      ENSURE(growth <= (1 + 1e-3) / (1 - f.scene->safety * f.scene->safety));
    }
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Masses of the paper: (29) k_CT,i = (k_n + k_s) L_i at the vertex and, by the lever, at the face opposite;
   (31) for bodies; (33) with safety 1. */
static PetscErrorCode PaperMasses(Fixture *f)
{
  const Model *m = f->model;
  const Contacts *c = f->contacts;
  const Joint *j = f->scene->joints;
  PetscReal *k;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->mesh.n_vertices + DUMMY_VERTICES, &k));
  PetscCall(ElementStiffness(m, k));
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int s = 0; s < 2; s++) {
      PetscInt v[3];
      ContactEndVertices(c, i, s, v);
      const PetscReal row = (j->k_n + j->k_s) * 0.5 * c->length[i] * m->materials.thickness,
                      t = c->t[SUB(i, s)];
      k[v[0]] += row, k[v[1]] += row * (1 - t), k[v[2]] += row * t;
    }
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    PetscReal row[3] = {0, 0, 0};
    for (PetscInt v = m->rigid.start[b]; v < m->rigid.start[b + 1]; v++) {
      const PetscReal x = m->mesh.X[2 * v] - m->rigid.X[2 * b],
                      y = m->mesh.X[2 * v + 1] - m->rigid.X[2 * b + 1];
      row[0] += k[v], row[1] += k[v], row[2] += k[v] * (x * x + y * y);
    }
    for (int i = 0; i < 3; i++) f->state->m[3 * b + i] = 0.25 * row[i];
  }
  for (PetscInt d = 0; d < 2 * m->mesh.n_deformable; d++) f->state->m[3 * m->rigid.n + d] = 0.25 * k[d / 2];
  for (PetscInt d = 0; d < m->n_dof; d++) f->state->m_inv[d] = 1 / f->state->m[d];
  PetscCall(PetscFree(k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The reason for masses of our own: two free rigid blocks with (29) and k_s = 0.3 k_n
   have omega dt = 2.481. */
static PetscErrorCode PaperMassesBlowUpTwoFreeBlocks(void)
{
  static PetscReal K[MAX_DOF][MAX_DOF];
  static const struct {
    double ratio, omega_dt;
  } table[] = {{0.3, 2.4807}, {0.1, 2.6968}, {0, 2.8284}};

  PetscFunctionBeginUser;
  for (int i = 0; i < 3; i++) {
    Fixture f;
    PetscReal growth;
    PetscCall(OpenAssembly(TWO_RIGID, "small", "pt", 1e10, table[i].ratio * 1e10, &f));
    PetscCall(PaperMasses(&f));
    PetscCall(Stiffness(&f, K));
    ENSURE_NEAR(sqrt(LargestEigenvalue(f.model->n_dof, K, f.state->m)), table[i].omega_dt, 1e-3);
    PetscCall(Growth(&f, 20, &growth));
    ENSURE(growth > 1e9);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* V09, second part: two unit Q4 of 10 GPa, pt, k_s = 0.3 k_n; stable at the paper's own 1e10 Pa/m only. */
static PetscErrorCode PaperMassesBlowUpStiffJointsOfDeformableBlocks(void)
{
  static PetscReal K[MAX_DOF][MAX_DOF];
  static const double omega_dt[4] = {1.905, 1.956, 2.319, 2.461};

  PetscFunctionBeginUser;
  for (int i = 0; i < 4; i++) {
    Fixture f;
    PetscCall(OpenAssembly(TWO_DEFORMABLE, "small", "pt", k_n[i + 1], 0.3 * k_n[i + 1], &f));
    PetscCall(PaperMasses(&f));
    PetscCall(Stiffness(&f, K));
    ENSURE_NEAR(sqrt(LargestEigenvalue(f.model->n_dof, K, f.state->m)), omega_dt[i], 2e-3);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Held dofs have no inverse mass; bodies without any contact keep a mass. */
static PetscErrorCode EveryDofHasAMass(void)
{
  Fixture f;

  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0), hard = SketchGroup(&sketch, "hard", 1);
  SketchBox(&sketch, soft, 0, 0, 1, 1);
  SketchBox(&sketch, hard, 5, 0, 1, 1);
  PetscCall(FixtureOpen(
      PETSC_COMM_WORLD, &sketch, &f,
      "materials: {soft: {density: 0, young: 1e10, poisson: 0.2}, hard: {density: 0, rigid: true}}\n"
      "relaxation: {allow_floating: true}\n"
      "joints: {default: {law: elastic, k_n: 1, k_s: 1}}\nsupports: {soft: {fix: x}}\n"
      "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n"));
  PetscCall(ScaledMasses(f.scene, f.model, f.scene->joints, f.contacts, f.state));
  for (PetscInt d = 0; d < f.model->n_dof; d++) {
    ENSURE(f.state->m[d] > 0);
    ENSURE(f.state->m_inv[d] == (d >= 3 && d % 2 ? 0 : 1 / f.state->m[d]));
  }
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(LargestFrequencyIsBelowTheLimit);
  RUN_TEST(UndampedMotionDoesNotGrow);
  RUN_TEST(PaperMassesBlowUpTwoFreeBlocks);
  RUN_TEST(PaperMassesBlowUpStiffJointsOfDeformableBlocks);
  RUN_TEST(EveryDofHasAMass);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}
