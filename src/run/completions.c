/* completions.c: lists the functions that complete keys of a scene, each from the room that owns the keys. */
#include "run/run.h"
#include "scene/reader.h"

const Completions SceneCompletions = {.material = CompleteMaterial,
                                      .joint = CompleteJoint,
                                      .motion = CompleteMotion,
                                      .support = CompleteSupport,
                                      .load = {[LOAD_UPLIFT] = CompleteUplift,
                                               [LOAD_DRAIN] = CompleteDrain,
                                               [LOAD_CURTAIN] = CompleteCurtain,
                                               [LOAD_PSEUDO_STATIC] = CompletePseudoStatic,
                                               [LOAD_TEMPERATURE] = CompleteTemperature,
                                               [LOAD_SILT] = CompleteSilt,
                                               [LOAD_OVERFLOW] = CompleteOverflow,
                                               [LOAD_TAILWATER] = CompleteTailwater,
                                               [LOAD_WAVE] = CompleteWave},
                                      .any_stage = CompleteStage,
                                      .stage = {[STAGE_DYNAMIC] = CompleteDamping,
                                                [STAGE_STRENGTH_REDUCTION] = CompleteReduction,
                                                [STAGE_FLOOD] = CompleteFlood,
                                                [STAGE_TRANSIENT] = CompleteTransient,
                                                [STAGE_LOAD_FACTOR] = CompleteLoadFactor,
                                                [STAGE_ANCHOR_FORCE] = CompleteAnchorForce,
                                                [STAGE_PUSHOVER] = CompletePushover},
                                      .term = {[SECTION_ANCHORS] = CompleteAnchors}};
