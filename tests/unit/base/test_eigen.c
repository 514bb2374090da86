/* The slowest modes against chains of masses and springs in closed form, alone and many alike, held, free,
   with rows without mass, with a spring that pushes, and a block on a joint with its water. ranks: 1 2 3 4 */
#include "base/eigen.h"
#include "check.h"

static const PetscReal pi = 3.14159265358979323846;

/* A chain: equal masses and springs between them; the first is held by a spring of its own, or by none. */
typedef struct {
  PetscInt length, copies; /* masses; chains alike */
  PetscReal ground;        /* stiffness of the first spring over the others', 0: the chain is free */
  PetscInt massless;       /* this mass of each chain is 0; -1: none */
} Chain;

/* Copies that do not touch stand one behind the other, k = m = 1. */
static PetscErrorCode MakeChains(MPI_Comm comm, const Chain *chain, Mat *K, Mat *M)
{
  const PetscInt n = chain->length * chain->copies;
  PetscInt first, end;
  PetscFunctionBeginUser;
  PetscCall(MatCreateAIJ(comm, PETSC_DECIDE, PETSC_DECIDE, n, n, 3, NULL, 2, NULL, K));
  PetscCall(MatCreateAIJ(comm, PETSC_DECIDE, PETSC_DECIDE, n, n, 1, NULL, 0, NULL, M));
  PetscCall(MatGetOwnershipRange(*K, &first, &end));
  for (PetscInt i = first; i < end; i++) {
    const PetscInt at = i % chain->length;
    PetscReal diagonal = at ? 1. : chain->ground;
    if (at) PetscCall(MatSetValue(*K, i, i - 1, -1., INSERT_VALUES));
    if (at + 1 < chain->length) {
      diagonal += 1.;
      PetscCall(MatSetValue(*K, i, i + 1, -1., INSERT_VALUES));
    }
    PetscCall(MatSetValue(*K, i, i, diagonal, INSERT_VALUES));
    PetscCall(MatSetValue(*M, i, i, at == chain->massless ? 0. : 1., INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(*K, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*K, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyBegin(*M, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*M, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode EnsureResiduals(Mat K, Mat M, const Modes *modes)
{
  Vec x, r;
  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(K, &x, &r));
  for (PetscInt i = 0; i < modes->n; i++) {
    PetscReal rest;
    PetscCall(VecPlaceArray(x, modes->shapes + i * modes->rows));
    PetscCall(MatMult(M, x, r));
    PetscCall(VecScale(r, -modes->omega2[i]));
    PetscCall(MatMultAdd(K, x, r, r));
    PetscCall(VecNorm(r, NORM_2, &rest));
    ENSURE(rest < 1e-8);
    PetscCall(VecResetArray(x));
  }
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ModesOfChains(MPI_Comm comm, const Chain *chain, PetscReal omega_max, PetscInt most,
                                    Modes *modes)
{
  Mat K, M;
  PetscFunctionBeginUser;
  PetscCall(MakeChains(comm, chain, &K, &M));
  PetscCall(LowestModes(K, M, omega_max, most, modes));
  ENSURE(modes->missed == 0);
  ENSURE(!modes->wants);
  PetscCall(EnsureResiduals(K, M, modes));
  PetscCall(MatDestroy(&K));
  PetscCall(MatDestroy(&M));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* omega of mode i of n masses; held: at one end */
static PetscReal OmegaOfChain(PetscInt n, PetscInt i, int held)
{
  return 2. * sin(held ? (2. * i + 1.) * pi / (2. * (2. * n + 1.)) : i * pi / (2. * n));
}

/* The sum over all ranks of phi_i' phi_j, masses 1. */
static PetscReal Product(MPI_Comm comm, const Modes *modes, PetscInt i, PetscInt j)
{
  PetscReal sum = 0.;
  for (PetscInt row = 0; row < modes->rows; row++)
    sum += modes->shapes[i * modes->rows + row] * modes->shapes[j * modes->rows + row];
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPI_SUM, comm);
  return sum;
}

static PetscErrorCode TestChain(void)
{
  const MPI_Comm comms[] = {PETSC_COMM_WORLD, PETSC_COMM_SELF};
  enum { N = 60 };
  PetscFunctionBeginUser;
  for (int held = 0; held < 2; held++)
    for (int c = 0; c < 2; c++) {
      Modes modes;
      PetscCall(ModesOfChains(comms[c], &(Chain){N, 1, held, -1}, 0., 7, &modes));
      ENSURE(modes.n == 7);
      for (PetscInt i = 0; i < modes.n; i++) {
        const PetscReal omega = OmegaOfChain(N, i, held);
        ENSURE_NEAR(modes.omega2[i], omega * omega, 1e-12);
        for (PetscInt j = 0; j <= i; j++)
          ENSURE_NEAR(Product(comms[c], &modes, i, j), i == j ? 1. : 0., 1e-8);
      }
      PetscCall(ModesDestroy(&modes));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The end that moves most moves in the positive direction; a free chain's ends move alike and the first
   counts. */
static PetscErrorCode TestSign(void)
{
  enum { N = 12 };
  PetscFunctionBeginUser;
  for (int held = 0; held < 2; held++) {
    Modes modes;
    PetscCall(ModesOfChains(PETSC_COMM_SELF, &(Chain){N, 1, held, -1}, 0., 4, &modes));
    for (PetscInt i = 0; i < modes.n; i++) {
      const PetscReal *shape = modes.shapes + i * modes.rows;
      PetscInt largest = 0;
      for (PetscInt row = 1; row < N; row++)
        if (fabs(shape[row]) > fabs(shape[largest]) * (1. + 1e-6)) largest = row;
      ENSURE(shape[largest] > 0.);
    }
    PetscCall(ModesDestroy(&modes));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chains alike have modes of one frequency, as many as there are chains: one vector that Lanczos' method
   starts from has a part in one of them only. */
static PetscErrorCode TestAlike(void)
{
  enum { N = 25, COPIES = 5 };
  PetscFunctionBeginUser;
  for (int held = 0; held < 2; held++) {
    Modes modes;
    PetscCall(ModesOfChains(PETSC_COMM_WORLD, &(Chain){N, COPIES, held, -1}, 0., 12, &modes));
    ENSURE(modes.n == 12);
    for (PetscInt i = 0; i < modes.n; i++) {
      const PetscReal omega = OmegaOfChain(N, i / COPIES, held);
      ENSURE_NEAR(modes.omega2[i], omega * omega, 1e-11);
    }
    PetscCall(ModesDestroy(&modes));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestLimit(void)
{
  enum { N = 40 };
  const Chain chain = {N, 2, 1., -1};
  const PetscReal between = 0.5 * (OmegaOfChain(N, 4, 1) + OmegaOfChain(N, 5, 1));
  Modes modes;
  PetscFunctionBeginUser;
  PetscCall(ModesOfChains(PETSC_COMM_WORLD, &chain, between, 0, &modes));
  ENSURE(modes.n == 10);
  PetscCall(ModesDestroy(&modes));
  PetscCall(ModesOfChains(PETSC_COMM_WORLD, &chain, between, 3, &modes));
  ENSURE(modes.n == 3);
  ENSURE_NEAR(modes.omega2[2], pow(OmegaOfChain(N, 1, 1), 2), 1e-12);
  PetscCall(ModesDestroy(&modes));
  PetscCall(ModesOfChains(PETSC_COMM_WORLD, &chain, between, 30, &modes));
  ENSURE(modes.n == 10);
  PetscCall(ModesDestroy(&modes));
  PetscCall(ModesOfChains(PETSC_COMM_WORLD, &chain, 0.5 * OmegaOfChain(N, 0, 1), 5, &modes));
  ENSURE(modes.n == 0);
  PetscCall(ModesDestroy(&modes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A mass that is none leaves two springs in series: a chain of one mass less, with one spring of half the
   stiffness. All modes there are come, however many are asked for. */
static PetscErrorCode TestNoMass(void)
{
  Modes modes;
  PetscFunctionBeginUser;
  PetscCall(ModesOfChains(PETSC_COMM_WORLD, &(Chain){3, 1, 1., 1}, 0., 9, &modes));
  ENSURE(modes.n == 2);
  // 1 + 1/2 and 1/2 on the diagonal, -1/2 between
  ENSURE_NEAR(modes.omega2[0], 1. - sqrt(0.5), 1e-12);
  ENSURE_NEAR(modes.omega2[1], 1. + sqrt(0.5), 1e-12);
  PetscCall(ModesDestroy(&modes));
  PetscCall(ModesOfChains(PETSC_COMM_WORLD, &(Chain){1, 7, 1., 0}, 0., 2, &modes));
  ENSURE(modes.n == 0);
  PetscCall(ModesDestroy(&modes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A ground spring that pushes makes one motion that grows. */
static PetscErrorCode TestUnstable(void)
{
  Modes modes;
  PetscFunctionBeginUser;
  PetscCall(ModesOfChains(PETSC_COMM_WORLD, &(Chain){30, 1, -0.05, -1}, 0., 3, &modes));
  ENSURE(modes.n == 3);
  ENSURE(modes.omega2[0] < -1e-4);
  ENSURE(modes.omega2[1] > 1e-4);
  PetscCall(ModesDestroy(&modes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A rigid block of 20 m x 30 m on a joint of 10 and 3 GPa/m, with the water of a reservoir of 30 m at its
   vertical face (Westergaard): sliding, rocking and lifting. */
static PetscErrorCode TestBlock(void)
{
  const PetscReal mass = 2400. * 20. * 30., k_n = 10e9, k_s = 3e9,
                  K_of[9] = {20 * k_s,
                             0,
                             20 * k_s * 15,
                             0,
                             20 * k_n,
                             0,
                             20 * k_s * 15,
                             0,
                             20 * k_s * 15 * 15 + k_n * 20 * 20 * 20 / 12},
                  expected[2][3] = {{16.8005, 59.3136, 63.6216}, {15.0001, 55.0047, 59.3136}};
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  const PetscInt mine = rank == 0 ? 3 : 0;
  for (int wet = 0; wet < 2; wet++) {
    // moments of 7/8 rho sqrt(30 z) about the mass centre, z from the surface
    const PetscReal water = wet ? 7. / 8. * 1000. * sqrt(30.) : 0., root = pow(30., 1.5),
                    w_0 = water * root * 2. / 3., w_1 = water * root * 30. * 2. / 5.,
                    w_2 = water * root * 900. * 2. / 7.,
                    M_of[9] = {mass + w_0,
                               0,
                               w_1 - 15. * w_0,
                               0,
                               mass,
                               0,
                               w_1 - 15. * w_0,
                               0,
                               mass * (400. + 900.) / 12. + w_2 - 30. * w_1 + 225. * w_0};
    Mat K, M;
    Modes modes;
    PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, mine, mine, 3, 3, 3, NULL, 3, NULL, &K));
    PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, mine, mine, 3, 3, 3, NULL, 3, NULL, &M));
    for (PetscInt row = 0; row < mine; row++)
      for (PetscInt column = 0; column < 3; column++) {
        PetscCall(MatSetValue(K, row, column, K_of[3 * row + column], INSERT_VALUES));
        // the rotation by which the centre, 15 m above the joint, moves to -x is positive: see K
        PetscCall(MatSetValue(M, row, column, M_of[3 * row + column], INSERT_VALUES));
      }
    PetscCall(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyBegin(M, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(M, MAT_FINAL_ASSEMBLY));
    PetscCall(LowestModes(K, M, 0., 3, &modes));
    ENSURE(modes.n == 3);
    ENSURE(modes.missed == 0);
    for (PetscInt i = 0; i < modes.n; i++)
      ENSURE_NEAR(sqrt(modes.omega2[i]) / (2. * pi), expected[wet][i], 1e-4);
    PetscCall(ModesDestroy(&modes));
    PetscCall(MatDestroy(&K));
    PetscCall(MatDestroy(&M));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TestChain);
  RUN_TEST(TestSign);
  RUN_TEST(TestAlike);
  RUN_TEST(TestLimit);
  RUN_TEST(TestNoMass);
  RUN_TEST(TestUnstable);
  RUN_TEST(TestBlock);
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}
