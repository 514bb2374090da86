#!/usr/bin/env python3
"""How sure a probability of failure is against the time it took: ways to judge a sample beside ways to choose samples.

    PYTHONPATH=tools python tests/benchmark/probabilities.py --quoin build/quoin [--parts judges] [--samples 24]

A dam of 28 m by 46 m that slides on its base under water of 40 m (one in six fails) and 34 m (one in eight thousand), friction and cohesion lognormal: problem E01
of the case `ensembles`, whose probability is known by quadrature.

judges    What a sample costs [processor seconds, the child's own] and how many of --samples verdicts differ from the formula's: one rigid dam, or one of 322 or
          5152 deformable blocks by explicit cycles, by Newton's method, by Newton's method with the dam condensed; limit analysis; the formula itself, as a surrogate.
ways      How far the estimate of a set of samples scatters: Monte Carlo, Latin hypercube, Sobol sequences, importance sampling, from --repeats sets each by the formula,
          which gives each sample the verdict of the solver.

Both together: the scatter that a way and a judge reach in a second. Writes docs/data/probabilities.json, docs/img/probabilities.png and the tables of docs/generated/benchmarks.md."""

import argparse
import contextlib
import io
import json
import math
import os
import sys
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from types import SimpleNamespace

import matplotlib

matplotlib.use("Agg")
import numpy as np
import yaml
from matplotlib import pyplot

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tests" / "verification" / "ensembles"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark")]

from case import BY_LIMIT, ROWS, WEIGHT, exact, factor, folder_of  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.ensemble import design, models, running  # noqa: E402
from quoin_tools.ensemble.importance import design_point  # noqa: E402
from quoin_tools.ensemble.sampling import Sampler  # noqa: E402
from quoin_tools.ensemble.variables import variables  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402
from record import DATA, keep, replace_between, table  # noqa: E402

LEVELS = (40, 34)  # [m]
COLUMNS, ROWS_UP, LOADED = 14, 23, 2  # blocks of the deformable dam; columns at its crest that carry its weight
ELASTIC = {"young": 20e9, "poisson": 0.2}
EXPLICIT, NEWTON = {"method": "explicit"}, {"method": "preconditioned"}
JUDGES = {  # times that the mesh of the deformable dam is refined, keys of its material, method; None: not the solver
    "solver, rigid dam, explicit": (0, {}, EXPLICIT),
    "solver, 322 blocks, explicit": (1, {}, EXPLICIT),
    "solver, 5152 blocks, explicit": (4, {}, EXPLICIT),
    "solver, 5152 blocks, Newton": (4, {}, NEWTON),
    "solver, 5152 blocks condensed, Newton": (4, {"condensed": True}, NEWTON),
    "limit analysis": None,
    "formula": None,
}
WAYS = {"Monte Carlo": "monte_carlo", "Latin hypercube": "latin_hypercube", "Sobol": "sobol", "importance": "importance"}
POINT = 21  # samples that the design point asks for, about
GOAL = 0.1  # coefficient of variation that the tables ask for


def deformable(folder, finer, dam, relaxation):
    """The same dam of blocks that deform: its weight presses on the crest above the place where that of the rigid one does."""
    blocks = rectangle(0, 0, 28, 46, finer * COLUMNS, finer * ROWS_UP, group="dam")
    blocks = renamed(blocks, {"upstream": "left", "base": "bottom", "crest": "top"})
    blocks.face_sets["crest"] = blocks.face_sets["crest"][: finer * LOADED]
    write(str(folder / "model.h5"), join([renamed(rectangle(-20, -5, 80, 5, group="rock", rigid=True), {}), blocks]))
    scene = yaml.safe_load((folder / "scene.yaml").read_text())
    scene["materials"]["dam"] = {"density": 1e-3, **ELASTIC, **dam}
    scene["loads"]["mass"] = {"type": "traction", "faces": "crest", "value": [0, -WEIGHT / (LOADED * 28 / COLUMNS)]}
    if dam.get("condensed"):
        scene["strain"] = "small"
    scene["relaxation"] = relaxation
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")


class Formula:
    """The verdict by hand, in place of a model."""

    def __init__(self, level):
        self.level = level

    def judge(self, values, _sample, _level):
        number = float(factor(values, self.level))
        return ("fails" if number < 1 else "stands"), number, ""


class Place:
    """What folder_of asks of a case: a folder."""

    def __init__(self, folder):
        self.folder = Path(folder)


def judge_of(name, place):
    """(judge, design) of a way to judge."""
    limit = BY_LIMIT if name == "limit analysis" else {}
    folder = folder_of(place, name.replace(" ", "_").replace(",", ""), **limit)
    if JUDGES[name]:
        finer, dam, relaxation = JUDGES[name]
        if finer:
            deformable(folder, finer, dam, relaxation)
        else:
            scene = yaml.safe_load((folder / "scene.yaml").read_text()) | {"relaxation": relaxation}
            (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    wanted = design.read(str(folder / "ensemble.yaml"))
    return Formula(40) if name == "formula" else models.model_of(wanted, str(folder / "out")), wanted


def processor_seconds():
    return sum(use.ru_utime + use.ru_stime for use in (getrusage(RUSAGE_SELF), getrusage(RUSAGE_CHILDREN)))


def judges(samples):
    """Rows: what a sample costs by each judge, and verdicts that are not the formula's."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        place = Place(folder)
        for name in JUDGES:
            judge, wanted = judge_of(name, place)
            drawn = running.Samples(wanted)
            began, differ, undecided = processor_seconds(), 0, 0
            count = 100 * samples if name == "formula" else samples
            for index in range(count):
                values, _ = drawn.of(index)  # to draw it costs time, too: most of what the formula takes
                outcome = judge.judge(values, index, None)[0]
                undecided += outcome == "undecided"
                differ += outcome not in ("undecided", "fails" if factor(values, 40) < 1 else "stands")
            rows.append({"judge": name, "samples": count, "seconds": (processor_seconds() - began) / count, "differ": differ, "undecided": undecided})
            print(*rows[-1].values(), sep=", ", flush=True)
    return rows


def ways(repeats):
    """Rows: coefficient of variation of the estimate by one block of samples, at each level; of independent blocks it falls with the root of their number."""
    rows = []
    both = variables(ROWS, [])
    for level in LEVELS:
        p = exact(level)
        for way, method in WAYS.items():
            centre = design_point_of(both, level) if method == "importance" else None
            sampler = Sampler(method, both, 1, centre=centre)
            size = max(sampler.block, 1)
            normals = [sampler.normal(i) for i in range(size * repeats)]
            fails = factor(both.values(normals), level) < 1
            weights = np.array([sampler.weight(i) for i in range(size * repeats)]) if method == "importance" else 1.0
            blocks = (weights * fails).reshape(repeats, size).mean(axis=1)
            variation = math.sqrt((1 - p) / p) if method == "monte_carlo" else float(blocks.std(ddof=1)) / p
            rows.append({"level": level, "way": way, "block": size, "exact": p, "variation": variation, "mean": float(blocks.mean())})
            print(*rows[-1].values(), sep=", ", flush=True)
    return rows


def design_point_of(both, level):
    """Nearest failure in the space of independent normal numbers, by the rule that `quoin ensemble` has, with the formula as judge."""

    wanted = SimpleNamespace(columns=both.names, variables=both, levels=[None], condition=design.condition_of("limit < 1", "limit"))
    return design_point(wanted, Formula(level))[0]


def samples_for(way, variation):
    """Samples after which the estimate of a way scatters by `variation`; those of the design point among them."""
    n = way["block"] * max(1.0, (way["variation"] / variation) ** 2)
    return n + (POINT if way["way"] == "importance" else 0)


def draw(found, known, path):
    figure, panels = pyplot.subplots(1, len(LEVELS), figsize=(11, 4.6), sharey=True, constrained_layout=True)
    styles = {"Monte Carlo": "-", "Sobol": ":", "importance": "--"}
    for axes, level in zip(panels, LEVELS, strict=True):
        for number, judge in enumerate(found):
            for way in known:
                if way["level"] != level or way["way"] not in styles:
                    continue
                goals = np.geomspace(1.0, 0.01, 40)
                seconds = [judge["seconds"] * samples_for(way, goal) for goal in goals]
                axes.loglog(seconds, goals, styles[way["way"]], color=f"C{number}", lw=1.4, label=judge["judge"] if way["way"] == "Monte Carlo" else None)
        p = next(way["exact"] for way in known if way["level"] == level)
        axes.axhline(GOAL, color="0.7", lw=0.8, zorder=0)
        axes.set(title=f"water of {level} m: probability of failure {p:.3g}", xlabel="processor seconds")
        axes.grid(alpha=0.25)
    panels[0].set_ylabel("coefficient of variation of the estimate [-]")
    for way, style in styles.items():
        panels[1].plot([], [], style, color="0.3", label={"Monte Carlo": "Monte Carlo", "Sobol": "Sobol, blocks of 64", "importance": "importance, at the design point"}[way])
    handles, labels = panels[1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    save_figure(figure, str(path), dpi=110)


def record(found, known):
    """The table of judges, and what each pair needs for the variation GOAL."""
    text = table(["judge of a sample", "processor time a sample [ms]", "samples", "verdicts unlike the formula's", "undecided"],
                 [[row["judge"], f"{1e3 * row['seconds']:.3g}", row["samples"], row["differ"], row["undecided"]] for row in found])  # fmt: skip
    head = ["probability", "samples by", "samples for a variation of 0.1", *(f"{row['judge']} [s]" for row in found)]
    lines = []
    for way in known:
        n = samples_for(way, GOAL)
        lines.append([f"{way['exact']:.3g}", way["way"], f"{n:.3g}", *(f"{n * row['seconds']:.2g}" for row in found)])
    replace_between("probabilities", text + "\n" + table(head, lines))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--parts", nargs="*", default=["judges", "ways"], choices=["judges", "ways"])
    parser.add_argument("--samples", type=int, default=24, help="that each judge judges")
    parser.add_argument("--repeats", type=int, default=2000, help="sets of samples")
    options = parser.parse_args()
    os.environ["QUOIN_SOLVER"] = os.path.abspath(options.quoin)
    path = DATA / "probabilities.json"
    rows = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    if "judges" in options.parts:
        with contextlib.redirect_stderr(io.StringIO()):
            rows = keep("probabilities", [{"part": "judges", "name": row["judge"], **row} for row in judges(options.samples)], ("part", "name"))
    if "ways" in options.parts:
        rows = keep("probabilities", [{"part": "ways", "name": f"{row['way']}, {row['level']} m", **row} for row in ways(options.repeats)], ("part", "name"))
    found, known = ([row for row in rows if row["part"] == part] for part in ("judges", "ways"))
    found = [row for name in JUDGES for row in found if row["judge"] == name]
    draw(found, known, ROOT / "docs" / "img" / "probabilities.png")
    record(found, known)


if __name__ == "__main__":
    main()
