"""Samples of a scene in one process (the key `samples`).

Each sample ends as a run of its own with the same numbers on the command line: same outcome, stage, bracket, numbers and checksum, whatever
ran before it. What a run remembers must all go back, so each kind of memory has a scene."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
from cases.case import BASE, STONE, dam, scene
from driver import ENVIRONMENT, VERDICTS

WHAT = "samples in one process: outcome, bracket, numbers and bits of a run of each; any order; kills; rows of other tables; memory; refusals"
SOURCE = "the same numbers in runs of their own"
BY = "Quoin itself, runs of their own"

OUTCOMES = {"converged": "stands", "collapsed": "fails"}
WEAK = {"default": {"k_n": 1e10, "k_s": 4e9, "friction": 40, "friction_residual": 8, "cohesion": 2e4, "tension": 1e4}}
NEWTON = {"tolerance": 1e-7, "velocity_tolerance": 1e-7, "method": "preconditioned"}
STAGES = [*BASE, {"pushed": {"loads": ["weight", "water", "push"]}}]
FRICTION = "joints.default.friction"


def run(case):
    kinds(case)
    by_words(case)
    inside(case)
    off_its_face(case)
    killed(case)
    flat(case)
    refused(case)


# ---- each sample is a run


def scenes():
    """(what, mesh, scene, columns, rows): the second row leaves the third something behind that it must not find."""
    water = [FRICTION, "loads.water.level"]
    rows = [(38, 5.5), (9, 6.5), (20, 6.0)]
    yield (
        "slip and broken bonds, explicit cycles",
        dam(),
        scene(STAGES, joints=WEAK),
        ["loads.water.level", "joints.default.cohesion"],
        [(6, 2e4), (7.9, 10.0), (5.9, 1.9e4)],
    )
    yield (
        "... by Newton's method, triangles, large strain",
        dam(triangles=True),
        scene(STAGES, joints=WEAK, relaxation=NEWTON, strain="large"),
        water,
        rows,
    )
    condensed = {"rock": STONE | {"condensed": True}, "low": STONE | {"condensed": True}, "high": STONE}
    yield (
        "condensed bodies",
        dam(),
        scene(STAGES, materials=condensed, relaxation=NEWTON),
        [*water, "joints.default.k_s"],
        [(*row, k) for row, k in zip(rows, (4e9, 4e9, 2e9), strict=True)],
    )
    yield (
        "a rigid part, a number of one stage, one of a pair",
        dam(rigid=True),
        scene(STAGES, strain="large", relaxation=NEWTON),
        ["stages.pushed.joints.default.friction", "loads.push.value[0]"],
        [(24, 6e4), (12, 7e4), (23, 5e4)],
    )
    one = scene(STAGES, relaxation=NEWTON)
    one["loads"]["uplift"] = {"type": "uplift", "faces": "foot", "level": 6, "rule": "linear", "cracked": True}
    for row in one["stages"][1:]:
        next(iter(row.values()))["loads"].append("uplift")
    yield "uplift in a crack", dam(), one, ["loads.uplift.level", FRICTION], [(6, 40), (7.8, 12), (5, 40)]
    one = scene(
        STAGES,
        relaxation=NEWTON,
        joints={
            "default": {"k_n": 1e10, "k_s": 4e9, "friction": 40},
            "base": {"aperture": 1e-4, "aperture_residual": 2e-5, "aperture_max": 1e-3},
        },
    )
    one["loads"] |= {"in": {"type": "head", "faces": "up", "level": 6}, "out": {"type": "head", "faces": "air", "level": 0}}
    for row in one["stages"][1:]:
        next(iter(row.values()))["loads"] += ["in", "out"]
    yield (
        "water that flows in a joint",
        dam(),
        one,
        ["loads.in.level", "joints.base.aperture"],
        [(6, 1e-4), (7, 2e-4), (6, 1.1e-4)],
    )
    anchored = scene([*BASE, {"lock": {"loads": ["weight", "water"]}}, {"pushed": {"loads": ["weight", "water", "push"]}}], relaxation=NEWTON, strain="large",
                     anchors={"a": {"head": [1, 7.5], "root": [2, -3], "area": 2e-3, "young": 2e11, "prestress": 4e5, "lock": "lock", "yield": 3e8}})  # fmt: skip
    yield "an anchor that is stressed", dam(), anchored, ["anchors.a.young", "anchors.a.prestress", FRICTION], [(2e11, 4e5, 40), (1e11, 1e5, 6), (1.9e11, 3e5, 40)]
    warm = scene(
        [*BASE, {"winter": {"loads": ["weight", "water", "cold"]}}],
        relaxation=NEWTON,
        materials={"rock": STONE, "low": STONE | {"expansion": 1e-5}, "high": STONE | {"expansion": 1e-5}},
    )
    warm["loads"]["cold"] = {"type": "temperature", "groups": ["low", "high"], "change": -15}
    yield "temperature", dam(), warm, ["loads.cold.change"], [(-15,), (-25,), (-14,)]
    soft = {"rock": STONE, "low": STONE | {"law": "mohr_coulomb", "cohesion": 4e4, "friction": 30, "tension": 1e4}, "high": STONE}
    yield (
        "blocks that yield",
        dam(),
        scene(STAGES, materials=soft, relaxation=NEWTON),
        ["loads.water.level"],
        [(6,), (7.9,), (5.9,)],
    )
    limit = {
        "type": "strength_reduction",
        "what": "friction",
        "loads": ["weight", "water"],
        "step": 5,
        "limit": 5,
        "bracket": 0.5,
    }
    yield (
        "trials, some of which do not stand at their start",
        dam(),
        scene([*BASE, {"limit": limit}], relaxation=NEWTON),
        ["stages.limit.start", "loads.water.level"],
        [(40, 6), (9, 6), (39, 5)],
    )
    flood = {"type": "flood", "loads": ["weight", "water"], "step": 1, "limit": 14, "bracket": 0.1}
    yield "a flood", dam(), scene([*BASE, {"flood": flood}], relaxation=NEWTON), [FRICTION], [(20,), (12,), (19,)]


def write_table(folder, columns, rows, name="table.csv"):
    lines = [
        ",".join(["sample", *columns]),
        *(
            ",".join([f"s{i}", *(repr(float(value)) for value in row), *["" for column in columns if column.startswith("tell:")]])
            for i, row in rows
        ),
    ]
    (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def started(case, folder, *options, **more):
    return subprocess.run(
        [case.quoin, "-options_file", "scene.yaml", *options],
        cwd=folder,
        capture_output=True,
        text=True,
        env=ENVIRONMENT | dict(os.environ),
        timeout=300,
        check=False,
        **more,
    )


def results_of(folder, out="out"):
    with open(folder / out / "samples.csv", encoding="utf-8", newline="") as file:
        return {row["sample"]: row for row in csv.DictReader(line for line in file if not line.startswith("#"))}


def same(ours, expected):
    """The first cell that differs; times may."""
    if sorted(ours) != sorted(expected):
        return f"samples {list(ours)}"
    return next(
        (
            f"{name}: {key}: {row[key]}"
            for name, row in ours.items()
            for key in row
            if key != "seconds" and row[key] != expected[name][key]
        ),
        "same",
    )


def words_of(columns, row):
    return [
        word for column, value in zip(columns, row, strict=False) for word in ("-" + column.replace(".", "_"), repr(float(value)))
    ]


def alone(case, folder, columns, row, out, *options):
    """(outcome, stage, stable, failing, checksum) of a run of its own, and its last stage."""
    done = started(case, folder, *words_of(columns, row), *options, "-output", out)
    if done.returncode == 2 and "does not stand at its start" in done.stderr:
        return ["fails"], {"warned": warnings_of(done)}
    stage = json.loads((folder / out / "summary.json").read_text(encoding="utf-8"))["stages"][-1]
    trials = next((stage[kind] for kind in ("strength_reduction", "flood") if kind in stage), {})
    return [
        OUTCOMES.get(stage["verdict"], "undecided"),
        stage["name"],
        trials.get("stable"),
        trials.get("failing"),
        stage.get("checksum_kept", stage["checksum"]),
        VERDICTS[done.returncode],
    ], stage | {"warned": warnings_of(done)}


def warnings_of(done):
    # that loads of the scene and mesh fit together is looked at once, for the numbers of the file
    once = "expected the level of the water of the stage"
    said = [line.removeprefix("quoin: ") for line in (done.stdout + done.stderr).splitlines() if once not in line]
    return sorted({line.removeprefix("warning: ").replace(",", ";") for line in said if line.startswith("warning: ")})


def number(text):
    return float(text) if text else None


def kinds(case):
    told_of = set()
    for what, mesh, one, columns, rows in scenes():
        folder = case.prepare(mesh, one)
        write_table(folder, columns, list(enumerate(rows)))
        done = started(case, folder, "-samples", "table.csv")
        case.check(f"{what}: exit code, lines of errors beside warnings", [done.returncode, done.stderr.count("error")], [0, 0])
        found = results_of(folder)
        ours, expected, warned = [], [], []
        for i, row in list(enumerate(rows))[1:]:  # what nothing came before is one of the others
            told, stage = alone(case, folder, columns, row, f"alone_{i}")
            mine = found[f"s{i}"]
            texts = sorted(mine["warned"].split(" | ")) if mine["warned"] else []
            warned.append([texts == stage["warned"], int(mine["warnings"]) == len(texts)])
            told_of |= set(texts)
            expected.append(told[:5])
            ours.append(
                [mine["outcome"], mine["stage"], number(mine["stable"]), number(mine["failing"]), mine["checksum"]][
                    : len(told[:5])
                ]
            )
        case.check("... outcome, stage, bracket and checksum of runs of their own", ours, expected)
        case.check("... and their warnings", warned, [[True, True]] * len(warned))
        case.check("... no two are alike", len({row["checksum"] for row in found.values()}), len(rows))
        case.report("... that fail", sum(row["outcome"] == "fails" for row in found.values()), 1)
    case.check("kinds of warnings among them", len({text.partition(":")[2] for text in told_of}) > 3, True)
    case.report("... they are", len(told_of), 4)


def by_words(case):
    """Numbers of summary.json; another order; rows through a pipe; a sample that is bad input."""
    folder = case.prepare(dam(), scene(STAGES, relaxation=NEWTON))
    columns = [
        FRICTION,
        "loads.water.level",
        "tell:joints.default.sliding_factor_peak",
        "tell:max_displacement.value",
        "tell:joints.default.nothing",
    ]
    draw = np.random.default_rng(4)
    rows = [(draw.uniform(9, 20), draw.uniform(5, 7)) for _ in range(8)]
    write_table(folder, columns, list(enumerate(rows)))
    started(case, folder, "-samples", "table.csv")
    found = results_of(folder)
    told, expected = [], []
    for i in (0, 5):
        _, stage = alone(case, folder, columns[:2], rows[i], f"alone_{i}")
        stands = stage["verdict"] == "converged"
        expected.append(
            [
                stage["joints"]["default"]["sliding_factor_peak"] if stands else None,
                stage["max_displacement"]["value"] if stands else None,
                None,
            ]
        )
        told.append([number(found[f"s{i}"][path.partition(":")[2]]) for path in columns[2:]])
    case.check("numbers of the stage, to the last digit", told, expected)
    write_table(folder, columns, [(i, rows[i]) for i in (6, 2, 7, 0)], "other.csv")
    started(case, folder, "-samples", "other.csv", "-output", "other")
    other = results_of(folder, "other")
    case.check(
        "half of them in another order: the same rows",
        same(other, {name: row for name, row in found.items() if name in other}),
        "same",
    )
    piped = started(
        case, folder, "-samples", "/dev/stdin", "-output", "piped", input=(folder / "table.csv").read_text(encoding="utf-8")
    )
    lines = piped.stdout.split("\n")
    lines = lines[next(i for i, line in enumerate(lines) if line.startswith("sample,")) :]
    case.check(
        "through a pipe: the same rows",
        same({row["sample"]: row for row in csv.DictReader(line for line in lines if line)}, found),
        "same",
    )
    write_table(folder, columns[:2], [(5, rows[5])], "short.csv")
    text = (folder / "short.csv").read_text(encoding="utf-8").split("\n")
    (folder / "short.csv").write_text(f"{text[0]},until:full\n{text[1]},\n", encoding="utf-8")
    started(case, folder, "-samples", "short.csv", "-output", "short")
    _, stage = alone(case, folder, [*columns[:2]], rows[5], "alone_short", "-stages", "own,full")
    case.check(
        "up to a stage: its end",
        [results_of(folder, "short")["s5"][key] for key in ("stage", "checksum")],
        ["full", stage["checksum"]],
    )
    write_table(folder, columns[:1], [(0, (95,)), (1, (30,))], "bad.csv")
    done = started(case, folder, "-samples", "bad.csv", "-output", "bad")
    bad = results_of(folder, "bad")
    case.check(
        "bad input in a row is told there, the others run",
        [done.returncode, bad["s0"]["outcome"], "95.0 is out of range" in bad["s0"]["why"], bad["s1"]["outcome"]],
        [0, "refused", True, "stands"],
    )


def inside(case):
    """What is inside condensed bodies is found where a number asks for it, and where they may have turned too far to be condensed."""
    dams = {"rock": STONE | {"condensed": True}, "low": STONE | {"condensed": True}, "high": STONE | {"condensed": True}}
    folder = case.prepare(dam(), scene(BASE, materials=dams, relaxation=NEWTON, joints={"default": {"law": "elastic", "k_n": 1e10, "k_s": 4e9}}, strain="large"))
    columns = ["joints.default.k_n", "tell:max_displacement.value"]
    rows = [(1e10,), (1.3e6,), (9e9,)]
    write_table(folder, columns, list(enumerate(rows)))
    write_table(folder, columns[:1], list(enumerate(rows)), "plain.csv")
    started(case, folder, "-samples", "table.csv")
    started(case, folder, "-samples", "plain.csv", "-output", "plain")
    found, plain = results_of(folder), results_of(folder, "plain")
    done = started(case, folder, *words_of(columns, rows[1]), "-output", "turned")
    _, stage = alone(case, folder, columns[:1], rows[2], "alone")
    case.check("condensed bodies: a number of the inside", number(found["s2"]["max_displacement.value"]), stage["max_displacement"]["value"])
    case.check(
        "... one that turns too far is refused, as a run of its own is",
        [[row["outcome"], "has turned by" in row["why"]] for row in (found["s1"], plain["s1"])] + [done.returncode],
        [["refused", True], ["refused", True], 2],
    )
    case.check("... and without numbers of the inside the same", same(plain, {name: {key: row[key] for key in plain["s0"]} for name, row in found.items()}), "same")


def off_its_face(case):
    """A number that the set-up of loads refuses: reported in its row, and the next sample is as if it had not been."""
    one = scene(STAGES, relaxation=NEWTON)
    one["loads"]["ice"] = {"type": "ice", "faces": "up", "level": 5.5, "force": 1e4}
    one["stages"][1]["full"]["loads"].append("ice")
    folder = case.prepare(dam(), one)
    write_table(folder, ["loads.ice.level"], [(0, (5.5,)), (1, (99,)), (2, (5.5,))])
    started(case, folder, "-samples", "table.csv")
    found = results_of(folder)
    case.check("ice above the dam: refused, the next has the same bits as the one before", [found["s1"]["outcome"], found["s2"]["outcome"], found["s2"]["checksum"] == found["s0"]["checksum"]], ["refused", "stands", True])


# ---- a kill, and what is there already


def killed(case):
    folder = case.prepare(dam(), scene(STAGES, relaxation=NEWTON))
    draw = np.random.default_rng(5)
    rows = [(draw.uniform(9, 20), draw.uniform(5, 7)) for _ in range(60)]
    columns = [FRICTION, "loads.water.level"]
    write_table(folder, columns, list(enumerate(rows)))
    started(case, folder, "-samples", "table.csv", "-output", "whole")
    whole = results_of(folder, "whole")
    path = folder / "out" / "samples.csv"
    with subprocess.Popen(
        [case.quoin, "-options_file", "scene.yaml", "-samples", "table.csv"],
        cwd=folder,
        env=ENVIRONMENT | dict(os.environ),
        stdout=subprocess.DEVNULL,
    ) as process:
        while process.poll() is None and not (path.exists() and path.read_text(encoding="utf-8").count("\n") > 6):
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
    before = path.read_text(encoding="utf-8")
    path.write_text(before[: before.rindex("\n") - 7], encoding="utf-8")  # and a row that was cut
    again = started(case, folder, "-samples", "table.csv")
    text = path.read_text(encoding="utf-8")
    case.check(
        "after a kill: every sample once, as without",
        [text.count("\n"), same(results_of(folder), whole), again.returncode],
        [2 + len(rows), "same", 0],
    )
    case.check("... those that were there are kept as they are", text.startswith(before[: before.rindex("\n", 0, -8)]), True)
    last = started(case, folder, "-samples", "table.csv")
    case.check(
        "... and none is left to run", ["\n0 samples in" in last.stdout, path.read_text(encoding="utf-8") == text], [True, True]
    )
    write_table(folder, columns, [(3, (30.0, 6.0))])
    other = started(case, folder, "-samples", "table.csv")
    case.check(
        "a sample with other numbers",
        [other.returncode, "sample s3 has other numbers" in other.stderr, other.stderr.count("error")],
        [2, True, 1],
    )
    other = started(case, folder, "-samples", "table.csv", "-gravity", "9.8")
    case.check(
        "results of another scene",
        [other.returncode, "results of another table, scene or mesh" in other.stderr, other.stderr.count("error")],
        [2, True, 1],
    )


PEAK = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL); print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"


def flat(case):
    """Peak memory [kB] of some and of many samples, some of which fail, and some at the start of their trials. A factor of its own, 2.5 MB, is needed first by one
    of the first 320."""
    limit = {"type": "strength_reduction", "what": "friction", "loads": ["weight", "water"], "step": 5, "limit": 5}
    folder, peaks = case.prepare(dam(rigid=True), scene([*BASE, {"limit": limit}], relaxation=NEWTON)), []
    for n in (320, 960):
        write_table(
            folder,
            ["loads.water.level", "stages.limit.start"],
            [(i, (5 + 0.001 * i, 6 if i % 3 else 40)) for i in range(n)],
            f"{n}.csv",
        )
        command = [sys.executable, "-c", PEAK, case.quoin, "-options_file", "scene.yaml", "-samples", f"{n}.csv", "-output"]
        runs = [subprocess.run([*command, f"out_{n}_{k}"], cwd=folder, env=ENVIRONMENT | dict(os.environ), capture_output=True, text=True, check=True) for k in range(2)]
        peaks.append(min(int(run.stdout) for run in runs))  # what else runs on the machine can only add to it
    outcomes = {row["outcome"] for row in results_of(folder, "out_960_0").values()}
    case.report("peak memory of 960 samples over that of 320", peaks[1] / peaks[0], 1)
    case.check(
        "960 samples take no more memory than 320 (1.5 MB)", [peaks[1] - peaks[0] < 1500, outcomes], [True, {"stands", "fails"}]
    )


def refused(case):
    plain, words = scene(STAGES), "expected a number of joints, loads, anchors or stages"
    builds = [{"own": {"loads": ["weight"]}}, {"high": {"loads": ["weight"], "build": ["high"]}}]
    for what, one, table, message in (
        ("a material", plain, "sample,materials.low.young\n1,1e9\n", words),
        ("a word", plain, "sample,joints.default.law\n1,elastic\n", words),
        ("no such row", plain, "sample,stages.none.start\n1,3\n", words),
        ("no such stage", plain, f"sample,{FRICTION},until:none\n1,3,\n", "until:none: no such stage"),
        ("pivots in a file", plain, f"sample,{FRICTION}\npivot:1,40\n", "table.csv:2: pivot:1: pivots come through a pipe alone"),
        ("no header", plain, "1,2\n", "expected a header sample,<key>,.."),
        ("twice", plain, f"sample,{FRICTION},{FRICTION}\n1,2,3\n", f"column {FRICTION} twice"),
        ("loads in a file", plain, "sample,loads\n1,full\n", "table.csv: loads come through a pipe alone"),
        ("a rise without loads", plain, "sample,rise\n1,2\n", "table.csv: column rise without a column loads"),
        ("a short row", plain, f"sample,{FRICTION}\n1\n", "table.csv:2: expected the name of a sample and 1 cells"),
        ("lifts", scene(builds), f"sample,{FRICTION}\n1,40\n", "stages that build groups (build) need a run for each sample"),
        (
            "cases",
            scene([*BASE, {"last": {"from": "own", "loads": ["weight"]}}]),
            f"sample,{FRICTION}\n1,40\n",
            "(from) need a run for each sample",
        ),
        (
            "in time",
            scene([{"move": {"type": "dynamic", "loads": ["weight"], "duration": 0.01}}]),
            f"sample,{FRICTION}\n1,40\n",
            "stages in time and modes need a run for each sample",
        ),
    ):
        folder = case.prepare(dam(), one)
        (folder / "table.csv").write_text(table, encoding="utf-8")
        done = started(case, folder, "-samples", "table.csv")
        case.check(f"refused: {what}", [done.returncode, message in done.stderr, done.stderr.count("quoin: error")], [2, True, 1])
    two = case.again(case.prepare(dam(), plain), "-samples", "table.csv", ranks=2, short=True)
    case.check("refused: two ranks", [two.exit_code, "samples run on one rank each" in two.stderr], [2, True])
