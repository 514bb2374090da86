"""Writes the result of an ensemble: one table of its samples (HDF5), its probabilities (JSON), and pictures."""

import contextlib
import json
import os
from dataclasses import asdict

import h5py
import numpy as np
from matplotlib import pyplot

import quoin_tools
from quoin_tools.base.files import write_file, writing
from quoin_tools.ensemble import analysis
from quoin_tools.ensemble.journal import OUTCOMES
from quoin_tools.show.style import GREY, LINES, STYLE, save

UNITS = "[SI; angles in degrees]"  # as keys of a scene
BEFORE_AFTER = "before_after.png"
MOST_CURVES, DASHES = 6, ("--", ":", "-.")  # of the values of choices


def write(design, rows, found, curve, choices, folder):
    """Returns the paths of samples.h5, ensemble.json and pictures. A picture of an earlier posterior beside them goes: this answer has none."""
    with contextlib.suppress(FileNotFoundError):
        os.remove(os.path.join(folder, BEFORE_AFTER))
    kept = [rows[key] for key in sorted(rows, key=lambda key: (key[0], key[1] is not None, key[1] or 0.0))]
    written = [write_samples(design, kept, os.path.join(folder, "samples.h5")), os.path.join(folder, "ensemble.json")]
    answer = {"ensemble": design.mark, "scene": design.scene, "method": design.method, "seed": design.seed, "samples": analysis.counted(design, rows), "judge": design.judge, "stage": design.stage,
            "fail": design.condition.words() if design.condition else "collapsed", "variables": design.words(), "level_keys": design.level_keys,
            "probabilities": [asdict(p) | {"words": analysis.words(p)} for p in found], "fragility": curve and asdict(curve),
            "choices": choices, "danger": danger_of(design, rows), "posterior": design.drawn and design.drawn.path,
            "influence": [] if design.method == "sobol_indices" else analysis.influence(design, rows)}  # fmt: skip
    write_file(written[1], json.dumps(answer, indent=1, default=str) + "\n")
    with pyplot.rc_context(STYLE):
        if design.level_keys and found:
            written.append(fragility_picture(design, found, curve, choices, os.path.join(folder, "fragility.png")))
        if len(design.columns()) > 1 and kept:
            written.append(scatter_picture(design, kept, os.path.join(folder, "samples.png")))
    return written


def danger_of(design, rows):
    """Returns the danger level as ensemble.json has it."""
    found = analysis.danger(design, rows)
    return found and asdict(found) | {"words": found.words()}


def write_after(design, folder, before):
    """Adds the result after the readings (a folder) to the ensemble.json of the one before them. Returns the path of a picture of both, None where no probability has a level."""
    path, other = (os.path.join(one, "ensemble.json") for one in (before, folder))
    with open(path, encoding="utf-8") as first, open(other, encoding="utf-8") as second:
        found, after = json.load(first), json.load(second)
    write_file(path, json.dumps(found | {"after": {key: after[key] for key in ("posterior", "probabilities", "danger")} | {"variables": design.drawn.variables, "unused": design.drawn.unused, "warnings": design.drawn.warnings}}, indent=1) + "\n")
    if not design.level_keys or not found["probabilities"]:
        return None
    with pyplot.rc_context(STYLE):
        return before_after_picture(design, {"before the readings": found, "after": after}, os.path.join(before, BEFORE_AFTER))


def label_of(level_keys):
    """Returns the label of the axis of levels: those of loads in metres, other keys as the scene has them."""
    loads = [load for section, load, key in (path.split(".") for path in level_keys if path.count(".") == 2) if (section, key) == ("loads", "level")]
    return f"level of {', '.join(loads)} [m]" if len(loads) == len(level_keys) else f"{', '.join(level_keys)} {UNITS}"


def before_after_picture(design, answers, path):
    """Probability of failure over the level, before and after the readings, with 95 % intervals; the median danger level of each as a line. answers: {label: ensemble.json}."""
    figure, axes = pyplot.subplots(figsize=(7, 4.6))
    for (label, answer), colour, shift in zip(answers.items(), (GREY, LINES[0]), (-0.004, 0.004), strict=True):
        level, value, low, high = (np.array([one[key] for one in answer["probabilities"]], dtype=float) for key in ("level", "value", "low", "high"))
        reach = [np.maximum(value - low, 0), np.maximum(high - value, 0)]
        axes.errorbar(level + shift * np.ptp(level), value, yerr=reach, fmt="o-", color=colour, capsize=3, linewidth=1, label=label)
        danger = answer["danger"]
        if danger and danger["median"] is not None:
            axes.axvline(danger["median"], color=colour, linestyle="--", linewidth=1, label=f"danger level, {label}: {danger['median']:.1f}")
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel(label_of(design.level_keys))
    axes.set_ylabel("probability of failure [-]")
    axes.legend(loc="upper left", fontsize=8)
    save(figure, path)
    return path


def write_samples(design, kept, path):
    """One dataset a column; undecided and missing numbers are NaN."""
    with writing(path) as file:
        file.attrs.update({"format": "quoin-ensemble", "version": 1, "ensemble": design.mark, "quoin": quoin_tools.__version__, "seed": design.seed, "method": design.method})
        file["sample"] = np.array([r.sample for r in kept], dtype=np.int64)
        file["level"] = np.array([np.nan if r.level is None else r.level for r in kept], dtype=float)
        file["weight"] = np.array([r.weight for r in kept], dtype=float)
        file["outcome"] = np.array([OUTCOMES.index(r.outcome) for r in kept], dtype=np.int32)
        file["outcome"].attrs["meaning"] = ", ".join(f"{k} {name}" for k, name in enumerate(OUTCOMES))
        file["response"] = np.array([np.nan if r.response is None else r.response for r in kept], dtype=float)
        file["response"].attrs["what"] = design.response or ""
        file["seconds"] = np.array([r.seconds for r in kept], dtype=float)
        for k, one in enumerate(design.variables.each):
            file[f"variables/{one.name}"] = np.array([r.values[k] for r in kept], dtype=h5py.string_dtype() if one.has_words() else float)
            file[f"variables/{one.name}"].attrs["distribution"] = one.words()
    return path


def fragility_picture(design, found, curve, choices, path):
    figure, axes = pyplot.subplots(figsize=(7, 4.6))
    levels, value = np.array([p.level for p in found]), np.array([p.value for p in found])
    low, high = np.array([p.low for p in found]), np.array([p.high for p in found])
    axes.errorbar(levels, value, yerr=[np.maximum(value - low, 0), np.maximum(high - value, 0)], fmt="o", color=LINES[0], capsize=3, label="samples, 95 % interval")
    if curve:
        at = np.linspace(levels.min(), levels.max(), 200)
        axes.plot(at, curve.at(at), color=LINES[1], label=f"lognormal: median {curve.median:.4g}, spread {curve.spread:.3g}")
    values = list(dict.fromkeys((c["variable"], c["choice"]) for c in choices))
    for k, (name, value) in enumerate(values if len(values) <= MOST_CURVES else ()):
        mine = [c for c in choices if (c["variable"], c["choice"]) == (name, value)]
        axes.plot([c["level"] for c in mine], [c["value"] for c in mine], linestyle=DASHES[k % len(DASHES)], linewidth=0.9, color=GREY, label=f"{name.split('.')[-1]} {os.path.basename(str(value))}")
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel(label_of(design.level_keys))
    axes.set_ylabel("probability of failure [-]")
    axes.set_title(f"{found[0].n} common samples at each level")
    axes.legend(loc="upper left")
    save(figure, path)
    return path


def place(one, value):
    """Returns the place of a value along its axis: words stand in the order of their list."""
    return one.choices.index(value) if one.has_words() else value


def scatter_picture(design, kept, path):
    """The two variables that matter most, samples by outcome, at the last level."""
    mine = [r for r in kept if r.level == design.levels[-1]]
    names = design.columns()
    rank = {name: abs(value) for name, value, _ in analysis.influence(design, {r.key(): r for r in kept})} if design.method != "sobol_indices" else {}
    x, y = sorted(range(len(names)), key=lambda k: -rank.get(names[k], 0.0))[:2]
    figure, axes = pyplot.subplots(figsize=(6.4, 5))
    for outcome, colour, mark in (("stands", LINES[0], "o"), ("fails", LINES[1], "x"), ("undecided", GREY, "+")):
        at = np.array([[place(design.variables.each[k], r.values[k]) for k in (x, y)] for r in mine if r.outcome == outcome], dtype=float).reshape(-1, 2)
        if len(at):
            axes.plot(*at.T, mark, color=colour, markersize=4, alpha=0.7, linestyle="none", label=f"{outcome} ({len(at)})")
    for k, name_axis, ticks in ((x, axes.set_xlabel, axes.set_xticks), (y, axes.set_ylabel, axes.set_yticks)):
        words = design.variables.each[k].has_words()
        name_axis(names[k] if words else f"{names[k]} {UNITS}")
        if words:
            ticks(range(len(design.variables.each[k].choices)), [os.path.basename(value) for value in design.variables.each[k].choices])
    axes.legend(loc="best")
    axes.set_title("Samples" if design.levels[-1] is None else f"Samples at {', '.join(design.level_keys)} = {design.levels[-1]:g}")
    save(figure, path)
    return path
