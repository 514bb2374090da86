"""Checks of a scene what the solver does not look at: the items of what_if, and its uplift against what a guideline asks for.

    lines, wrong = scene_check.look(scene, keys, guideline, file)      lines to print; wrong: the sheet could not do what the scene asks
"""

import os

import yaml

from quoin_tools.base import scene as scenes
from quoin_tools.base import solver


def look(path, keys, guideline=None, file=None):
    """(lines, whether one is an error) about a scene that the solver has found right. keys: words of the command line for the solver; guideline: its name; file: of the user, with guidelines."""
    with open(path, encoding="utf-8") as text:
        has_items = scenes_has_items(text.read())
    if not has_items and not guideline:
        return [], False
    used, beside, items = scenes.parse(solver.settled(path, keys), path), os.path.dirname(path) or ".", []
    if has_items:
        from quoin_tools.ensemble import what_if

        items = [f"{path}: {line}" for line in what_if.complaints(used, scenes.find(beside, used.model) or used.model)]
    file = file or (scenes.find(beside, used.guidelines) if used.guidelines else None)
    return items + (against(used, path, guideline, file) if guideline else []), bool(items)


def scenes_has_items(text):
    """Tells whether the text of a scene has a section what_if."""
    try:
        return "what_if" in (yaml.load(text, scenes.Loader) or {})  # noqa: S506 (a SafeLoader)
    except yaml.YAMLError:
        return "what_if:" in text


def against(used, path, name, file):
    """Lines about uplift loads of a scene that do another thing than a guideline asks for."""
    from quoin_tools.assess import guidelines, uplift

    known = guidelines.read(file)
    if name not in known:
        raise guidelines.GuidelineError(f"--guideline: no guideline '{name}', there are: {', '.join(known)}")
    guideline, lines = known[name], []
    at_rest, entry, _none = guidelines.in_crack(guideline, "at_rest", {})
    shaken, in_quake, _none = guidelines.in_crack(guideline, "earthquake", {})
    quakes = {one for stage in used.stages for one in used.stage_loads(stage) if any(load.get("type") == "pseudo_static" for load in used.stage_loads(stage).values())}
    for load, keys in used.loads.items():
        if keys.get("type") != "uplift":
            continue
        follows = keys.get("cracked") in (True, 1)
        mine = keys.get("in_earthquake", "rule") if follows else "unchanged"
        mine = uplift.rule_named(keys["rule"]).shaken if mine == "rule" else mine
        wanted = [("rule", keys["rule"], guideline.get("uplift") if keys.get("drain") is not None else None, None),
                  ("cracked", "full" if follows else "unchanged", at_rest, entry), ("in_earthquake", mine, shaken if load in quakes else None, in_quake)]  # fmt: skip
        lines += [f"{path}: loads.{load}.{key}: {has}; guideline {name} asks for {asked}" + (f" ({guidelines.source_of(where)})" if where else "")
                  for key, has, asked, where in wanted if isinstance(asked, str) and asked != has]  # fmt: skip
        if (drains := (entry or {}).get("drains", "past")) != "past" and keys.get("drain") is not None:
            lines.append(f"{path}: loads.{load}: a run loses a drain once the crack has passed it; guideline {name} asks for {drains} ({guidelines.source_of(entry)})")
    return lines
