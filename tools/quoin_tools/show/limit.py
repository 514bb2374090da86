"""Prints limit analysis of a scene, or of the scene of a run beside its trials.

    quoin limit scene.yaml [--stage flood] [--raises water] [--picture limit.png] [-key value ...]
    quoin limit out/                                         beside the brackets of the run
    quoin limit scene.yaml --both                            where blocks stand and fail whose joints slide without dilation

For each stage of trials: the largest factor or level, or the least strength, at which rigid blocks with friction, cohesion and tension find
equilibrium, by a linear programme (Clarabel, HiGHS). An upper bound: joints that slide may open by tan(phi) there, blocks that really slide do not.
docs/limit_analysis.md says what the number means. Options that it does not know are keys of the scene. Exit code 0; 6: a run stands beyond the bound, so one of both is wrong; 2: it cannot be done; 130: stopped by Ctrl-C or SIGTERM, with one line that has the bracket so far."""

import argparse
import contextlib
import math
import os
import signal
import sys
import threading

from quoin_tools.base import scene as scenes
from quoin_tools.base import sheet_units, solver
from quoin_tools.base.command import Parser
from quoin_tools.base.language import N_, _, numeral
from quoin_tools.base.results import Results, trials_of
from quoin_tools.base.terminal import table
from quoin_tools.limit import LimitError, bounds, water
from quoin_tools.limit.both import both
from quoin_tools.mesh.of_run import mesh_of, mesh_of_scene
from quoin_tools.show import limit_both

TRIALS = ("load_factor", "flood", "strength_reduction")
JOINT_SECONDS = 0.1  # processor time without dilation: three paths and three to five runs of walls of 80 to 140 joints, 0.05 to 0.11
HOLDS = 1e-8  # smaller errors are not told apart
CONTRADICTION, STOPPED = 6, 130  # exit codes


class Withdrawn(argparse.Action):
    def __call__(self, parser, *_):
        parser.exit(2, f"{parser.prog}: --sliding is withdrawn: its estimate without dilation was 2 to 25 % above what blocks bear; --both says what stands and what fails\n")


def main(arguments=None):
    parser = Parser(prog="quoin limit", description="Limit analysis: what rigid blocks can bear at most.",
                    epilog="quoin limit --hinges SCENE: how the limits of a run move with the stiffness of its joints; quoin limit --hinges -h.")  # fmt: skip
    parser.add_argument("path", metavar="SCENE or FOLDER", help="a scene, or the folder of a run")
    parser.add_argument("--stage", action="append", help="stages (all of trials; where there are none, all static ones)")
    parser.add_argument("--raises", action="append", metavar="LOAD", help="loads that are multiplied (as the stage says; of a static stage all but weight)")
    parser.add_argument("--both", action="store_true", help="beside the bound, where blocks stand and where they fail without dilation; runs the scene three times or more")
    parser.add_argument("--sliding", action=Withdrawn, nargs=0, help=argparse.SUPPRESS)
    parser.add_argument("--picture", metavar="FILE", help="draws mechanism and line of thrust (of several stages: FILE_<stage>)")
    given, options = parser.parse_known_args(arguments)
    if given.both and (given.raises or os.path.isdir(given.path)):
        parser.error("--both runs the scene as it is: it takes a scene, no folder of a run, and no --raises")
    mesh, scene, results = inputs(given.path, options)
    answers, found, asked, ends = [], {}, {}, []
    try:
        with interruptible():
            for stage in given.stage or stages_of(scene):
                answers.append(bounds.bound(mesh, scene, stage, given.raises, water=water.of_run(results, stage) if results else None, asked=asked, watch=say))
                found[stage] = trials_of(results.stage_summary(stage)) if results and not given.raises and stage in results.stages else None
                if given.both:
                    expected = JOINT_SECONDS * len(answers[-1].parts.contacts)
                    if expected > bounds.LONG:
                        say(f"{stage}: the bound is {value_words(answers[-1].value, answers[-1].unit)}; {len(answers[-1].parts.contacts)} joints without dilation, about {bounds.rounded(expected)}")
                    ends.append(both(mesh, scene, answers[-1]))
    except KeyboardInterrupt as end:
        print("\n".join(text_of(answers, found) if answers else []), end="\n" if answers else "")
        say(f"{stage}: {str(end) or 'stopped'}")
        return STOPPED
    print("\n".join(text_of(answers, found) + limit_both.text_of(ends)))
    if given.picture:
        from quoin_tools.show.limit_picture import draw  # here: matplotlib is slow to load

        for answer in answers:
            path = given.picture if len(answers) == 1 else "{0}_{2}{1}".format(*os.path.splitext(given.picture), answer.stage)
            print(f"wrote {draw(answer, path, *words(answer))}" if answer.limit and answer.limit.normal is not None else f"stage {answer.stage}: nothing to draw")
    return CONTRADICTION if any(against(answer, found[answer.stage]) for answer in answers) else 0


def say(sentence):
    print(f"quoin limit: {sentence}", file=sys.stderr, flush=True)


@contextlib.contextmanager
def interruptible():
    """Lets SIGTERM stop a search as Ctrl-C does."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def inputs(path, options=()):
    """Returns (mesh, scene, results or None) of a scene file, with options of the solver, or of the folder of a run."""
    if os.path.isdir(path):
        if options:
            raise LimitError(f"{' '.join(options)}: a run is what it is; options are for scenes")
        results = Results(path)
        scene = scenes.of_run(path, results.summary)
        return mesh_of(results, scene)[0], scene, results
    scene = scenes.parse(solver.settled(path, options), path)
    return mesh_of_scene(scene)[0], scene, None


def stages_of(scene, trials=TRIALS):
    kinds = {name: keys.get("type", "static") for name, keys in scene.stages.items()}
    found = [name for name, kind in kinds.items() if kind in trials] or [name for name, kind in kinds.items() if kind == "static"]
    if not found:
        raise LimitError("the scene has neither a stage of trials (load_factor, flood, strength_reduction) nor a static one")
    return found


# ---- words -------------------------------------------------------------------------------------------------

WHAT = {"load_factor": N_("loads times"), "flood": N_("level"), "strength_reduction": N_("strength")}


def value_words(value, unit):
    if value is None:
        return _("stands at none")
    if math.isinf(value):
        return _("none")
    return _("{0:.6g} degree", value) if unit == "degree" else numeral(f"{value:.6g}") if unit == "-" else sheet_units.said(numeral(f"{value:.6g}"), unit)


def words(answer):
    """What is raised or reduced, and its limit."""
    return _(WHAT[answer.kind]), value_words(answer.value, answer.unit)


def against(answer, trials):
    """Tells whether the run stands beyond the bound."""
    return bool(trials) and bounds.contradicts(answer, bounds.stood(trials)[0])


def rows_of(answers, found):
    """stage, what, bound, run stands, run fails, verdict"""
    rows = []
    for answer in answers:
        trials = found.get(answer.stage)
        stood, failed = bounds.stood(trials) if trials else (None, None)
        side = _("not below") if answer.kind == "strength_reduction" else _("not above")
        rows.append((answer.stage, _(WHAT[answer.kind]) + (f" ({', '.join(answer.raised)})" if answer.raised else ""), side, value_words(answer.value, answer.unit),
                     "-" if stood is None else value_words(stood, answer.unit), "-" if failed is None else value_words(failed, answer.unit),
                     "-" if not trials else _("BEYOND THE BOUND") if against(answer, trials) else _("inside")))  # fmt: skip
    return rows


HEADER = (N_("stage"), N_("what"), N_("can stand"), N_("limit analysis"), N_("run stands"), N_("run fails"), N_("run"))


def text_of(answers, found):
    return table(map(_, HEADER), rows_of(answers, found)) + [f"  {line}" for answer in answers for line in (*remarks(answer, found), *certificate(answer))]


def certificate(answer):
    """Lists in a sentence the errors of the programmes."""
    limit = answer.limit
    if limit is None or limit.normal is None:
        return []
    worst = max(limit.residual, limit.dual_residual, limit.gap)
    return [f"{answer.stage}: checked: equilibrium, strengths, mechanism and the value of the dual hold to {max(worst, HOLDS):.0e} of the heaviest load."]


def remarks(answer, found):
    """Sentences about one stage."""
    sentences = [f"{answer.stage}: {note}" for note in answer.notes]
    if answer.value is not None and math.isinf(answer.value):
        sentences.append(_("{0}: no size of these loads moves the blocks, if joints that slide may open: sliding is confined.", answer.stage))
    if against(answer, found.get(answer.stage)):
        sentences.append(_("{0}: the run stands where no forces within the strengths are in equilibrium: geometry that has moved (large strain), or a fault. Trust neither before you know why.", answer.stage))
    return sentences
