"""Checks the names of bases in the options of the assessment: a name that no base has is refused.

    base_names.check(case)     UnknownBaseError with the names there are
"""

from quoin_tools.assess import sliding_paths
from quoin_tools.assess.strength import row_of, rows_of

LIFTS = "lifts"  # --strength-on: all level sections


class UnknownBaseError(ValueError):
    """A name on the command line that no base has, in one line."""


def joints_of(case):
    """Returns the facts of the joints of a run by name, each from the first stage in which the joint is a line."""
    found = {}
    for stage in case.results.summary["stages"]:
        for name, facts in stage["joints"].items():
            if name not in found or (facts["line"] and not found[name]["line"]):
                found[name] = facts
    return found


def bases_of(case):
    """Names of joints that are lines, alone or with those in one line with them, and of the paths of the options."""
    lines = {name: facts for name, facts in joints_of(case).items() if facts["line"]}
    rows = rows_of(lines, case.options.merged)
    together = [row_of(names[0], lines) for names in rows if len(names) == 1]
    return list(dict.fromkeys("+".join(names) for names in rows + together)) + list(case.options.paths)


def ways_of(case):
    """Names of the ways through joints that are no base by themselves."""
    stages = [stage for stage in case.results.stages if case.scene.stages.get(stage, {}).get("type") != "modes"]
    return list(dict.fromkeys(way.name for stage in stages for name in case.results.stage_summary(stage)["joints"] for way in sliding_paths.through(case, stage, name)))


def check(case):
    """Refuses a name of --strength-on, --uplift-on or --plane that no base has, and a path with the name of a joint."""
    o = case.options
    for name in o.paths:
        if name in joints_of(case) or name == LIFTS:
            raise UnknownBaseError(f"--path: {name} is the name of {'all level sections' if name == LIFTS else 'a joint'} already")
    given = [("--strength-on", name) for name in o.strengths] + [("--uplift-on", name) for name in o.uplift_on] + [("--plane", name) for name in o.planes]
    known = bases_of(case) if given else []
    if any(name not in allowed(option, known) for option, name in given):
        known += [name for name in ways_of(case) if name not in known]
    for option, name in given:
        there = allowed(option, known)
        if name not in there:
            raise UnknownBaseError(f"{option}: no base '{name}', there are: {', '.join(there)}")


def check_used(case, found):
    """Refuses a name of --strength-on, --uplift-on or --plane whose base has no numbers: a joint that is only part of a base has none of its own."""
    o, there = case.options, list(dict.fromkeys(a.name for a in found))
    for option, names in (("--strength-on", o.strengths), ("--uplift-on", o.uplift_on), ("--plane", o.planes)):
        for name in names:
            if name not in there and name not in o.paths and not (option == "--strength-on" and name == LIFTS):
                raise UnknownBaseError(f"{option}: {name} is no base by itself, so it would change nothing; bases are: {', '.join(there)}")


def allowed(option, bases):
    return [*bases, LIFTS] if option == "--strength-on" else bases
