"""Load cases that stand on their own (stages.<name>.from).

Each case of a scene that branches ends as in a scene that has its own stages only, one behind the other: with the same bits, whatever a
run must remember. What fails stops only what starts from it."""

import copy
import math

import numpy as np
from driver import changed, dump
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, split_triangles

WHAT = "load cases from an earlier stage: bits of a scene of that case alone, for each thing that a run remembers; cases that fail; ranks, restart, refusals"
SOURCE = "the same stages one behind the other, in scenes of their own"
BY = "Quoin itself, the same stages in other scenes"

RHO = 2400.0


def dam(triangles=False, rigid=False):
    """A dam of two parts, with a joint between them, on rock."""
    low, high = (quad_patch((0, y), (w0, y), (w1, y + 4), (0, y + 4), 4, 3, group=name) for y, w0, w1, name in ((0, 7, 5, "low"), (4, 5, 3, "high")))
    low = split_triangles(low) if triangles else low
    mesh = join([renamed(rectangle(-8, -6, 24, 6, 8, 2, group="rock"), {"bottom": "bottom", "base": "top"}),
                 renamed(low, {"up": "left", "foot": "bottom", "air": "right"}, {"toe": "bottom_right"}), renamed(high, {"up": "left"}, {"crest": "top_left"})])
    mesh.group_rigid[mesh.group_names.index("high")] = rigid
    return mesh


STONE = {"density": RHO, "young": 10e9, "poisson": 0.2}


def scene(stages, **more):
    return {
        "relaxation": {"tolerance": 1e-7, "velocity_tolerance": 1e-7, "method": "explicit", "ramp": 300}, "strain": "small",
        "materials": {"rock": STONE, "low": STONE, "high": STONE},
        "joints": {"default": {"k_n": 1e10, "k_s": 4e9, "friction": 40}}, "supports": {"bottom": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "up", "level": 6},
                  "high_water": {"type": "reservoir", "faces": "up", "level": 7.5}, "push": {"type": "point_force", "point": "crest", "value": [6e4, 0]}},
        "stages": copy.deepcopy(stages),
    } | more  # fmt: skip


def rows(stages):
    return [next(iter(row.items())) for row in stages]


def chain(stages, name):
    """The stages that a stage comes of and itself, one behind the other."""
    names, keys = [n for n, _ in rows(stages)], dict(rows(stages))
    found = []
    while name:
        found.insert(0, {name: {key: value for key, value in keys[name].items() if key != "from"}})
        at = names.index(name)
        name = keys[name].get("from") or (names[at - 1] if at else None)
    return found


def answers(result, name):
    """What a stage ends with: state, stresses, joints, and its report."""
    stage, said = result.stage(name), result.stage_summary(name)
    told = without_times({key: said[key] for key in said if key != "from"})
    contacts = [getattr(stage.contacts, key).tobytes() for key in ("slip", "opening", "state")] if stage.contacts is not None else []
    return stage.displacement.tobytes(), stage.stress.tobytes(), contacts, told


def without_times(said):
    if isinstance(said, list):
        return [without_times(item) for item in said]
    return {key: without_times(item) for key, item in said.items() if key != "wall_s"} if isinstance(said, dict) else said


LONG = ("ranks_and_restart",)  # parts that the short form leaves out


def run(case):
    kinds(case)
    fails(case)
    ranks_and_restart(case)
    joints_of(case)
    appended(case)
    refused(case)


# ---- whatever a run remembers

BASE = [{"own": {"loads": ["weight"]}}, {"full": {"loads": ["weight", "water"]}}]
PUSHED = {"pushed": {"from": "full", "loads": ["weight", "water", "push"]}}
FLOODED = {"flooded": {"from": "full", "loads": ["weight", "high_water"]}}
EMPTY = {"empty": {"from": "own", "loads": ["weight", "push"]}}


def scenes():
    """(what, mesh, scene): each with cases that leave something behind which the next case must not find."""
    stages = [*BASE, PUSHED, FLOODED, EMPTY]
    weak = {"default": {"k_n": 1e10, "k_s": 4e9, "friction": 26, "friction_residual": 20, "cohesion": 2e4, "cohesion_residual": 0, "tension": 1e4}}
    yield "slip and broken bonds", dam(), scene(stages, joints=weak)
    yield "... triangles, large strain", dam(triangles=True), scene(stages, joints=weak, strain="large")
    yield "a rigid part", dam(rigid=True), scene(stages, strain="large")
    variable = {"connectivity": "variable", "tolerance": 0.02}
    yield "connectivity that is variable", dam(rigid=True), scene(stages, strain="large", contact=variable, joints={"default": {"k_n": 1e9, "k_s": 4e8, "friction": 30}})
    condensed = {"rock": STONE | {"condensed": True}, "low": STONE, "high": STONE}
    yield "condensed bodies", dam(), scene(stages, materials=condensed)
    one = scene(stages)
    one["loads"] |= {"uplift": {"type": "uplift", "faces": "foot", "level": 6, "rule": "linear", "cracked": True},
                     "high_uplift": {"type": "uplift", "faces": "foot", "level": 7.5, "rule": "linear", "cracked": True}}  # fmt: skip
    for _, keys in rows(one["stages"][1:]):
        keys["loads"] = [*keys["loads"], "high_uplift" if "high_water" in keys["loads"] else "uplift"]
    yield "uplift in a crack", dam(), one
    one = scene(stages, joints={"default": {"k_n": 1e10, "k_s": 4e9, "friction": 40}, "base": {"aperture": 1e-4, "aperture_residual": 2e-5, "aperture_max": 1e-3}})
    one["loads"] |= {"in": {"type": "head", "faces": "up", "level": 6}, "in_high": {"type": "head", "faces": "up", "level": 7.5}, "out": {"type": "head", "faces": "air", "level": 0}}
    for _, keys in rows(one["stages"][1:4]):
        keys["loads"] = [*keys["loads"], "out", "in_high" if "high_water" in keys["loads"] else "in"]
    yield "water that flows in a joint", dam(), one
    one = changed(scene(stages), ("loads.back", {"type": "traction", "faces": "up", "value": [2e4, -1e3]}))
    one["stages"] = [*BASE, {"back": {"from": "full", "loads": ["weight", "back"]}}, EMPTY,
                     {"later": {"from": "back", "loads": ["weight"]}}, {"last": {"from": "own", "loads": ["weight", "back"]}}]  # fmt: skip
    yield "loads that go, a case of a case", dam(), one
    anchored = scene([*BASE, {"lock": {"loads": ["weight", "water"]}}, {"shaken": {"type": "dynamic", "from": "lock", "loads": ["weight", "water"], "duration": 0.02, "alpha": 3}},
                      {"without": {"from": "full", "loads": ["weight", "high_water"]}}, {"more": {"from": "lock", "loads": ["weight", "high_water", "push"]}}],
                     anchors={"a": {"head": [1, 7.5], "root": [2, -3], "area": 2e-3, "young": 2e11, "prestress": 4e5, "lock": "lock", "yield": 3e8},
                              "bar": {"head": [1.5, 5], "root": [1.5, 2], "area": 1e-3, "young": 2e11, "from": "without", "bond_stiffness": 1e9, "bond_strength": 3e4}})  # fmt: skip
    yield "anchors that are stressed, bars of one case", dam(), anchored
    lifts = [{"rock": {"loads": ["weight"]}}, {"first": {"loads": ["weight"], "build": ["low"]}}, {"second": {"loads": ["weight"], "build": ["high"], "displacements": "reset"}},
             {"wet": {"from": "first", "loads": ["weight", "water"]}}, {"late": {"loads": ["weight", "water"], "build": ["high"]}}, {"dry": {"from": "rock", "loads": ["weight"], "build": ["low", "high"]}}]  # fmt: skip
    yield "lifts that are placed in one case or another", dam(), scene(lifts)
    yield "... large strain", dam(triangles=True), scene(lifts, strain="large")
    warm = {"rock": STONE, "low": STONE | {"expansion": 1e-5}, "high": STONE | {"expansion": 1e-5}}
    one = scene([*BASE, {"winter": {"from": "full", "loads": ["weight", "water", "cold"]}}, FLOODED, {"spring": {"from": "winter", "loads": ["weight", "water"]}}], materials=warm)
    one["loads"]["cold"] = {"type": "temperature", "groups": ["low", "high"], "change": -15}
    yield "temperature", dam(), one
    soft = {"rock": STONE, "low": STONE | {"law": "mohr_coulomb", "cohesion": 4e4, "friction": 30, "tension": 1e4}, "high": STONE}
    yield "blocks that yield", dam(), scene([*BASE, PUSHED, FLOODED, EMPTY], materials=soft)
    cracks = {"rock": STONE, "low": STONE | {"law": "damage", "tension": 3e4, "fracture_energy": 20}, "high": STONE}
    yield "blocks that crack", dam(), scene([*BASE, PUSHED, FLOODED, EMPTY], materials=cracks)
    motions = [*BASE, {"shake": {"type": "dynamic", "from": "full", "loads": ["weight", "water"], "duration": 0.03, "beta": 1e-4}},
               {"again": {"type": "dynamic", "loads": ["weight", "water"], "duration": 0.02}}, {"after": {"from": "shake", "loads": ["weight", "high_water"]}},
               {"other": {"type": "dynamic", "from": "full", "loads": ["weight", "water"], "duration": 0.02}}]  # fmt: skip
    quiet = {"bottom": {"boundary": "quiet", "motion": "pulse", "fix": "xy"}}
    pulse = {"pulse": {"file": "pulse.csv", "quantity": "velocity", "direction": "x"}}
    yield "motion in time, quiet ground", dam(), scene(motions, supports=quiet, motions=pulse)
    moved = {"bottom": {"fix": "xy", "motion": "pulse"}}
    yield "a support that moves", dam(), scene(motions, supports=moved, motions=pulse, joints=weak)
    trials = [*BASE, {"limit": {"type": "strength_reduction", "from": "full", "loads": ["weight", "water"], "step": 5, "limit": 20}},
              {"flood": {"type": "flood", "from": "full", "loads": ["weight", "water"], "step": 1, "limit": 9}}, {"small": {"type": "modes", "from": "own", "loads": [], "count": 3}},
              {"pulled": {"from": "small", "loads": ["weight", "push"]}}]  # fmt: skip
    yield "trials and modes", dam(), scene(trials)


def prepared(case, mesh, one):
    """A folder with the record that shakes it."""
    folder = case.prepare(mesh, one)
    (folder / "pulse.csv").write_text("".join(f"{t:.4f} {0.02 * math.sin(200 * t):.8f}\n" for t in np.linspace(0, 0.06, 200)))
    return folder


def kinds(case):
    for what, mesh, one in scenes():
        result = case.again(prepared(case, mesh, one))
        stages = one["stages"]
        case.check(f"{what}: all stages stand", [result.exit_code, {s["verdict"] for s in result.summary["stages"]} <= {"converged", "completed"}, list(result.stages)],
                   [0, True, [name for name, _ in rows(stages)]])
        names = [name for name, _ in rows(stages)]
        parents = {keys.get("from", names[i - 1]) for i, (_, keys) in enumerate(rows(stages)) if i}
        for name in names:
            if name in parents:
                continue
            known = {n for row in chain(stages, name) for n in row}
            alone = changed(one, ("stages", chain(stages, name)))
            if "in" in one["loads"] and not any("out" in keys["loads"] for _, keys in rows(alone["stages"])):
                # water that never flows in a scene has no part in checksums: here it flows in the last stage
                alone["stages"].append({"wet": dict(rows(stages))["full"] | {"from": name}})
            if "anchors" in one:
                alone["anchors"] = {a: keys for a, keys in one["anchors"].items() if keys.get("lock", keys.get("from")) in known}
            line = case.again(prepared(case, mesh, alone))
            same = [answers(result, n)[:3] == answers(line, n)[:3] for n in known]
            case.check(f"... {name}: the bits of a scene of {', '.join(n for row in chain(stages, name) for n in row)} alone", same, [True] * len(known))
            ours, theirs = answers(result, name)[3], answers(line, name)[3]
            others = ("anchors", "checksum") if "anchors" in one else ()  # the whole scene has anchors that the chain alone has not
            differ = sorted(key for key in ours if key not in others and ours[key] != theirs[key])
            case.check(f"... {name}: the same is said of it", differ, [])


# ---- cases that fail


def failing():
    stages = [*BASE, {"too_high": {"from": "full", "loads": ["weight", "flood"]}}, {"then": {"loads": ["weight"]}}, {"behind": {"from": "then", "loads": ["weight", "water"]}},
              FLOODED, {"short": {"from": "own", "loads": ["weight", "push"], "max_cycles": 60}}, EMPTY]  # fmt: skip
    one = scene(stages, joints={"default": {"k_n": 1e10, "k_s": 4e9, "friction": 30}})
    one["loads"]["flood"] = {"type": "reservoir", "faces": "up", "level": 25}
    return one


def fails(case):
    one = failing()
    folder = case.prepare(dam(), one)
    result = case.again(folder)
    verdicts = {s["name"]: s["verdict"] for s in result.summary["stages"]}
    case.check("verdicts: what does not start from a case that failed runs", verdicts,
               {"own": "converged", "full": "converged", "too_high": "collapsed", "flooded": "converged", "short": "undecided", "empty": "converged"})
    case.check("... stages that were not run; exit code: of the first case that failed", [result.summary["not_run"], result.exit_code], [["then", "behind"], 6])
    case.check("... results have the same stages", list(result.stages), list(verdicts))
    lines = result.stdout
    case.check("... what is said", ["stage then         is not run: stage too_high, from which it starts, has failed" in lines,
                                    "cases that do not stand: too_high collapsed, then not run, behind not run, short undecided; 4 of 8 stages stand" in lines], [True, True])
    for name in ("flooded", "empty"):
        alone = case.run(dam(), changed(one, ("stages", chain(one["stages"], name))))
        case.check(f"... {name} is what it is without them", answers(result, name) == answers(alone, name), True)
    good = case.run(dam(), changed(one, ("stages", [*BASE, FLOODED])))
    case.check("no case fails: nothing is said of cases, no stage is missing", ["cases" in good.stdout, "not_run" in good.summary, good.exit_code], [False, False, 0])
    first = case.run(dam(), changed(one, ("stages", [{"own": {"loads": ["weight", "flood"]}}, {"a": {"from": "own", "loads": ["weight"]}}, {"b": {"from": "own", "loads": ["weight"]}}])))
    case.check("the first stage fails: no other runs", [first.exit_code, list(first.stages), first.summary["not_run"]], [6, ["own"], ["a", "b"]])


def ranks_and_restart(case):
    """The same bits on 1 to 4 ranks; restarts from everywhere, between cases and within them."""
    one = changed(failing(), ("checkpoint", {"every": 150, "keep": 1000}), ("joints.default.friction", 30))
    folder = case.prepare(dam(), one)
    first = case.again(folder)
    case.again(folder, "-output", "kept")

    def said(result):
        return [[s[key] for key in ("name", "verdict", "checksum", "cycles")] for s in result.summary["stages"]] + result.summary["not_run"] + [result.exit_code]
    for ranks in case.ranks(2, 3, 4):
        result = case.run(dam(), one, ranks=ranks)
        case.check(f"the same on {ranks} ranks", said(result) == said(first), True)
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    for i, at in enumerate(np.linspace(1, len(kept) - 1, 9).astype(int)):
        again = case.again(folder, "-restart", kept[at], ranks=1 + i % 2)
        case.check(f"restart from checkpoint {at} of {len(kept)}: the same", said(again) == said(first), True)
        case.check("... results too", [answers(again, name)[:3] == answers(first, name)[:3] for name in first.stages], [True] * len(first.stages))
    variable = changed(one, ("strain", "large"), ("contact", {"connectivity": "variable", "tolerance": 0.02}), ("partition", "stripes"))
    a, b = case.run(dam(), variable), case.run(dam(), variable, ranks=2)
    case.check("variable connectivity: the same on 2 ranks", said(a) == said(b), True)


def joints_of(case):
    """A case has the joints of the stage from which it starts, not those of the case before it."""
    weak = {"default": {"friction": 33}}
    stages = [*BASE, {"weaker": {"loads": ["weight", "water"], "joints": weak}}, {"still": {"loads": ["weight", "water"]}},
              {"firm": {"from": "full", "loads": ["weight", "water"]}}, {"soft": {"from": "still", "loads": ["weight", "water"], "joints": {"default": {"cohesion": 1e5}}}}]
    result = case.run(dam(), scene(stages))
    limits = {name: result.stage_summary(name)["joints"]["default"]["sliding_factor_peak"] for name in result.stages}
    tangent = math.tan(math.radians(33)) / math.tan(math.radians(40))
    case.check("factors of sliding after weakening: in its case, and not in the next one", [limits["still"] / limits["full"], limits["firm"] / limits["full"]], [tangent, 1.0], relative=2e-3)
    case.check("... cohesion on top of it", limits["soft"] > limits["still"], True)
    echo = (case.folder / f"run_{case.runs:03d}" / "out" / "scene_echo.yaml").read_text()
    folder = case.prepare(dam(), echo)
    again = case.again(folder, "-output", "out")
    case.check("... scene_echo.yaml is the same scene", [s["checksum"] for s in again.summary["stages"]], [s["checksum"] for s in result.summary["stages"]])


def appended(case):
    """A case that is added later goes on from the last checkpoint, where that has what it starts from."""
    folder = case.prepare(dam(), scene([*BASE, PUSHED]))
    case.again(folder)
    whole = scene([*BASE, PUSHED, FLOODED])
    (folder / "scene.yaml").write_text(dump(whole))
    try:
        said = case.again(folder, "-restart", "auto").stderr
    except RuntimeError as error:  # exit code 10
        said = str(error)
    case.check("a checkpoint without the stage that a new case starts from is refused",
               ["exit code 10" in said, "has not kept the end of stage full, from which stage flooded starts" in said], [True, True])
    more = scene([*BASE, PUSHED, {"last": {"from": "pushed", "loads": ["weight"]}}, {"other": {"from": "pushed", "loads": ["weight", "water"]}}])
    (folder / "scene.yaml").write_text(dump(more))
    result, wanted = case.again(folder, "-restart", "auto"), case.run(dam(), more)
    case.check("cases that start from the last end are added", [s["checksum"] for s in result.summary["stages"]], [s["checksum"] for s in wanted.summary["stages"]])


def refused(case):
    for stages, words in (
        ([{"own": {"loads": ["weight"], "from": "full"}}, *BASE[1:]], "scene.yaml:22: stages.own.from: no stage named 'full' before it; stages before it: none"),
        ([*BASE, {"last": {"from": "fall", "loads": ["weight"]}}], "stages.last.from: no stage named 'fall' before it; stages before it: own, full"),
        ([*BASE, {"last": {"from": "last", "loads": ["weight"]}}], "stages.last.from: no stage named 'last' before it"),
    ):  # fmt: skip
        result = case.run(dam(), scene(stages))
        case.check(f"refused: {words}", [result.exit_code, words.partition(": ")[2] in result.stderr, result.stderr.count("\n")], [2, True, 1])
