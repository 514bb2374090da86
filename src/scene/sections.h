/* sections.h: lists the sections of a scene that are lists of names. A file keys_<room>.h holds what belongs
   to one: its structs under KEY_STRUCTS (scene.h includes these), the words of its choices under KEY_WORDS
   and the rows of its keys under KEY_ROWS (keys.h includes both). So this file is included once for each.
   A force term adds its section to TERM_SECTIONS and its file below; a TermEntry comes first in the struct
   of an entry. */
#ifndef TERM_SECTIONS
/* S(SECTION, "section of the scene", struct of an entry) */
#define TERM_SECTIONS(S) S(ANCHORS, "anchors", Anchor)
#endif
#include "scene/keys_blocks.h"
#include "scene/keys_joints.h"
#include "scene/keys_motions.h"
#include "scene/keys_supports.h"
#include "scene/keys_loads.h"
#include "scene/keys_stages.h"
#include "scene/keys_anchors.h"
