/* bench_stability: how far the scaled masses are from the limit of the explicit scheme.

     bench_stability <scene.yaml> [-key value ...]

   With elastic joints and small strain the scheme is stable without damping as long as omega dt <= 2, omega^2
   the largest eigenvalue of M^-1 K. Prints omega dt / 2 for dt = 1 (safety 1) with the masses of masses.c,
   and with the paper's, which count (29) (k_n + k_s) L_i at each end of a contact: above 1 the run blows up.
   Power iteration with the program's own forces. One rank. */
#include "run/run.h"

enum { SWEEPS = 600 };
static const PetscReal SMALL = 1e-9; /* of the model's diameter: displacements of the iteration */

typedef struct {
  Scene *scene;
  Model *model;
  State *state;
  Contacts *contacts;
  Relaxation *relax;
} Parts;

/* (29) per vertex, as the paper has it: the destination's share by where the vertex stands on the edge. */
static void paper_stiffness(const Parts *p, const Joint *joints, PetscReal *k)
{
  const Contacts *c = p->contacts;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const Joint *joint = joints + c->joint[i];
    for (int s = 0; s < 2 && c->key[2 * i] >= 0; s++) {
      PetscInt v[3];
      ContactEndVertices(c, i, s, v);
      const PetscReal row = (joint->k_n + joint->k_s) * 0.5 * c->length[i] * p->model->materials.thickness,
                      t = c->t[SUB(i, s)];
      k[v[0]] += row;
      k[v[1]] += row * (1. - t);
      k[v[2]] += row * t;
    }
  }
}

/* Masses (33)-(34), (31) from a stiffness per vertex, as printed. */
static void paper_masses(const Parts *p, const PetscReal *k, PetscReal *m)
{
  const Model *model = p->model;
  for (PetscInt b = 0; b < model->rigid.n; b++) {
    const PetscReal *C = model->rigid.X + 2 * b;
    PetscReal K = 0., K_rot = 0.;
    for (PetscInt v = model->rigid.start[b]; v < model->rigid.start[b + 1]; v++) {
      K += k[v];
      K_rot += k[v] *
               (PetscSqr(model->mesh.X[2 * v] - C[0]) + PetscSqr(model->mesh.X[2 * v + 1] - C[1])); // (31)
    }
    m[3 * b] = m[3 * b + 1] = 0.25 * K;
    m[3 * b + 2] = 0.25 * K_rot;
  }
  for (PetscInt d = 0; d < 2 * model->mesh.n_deformable; d++) m[3 * model->rigid.n + d] = 0.25 * k[d / 2];
}

/* omega dt / 2 of the masses m, dt = 1. */
static PetscErrorCode half_frequency(const Parts *p, const PetscReal *m, PetscReal *half)
{
  const Joint *joints = p->scene->stages[0].joints;
  const Model *model = p->model;
  const PetscReal size = SMALL * model->mesh.diameter;
  PetscReal top = 0., *u = p->state->u, *f_0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->n_dof, &f_0));
  PetscCall(PetscArrayzero(u, model->n_dof));
  RigidMotion(model, u);
  PetscCall(Forces(p->scene, model, joints, p->contacts, p->state, NULL));
  PetscCall(PetscArraycpy(f_0, p->state->f, model->n_dof));
  for (PetscInt d = 0; d < model->n_dof; d++)
    u[d] = Held(model, d) ? 0. : size * (2. * rand() / RAND_MAX - 1.);
  for (int sweep = 0; sweep < SWEEPS; sweep++) {
    PetscReal num = 0., den = 0., most = 0.;
    RigidMotion(model, u);
    PetscCall(Forces(p->scene, model, joints, p->contacts, p->state, NULL));
    for (PetscInt d = 0; d < model->n_dof; d++) {
      if (Held(model, d)) continue;
      const PetscReal r = p->state->f[d] - f_0[d];
      num += u[d] * r, den += m[d] * u[d] * u[d];
      u[d] = m[d] > 0. ? r / m[d] : 0.;
      most = PetscMax(most, PetscAbsReal(u[d]));
    }
    top = num / den;
    for (PetscInt d = 0; d < model->n_dof; d++) u[d] *= size / most;
  }
  *half = 0.5 * PetscSqrtReal(top);
  PetscCall(PetscFree(f_0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode run(int argc, char **argv)
{
  Quoin quoin;
  Parts p;
  PetscReal *k, *m, ours, paper;
  PetscFunctionBeginUser;
  PetscCall(QuoinCreate(PETSC_COMM_WORLD, &quoin));
  PetscCall(QuoinSetFromOptions(quoin, argv[1], argc - 1, argv + 1));
  PetscCall(QuoinSetUp(quoin));
  PetscCall(QuoinGetParts(quoin, &p.scene, &p.model, &p.state, &p.contacts, &p.relax));
  p.scene->safety = 1.;
  PetscCall(ScaledMasses(p.scene, p.model, p.scene->stages[0].joints, p.contacts, p.state));
  PetscCall(half_frequency(&p, p.state->m, &ours));
  PetscCall(PetscCalloc1(p.model->mesh.n_vertices + DUMMY_VERTICES, &k));
  PetscCall(PetscMalloc1(p.model->n_dof, &m));
  PetscCall(ElementStiffness(p.model, k)); // (28)
  paper_stiffness(&p, p.scene->stages[0].joints, k);
  paper_masses(&p, k, m);
  PetscCall(half_frequency(&p, m, &paper));
  PetscCall(
      PetscPrintf(PETSC_COMM_WORLD, "{\"ours\": %.6g, \"paper\": %.6g}\n", (double)ours, (double)paper));
  PetscCall(PetscFree(k));
  PetscCall(PetscFree(m));
  PetscCall(QuoinDestroy(&quoin));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  if (argc < 2) {
    fprintf(stderr, "use: bench_stability <scene.yaml> [-key value ...]\n");
    return 2;
  }
  PetscCall(PetscInitialize(NULL, NULL, NULL, NULL));
  PetscCall(QuoinErrorHandlerPush());
  const PetscErrorCode code = run(argc, argv);
  PetscCall(PetscPopErrorHandler());
  if (code) MPI_Abort(MPI_COMM_WORLD, 1);
  return PetscFinalize();
}
