#!/usr/bin/env python3
"""Water in joints: error against contacts and time, and where the coupling of water and openings stops.

    PYTHONPATH=tools python tests/benchmark/seepage.py --quoin build/quoin            # three minutes of processor time
    PYTHONPATH=tools python tests/benchmark/seepage.py --quoin build/quoin --check    # some cells against LIMITS, seconds

The problem is the rigid dam of 38 m on its base, W06 of the case seepage_coupled; a wall without weight carries water above the crest.
The reference solves its two equations (openings of heel and toe) with 4004 pieces of joint, and is checked against the numbers
of the plan. It follows the equilibria as the dam turns: the level rises to a limit and falls beyond. Equilibria on rising stretches
are stable; some joints have two of them. Error: the larger of that of the uplift, over it, and of the open length, over the base.
Time: seconds of all stages on one rank, the least of several runs; evaluations of forces are the same on every machine.
Maps: stiffness and aperture of the joint, levels, with and without a drain, explicit and preconditioned, tolerances that the program
takes where a scene gives none. A cell misses where the program finds no equilibrium and the reference does; it lies where the program
finds one that the reference does not have, or is more than 5 % off it also with four times the contacts.
Writes docs/img/seepage_accuracy.png, docs/img/seepage_stability.png, docs/data/seepage_accuracy.csv, docs/data/seepage_stability.csv and
tables of docs/generated/benchmarks.md. Exit code 1: a cell lies, or is over its limit."""

import argparse
import csv
import os
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import colors, pyplot

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark")]

from driver import Case, load  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.mesh.blockmesh import BlockMesh  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle  # noqa: E402
from record import DATA, DOCS, replace_between, table  # noqa: E402

W06 = load("seepage_coupled")
LENGTH, WALL = W06.LENGTH, 24.0
METHODS = ("explicit", "preconditioned")
LIE = 0.05

# ---- the reference

PIECES = 4004  # a multiple of 7: one of its ends is at the drain
STEP = LENGTH / PIECES
MIDDLE = (np.arange(PIECES) + 0.5) * STEP
AT_DRAIN = round(W06.DRAIN / STEP)
WEIGHT, LEVER = W06.weight()
MPA = 1e6
PARTS = 0.05  # [m] a dam stands whose heel has opened by no more; at twice as much the program says that blocks have parted


@dataclass(frozen=True)
class Base:
    """The joint under the dam."""

    k_n: float  # [Pa/m]
    aperture: float  # [m]
    drained: bool

    @property
    def least(self):
        return self.aperture / 5

    @property
    def most(self):
        return max(1e-3, 2 * self.aperture)


def pressures(base, openings, level):
    """[Pa] in the middle of each piece of a joint so wide."""
    wide = np.clip(base.aperture + openings, base.least, base.most)
    way = np.concatenate([[0], np.cumsum(wide**-3.0)])
    places, levels = ([0, AT_DRAIN, PIECES], [level, W06.GALLERY, 0]) if base.drained else ([0, PIECES], [level, 0])
    head = np.interp(way, way[places], levels)
    return W06.GW * (head[1:] + head[:-1]) / 2


def along(ends):
    return ends[0] + (ends[1] - ends[0]) * MIDDLE / LENGTH


def state(base, ends, level, frozen=None):
    """What openings [m] of heel and toe lead to: missing to balance [MN/m, MN], uplift [N/m], open length [m]. frozen: openings of the
    ends by which the water flows, in place of these."""
    openings = along(ends)
    water = pressures(base, openings if frozen is None else along(frozen), level)
    bears = water - base.k_n * np.minimum(openings, 0)
    turns = STEP * (bears * MIDDLE).sum() - WEIGHT * LEVER - W06.GW * level**3 / 6
    opened = np.clip(LENGTH * ends[0] / (ends[0] - ends[1]), 0, LENGTH) if ends[0] > 0 else 0.0
    return np.array([STEP * bears.sum() - WEIGHT, turns / LENGTH]) / MPA, STEP * water.sum(), opened


def newton(missing, y, steps):
    """y with missing(y) = 0, None: not found."""
    for _ in range(40):
        off = missing(y)
        if abs(off).max() < 1e-10:
            return y
        slopes = np.column_stack([(missing(y + step) - off) / step.sum() for step in np.diag(steps)])
        y = y - np.linalg.solve(slopes, off)
    return None


def solve(base, level, guess, frozen=None):
    """Openings of the ends [m] at a level."""
    scale = MPA / base.k_n
    found = newton(lambda y: state(base, y * scale, level, frozen)[0], np.asarray(guess) / scale, [1e-6, 1e-6])
    return None if found is None else found * scale


def own_weight(base):
    return solve(replace(base, drained=False), 0.0, np.array([-0.8, -0.1]) * MPA / base.k_n)


def one_way(base, level):
    """Uplift and open length where water flows through the joint as the weight alone has left it."""
    frozen = own_weight(base)
    return state(base, solve(base, level, frozen, frozen), level, frozen)[1:]


def equilibria(base, until=np.inf):
    """Level and openings of the ends as the dam turns, (n, 3); until: [m] a level beyond which no more are wanted."""
    scale, low = MPA / base.k_n, 5.0
    first = solve(base, low, own_weight(base)) / scale
    turn, guess, rows = first[0] - first[1], np.array([first[1], low]), []
    while True:
        ends = lambda y: np.array([y[0] + turn, y[0]]) * scale  # noqa: E731, B023
        found = newton(lambda y: state(base, ends(y), y[1])[0], guess, [1e-6, 1e-5])  # noqa: B023
        if found is None:
            return np.array(rows)
        rows.append([found[1], *ends(found)])
        heel, toe = rows[-1][1:]
        hangs = heel > 0 and LENGTH * toe / (toe - heel) < 20 * STEP
        if found[1] < max(row[0] for row in rows) - 1 or found[1] > until or heel > 3 * PARTS or hangs:
            return np.array(rows)
        guess, turn = found, turn + max(0.01, 0.02 * abs(turn))


def limit(curve):
    """[m] The level that the rising water reaches before the dam falls, or turns to another equilibrium by a jump."""
    levels = curve[curve[:, 1] <= PARTS, 0]
    falls = np.flatnonzero(np.diff(levels) < 0)
    return levels[falls[0] if len(falls) else -1]


def stable(base, curve, level):
    """Uplift, open length and opening of the heel of the stable equilibria at a level, as rising water comes to them."""
    found = []
    for low, high in zip(curve, curve[1:]):
        if low[0] <= level < high[0]:
            between = low + (high - low) * (level - low[0]) / (high[0] - low[0])
            ends = next(ends for ends in (solve(base, level, guess[1:]) for guess in (between, low, high)) if ends is not None)
            found.append((*state(base, ends, level)[1:], ends[0]))
    return found


def error(ours, wanted):
    """The larger of the errors of uplift, over the uplift, and of the open length, over the base."""
    return max(abs(ours[0] / wanted[0] - 1), abs(ours[1] - wanted[1]) / LENGTH)


def compare_with_plan(limits):
    """The numbers of W06; limits: its limit levels too."""
    for (k_n, drained), (ends, _, opened, uplift, *_) in W06.PLAN.items():
        base = Base(k_n, W06.APERTURE, drained)
        mine = solve(base, W06.LEVEL, np.array(ends) * 1e-3)
        off = [*(mine * 1e3 - ends) / np.abs(ends).max(), error(state(base, mine, W06.LEVEL)[1:], (uplift * 1e3, opened))]
        assert np.abs(off).max() < 1e-3, f"the reference is not W06: {off}"
    if not limits:
        return
    low, high = (limit(equilibria(Base(k_n, W06.APERTURE, False))) for k_n in (20e9, 100e9))
    assert abs(low - 38.86) < 0.01 and abs(high - 40.44) < 0.01, f"limit levels {low} and {high} m are not those of W06"


# ---- the program

def dam(n):
    """The dam of W06, n faces on its rock; blocks are a fan, for it is rigid."""
    crest, fan = W06.OUTLINE[4, 1], n + 1
    vertices = [*((x, 0) for x in np.linspace(0, LENGTH, n + 1)), (4, 34), (4, crest), (0, crest), (4, crest + WALL), (0, crest + WALL)]
    blocks = [[i, i + 1, fan, -1] for i in range(n)] + [[0, fan, fan + 1, fan + 2], [fan + 2, fan + 1, fan + 3, fan + 4]]
    sets = {"base": [(i, 0) for i in range(n)], "upstream": [(n, 3), (n + 1, 3)], "downstream": [(n - 1, 1)]}
    body = BlockMesh(np.array(vertices, float), np.array(blocks), np.array([0] * (n + 1) + [1]), ["dam", "wall"], [1, 1],
                     {name: np.array(rows) for name, rows in sets.items()}, {"heel": 0, "toe": n})  # fmt: skip
    return join([rectangle(0, -2, LENGTH, 2, n, 1, group="rock", rigid=True), body])


def scene(base, level, method, *changes):
    joint = {"aperture": base.aperture, "aperture_residual": base.least, "aperture_max": base.most}
    return W06.scene(base.k_n, base.drained, ("materials.wall", {"density": 0}), ("joints.base", joint), ("loads.water.level", level),
                     ("loads.up.level", level), ("relaxation", {"method": method}), ("flow", {}), *changes)  # fmt: skip


def answer(run):
    """What a run has found."""
    stages = run.summary["stages"]
    last = stages[-1]
    effort = {key: sum(stage.get(key, 0) for stage in stages) for key in ("cycles", "force_evaluations", "solves", "factorisations")}
    return effort | {"verdict": run.verdict, "rounds": last["flow"]["rounds"], "uplift": last["flow"]["joints"]["base"]["uplift"],
                     "open": last["joints"]["base"]["open_length"], "evidence": last["evidence"],
                     "seconds": sum(stage["wall_s"] for stage in stages)}  # fmt: skip


# ---- error against contacts and time

CONTACTS = (2, 4, 7, 14, 28, 56, 112)
ACCURACY = {"k_n 20 GPa/m": Base(20e9, 1.5e-4, False), "k_n 5 GPa/m": Base(5e9, 1.5e-4, False), "k_n 5 GPa/m, drain": Base(5e9, 1.5e-4, True)}
LINES = {"two_way": ("-", "full", "two ways"), "one_way": ("--", "none", "one way")}
TIGHT = (("relaxation.tolerance", 1e-9), ("relaxation.velocity_tolerance", 1e-9), ("flow.tolerance", 1e-7))


def accuracy(case, repeats):
    """Rows of every run, each the fastest of its repeats, which take turns."""
    jobs = [(name, method, coupling, n) for name in ACCURACY for method in METHODS for coupling in LINES for n in CONTACTS]
    best = {}
    for job in jobs * repeats:
        name, method, coupling, n = job
        ours = answer(case.run(dam(n), scene(ACCURACY[name], W06.LEVEL, method, ("flow.coupling", coupling), *TIGHT)))
        assert ours["verdict"] == "converged", f"{job}: {ours['verdict']}"
        best[job] = min(best.get(job, ours), ours, key=lambda run: run["seconds"])
    rows = []
    for name, base in ACCURACY.items():
        wanted = {"two_way": stable(base, equilibria(base), W06.LEVEL)[0], "one_way": one_way(base, W06.LEVEL)}
        print(f"{name}: uplift [kN] and open length [m] {', '.join(f'{way} {pair[0] / 1e3:.1f}, {pair[1]:.3f}' for way, pair in wanted.items())}", flush=True)
        for (_, method, coupling, n), ours in ((job, run) for job, run in best.items() if job[0] == name):
            pair = ours["uplift"], ours["open"]
            rows.append({"case": name, "method": method, "coupling": coupling, "contacts": n, "error": error(pair, wanted["two_way"]),
                         "error_of_its_own": error(pair, wanted[coupling])}
                        | {key: ours[key] for key in ("uplift", "open", "rounds", "cycles", "force_evaluations", "solves", "seconds")})  # fmt: skip
    return rows


def costs(rows):
    """What coupling takes off the error, and what it costs: table of docs/generated/benchmarks.md."""
    lines = []
    for name in ACCURACY:
        for n in (7, 28, 112):
            row = {(row["method"], row["coupling"]): row for row in rows if (row["case"], row["contacts"]) == (name, n)}
            both = [row["explicit", coupling] for coupling in ("one_way", "two_way")]
            effort = [f"{row[method, coupling]['force_evaluations']}" for method in METHODS for coupling in ("one_way", "two_way")]
            lines.append([name, n, *(f"{100 * one['error']:.2g}" for one in both), both[1]["rounds"], *effort])
    return table(["joint", "contacts", "error, one way [%]", "error, two ways [%]", "rounds", "evaluations: explicit, one way", "two ways",
                  "preconditioned, one way", "two ways"], lines)  # fmt: skip


METHOD_COLOURS = dict(zip(METHODS, ("#0072b2", "#d55e00")))


def draw_accuracy(rows, path):
    figure, panels = pyplot.subplots(2, len(ACCURACY), figsize=(4.6 * len(ACCURACY), 8.4), sharex="row", sharey=True, constrained_layout=True)
    for above, below, name in zip(*panels, ACCURACY):
        for method, coupling in ((method, coupling) for method in METHODS for coupling in LINES):
            style, fill, word = LINES[coupling]
            mine = [row for row in rows if (row["case"], row["method"], row["coupling"]) == (name, method, coupling)]
            errors, look = [100 * row["error"] for row in mine], {"color": METHOD_COLOURS[method], "fillstyle": fill, "linewidth": 1, "marker": "o"}
            below.plot([1e3 * row["seconds"] for row in mine], errors, style, markersize=5, label=f"{method}, {word}", **look)
            if method == METHODS[0]:  # the other has the same errors
                above.plot(CONTACTS, errors, style, markersize=5, label=f"{word}: off the two-way reference", **look | {"color": "black"})
        above.plot(CONTACTS, [100 * row["error_of_its_own"] for row in mine], ":", color="grey", marker=".", label="one way: off its own reference")
        above.set(xscale="log", yscale="log", title=name, xlabel="contacts along the base [-]")
        below.set(xscale="log", xlabel="time of the solution, one rank [ms]")
        above.set_xticks(CONTACTS, [str(n) for n in CONTACTS])
        below.set_xticks((2, 5, 10, 20, 50), ("2", "5", "10", "20", "50"))
        for axes in (above, below):
            axes.minorticks_off()
            axes.grid(alpha=0.3)
    for axes in panels[:, 0]:
        axes.set_ylabel("error of uplift and open length, the larger [%]")
    panels[0, 0].legend(fontsize=7, loc="lower left", title="contacts: both methods", title_fontsize=7)
    panels[1, 0].legend(fontsize=7, loc="upper right", title="time", title_fontsize=7)
    save_figure(figure, path, dpi=110)


# ---- where it stops

STIFFNESSES = (1, 5, 20, 100, 1000)  # [GPa/m]
APERTURES = (0.02, 0.05, 0.15, 0.4, 1.0)  # [mm]
LEVELS = {False: (30, 32.5, 34, 35, 36, 37, 38, 38.8, 40, 42), True: (30, 37, 38.8, 42)}  # [m] with a drain or not
BELOW = (0.5, 0.1, 0.02, -0.1)  # [m] below the limit level
MOST_CYCLES = 200000  # a few explicit cells within 0.1 m of the limit level need up to 430000; the program's own limit, 1e6, takes minutes
FINER = 4


def judge(ours, wanted):
    """Kind of a cell, and its error."""
    errors = [error((ours["uplift"], ours["open"]), one) for one in wanted]
    if ours["verdict"] != "converged":
        return ("missed" if any(heel <= PARTS for _, _, heel in wanted) else "told"), np.nan
    if not wanted or min(errors) > LIE:
        return "lies", min(errors, default=np.nan)
    return ("right" if errors[0] <= LIE else "jumped"), min(errors)


def columns(drained, curve):
    """Name of a column: level."""
    most = limit(curve)
    return {f"{level:g}": float(level) for level in LEVELS[drained]} | {f"limit {'-' if off > 0 else '+'} {abs(off):g}": most - off for off in BELOW}


def cells(drained, stiffnesses=STIFFNESSES, apertures=APERTURES):
    """Base, its equilibria, limit level, column, level: of every cell."""
    for k_n in stiffnesses:
        for aperture in apertures:
            base = Base(k_n * 1e9, aperture * 1e-3, drained)
            curve = equilibria(base)
            for column, level in columns(drained, curve).items():
                yield base, stable(base, curve, level), limit(curve), column, level


def stability(case):
    rows, mesh = [], dam(28)
    for drained in (False, True):
        todo = list(cells(drained))
        for method in METHODS:
            runs = case.run_all([(mesh, scene(base, level, method, ("relaxation.max_cycles", MOST_CYCLES))) for base, _, _, _, level in todo])
            for (base, wanted, most, column, level), run in zip(todo, runs):
                ours = answer(run)
                kind, off = judge(ours, wanted)
                if kind == "lies" and judge(answer(case.run(dam(28 * FINER), scene(base, level, METHODS[1]))), wanted)[0] == "right":
                    kind = "coarse"
                uplift, opened, heel = wanted[0] if wanted else 3 * [np.nan]
                rows.append({"drain": drained, "method": method, "k_n": base.k_n, "aperture": base.aperture, "limit": most, "column": column, "level": level,
                             "kind": kind, "error": off, "reference_equilibria": len(wanted), "reference_uplift": uplift, "reference_open": opened, "reference_heel": heel}
                            | {key: ours[key] for key in ("uplift", "open", "verdict", "rounds", "cycles", "force_evaluations", "evidence")})  # fmt: skip
            mine = [row["kind"] for row in rows if (row["drain"], row["method"]) == (drained, method)]
            print(f"{title(drained, method)}: {', '.join(f'{mine.count(kind)} {kind}' for kind in KINDS)}", flush=True)
    return rows


KINDS = {"right": ("#2a9d5c", "right"), "jumped": ("#56b4e9", "right, but a farther one of two equilibria"), "told": ("#c9ced6", "stops; no equilibrium with a heel open by less than 5 cm"),
         "coarse": ("#f0e442", "error > 5 %, less with four times the contacts"), "missed": ("#e69f00", "stops, though there is one"), "lies": ("#d62828", "converged, error > 5 %")}  # fmt: skip
SHORT = {"undecided": "und.", "diverged": "div.", "collapsed": "coll."}


def title(drained, method):
    return f"{method}, {'drain' if drained else 'no drain'}"


def counted(n):
    return f"{n}" if n < 1000 else f"{n / 1000:.0f}k"


def draw_map(axes, rows):
    names = list(dict.fromkeys(row["column"] for row in rows))
    lines = list(dict.fromkeys((row["k_n"], row["aperture"], row["limit"]) for row in rows))
    grid = np.zeros((len(lines), len(names)))
    for row in rows:
        i, j = lines.index((row["k_n"], row["aperture"], row["limit"])), names.index(row["column"])
        grid[i, j] = list(KINDS).index(row["kind"])
        text = SHORT.get(row["verdict"], f"{row['rounds']}, {counted(row['cycles'])}")
        axes.text(j, i, text, ha="center", va="center", fontsize=6.5, color="black" if row["kind"] not in ("right", "lies") else "white")
    axes.imshow(grid, cmap=colors.ListedColormap([colour for colour, _ in KINDS.values()]), vmin=-0.5, vmax=len(KINDS) - 0.5, aspect="auto")
    axes.set_xticks(range(len(names)), [name.replace("limit ", "limit\n") for name in names], fontsize=7)
    axes.set_yticks(range(len(lines)), [f"{k_n * 1e-9:g}, {aperture * 1e3:g}: {most:.2f}" for k_n, aperture, most in lines], fontsize=7)
    for i in range(len(APERTURES), len(lines), len(APERTURES)):
        axes.axhline(i - 0.5, color="white", linewidth=2)
    axes.axvline(len(names) - len(BELOW) - 0.5, color="white", linewidth=2)


def draw_stability(rows, path):
    figure, panels = pyplot.subplots(2, 2, figsize=(17, 15), constrained_layout=True)
    for drained in (False, True):
        for j, method in enumerate(METHODS):
            axes = panels[int(drained), j]
            draw_map(axes, [row for row in rows if (row["drain"], row["method"]) == (drained, method)])
            axes.set(title=title(drained, method), xlabel="level [m]", ylabel="k_n [GPa/m], aperture [mm]: limit level of the reference [m]")
    handles = [pyplot.Rectangle((0, 0), 1, 1, color=colour, label=words) for colour, words in KINDS.values()]
    figure.legend(handles=handles, loc="outside lower center", ncol=len(KINDS), fontsize=9, title="rounds, cycles; or how it stopped", title_fontsize=9)
    save_figure(figure, path, dpi=110)


# ---- the check

# k_n [GPa/m], aperture [mm], drain, level [m]: most rounds, most force evaluations of an explicit and of a preconditioned run
LIMITS = {
    (5, 0.15, False, 37): (7, 4500, 38),
    (20, 0.15, False, 37): (3, 3400, 21),
    (5, 0.15, True, 37): (3, 2600, 14),
    (20, 0.15, False, 38.8): (9, 5100, 52),
    (20, 0.02, False, 34): (12, 5700, 32),
    (1000, 1, False, 42): (3, 3700, 31),
    (5, 0.08, False, 32.5): (13, 8400, 33),  # the plain iteration swings
}


def check(case):
    """Exit code 1: a cell of LIMITS is wrong, or takes more than it may."""
    bad = 0
    for (k_n, aperture, drained, level), (rounds, *efforts) in LIMITS.items():
        base = Base(k_n * 1e9, aperture * 1e-3, drained)
        wanted = stable(base, equilibria(base, until=level), level)
        for method, most in zip(METHODS, efforts):
            ours = answer(case.run(dam(28), scene(base, level, method)))
            kind, off = judge(ours, wanted)
            good = kind == "right" and ours["rounds"] <= rounds and ours["force_evaluations"] <= most
            bad += not good
            print(f"k_n {k_n:g} GPa/m, {aperture:g} mm, {level:g} m, {title(drained, method)}: {kind}, error {100 * off:.2g} %, {ours['rounds']} rounds of {rounds}, "
                  f"{ours['force_evaluations']} evaluations of {most}{'' if good else '  OVER'}", flush=True)  # fmt: skip
    return 1 if bad else 0


def keep(name, rows):
    with open(DATA / f"{name}.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()} for row in rows)


def charts(rows):
    keep("seepage_accuracy", rows)
    draw_accuracy(rows, DOCS / "img" / "seepage_accuracy.png")
    replace_between("water in joints", costs(rows))


def maps(rows):
    """Exit code 1: a cell lies."""
    keep("seepage_stability", rows)
    draw_stability(rows, DOCS / "img" / "seepage_stability.png")
    found = [row for row in rows if row["kind"] not in ("right", "told")]
    for row in found:
        print(f"{row['kind']}: k_n {row['k_n'] * 1e-9:g} GPa/m, {row['aperture'] * 1e3:g} mm, {row['level']:.2f} m (limit {row['limit']:.2f}), "
              f"{title(row['drain'], row['method'])}: {row['verdict']}, {row['rounds']} rounds, error {100 * row['error']:.2g} %; {row['evidence']}")  # fmt: skip
    return 1 if any(row["kind"] == "lies" for row in found) else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--repeats", type=int, default=5, help="of the runs that are timed")
    parser.add_argument("--only", choices=("accuracy", "stability"), help="the other keeps its data")
    parser.add_argument("--check", action="store_true", help="some cells against LIMITS; exit code 1 over one; writes nothing")
    options = parser.parse_args()
    compare_with_plan(limits=not options.check)
    with tempfile.TemporaryDirectory() as folder:
        case = Case("seepage", os.path.abspath(options.quoin), folder)
        if options.check:
            return check(case)
        if options.only != "stability":
            charts(accuracy(case, options.repeats))
        return maps(stability(case)) if options.only != "accuracy" else 0


if __name__ == "__main__":
    sys.exit(main())
