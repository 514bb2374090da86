/* loads.h: dead loads: weight, traction, point force; the force term to copy. */
#pragma once
#include "forces/blocks/blocks.h"

extern const TermKind Loads_term;
