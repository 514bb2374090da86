/* seepage.h: water that flows in joints, and open joints that no water reaches. */
#pragma once
#include "water/water.h"

/* Rows of the table of force terms. */
extern const TermKind Flow_term, Dry_term;
