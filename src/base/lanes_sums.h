/* lanes_sums.h: sums the numbers of LANES elements in two bins each, lane by lane, with the same bits in any
   order (reproducible.h). */
#pragma once
#include "base/lanes.h"
#include "base/reproducible.h"

/* Adds x to the bins of each lane. */
KERNEL void BinAddLanes(const Bins *bins, Lanes x, Lanes sum[2])
{
#ifdef PLAIN_SUMS // bench_plain_sums measures with this the cost of sums that have the same bits in any order
  (void)bins, sum[0] += x;
  return;
#endif
  const Lanes high = (x + bins->a[0]) - bins->a[0], rest = x - high;
  sum[0] += high;
  sum[1] += (rest + bins->a[1]) - bins->a[1];
}
