/* reproducible.h: sums doubles in two bins, with the same bits in any order and on any number of ranks.

   A number x with |x| <= bound is cut at fixed places: q = (x + A) - A rounds x to a multiple of ulp(A), and
   the rest goes into the next bin. Sums of up to 2^26 such multiples are exact in a double, so a plain
   MPI_SUM keeps the bits in any order. Two bins keep 54 bits below the bound. This needs -ffp-contract=off
   and no reassociation. */
#pragma once
#include "base/base.h"
#include <petscsys.h>
#include <math.h>

enum { BIN_BITS = 27 }; /* width of a bin; 2^26 terms fit */

typedef struct {
  PetscReal a[2];
} Bins;

/* Returns bins for terms up to `bound` (> 0) in magnitude; the bound need not be tight. */
static inline Bins BinsFor(PetscReal bound)
{
  int exponent;
  (void)frexp(bound, &exponent); // bound <= 2^exponent
  exponent = PetscMax(PetscMin(exponent, 900), -800);
  const PetscReal unit = ldexp(1., exponent - BIN_BITS);
  return (Bins){{1.5 * ldexp(unit, 52), 1.5 * ldexp(unit, 52 - BIN_BITS)}};
}

static inline void BinAdd(const Bins *bins, PetscReal x, PetscReal sum[2])
{
  const PetscReal high = (x + bins->a[0]) - bins->a[0], rest = x - high;
  sum[0] += high;
  sum[1] += (rest + bins->a[1]) - bins->a[1];
}
