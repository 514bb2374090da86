/* anchors.h: tendons and bars from block to block. */
#pragma once
#include "forces/term/term.h"

extern const TermKind Anchors_term;
