/* lanes.h: arithmetic on LANES blocks or contacts at once, and how their vertices are gathered and their
   forces scattered. It uses no MPI, no PETSc objects, and no memory beyond the arguments.

   A Lanes value holds one number of each of LANES elements (GCC vector extension). + - * / act on all of
   them, so a formula reads as it would for one element. No lane sees another, and the build forbids
   contraction (-ffp-contract=off). So an element has the same bits in every lane, in every batch and with
   every instruction set: IEEE 754 fixes the rounding of + - * / and of the square root. */
#pragma once
#include "base/base.h"

/* Vectors are passed by value between functions that are always inlined, so the ABI does not matter. */
#pragma GCC diagnostic ignored "-Wpsabi"

#define KERNEL static inline __attribute__((always_inline))

/* Four fill AVX2; eight run out of registers there (measured: 2.5 times slower). The alignment is that of the
   stack, because the compiler warns of structures of more aligned vectors as arguments. */
enum { LANES = 4 };
typedef PetscReal Lanes __attribute__((vector_size(LANES * sizeof(PetscReal)), aligned(16)));
typedef long long Mask __attribute__((vector_size(LANES * sizeof(PetscReal)), aligned(16))); /* -1: true, 0 */
_Static_assert(BATCH % LANES == 0 && LANES == 4,
               "a batch is a whole number of vectors; the shuffles below are for 4");

typedef struct {
  Lanes x, y;
} LanesVector;

/* ---- numbers and masks */

KERNEL Lanes LanesOf(PetscReal x)
{
  return (Lanes){x, x, x, x};
}

KERNEL Lanes LoadLanes(const PetscReal *x)
{
  typedef PetscReal Unaligned __attribute__((vector_size(LANES * sizeof(PetscReal)), aligned(8)));
  return (Lanes) * (const Unaligned *)x;
}

KERNEL void StoreLanes(PetscReal *x, Lanes value)
{
  typedef PetscReal Unaligned __attribute__((vector_size(LANES * sizeof(PetscReal)), aligned(8)));
  *(Unaligned *)x = (Unaligned)value;
}

/* a where the mask is true, else b */
KERNEL Lanes Select(Mask mask, Lanes a, Lanes b)
{
  return (Lanes)((mask & (Mask)a) | (~mask & (Mask)b));
}

/* a where the mask is true, else 0; where the mask is false, a NaN becomes 0 */
KERNEL Lanes Keep(Mask mask, Lanes a)
{
  return (Lanes)(mask & (Mask)a);
}

KERNEL Lanes Absolute(Lanes a)
{
  return (Lanes)((Mask)a & 0x7fffffffffffffffLL);
}

KERNEL Lanes Larger(Lanes a, Lanes b)
{
  return Select(a > b, a, b);
}

/* max(a, 0); a NaN stays */
KERNEL Lanes NotNegative(Lanes a)
{
  return Keep(~(a < 0.), a);
}

KERNEL Lanes SquareRoot(Lanes a)
{
  return (Lanes){__builtin_sqrt(a[0]), __builtin_sqrt(a[1]), __builtin_sqrt(a[2]), __builtin_sqrt(a[3])};
}

KERNEL int Any(Mask mask)
{
  typedef long long Half __attribute__((vector_size(2 * sizeof(long long))));
  const Half half = __builtin_shufflevector(mask, mask, 0, 1) | __builtin_shufflevector(mask, mask, 2, 3);
  return (half[0] | half[1]) != 0;
}

/* ---- vectors in the plane */

KERNEL LanesVector VectorAdd(LanesVector p, LanesVector q)
{
  return (LanesVector){p.x + q.x, p.y + q.y};
}

KERNEL LanesVector VectorSubtract(LanesVector p, LanesVector q)
{
  return (LanesVector){p.x - q.x, p.y - q.y};
}

KERNEL LanesVector VectorScale(PetscReal s, LanesVector p)
{
  return (LanesVector){s * p.x, s * p.y};
}

KERNEL Lanes VectorDot(LanesVector p, LanesVector q)
{
  return p.x * q.x + p.y * q.y;
}

KERNEL Lanes VectorCross(LanesVector p, LanesVector q)
{
  return p.x * q.y - p.y * q.x;
}

/* ---- vertices. `vertex` is a row of BATCH local vertices, one per lane. */

/* x and y of one vertex, as they lie in memory */
typedef PetscReal Pair __attribute__((vector_size(2 * sizeof(PetscReal)), aligned(sizeof(PetscReal))));

KERNEL Pair LoadPair(const PetscReal *x)
{
  return *(const Pair *)x;
}

KERNEL void StorePair(PetscReal *x, Pair value)
{
  *(Pair *)x = value;
}

/* x: vertex array (n,2): loads of pairs, then a transposition. */
KERNEL LanesVector GatherVertex(const PetscReal *x, const PetscInt *vertex)
{
  Pair p[LANES];
  for (int lane = 0; lane < LANES; lane++) p[lane] = *(const Pair *)(x + 2 * (ptrdiff_t)vertex[lane]);
  const Lanes even = __builtin_shufflevector(p[0], p[2], 0, 1, 2, 3);
  const Lanes odd = __builtin_shufflevector(p[1], p[3], 0, 1, 2, 3);
  return (LanesVector){__builtin_shufflevector(even, odd, 0, 4, 2, 6),
                       __builtin_shufflevector(even, odd, 1, 5, 3, 7)};
}

/* n rows of BATCH vertices at `vertex` */
KERNEL void Gather(int n, const PetscReal *x, const PetscInt *vertex, LanesVector *p)
{
  for (int i = 0; i < n; i++) p[i] = GatherVertex(x, vertex + i * BATCH);
}

/* The inverse of Gather: adds the rows to f. It goes lane by lane, so that blocks and contacts are added in
   ascending order. n <= 6. */
KERNEL void ScatterAdd(int n, const LanesVector *p, const PetscInt *vertex, PetscReal *f)
{
  Pair pair[LANES][6];
  for (int i = 0; i < n; i++) {
    const Lanes even = __builtin_shufflevector(p[i].x, p[i].y, 0, 4, 2, 6);
    const Lanes odd = __builtin_shufflevector(p[i].x, p[i].y, 1, 5, 3, 7);
    pair[0][i] = __builtin_shufflevector(even, even, 0, 1);
    pair[1][i] = __builtin_shufflevector(odd, odd, 0, 1);
    pair[2][i] = __builtin_shufflevector(even, even, 2, 3);
    pair[3][i] = __builtin_shufflevector(odd, odd, 2, 3);
  }
  for (int lane = 0; lane < LANES; lane++)
    for (int i = 0; i < n; i++) *(Pair *)(f + 2 * (ptrdiff_t)vertex[i * BATCH + lane]) += pair[lane][i];
}

/* ---- one copy of a hot loop per instruction set; key isa picks one (isa.c).

   VARIANTS(Name, (parameters), (arguments)) makes the function Name from the kernel Name_code. The four Gauss
   points of an element, the two ends of a contact, are independent; scheduling before register allocation
   mixes them and hides the latency of the divisions: a fifth of the time with AVX-512. With the 16 registers
   of AVX2 the gain is lost to the stack unless it counts them (sched-pressure): 150 stack accesses for four
   blocks instead of 260. */
extern InstructionSet instruction_set; /* of this process, written by IsaSelect */

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define SCHEDULED optimize("schedule-insns", "sched-pressure", "rename-registers")
#define VARIANTS(name, parameters, arguments)                                                                \
  __attribute__((SCHEDULED)) static void name##_base parameters                                              \
  {                                                                                                          \
    name##_code arguments;                                                                                   \
  }                                                                                                          \
  __attribute__((target("arch=x86-64-v3"), SCHEDULED)) static void name##_v3 parameters                      \
  {                                                                                                          \
    name##_code arguments;                                                                                   \
  }                                                                                                          \
  __attribute__((target("arch=x86-64-v4"), SCHEDULED)) static void name##_v4 parameters                      \
  {                                                                                                          \
    name##_code arguments;                                                                                   \
  }                                                                                                          \
  static void name parameters                                                                                \
  {                                                                                                          \
    if (instruction_set == ISA_V4)                                                                           \
      name##_v4 arguments;                                                                                   \
    else if (instruction_set == ISA_V3)                                                                      \
      name##_v3 arguments;                                                                                   \
    else                                                                                                     \
      name##_base arguments;                                                                                 \
  }
#else
#define VARIANTS(name, parameters, arguments)                                                                \
  static void name parameters                                                                                \
  {                                                                                                          \
    name##_code arguments;                                                                                   \
  }
#endif
