"""Writes the part of the sheet about limit analysis: a bound beside the trials of the run, and its meaning in a plain sentence."""

import os

from quoin_tools.base.language import N_, _
from quoin_tools.base.results import ResultsError, trials_of
from quoin_tools.base.scene import SceneError
from quoin_tools.limit import LimitError, bounds, water
from quoin_tools.mesh.blockmesh import MeshError
from quoin_tools.show import limit, limit_picture
from quoin_tools.show.hypertext import esc, file_picture, head, soft, table

LARGEST = 3000  # contacts: more take longer than a sheet should
MEANING = N_("A linear programme looks for forces in equilibrium within the strengths of the joints, for rigid blocks in the undeformed geometry. No structure of such blocks can bear more, so a run that stands "
           "beyond the bound is wrong. The bound is no safe value: in it joints that slide also open, by tan(phi), which real ones hardly do; where sliding is confined it can be well above what the blocks bear.")


def bound_of(case, stage):
    """Returns the bound of a stage of trials, or the reason why there is none; found once for a sheet."""
    if stage not in case.bounds:
        asked = case.bounds.setdefault("", {})
        try:
            case.bounds[stage] = bounds.bound(case.mesh, case.scene, stage, largest=LARGEST, water=water.of_run(case.results, stage), asked=asked)
        except (LimitError, SceneError, MeshError, ResultsError) as error:
            case.bounds[stage] = str(error)
    return case.bounds[stage]


def limit_level(case, stage):
    """Returns the level or factor [m, -] of the bound of a stage of trials, with water in the crack where that is known; None without a bound."""
    bound = bound_of(case, stage)
    return None if isinstance(bound, str) else bound.value if bound.cracked is None else bound.cracked


def limit_part(case):
    stages = [s["name"] for s in case.results.summary["stages"] if trials_of(s)]
    if not stages:
        return ""
    answers, found, refused, pictures = [], {}, [], []
    for stage in stages:
        answer = bound_of(case, stage)
        if isinstance(answer, str):
            refused.append(_("Stage {0}: {1}.", stage, answer))
            continue
        answers.append(answer)
        found[stage] = trials_of(case.results.stage_summary(stage))
        if answer.limit and answer.limit.normal is not None:
            pictures.append(limit_picture.draw(answer, os.path.join(case.results.folder, f"limit_{stage}.png"), *limit.words(answer)))
    if not answers:
        return head(_("Upper bound by limit analysis")) + "".join(map(soft, refused))
    rows = limit.rows_of(answers, found)
    sentences = [line.strip() for answer in answers for line in limit.remarks(answer, found)] + refused
    return (head(_("Upper bound by limit analysis")) + table(map(_, limit.HEADER), rows, range(3, 6)) + f"<p>{esc(_(MEANING))}</p>"
            + "".join(map(soft, sentences)) + "".join(file_picture(path, _("Limit analysis of stage {0}", os.path.basename(path)[6:-4])) for path in pictures))  # fmt: skip
