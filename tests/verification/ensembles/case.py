"""Ensembles (quoin ensemble): probabilities, intervals, fragility and sensitivity of a rigid dam that slides, against quadrature; the solver and limit analysis sample by sample; kills, parts, any number of jobs.

The dam: N = 12909.96 - K 9.81 h 14 kN, H = 4.905 h^2 kN, base 28 m; R = N tan(phi) + c L, lognormal tan(phi) 0.9 (cov 0.15) and c 0.1 MPa (cov 0.5)."""

import contextlib
import csv
import io
import json
import math
import os
import signal
import subprocess
import sys
import time
from functools import partial

import numpy as np
import yaml
from driver import ENVIRONMENT, ROOT
from quoin_tools.base import scene as scenes
from quoin_tools.base import solver
from quoin_tools.ensemble import analysis, design, running
from quoin_tools.ensemble.intervals import clopper_pearson, zero_bound
from quoin_tools.ensemble.models import Solver
from quoin_tools.ensemble.sampling import Sampler
from quoin_tools.ensemble.variables import variables
from quoin_tools.front import ensemble
from quoin_tools.limit.bounds import bound
from quoin_tools.mesh import blockmesh, voronoi
from quoin_tools.mesh.blockmesh import BlockMesh, write
from quoin_tools.mesh.meshing import join, rectangle, renamed
from scipy.integrate import quad
from scipy.stats import kstest, norm, weibull_min

WHAT = "ensembles: exact probabilities inside their intervals, coverage, fragility, Sobol indices, design point; solver and limit analysis sample by sample; kills, parts, jobs"
SOURCE = "quadrature over two lognormal variables; exact binomial intervals; FORM"
BY = "quadrature, exact intervals and FORM of this project"

FRICTION = {"distribution": "lognormal", "of": "tan", "mean": 0.9, "cov": 0.15}
COHESION = {"distribution": "lognormal", "mean": 1e5, "cov": 0.5, "keys": ["joints.base.cohesion", "joints.base.cohesion_residual"]}
ROWS = {"joints.base.friction": FRICTION, "c": COHESION}
WEIGHT, WIDTH = 12909.96e3, 28.0


def normal_force(h, uplift=1.0):
    return WEIGHT - uplift * 9810 * h * WIDTH / 2


def factor(values, h):
    """Of the formula; values: angle [degree], cohesion [Pa]."""
    values = np.asarray(values, dtype=float)
    return (normal_force(h) * np.tan(np.radians(values[..., 0])) + values[..., 1] * WIDTH) / (4905 * h**2)


def exact(h, rho=0.0, uplift=1.0):
    """Probability of R < H by quadrature over the logarithm of tan(phi)."""
    (m1, s1), (m2, s2) = ((math.log(mean) - 0.5 * math.log1p(cov**2), math.sqrt(math.log1p(cov**2))) for mean, cov in ((0.9, 0.15), (1e5, 0.5)))

    def density(z):
        left = (4905 * h**2 - normal_force(h, uplift) * math.exp(m1 + s1 * z)) / WIDTH
        below = 0.0 if left <= 0 else norm.cdf((math.log(left) - m2 - rho * s2 * z) / (s2 * math.sqrt(1 - rho**2)))
        return norm.pdf(z) * below

    edge = (math.log(4905 * h**2 / normal_force(h, uplift)) - m1) / s1
    return quad(density, -9, edge, limit=400, epsabs=1e-14)[0]


def folder_of(case, name, **keys):
    """A folder with mesh, scene and ensemble; the weight stands where the resultant stays within the middle of the base."""
    folder = case.folder / name
    folder.mkdir(parents=True)
    dam = BlockMesh([(0, 0), (1.5, 0), (28, 0), (0, 46), (1.5, 46), (28, 46)], [(0, 1, 4, 3), (1, 2, 5, 4)], [0, 0], ["dam"], [1], {"upstream": [(0, 3)], "base": [(0, 0), (1, 0)]}, {})
    mesh = join([renamed(rectangle(-20, -5, 80, 5, group="rock", rigid=True), {}), dam])
    mesh.points = {"mass": 8}
    write(str(folder / "model.h5"), mesh)
    scene = {
        "model": str(folder / "model.h5"),
        "materials": {"dam": {"density": 1e-3, "rigid": True}, "rock": {"density": 2000, "rigid": True}},
        "joints": {"base": {"k_n": 1e10, "k_s": 1e10, "friction": 42, "cohesion": 1e5, "cohesion_residual": 1e5}},
        "supports": {"rock": {"fix": "xy"}},
        "loads": {"mass": {"type": "point_force", "point": "mass", "value": [0, -WEIGHT]}, "water": {"type": "reservoir", "faces": "upstream", "level": 40}, "uplift": {"type": "uplift", "faces": "base", "level": 40}},
        "stages": [{"full": {"loads": ["mass", "water", "uplift"]}}],
    }
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    (folder / "ensemble.yaml").write_text(yaml.safe_dump({"scene": "scene.yaml", "samples": 40, "seed": 1, "variables": ROWS} | keys, sort_keys=False), encoding="utf-8")
    return folder


BY_LIMIT = {"judge": "limit", "fail": "limit < 1", "raises": ["water"]}
LEVELS = {"keys": ["loads.water.level", "loads.uplift.level"], "values": [34, 36, 38, 40, 42, 44, 46]}


LONG = ("by_levels", "whole_sets", "killed")  # parts that the short form leaves out


def run(case):
    os.environ["QUOIN_SOLVER"] = os.path.abspath(case.quoin)
    intervals(case)
    coverage(case)
    spread(case)
    sample_by_sample(case)
    by_levels(case)
    sensitive(case)
    rare(case)
    weakest_link(case)
    whole_sets(case)
    killed(case)
    other_mesh(case)
    other_keys(case)
    two_ways(case)
    fabrics(case)
    refused(case)


def command(folder, *words):
    """(exit code, what it said)"""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = ensemble.main([str(folder / "ensemble.yaml"), *words])
    return code, out.getvalue()


def rows_of(folder, output="out"):
    wanted = design.read(str(folder / "ensemble.yaml"))
    return wanted, running.Journal(str(folder / output), wanted).rows()


def intervals(case):
    for (k, n), low, high in (((1, 20), 0.0013, 0.2487), ((3, 50), 0.0125, 0.1655), ((7, 64), 0.0451, 0.2125), ((20, 200), 0.0622, 0.1502), ((0, 100), 0.0, 0.0362)):
        case.check(f"E02 Clopper-Pearson of {k} of {n}", clopper_pearson(k, n), (low, high), absolute=5.1e-5)
    case.check("bounds of no failure in 10, 30, 100, 300", [zero_bound(n) for n in (10, 30, 100, 300)], [0.259, 0.095, 0.0295, 0.0099], relative=5e-3)


def coverage(case):
    """100 seeds of 200 samples by the formula: how often the interval holds the exact value."""
    for h, rho, told in ((40, 0.0, 0.157577), (40, -0.5, 0.072850), (40, 0.5, 0.216547)):
        both = variables(ROWS, [["joints.base.friction", "c", rho]] if rho else [])
        p = exact(h, rho)
        case.check(f"E01 exact probability at {h} m, rho {rho:g}", p, told, relative=1e-5)
        inside = 0
        for seed in range(100):
            sampler = Sampler("monte_carlo", both, seed)
            values = both.values([sampler.normal(i) for i in range(200)])
            low, high = clopper_pearson(int((factor(values, h) < 1).sum()), 200)
            inside += low <= p <= high
        case.check("... inside the 95 % interval in at least 90 of 100 seeds", inside >= 90, True)
        case.report("... inside", inside, 95)


def spread(case):
    """Means and spreads come out as asked, truncation and tangents too; even samplings are nearer by far."""
    both = variables(ROWS | {"joints.base.k_n": {"distribution": "normal", "mean": 5.0, "deviation": 2.0, "min": 3.0, "max": 6.0}}, [["joints.base.friction", "c", -0.5]])
    for method, near in (("monte_carlo", 2e-2), ("latin_hypercube", 6e-3), ("sobol", 6e-3)):
        sampler = Sampler(method, both, 3)
        values = np.array(both.values([sampler.normal(i) for i in range(6400)]))
        tangent = np.tan(np.radians(values[:, 0]))
        case.check(f"{method}: means", [tangent.mean() / 0.9, values[:, 1].mean() / 1e5], [1, 1], absolute=near)
        case.check("... deviations", [tangent.std() / 0.135, values[:, 1].std() / 5e4], [1, 1], absolute=5 * near)
        case.check("... correlation of the logarithms", np.corrcoef(np.log(tangent), np.log(values[:, 1]))[0, 1], -0.5, absolute=2 * near)
        case.check("... a normal one, cut off at 3 and 6", [bool(values[:, 2].min() >= 3), bool(values[:, 2].max() <= 6)], [True, True])
    one, two = variables({"joints.base.friction": FRICTION}, []), variables({"x": {"distribution": "uniform", "min": 0, "max": 1}} | ROWS, [])
    first, second = Sampler("monte_carlo", one, 7), Sampler("monte_carlo", two, 7)
    case.check("a variable more changes no other", [first.normal(i)[0] for i in range(20)] == [second.normal(i)[1] for i in range(20)], True)


def sample_by_sample(case):
    """The solver, limit analysis and the formula give every sample the same verdict."""
    for judge in ({}, BY_LIMIT):
        folder = folder_of(case, f"one_by_one_{judge.get('judge', 'solver')}", **judge)
        command(folder, "-o", str(folder / "out"), "-j", "2")
        _, rows = rows_of(folder)
        formula = ["fails" if factor(rows[i, None].values, 40) < 1 else "stands" for i in range(40)]
        case.check(f"{judge.get('judge', 'solver')}: verdicts of 40 samples that differ from the formula's", sum(rows[i, None].outcome != formula[i] for i in range(40)), 0)
    case.check("... and the multiplier of limit analysis is the factor", [rows[i, None].response for i in range(40)], [float(factor(rows[i, None].values, 40)) for i in range(40)], relative=1e-9)
    one_by_one(case)
    code, said = command(folder, "-o", str(folder / "again"), "--sample", "17")
    case.check("one sample alone: exit code and number", [code, f"{rows[17, None].response:.6g}" in said], [{"stands": 0, "fails": 6}[rows[17, None].outcome], True])


def one_by_one(case):
    """Samples that share a process, with 1, 2 and 4 of these, and a process each: the same rows, numbers to the last digit."""
    folder = folder_of(
        case,
        "shared",
        samples=12,
        levels={"keys": ["loads.water.level", "loads.uplift.level"], "values": [39, 41]},
        fail="joints.base.sliding_factor_peak < 1.2",
        response="max_displacement.value",
    )
    wanted, found = design.read(str(folder / "ensemble.yaml")), []
    for jobs in (1, 2, 4):
        command(folder, "-o", str(folder / f"out_{jobs}"), "-j", str(jobs))
        rows = running.Journal(str(folder / f"out_{jobs}"), wanted).rows()
        found.append({key: (row.outcome, row.response, row.values, row.why) for key, row in sorted(rows.items())})
    case.check(
        "samples of 1, 2 and 4 processes: the same rows",
        [found[1] == found[0], found[2] == found[0], len(found[0])],
        [True, True, 24],
    )
    alone = Solver(wanted, str(folder / "alone"), shares=False)
    apart = [key for key, row in found[0].items() if key[0] % 3 == 0 and alone.judge(row[2], *key) != (row[0], row[1], row[3])]
    case.check("... and of a process each", apart, [])
    case.check("... of every kind", {row[0] for row in found[0].values()}, {"stands", "fails"})
    from_nearest(case, folder, found[0])


def from_nearest(case, folder, rows):
    """Samples that start from the nearest of some that are solved first: the same verdicts, numbers within the tolerance, any number of processes the same rows."""
    text = (folder / "ensemble.yaml").read_text(encoding="utf-8")
    (folder / "ensemble.yaml").write_text(text + "start: nearest\noptions: [-relaxation_method, preconditioned]\n", encoding="utf-8")
    found = []
    for jobs in (1, 2):
        command(folder, "-o", str(folder / f"nearest_{jobs}"), "-j", str(jobs))
        found.append(dict(sorted(rows_of(folder, f"nearest_{jobs}")[1].items())))
    case.check("from the nearest: verdicts", [row.outcome for row in found[0].values()], [row[0] for row in rows.values()])
    case.check("... numbers", [row.response for row in found[0].values() if row.response], [row[1] for row in rows.values() if row[1]], relative=1e-4)
    case.check("... of 1 and 2 processes to the last digit", all(row.same(found[1][key]) for key, row in found[0].items()), True)


def by_levels(case):
    folder = folder_of(case, "levels", samples=400, levels=LEVELS, **BY_LIMIT)
    _, said = command(folder, "-o", str(folder / "out"), "-j", "2")
    wanted, rows = rows_of(folder)
    found = analysis.probabilities(wanted, rows)
    case.check("E03 fails at each level: never fewer at a higher one", bool((np.diff([p.fails for p in found]) >= 0).all()), True)
    case.check("... exact values inside the intervals", sum(bool(p.low <= exact(p.level) <= p.high) for p in found) >= len(found) - 1, True)
    curve = analysis.fragility(found)
    case.check("... median [m]", curve.median, 42.663, absolute=0.3)
    case.check("... 5 and 95 % [m]", [curve.level(0.05), curve.level(0.95)], [38.448, 48.262], absolute=0.8)
    case.check("... reported", [f"{curve.median:.5g}" in said, (folder / "out/fragility.png").exists()], [True, True])


def sensitive(case):
    """E04: indices of the factor at 37 m; it has no interaction."""
    both = variables(ROWS, [])
    folder = folder_of(case, "indices", samples=4 * 10000, method="sobol_indices", **BY_LIMIT)
    wanted = design.read(str(folder / "ensemble.yaml"))
    sampler = Sampler("sobol_indices", both, 1)
    values = both.values([sampler.normal(i) for i in range(wanted.samples)])
    answers = factor(values, 37)
    rows = {(i, None): running.Row(i, None, 1.0, "stands", float(answers[i]), 0.0, "", tuple(values[i])) for i in range(wanted.samples)}
    indices, dropped = analysis.sobol_indices(wanted, rows)
    case.check("E04 first order of tan(phi) and c", [row[1] for row in indices], [0.3630, 0.6370], absolute=0.02)
    case.check("... total", [row[2] for row in indices], [0.3630, 0.6370], absolute=0.02)
    case.check("... mean and deviation of the factor", [answers[::4].mean(), answers[::4].std()], [1.46621, 0.26122], relative=2e-2)
    rows[5, None] = running.Row(5, None, 1.0, "undecided", None, 0.0, "", tuple(values[5]))
    case.check("... a sample without a number drops its group, reported", analysis.sobol_indices(wanted, rows)[1] - dropped, 1)


def rare(case):
    """Importance sampling at the design point: 500 samples for one in ten thousand."""
    folder = folder_of(case, "rare", samples=500, method="importance", **BY_LIMIT)
    scene = yaml.safe_load((folder / "scene.yaml").read_text())
    for name in ("water", "uplift"):
        scene["loads"][name]["level"] = 34
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    command(folder, "-o", str(folder / "out"), "-j", "2")
    wanted, rows = rows_of(folder)
    point = json.loads((folder / "out/design_point.json").read_text())
    case.check("design point at 34 m: distance (FORM)", point["distance"], 3.5956, absolute=2e-3)
    found = analysis.probabilities(wanted, rows)[0]
    case.check("... probability by 500 samples about it", found.value, exact(34), relative=0.25)
    case.check("... exact value inside the interval, which is narrow", [found.low <= exact(34) <= found.high, found.half_width < 0.25 * found.value], [True, True])


def on_planes(case, name, planes, **keys):
    """Blocks on planes of their own, pushed alike: the multiplier is the least tangent."""
    folder = folder_of(case, name, judge="limit", fail="limit < 0.5", raises=["push"], **keys)
    blocks = [renamed(rectangle(4 * i, 0, 2, 1, group="block", rigid=True), {f"plane_{i}": "bottom", "side": "left"}) for i in range(planes)]
    write(str(folder / "model.h5"), join([renamed(rectangle(-2, -1, 4 * planes + 2, 1, group="rock", rigid=True), {}), *blocks]))
    scene = yaml.safe_load((folder / "scene.yaml").read_text())
    scene["materials"] = {"rock": {"density": 2000, "rigid": True}, "block": {"density": 2000, "rigid": True}}
    scene["joints"] = {f"plane_{i}": {"k_n": 1e10, "k_s": 1e10, "friction": 40} for i in range(planes)}
    weight = 2000 * 9.81 * 2 * 1
    scene["loads"] = {"weight": {"type": "self_weight"}, "push": {"type": "traction", "faces": "side", "value": [weight, 0]}}
    scene["stages"] = [{"full": {"loads": ["weight", "push"]}}]
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    return folder, command(folder, "-o", str(folder / "out"), "-j", "2")[1]


def two_ways(case):
    """Importance sampling sees the way of failing that is nearest; that there is another one is reported."""
    one, other = ({"distribution": "lognormal", "of": "tan", "mean": mean, "cov": 0.15} for mean in (0.9, 1.0))
    for name, second in (("two", other), ("one", other | {"mean": 2.0})):
        _, said = on_planes(case, f"{name}_ways", 2, samples=20, method="importance", variables={"joints.plane_0.friction": one, "joints.plane_1.friction": second})
        case.check(f"importance sampling, failure in {name} way{'s' if name == 'two' else ''}: reported", "it fails in another way too" in said, name == "two")
    none = [running.Row(i, None, 0.1, "stands", 1.0, 0.0, "", (1.0,)) for i in range(20)]
    case.check("... where none of its samples fails nothing is known", analysis.weighted(None, none, 0, 0).high, 1.0)


def weakest_link(case):
    """E05: ten blocks on ten planes of independent strengths, pushed alike: the multiplier is that of the weakest, Weibull too with its scale over 10^(1/k)."""
    planes, cov, samples = 10, 0.2, 200
    folder, _ = on_planes(case, "weakest", planes, samples=samples, variables={
        f"joints.plane_{i}.friction": {"distribution": "weibull", "of": "tan", "mean": 0.9, "cov": cov} for i in range(planes)})  # fmt: skip
    wanted, rows = rows_of(folder)
    least = [min(np.tan(np.radians(rows[i, None].values))) for i in range(samples)]
    case.check("E05 multiplier and least of ten strengths", [rows[i, None].response for i in range(samples)], least, relative=1e-9)
    strength = wanted.variables.each[0].shape
    power = strength.args[0]
    weakest = weibull_min(power, scale=strength.kwds["scale"] * planes ** (-1 / power))
    case.check("... the exact chance of the chain and of its links", weakest.cdf(strength.ppf(0.01)), 0.095618, absolute=1e-6)
    case.check("... Kolmogorov's distance of 200 samples to the Weibull distribution of the least (95 %: 0.096)", kstest(least, weakest.cdf).statistic, 0, absolute=0.096)
    found = analysis.probabilities(wanted, rows)[0]
    case.check("... exact value inside the interval", found.low <= weakest.cdf(0.5) <= found.high, True)


def table_of(folder, output="out"):
    _, rows = rows_of(folder, output)
    return [(key, rows[key].outcome, rows[key].response, rows[key].values) for key in sorted(rows)]


def over_ranks(folder, output="out", ranks=3):
    """The ensemble over an MPI job, of which rank 0 hands out."""
    words = ["mpirun", "-q", "-n", str(ranks), sys.executable, str(ROOT / "tools/quoin.py"), "ensemble", str(folder / "ensemble.yaml"), "-o", str(folder / output), "--mpi"]
    return subprocess.run(words, env=ENVIRONMENT | dict(os.environ), capture_output=True, text=True, check=False)


def whole_sets(case):
    """1, 2, 3 jobs, two halves, and fewer samples first: the same table."""
    tables = []
    for name, calls in (("jobs_1", [["-j", "1"]]), ("jobs_3", [["-j", "3"]]), ("halves", [["-j", "1", "--part", "1/2"], ["-j", "2", "--part", "2/2"], []])):
        folder = folder_of(case, name, samples=60, **BY_LIMIT)
        for words in calls:
            command(folder, "-o", str(folder / "out"), *words)
        tables.append(table_of(folder))
    case.check("rows of 60 samples by 1 and 3 jobs, and of two halves", [tables[0] == tables[1], tables[0] == tables[2], len(tables[0])], [True, True, 60])
    folder = folder_of(case, "mpi", samples=60, **BY_LIMIT)
    case.check("... and over three ranks of an MPI job", [over_ranks(folder).returncode, table_of(folder) == tables[0]], [0, True])
    folder = folder_of(case, "stopped", samples=400, stop={"half_width": 0.06, "batch": 20}, **BY_LIMIT)
    command(folder, "-o", str(folder / "out"), "-j", "2")
    wanted, rows = rows_of(folder)
    found = analysis.probabilities(wanted, rows)[0]
    case.check("stopped by the width of the interval: samples, width", [found.n % 20, found.n < 400, found.half_width <= 0.06], [0, True, True])


def killed(case):
    """The ensemble, then single samples, are killed: what is there stays, what is missing follows, none counts twice."""
    folder = folder_of(case, "killed", samples=24)
    words = [sys.executable, str(ROOT / "tools/quoin.py"), "ensemble", str(folder / "ensemble.yaml"), "-o", str(folder / "out"), "-j", "2"]
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    rows = folder / "out/rows_1.csv"
    waited = time.monotonic()
    while (not rows.exists() or rows.read_text().count("\n") < 6) and time.monotonic() - waited < 60:
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = rows.read_text()
    with open(rows, "a", encoding="utf-8") as file:
        file.write("23,,1.0,fails,,0.4")  # a line that the kill has cut
    command(folder, "-o", str(folder / "out"), "-j", "2")
    lines = [line for line in csv.reader(rows.read_text().split("\n")) if line and line[0].isdigit() and len(line) > 9]
    case.check("killed: what was there stays", rows.read_text().startswith(kept), True)
    case.check("... every sample once", sorted(int(line[0]) for line in lines), list(range(24)))
    dying(case, folder)


FILTER = """import os, subprocess, sys, time
if "-samples" not in sys.argv:
    os.execv({quoin!r}, [{quoin!r}, *sys.argv[1:]])
child = subprocess.Popen([{quoin!r}, *sys.argv[1:]], stdin=subprocess.PIPE, text=True)
for line in sys.stdin:
    name = line.split(",")[0]
    if name in ("3", "5"):
        child.kill()
        os.kill(os.getpid(), 9) if name == "3" else os._exit(11)
    if name == "7":
        time.sleep(30)
    child.stdin.write(line)
    child.stdin.flush()
child.stdin.close()
"""


def dying(case, folder):
    """Samples that die or take too long, in a process that has many, and in one of their own."""
    script, one = (
        folder / "dies",
        folder_of(
            case,
            "killed_alone",
            samples=8,
            variables=ROWS | {"materials.dam.density": {"distribution": "uniform", "min": 1e-3, "max": 2e-3}},
        ),
    )
    (folder / "filter.py").write_text(FILTER.format(quoin=str(case.quoin)), encoding="utf-8")
    before, os.environ["QUOIN_SOLVER"] = os.environ["QUOIN_SOLVER"], str(script)
    text = (folder / "ensemble.yaml").read_text(encoding="utf-8")
    (folder / "ensemble.yaml").write_text(text + "time_limit: 2\n", encoding="utf-8")
    script.write_text(f'#!/bin/sh\nexec {sys.executable} {folder}/filter.py "$@"\n', encoding="utf-8")
    script.chmod(0o755)
    _, said = command(folder, "-o", str(folder / "other"), "-j", "2")
    case.check(
        "samples that die: undecided, with the reason; no other is harmed",
        ["3 undecided" in said, "SIGKILL" in said, "exit code 11" in said, "longer than 2 s" in said],
        [True] * 4,
    )
    case.check("... nor the ranks of an MPI job", over_ranks(folder, "over_ranks").returncode, 0)
    outcomes = [outcome for (i, _), outcome, *_ in table_of(folder, "over_ranks")]
    case.check("... by their rows", [outcomes.count("undecided"), len(outcomes), outcomes == [row.outcome for _, row in sorted(rows_of(folder, "other")[1].items())]], [3, 24, True])
    script.write_text(
        f'#!/bin/sh\ncase "$*" in *000003*) kill -9 $$ ;; *000005*) exit 11 ;; esac\nexec {case.quoin} "$@"\n', encoding="utf-8"
    )
    _, said = command(one, "-o", str(folder / "third"), "-j", "2")
    os.environ["QUOIN_SOLVER"] = before
    case.check("... a process each", ["2 undecided" in said, "SIGKILL" in said, "exit code 11" in said], [True] * 3)


def other_keys(case):
    """Rows of levels of other keys are refused: their numbers look alike."""
    folder = folder_of(case, "other_keys", samples=4, levels={"keys": ["loads.water.level"], "values": [38, 40]}, **BY_LIMIT)
    command(folder, "-o", str(folder / "out"))
    wanted = yaml.safe_load((folder / "ensemble.yaml").read_text())
    wanted["levels"] = {"keys": ["loads.water.level", "loads.uplift.level"], "values": [38, 40, 42]}
    (folder / "ensemble.yaml").write_text(yaml.safe_dump(wanted, sort_keys=False), encoding="utf-8")
    try:
        said = command(folder, "-o", str(folder / "out"))[1]
    except ValueError as error:
        said = str(error)
    case.check("rows of levels of other keys", "rows of another ensemble" in said, True)


def other_mesh(case):
    """Rows of another mesh are refused, also where the scene names the mesh."""
    folder = folder_of(case, "other_mesh", samples=4, **BY_LIMIT)
    command(folder, "-o", str(folder / "out"))
    mesh = blockmesh.read(folder / "model.h5")
    mesh.vertices[-1, 1] += 0.5
    write(str(folder / "model.h5"), mesh)
    try:
        said = command(folder, "-o", str(folder / "out"))[1]
    except ValueError as error:
        said = str(error)
    case.check("rows of another mesh that the scene names", "rows of another ensemble" in said, True)


def fabrics(case):
    """A mesh for each sample: the fabric is that of the command run by hand."""
    folder = folder_of(case, "fabrics", samples=2, mesh=["voronoi", "--square", "--side", "6", "--seed", "{seed}"], stage="less", judge="limit", fail="limit > 12",
                       variables={"fabric": {"distribution": "integer", "min": 1, "max": 1000, "keys": ["mesh.seed"]}})  # fmt: skip
    scene = {"materials": {"dam": {"density": 2400, "rigid": True}, "facing": {"density": 2400, "rigid": True}}, "joints": {"default": {"k_n": 1e10, "k_s": 1e10, "friction": 45}},
             "supports": {"base": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}}, "stages": [{"less": {"type": "strength_reduction", "loads": ["weight"], "bracket": 1}}]}  # fmt: skip
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    command(folder, "-o", str(folder / "out"), "-j", "2")
    _, rows = rows_of(folder)
    with contextlib.redirect_stdout(io.StringIO()):
        voronoi.main(["--square", "--side", "6", "--seed", str(int(rows[1, None].values[0])), "-o", str(folder / "model.h5")])
    alone = bound(blockmesh.read(folder / "model.h5"), scenes.parse(solver.settled(folder / "scene.yaml", ("-model", str(folder / "model.h5"))), "scene.yaml"), "less")
    case.check("a fabric of the ensemble and the same by hand: least friction [degree]", rows[1, None].response, alone.value, relative=1e-9)
    case.check("... two fabrics, two numbers", rows[0, None].response != rows[1, None].response, True)


def refused(case):
    """One line each."""
    def told(**keys):
        folder = folder_of(case, f"refused_{case.runs}_{abs(hash(str(keys)))}", **keys)
        try:
            command(folder, "-o", str(folder / "out"))
        except ValueError as error:
            return str(error)
        return "nothing"

    def choice(values, key="joints.base.friction", **more):
        return {"variables": {key: {"distribution": "choice", "values": values} | more}}

    normal = partial(dict, distribution="normal", mean=40)
    for keys, words in (
        ({"samples": 0}, "samples: 0: expected a whole number >= 1"), ({"speed": 1}, "speed: unknown key"), ({"fail": "soon"}, "fail: soon: expected collapsed, or a condition"),
        ({"variables": {"joints.base.friction": normal()}}, "expected mean and one of deviation, cov"), ({"variables": {"joints.base.friction": normal(deviation=-1)}}, "expected more than 0"),
        ({"variables": {"joints.base.friction": normal(deviation=1, min=50, max=40)}}, "max 40 is not above min 50"), ({"variables": {"joints.base.friction": {"distribution": "cauchy"}}}, "expected one of normal"),
        ({"variables": {"joints.base.friction": normal(deviation=1, min=90)}}, "hardly anything of the distribution"), ({"correlation": [["joints.base.friction", "c", 1.5]]}, "between -1 and 1"),
        ({"method": "importance"}, "needs a number that fails"), ({"judge": "limit"}, "limit analysis does not collapse"), ({"levels": {"keys": ["loads.water.level"], "values": [3, 2]}}, "numbers that rise"),
        ({"variables": {"joints.base.fiction": normal(deviation=1)}}, "fiction"), ({"variables": {"joints.base.friction": normal(deviation=1, keys=["joints.base.friction", "joints.base.friction"])}}, "is set twice"),
        ({"levels": {"keys": ["joints.base.friction"], "values": [40]}}, "is set twice"), (choice(["a.csv", "b.csv"], "motions.quake.file"), "a.csv: no such file"), (choice([]), "a list of two or more numbers or words"),
        (choice([1, 1]), "1 is there twice"), (choice([1, 2], weights=[0.5, 0.4]), "their sum is 0.9: expected 1"), (choice([1, 2], weights=[1]), "a number above 0 for each of the 2 values"), (choice([1, 2], min=0), "a choice has no min"),
        (choice(["elastic", "none"], "joints.base.law"), "none"), ({"start": "near"}, "expected one of shared, nearest"), (BY_LIMIT | {"start": "nearest"}, "have nothing to start from"),
        ({"start": "nearest", "variables": {"materials.dam.density": normal(deviation=1)}}, "cannot share a process"), (choice([40, 41]) | {"method": "importance", "fail": "x < 1"}, "is a choice, along which there is no design point"), (BY_LIMIT | {"raises": ["wind"]}, "no load 'wind' that presses on bodies, there are: mass, water, uplift"),
        ({"fail": "joints.bas.sliding_factor_peak < 1"}, "fail: joints.bas.sliding_factor_peak: no 'bas' in joints of stage full, there are: base"), ({"response": "joints.base.factor"}, "no 'factor' in joints.base of stage full, there are: line, law"), ({"stage": "ful"}, "stage: no stage 'ful', there are: full"),
    ):  # fmt: skip
        case.check(f"refused: {str(keys)[:70]}", words in (said := told(**keys)) and "\n" not in said, True)
