/* anchors.h: declares the force term of anchors: tendons and bars from block to block. */
#pragma once
#include "term/term.h"

extern const TermKind Anchors_term;
