/* law_point.h: what a material law sees of a point, in lanes. */
#pragma once
#include "forces/blocks/element_kernels.h"
#include "forces/blocks/laws.h"

/* Stress or strain in plane strain, z included. */
typedef struct {
  Lanes xx, yy, zz, xy;
} LanesStress;

typedef struct {
  const PetscReal *constant; /* (LAW_CONSTANTS, LANES) */
} LanesLaw;

KERNEL Lanes LawConstant(const LanesLaw *law, int k)
{
  return LoadLanes(law->constant + LANES * k);
}

/* The constants of LANES blocks: those of their group, or, where they are of several, gathered into `mixed`,
   (LAW_CONSTANTS, LANES). */
KERNEL LanesLaw LoadLaw(const LawHistory *h, const PetscInt *group, PetscReal *mixed)
{
  const PetscReal *first = h->constants + LAW_CONSTANTS * LANES * (ptrdiff_t)group[0];
  if (group[0] == group[1] && group[0] == group[2] && group[0] == group[3]) return (LanesLaw){first};
  for (int i = 0; i < LAW_CONSTANTS * LANES; i++)
    mixed[i] = h->constants[LAW_CONSTANTS * LANES * (ptrdiff_t)group[i % LANES] + i];
  return (LanesLaw){mixed};
}

KERNEL LanesMaterial MaterialOf(const LanesLaw *law)
{
  const Lanes c0 = LawConstant(law, LAW_HOURGLASS);
  return (LanesMaterial){LawConstant(law, LAW_LAMBDA),
                         LawConstant(law, LAW_MU),
                         {c0, LawConstant(law, LAW_HOURGLASS + 1), LawConstant(law, LAW_HOURGLASS + 2)},
                         c0 > 0.};
}

KERNEL Lanes Smaller(Lanes a, Lanes b)
{
  return Select(a < b, a, b);
}

/* ---- laws.c, by LANES blocks from `first` on, of the history now */
/* S at a point of the blocks, from the strain E there. */
void LawPointStress(const Elements *e, PetscInt first, int point, const LanesTensor *E, LanesTensor *S);
/* [J] per thickness: what is stored in the blocks, whose modes are X, u. */
void LawEnergy(const Elements *e, PetscInt first, const LanesModes *X, const LanesModes *u, Lanes *stored);
/* [J] What has been lost in the blocks of a list that this rank writes. */
PetscReal LawLost(const Model *model, const Elements *e);
