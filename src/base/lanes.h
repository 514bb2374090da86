/* lanes.h: computes with LANES blocks or contacts at once, gathers their vertices and scatters their
   forces. It uses no MPI, no PETSc objects, and no memory beyond the arguments.

   A Lanes value holds one number of each of LANES elements (GCC vector extension). + - * / act on all of
   them, so a formula reads as it would for one element. No lane sees another, and the build forbids
   contraction (-ffp-contract=off). So an element has the same bits in every lane, in every batch and with
   every instruction set: IEEE 754 fixes the rounding of + - * / and of the square root. */
#pragma once
#include "base/base.h"

/* Vectors are passed by value between functions that are always inlined, so the ABI does not matter. */
#pragma GCC diagnostic ignored "-Wpsabi"

#define KERNEL static inline __attribute__((always_inline))

/* LANES is 4, which fills AVX2; 8 runs out of registers there (measured: 2.5 times slower). A file
   compiled for AVX-512 alone defines WIDE_LANES before this header and has 8. The alignment is the alignment
   of the stack, because the compiler warns of more aligned vectors as arguments. */
#ifdef WIDE_LANES
enum { LANES = 8 };
#else
enum { LANES = 4 };
#endif
typedef PetscReal Lanes __attribute__((vector_size(LANES * sizeof(PetscReal)), aligned(16)));
typedef long long Mask __attribute__((vector_size(LANES * sizeof(PetscReal)), aligned(16))); /* -1: true, 0 */
_Static_assert(BATCH % LANES == 0, "a batch is a whole number of vectors");

typedef struct {
  Lanes x, y;
} LanesVector;

/* ---- numbers and masks */

KERNEL Lanes LanesOf(PetscReal x)
{
  return x - (Lanes){0.};
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

/* Returns a where the mask is true, else b. */
KERNEL Lanes Select(Mask mask, Lanes a, Lanes b)
{
  return (Lanes)((mask & (Mask)a) | (~mask & (Mask)b));
}

/* Returns a where the mask is true, else 0. A NaN becomes 0 where the mask is false. */
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

/* Returns max(a, 0); a NaN stays. */
KERNEL Lanes NotNegative(Lanes a)
{
  return Keep(~(a < 0.), a);
}

/* Returns the vector of an expression evaluated for each lane. */
#ifdef WIDE_LANES
#define LANE_BY_LANE(at)                                                                                     \
  {                                                                                                          \
    at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)                                                   \
  }
#else
#define LANE_BY_LANE(at)                                                                                     \
  {                                                                                                          \
    at(0), at(1), at(2), at(3)                                                                               \
  }
#endif

KERNEL Lanes SquareRoot(Lanes a)
{
#define ROOT(lane) __builtin_sqrt(a[lane])
  return (Lanes)LANE_BY_LANE(ROOT);
#undef ROOT
}

KERNEL int Any(Mask mask)
{
  typedef long long Half __attribute__((vector_size(2 * sizeof(long long))));
  Half any = __builtin_shufflevector(mask, mask, 0, 1) | __builtin_shufflevector(mask, mask, 2, 3);
#ifdef WIDE_LANES
  any |= __builtin_shufflevector(mask, mask, 4, 5) | __builtin_shufflevector(mask, mask, 6, 7);
#endif
  return (any[0] | any[1]) != 0;
}

/* Gathers the first number of a row of x, (n,3), for each lane. */
KERNEL Lanes GatherThird(const PetscReal *x, const PetscInt *row)
{
#define FIRST(lane) x[3 * row[lane]]
  return (Lanes)LANE_BY_LANE(FIRST);
#undef FIRST
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

/* Return the even or the odd places of p and q in turns: p_0, q_0, p_2, q_2, ... and p_1, q_1, p_3, q_3,
   ... */
#ifdef WIDE_LANES
#define EVEN_OF(p, q) __builtin_shufflevector(p, q, 0, 8, 2, 10, 4, 12, 6, 14)
#define ODD_OF(p, q) __builtin_shufflevector(p, q, 1, 9, 3, 11, 5, 13, 7, 15)
#else
#define EVEN_OF(p, q) __builtin_shufflevector(p, q, 0, 4, 2, 6)
#define ODD_OF(p, q) __builtin_shufflevector(p, q, 1, 5, 3, 7)
#endif

/* Returns the pairs p[0], p[2], ... one after the other. */
KERNEL Lanes EverySecond(const Pair *p)
{
#ifdef WIDE_LANES
  typedef PetscReal Half __attribute__((vector_size(4 * sizeof(PetscReal))));
  const Half low = __builtin_shufflevector(p[0], p[2], 0, 1, 2, 3),
             high = __builtin_shufflevector(p[4], p[6], 0, 1, 2, 3);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  return __builtin_shufflevector(p[0], p[2], 0, 1, 2, 3);
#endif
}

/* Inverts EverySecond. */
KERNEL void ToEverySecond(Lanes x, Pair *p)
{
  p[0] = __builtin_shufflevector(x, x, 0, 1);
  p[2] = __builtin_shufflevector(x, x, 2, 3);
#ifdef WIDE_LANES
  p[4] = __builtin_shufflevector(x, x, 4, 5);
  p[6] = __builtin_shufflevector(x, x, 6, 7);
#endif
}

/* Gathers x and y of vertices from x, (n,2): loads of pairs, then a transposition. */
KERNEL LanesVector GatherVertex(const PetscReal *x, const PetscInt *vertex)
{
  Pair p[LANES];
  for (int lane = 0; lane < LANES; lane++) p[lane] = *(const Pair *)(x + 2 * (ptrdiff_t)vertex[lane]);
  const Lanes even = EverySecond(p), odd = EverySecond(p + 1);
  return (LanesVector){EVEN_OF(even, odd), ODD_OF(even, odd)};
}

/* Gathers n rows of BATCH vertices. */
KERNEL void Gather(int n, const PetscReal *x, const PetscInt *vertex, LanesVector *p)
{
  for (int i = 0; i < n; i++) p[i] = GatherVertex(x, vertex + i * BATCH);
}

/* Adds the rows to f: the inverse of Gather. Adds lane by lane, so that blocks and contacts are added in
   ascending order. n <= 6. */
KERNEL void ScatterAdd(int n, const LanesVector *p, const PetscInt *vertex, PetscReal *f)
{
  Pair pair[6][LANES];
  for (int i = 0; i < n; i++) {
    ToEverySecond(EVEN_OF(p[i].x, p[i].y), pair[i]);
    ToEverySecond(ODD_OF(p[i].x, p[i].y), pair[i] + 1);
  }
  for (int lane = 0; lane < LANES; lane++)
    for (int i = 0; i < n; i++) *(Pair *)(f + 2 * (ptrdiff_t)vertex[i * BATCH + lane]) += pair[i][lane];
}

/* ---- one copy of a hot loop per instruction set; key isa picks one (isa.c).

   VARIANTS(Name, (parameters), (arguments)) makes the function Name from the kernel Name_code. The four Gauss
   points of an element, the two ends of a contact, are independent; scheduling before register allocation
   mixes them and hides the latency of the divisions: a fifth of the time with AVX-512. With the 16 registers
   of AVX2 the gain is lost to the stack unless it counts them (sched-pressure): 150 stack accesses for four
   blocks instead of 260. Without AVX the compiler compares lanes one by one, five times the code; -O1 spares
   half of the time that contacts/force.c takes to compile. */
extern InstructionSet instruction_set; /* of this process, written by IsaSelect */

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define SCHEDULED optimize("schedule-insns", "sched-pressure", "rename-registers")
#define VARIANTS(name, parameters, arguments)                                                                \
  __attribute__((optimize("O1"))) static void name##_base parameters                                         \
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
