"""Finds the load combination of a guideline (guidelines.yaml) to which a case belongs, by its loads and its condition, and the combinations without a case.

    rows, missing = combinations.of_cases(case)     case: assessment.Case, with a guideline in its options
    wanting = combinations.wanting(case)            the missing ones that concern the dam
"""

import functools
import re

from quoin_tools.assess import guidelines
from quoin_tools.assess.surface import WATERS
from quoin_tools.base.language import _

WORDS = {"self_weight": (), "reservoir": ("water",), "overflow": ("water", "overflow"), "head": ("uplift",), "tailwater": ("tailwater",), "uplift": ("uplift",), "silt": ("silt",),
         "ice": ("ice",), "wave": ("wave",), "pseudo_static": ("earthquake",), "added_mass": ("earthquake",), "temperature": ("temperature",)}  # fmt: skip


def words_of(case, stage, condition):
    """Returns the kinds of the loads at the end of a stage, in the words of guidelines.yaml."""
    loads = case.scene.stage_loads(stage).values()
    found = {word for load in loads for word in WORDS.get(load.get("type"), ())}
    if any(load.get("tailwater") is not None for load in loads) or len({load.get("faces") for load in loads if load.get("type") in WATERS}) > 1:
        found.add("tailwater")
    if any((load.get("type") == "uplift" and load.get("drain") is not None) or (load.get("type") == "drain" and load.get("conductance") != 0) for load in loads):
        found.add("drains")
    if case.options.uplift and "water" in found:  # by the rule of the options, which the gravity method takes
        found |= {"uplift", "drains"} if case.options.drain is not None else {"uplift"}
    before = [name for name in case.scene.stages_before(stage) if {"earthquake"} & {word for load in case.scene.stage_loads(name).values() for word in WORDS.get(load.get("type"), ())}
              or case.scene.stages[name].get("type") == "dynamic"]  # fmt: skip
    if case.scene.stages[stage].get("type") == "dynamic":
        found.add("earthquake")
    if "earthquake" in found or before or condition in ("earthquake", "after_earthquake"):
        found.add("shaken")
    return found | ({"reversed"} if is_reversed(case, stage) else set())


def is_reversed(case, stage):
    """Tells whether the earthquake of a stage at rest pushes the dam against its water."""
    if not any(load.get("type") == "pseudo_static" for load in case.scene.stage_loads(stage).values()):
        return False
    forces, _ = case.forces(stage)
    pushes = [sum(forces[name][0] for name, load in case.scene.stage_loads(stage).items() if load.get("type") in kinds and name in forces) for kinds in (WATERS, ("pseudo_static",))]
    return pushes[0] * pushes[1] < 0


def belongs(combination, condition, words):
    return condition in combination["conditions"] and set(combination.get("with", ())) <= words and not set(combination.get("without", ())) & words


def closest(combinations, condition, words):
    """Returns the combinations to which a case belongs; of a general and a special one the special."""
    found = [one for one in combinations if belongs(one, condition, words)]
    most = max((len(one.get("with", ())) for one in found), default=0)
    return [one for one in found if len(one.get("with", ())) == most]


def none_belongs(case, stage, condition):
    """Tells whether the guideline has combinations, but none for this stage and condition."""
    known = guidelines.of(case.options).get("combinations") or []
    return bool(known) and stage in case.scene.stages and not closest(known, condition, words_of(case, stage, condition))


def excluded(case, stage, condition):
    """Returns the words of loads of a case that exclude each other: what the combination forbids that has most of its loads; empty where one belongs."""
    known = [one for one in guidelines.of(case.options).get("combinations") or () if condition in one["conditions"]] if stage in case.scene.stages else []
    words = words_of(case, stage, condition) if known else set()
    forbidden = [(-len(one.get("with", ())), sorted(set(one.get("without", ())) & words)) for one in known if set(one.get("with", ())) <= words]
    return min(forbidden, key=lambda row: (len(row[1]) > 0, row[0], len(row[1])), default=(0, []))[1]


def of_cases(case):
    """Returns (stage, condition, its combinations, words of loads that they ask for and it lacks) of each judged case, and the combinations without a case; None where the file has none.
    An earthquake that pushes the dam against its water belongs to a combination with water, but is not the case that it asks for."""
    known = (guidelines.of(case.options) or {}).get("combinations")
    if not known:
        return None, None
    rows, used = [], set()
    for stage, condition in case.conditions.items():
        if stage in case.scene.stages:
            words = words_of(case, stage, condition)
            mine = closest(known, condition, words)
            rows.append((stage, condition, mine, sorted({word for one in mine for word in one.get("asks", ())} - words)))
            used |= {one["name"] for one in mine if not ("reversed" in words and "water" in one.get("with", ()))}
    return rows, [one for one in known if one["name"] not in used]


def wanting(case):
    """Returns the combinations without a case of which the options do not say why they do not concern the dam: a sheet without them is not complete."""
    return [one for one in of_cases(case)[1] or () if one["name"] not in case.options.no_case]


def check(case):
    """Refuses to leave out a combination that has a case."""
    missing = {one["name"] for one in of_cases(case)[1] or ()} if case.options.no_case else set()
    for name in case.options.no_case:
        if name not in missing:
            raise guidelines.GuidelineError(f"--no-case: '{name}' has a case in this run")


NAMES = ((r"(after|post)_?(the_)?(earth)?quake|post_?seism|pos_?sism", ("after_earthquake",)), (r"pmf|probable_max|extreme|catastroph", ("extreme", "unusual")), (r"flood|unusual|clogged|cheia", ("unusual",)))


def by_name(case, stage):
    """The condition that the name of a stage says, where the guideline has limits for it and no load says more; else usual."""
    for pattern, conditions in NAMES:
        if re.search(pattern, stage.lower().replace("-", "_")):
            known = guidelines.of(case.options) or {}
            allowed = [condition for condition in conditions if not known or (condition in known["conditions"] and not none_belongs(case, stage, condition))]
            return next(iter(allowed), conditions[0])
    return "usual"


def taken_from_names(case):
    """Returns the judged stages whose condition follows from their name: stage to condition."""
    if case.options.conditions:
        return {}
    return {stage: condition for stage, condition in case.conditions.items() if condition != "usual" and not case.scene.condition(stage) and condition == by_name(case, stage) and any(re.search(pattern, stage.lower().replace("-", "_")) for pattern, _ in NAMES)}


def judged_as(case):
    """Stage to its condition, with the names of its combinations; in words."""
    rows, missing = of_cases(case)
    said = {stage: _(condition) for stage, condition in case.conditions.items()}
    return said | {stage: f"{_(condition)}: {either(one['name'] for one in mine)}" for stage, condition, mine, lacks in rows or () if mine}


def either(names):
    """Says texts of the guideline with "or" between them."""
    return functools.reduce(lambda one, other: _("{0} or {1}", one, other), map(_, names))
