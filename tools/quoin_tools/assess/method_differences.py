"""Explains why block model and gravity method differ: brittle joints, above all.

    for note in notes(case, stage, found): ...      nothing where they agree to a tenth
"""

import functools
import math

from quoin_tools.assess.strength import factors
from quoin_tools.base import joints
from quoin_tools.base.language import N_, _
from quoin_tools.base.results import NO_SHEAR, trials_of

ALIKE = 0.1  # relative: factors that differ by more are explained
BRINK = ("strength_reduction", "load_factor", "flood")  # stages whose last stable trial is at the brink: the run's factor is 1 there


def losses(strength):
    """Names the strengths that the joints of a base lose where they fail; empty where they keep their strength."""
    rows = [own for _, _, own in strength.get("spans") or [(0, 0, strength)]]
    found = []
    for key, words, factor in (("cohesion", N_("cohesion falls from {0:g} to {1:g} kPa"), 1e-3), ("friction", N_("friction falls from {0:g} to {1:g} degrees"), 1.0),
                               ("tension", N_("tensile strength falls from {0:g} to {1:g} kPa"), 1e-3)):  # fmt: skip
        pairs = {(float(own[key]), float(own[f"{key}_residual"])) for own in rows if own.get(key) is not None and own.get(f"{key}_residual") is not None}
        worst = max(pairs, key=lambda pair: pair[0] - pair[1], default=(0.0, 0.0))
        if worst[0] > worst[1] * (1 + 1e-9):
            found.append(_(words, factor * worst[0], factor * worst[1]))
    return found


LOCKED = N_("The run is the higher one: what locks the base, a key or a step, bears in it, while the gravity method takes it as sheared, and the run may give way elsewhere. "
            "Limits are held against the lesser number.")  # fmt: skip


def why(found, ran, own):
    """Words. ran, own: the numbers of the run and of the gravity method."""
    if found.base.path is not None and ran > own:
        return _(LOCKED)
    lost = losses(found.strength)
    if not lost or ran > own:  # joints that break make the run the lower one
        return _("It is not that joints break: other ways to the ground, the stiffness of the blocks or loads that follow the motion make the difference.")
    if any(joints.softens(own) for _, _, own in found.strength.get("spans") or [(0, 0, found.strength)]):
        return _("Its joints soften: where their strength is passed, {0} along a slope, so a failure can run along the joint from where it is stressed most, while the gravity method takes the "
                 "peak strength of the whole length at once.", functools.reduce(lambda one, other: _("{0} and {1}", one, other), lost))  # fmt: skip
    return _("Its joints are brittle: where they fail, {0} at once, so a failure can run along the joint from where it is stressed most, while the gravity method takes the peak strength "
             "of the whole length at once. Residual strengths (cohesion_residual, friction_residual) say what is left.", functools.reduce(lambda one, other: _("{0} and {1}", one, other), lost))  # fmt: skip


def apart(one, other):
    """Tells whether two factors differ by more than a tenth."""
    return all(x is not None and math.isfinite(x) and x <= NO_SHEAR for x in (one, other)) and abs(one - other) > ALIKE * min(abs(one), abs(other))


def notes(case, stage, found):
    """Sentences about a base in a stage."""
    own, facts = factors(found.hand, found.strength)["peak"], case.results.stage_summary(stage)
    sentences = []
    if found.block and apart(found.block.get("peak"), own):
        sentences.append(_("The sliding factor of the block model, {0:.2f}, and that of the gravity method, {1:.2f}, differ by more than a tenth.", found.block["peak"], own) + " " + why(found, found.block["peak"], own))
    for name, which, value, _how, ran in found.yields:
        if ran and value is not None and not found.with_uplift and apart(abs(ran[0] or 0.0) or None, abs(value)):
            sentences.append(_("The yield coefficient {0} of {1} is {2:.3f} in the run and {3:.3f} by the gravity method: they differ by more than a tenth.", which, name, abs(ran[0]), abs(value)) + " " + why(found, abs(ran[0]), abs(value)))
    slides = [name for name, motion in (facts.get("mechanism") or {}).items() if "slides" in str(motion.get("moves"))]
    if case.scene.stages.get(stage, {}).get("type") in BRINK and trials_of(facts) and trials_of(facts).get("failing") is not None and set(slides) & set(found.name.split("+")) and apart(own, 1.0):
        sentences.append(_("At the brink of the run the gravity method still has a sliding factor of {0:.2f}, where it would be 1 if both agreed.", own) + " " + why(found, 1.0, own))
    return sentences
