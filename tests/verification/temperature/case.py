"""Blocks that become warmer or colder: free, held, in a row with joints, bent by a gradient, through a winter.

By hand: thermal strain of plane strain (1 + nu) alpha T, springs in series, the wave of the year in a half space."""

import math

import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import outer_faces
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, split_triangles

WHAT = "temperature: free and held blocks, a row with joints, a gradient, the wave of the year, trials, motion in time (M07)"
SOURCE = "thermal strain by hand, springs in series, half space with a periodic surface"
BY = "by hand"

E, NU, ALPHA, T = 20e9, 0.2, 1e-5, 15.0
STONE = {"density": 2400.0, "young": E, "poisson": NU, "expansion": ALPHA}
DEPTH = math.sqrt(1.1e-6 * 365.25 * 86400 / math.pi)  # 3.3241 m


def scene(change=-T, **more):
    return {
        "relaxation": {"tolerance": 1e-12, "velocity_tolerance": 1e-12, "method": "explicit"}, "strain": "small",
        "materials": {"stone": STONE}, "joints": {"default": {"k_n": 1e10, "k_s": 1e10, "friction": 45}},
        "supports": {"pin": {"target": "bottom_left", "fix": "xy"}, "roller": {"target": "bottom_right", "fix": "y"}},
        "loads": {"warm": {"type": "temperature", "change": change}}, "stages": [{"winter": {"loads": ["warm"]}}],
    } | more  # fmt: skip


FORMULATIONS = {"full": {}, "bending": {"element": "bending"}, "reduced": {"element": "reduced"}, "condensed": {"condensed": True}}


def block(triangles=False):
    """Blocks that are no rectangles, so that a mistake in a gradient shows."""
    mesh = rectangle(0, 0, 4, 2, 4, 2, group="stone")
    inner = (mesh.vertices > [0, 0]).all(axis=1) & (mesh.vertices < [4, 2]).all(axis=1)
    mesh.vertices[inner] += 0.2 * np.sin(7 * mesh.vertices[inner][:, ::-1])
    return split_triangles(mesh) if triangles else mesh


LONG = ("ranks_and_restart",)  # parts that the short form leaves out


def run(case):
    alone(case)
    row(case)
    gradient(case)
    fields(case)
    several(case)
    trials(case)
    in_time(case)
    anchored(case)
    ranks_and_restart(case)


def stretch(strain, measure):
    """Displacement over length of a block whose strain is that of the measure."""
    return strain if measure == "small" else math.sqrt(1 + 2 * strain) - 1


def alone(case):
    """Free: (1 + nu) alpha T and no stress but across; held along x: E alpha T/(1 - nu); plane stress; by Newton's method too."""
    for triangles in (False, True):
        for name, keys in FORMULATIONS.items():
            if triangles and name in ("bending", "reduced"):
                continue
            for measure in ("small", "large"):
                for method in ("explicit", "preconditioned"):
                    what = f"{'triangles' if triangles else 'blocks'}, {name}, {measure} strain, {method}"
                    one = changed(scene(), ("strain", measure), ("relaxation.method", method), ("materials.stone", STONE | keys))
                    result = case.run(block(triangles), one)
                    free = result.stage("winter")
                    top = np.array(result.probe("winter", "top_right"))
                    e = stretch(-ALPHA * T * (1 + NU), "small" if name == "condensed" else measure)
                    case.check(f"free, {what}: ux, uy of a corner [m]", top, [4 * e, 2 * e], relative=1e-6)
                    case.check("... stress over E alpha T", free.gauss_stress[np.isfinite(free.gauss_stress)] / (E * ALPHA * T), 0.0, absolute=1e-6)
                    case.check("... stress across [Pa]", free.stress_z, 3e6, relative=1e-6)
                    case.check("... strain energy [J]: that stress along alpha T", result.stage_summary("winter")["energy"]["strain"], 0.5 * 3e6 * ALPHA * T * 8, relative=2e-4 if measure == "large" else 1e-6)
    for measure in ("small", "large"):
        held = changed(scene(), ("strain", measure), ("supports", {"left": {"fix": "x"}, "right": {"fix": "x"}, "pin": {"target": "bottom_left", "fix": "y"}}))
        result = case.run(block(), held)
        now = result.stage("winter")
        relative = 1e-6 if measure == "small" else 1e-3  # Cauchy stress is that of the block as it is
        case.check(f"held along x, {measure} strain: sxx, szz [Pa]", [now.stress[:, 0], now.stress_z], 3.75e6, relative=relative)
        case.check("... uy of a corner [m]", result.probe("winter", "top_right")[1], 2 * stretch(-2.25e-4, measure), relative=1e-4 if measure == "large" else 1e-6)
        case.check("... reactions [N]", result.stage_summary("winter")["supports"]["right"]["x"], 3.75e6 * 2, relative=relative)
    result = case.run(block(), changed(scene(), ("plane", "stress"), ("supports", {"left": {"fix": "x"}, "right": {"fix": "x"}, "pin": {"target": "bottom_left", "fix": "y"}})))
    case.check("held along x, plane stress: sxx [Pa]", result.stage("winter").stress[:, 0], E * ALPHA * T, relative=1e-6)
    case.check("... energy [J]", result.stage_summary("winter")["energy"]["strain"], 0.5 * E * (ALPHA * T) ** 2 * 8, relative=1e-6)
    case.check("... summary: least and largest change [K]", list(result.stage_summary("winter")["temperature"].values()), [-T, -T])
    back = changed(scene(), ("stages", [{"winter": {"loads": ["warm"]}}, {"spring": {"loads": []}}]))
    for method in ("explicit", "preconditioned"):
        result = case.run(block(), changed(back, ("relaxation.method", method)))
        case.check(f"warm again, {method}: nothing is left, [m] and [Pa]", [np.abs(result.probe("spring", "top_right")).max(), np.abs(result.stage("spring").stress_z).max()], 0.0, absolute=1e-4)


def row(case):
    """Six blocks between fixed ends: seven joints in series with them; in the cold they open."""
    ends = [rectangle(-1, 0, 1, 2, group="end", rigid=True), rectangle(12, 0, 1, 2, group="end", rigid=True)]
    for triangles in (False, True):
        body = [rectangle(2 * i, 0, 2, 2, 2, 2, group="stone") for i in range(6)]
        mesh = join([renamed(m, {}, {}) for m in ([split_triangles(b) for b in body] if triangles else body)] + [renamed(e, {}, {}) for e in ends])
        for measure in ("small", "large"):
            for method in ("explicit", "preconditioned"):
                one = changed(scene(T), ("strain", measure), ("relaxation.method", method), ("materials.end", {"density": 2400.0, "rigid": True}), ("supports", {"end": {"fix": "xy"}}),
                              ("joints.default", {"k_n": 1e10, "k_s": 1.0, "law": "elastic"}))  # fmt: skip
                one["loads"]["warm"]["groups"] = ["stone"]
                result = case.run(mesh, one)
                now = result.stage("winter")
                relative = 1e-6 if measure == "small" else 5e-4
                what = f"row, {'triangles' if triangles else 'blocks'}, {measure} strain, {method}"
                case.check(f"{what}: sxx, szz [Pa]", [np.nanmean(now.stress[:, 0]), np.nanmean(now.stress_z)], [-1.69279e6, -3.33856e6], relative=max(relative, 2e-6))
                case.check("... closure of each joint [m]", -now.contacts.opening, 0.169279e-3, relative=max(relative, 3e-6))
    cold = changed(one, ("strain", "small"), ("relaxation", {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "method": "explicit", "allow_floating": True}),
                   ("joints.default", {"k_n": 1e10, "k_s": 1e10, "friction": 30}), ("loads.warm.change", -T))  # fmt: skip
    # blocks that joints let go of are held at their middles, so that they stay in the row
    middles = join([renamed(rectangle(2 * i, 0, 2, 2, 2, 2, group="stone"), {}, {}) for i in range(6)] + [renamed(e, {}, {}) for e in ends])
    for i in range(6):
        middles.points[f"m{i}"] = int(np.flatnonzero(np.all(np.isclose(middles.vertices, [2 * i + 1, 1]), axis=1))[0])
    cold["supports"] |= {f"m{i}": {"fix": "xy"} for i in range(6)}
    result = case.run(middles, cold)
    now = result.stage("winter")
    levels = {}
    for x, gap in zip(now.contacts.point[..., 0].ravel(), now.contacts.opening.ravel(), strict=True):
        levels.setdefault(round(float(x), 3), set()).add(gap)
    case.check("in the cold: the gaps [m], together", sum(max(g) for g in levels.values()), 2.16e-3, relative=1e-6)
    case.check("... sxx over E alpha T", np.nanmax(np.abs(now.stress[:, 0])) / (E * ALPHA * T), 0.0, absolute=1e-6)


def gradient(case):
    """10 K over 4 m: a free column bends, without stress within the plane; a bending block does so exactly, the others as the mesh becomes finer."""
    (case.folder / "gradient.csv").write_text("x, y, change\n0, 0, 5\n4, 0, -5\n0, 30, 5\n4, 30, -5\n2, 11, 0\n")
    points = {"type": "temperature", "points": str(case.folder / "gradient.csv")}
    supports = {"pin": {"target": "bottom_left", "fix": "xy"}, "roller": {"target": "bottom_right", "fix": "y"}}
    errors = {"full": [], "triangles": [], "bending": []}
    for n in (1, 2, 4, 8):
        mesh = renamed(rectangle(0, 0, 4, 30, 2 * n, 15 * n, group="stone"), {}, {})
        mesh.points |= {"bottom_left": 0, "bottom_right": 2 * n, "top_left": int(np.flatnonzero((mesh.vertices == [0, 30]).all(axis=1))[0])}
        mesh.points["bottom_left"], mesh.points["bottom_right"] = (int(np.flatnonzero((mesh.vertices == at).all(axis=1))[0]) for at in ([0, 0], [4, 0]))
        for name in errors:
            keys = {"element": "bending"} if name == "bending" else {}
            result = case.run(split_triangles(mesh) if name == "triangles" else mesh, changed(scene(), ("loads.warm", points), ("materials.stone", STONE | keys), ("supports", supports), ("relaxation.method", "preconditioned")))
            found = result.probe("winter", "top_left")[0]
            errors[name].append(abs(found / 13.5e-3 - 1))
            stress = np.abs(result.stage("winter").gauss_stress)
            if name == "bending" and n == 1:
                case.check("gradient: ux at 30 m [m]", found, 13.5e-3, relative=1e-6)
                case.check("... stress over E alpha 5 K", np.nanmax(stress) / (E * ALPHA * 5), 0.0, absolute=1e-6)
                case.check("... energy [J]: that across alone", result.stage_summary("winter")["energy"]["strain"], 0.5 * E * ALPHA**2 * 120 * 25 / 3 * (1 - 1 / 4), relative=1e-6)
    for name in ("full", "triangles"):
        case.check(f"... {name}: order of convergence of ux", math.log2(errors[name][-2] / errors[name][-1]), 2.0, absolute=0.25)


def fields(case):
    """The wave of the year as a load rule; points on a plane, on a line, beyond their range."""
    mesh = rectangle(0, -12, 6, 12, 6, 24, group="stone")
    supports = {"bottom": {"fix": "xy"}}
    for day in (0.0, 35.0, 182.625):
        one = changed(scene(), ("supports", supports), ("loads.warm", {"type": "temperature", "amplitude": 8.0, "mean": -3.0, "day": day, "faces": "top"}), ("relaxation.tolerance", 1e-6))
        found = case.run(mesh, one).stage("winter").temperature
        y = mesh.vertices[mesh.blocks][:, :, 1]
        wave = -3 + 8 * np.exp(y / DEPTH) * np.cos(2 * np.pi * day / 365.25 + y / DEPTH)
        case.check(f"wave, day {day:g}: change of each block [K]", found, wave.mean(axis=1), relative=1e-12)
    depths = np.array([2.0, 5.0, 10.0])
    case.check("... depth it reaches [m], what is left, days late at 2, 5, 10 m", [DEPTH, *np.exp(-depths / DEPTH), *depths / DEPTH * 365.25 / 2 / np.pi], [3.3241, 0.5479, 0.2222, 0.0494, 35.0, 87.4, 174.9], relative=1e-3)
    rng = np.random.default_rng(3)
    places = rng.uniform([0, -12], [6, 0], (40, 2))
    for name, rows, exact in (
        ("a plane of scattered points", np.column_stack([np.vstack([places, [[-1, -13], [7, -13], [7, 1], [-1, 1]]]), np.zeros(44)]), lambda x, y: 2 + 0.3 * x - 0.7 * y),
        ("a line of points", np.column_stack([np.full(9, 2.0), np.linspace(-12, 0, 9), np.zeros(9)]), lambda x, y: 2 - 0.7 * y),
        ("one point", np.array([[1.0, 1.0, 4.0]]), lambda x, y: 4 + 0 * x),
    ):  # fmt: skip
        rows[:, 2] = exact(rows[:, 0], rows[:, 1])
        np.savetxt(case.folder / "points.csv", rows, delimiter=",", fmt="%.17g")
        one = changed(scene(), ("supports", supports), ("loads.warm", {"type": "temperature", "points": str(case.folder / "points.csv")}), ("relaxation.tolerance", 1e-6))
        c = mesh.vertices[mesh.blocks].mean(axis=1)
        case.check(f"{name}: change of each block [K]", case.run(mesh, one).stage("winter").temperature, exact(c[:, 0], c[:, 1]), relative=1e-9)


def several(case):
    """Groups that share vertices, each with its own change; two loads at once; half a ramp. A column of both is free along y."""
    mesh = rectangle(0, 0, 2, 8, 2, 8, group="stone")
    mesh.group_names, mesh.group_rigid = ["stone", "brick"], np.zeros(2, np.int32)
    mesh.block_group = (mesh.vertices[mesh.blocks].mean(axis=1)[:, 1] > 4).astype(np.int32)
    soft = STONE | {"young": 5e9, "poisson": 0.0, "expansion": 2e-5}
    both = {"warm": {"type": "temperature", "groups": ["stone"], "change": 10}, "more": {"type": "temperature", "change": 4}}
    one = changed(scene(), ("materials", {"stone": STONE | {"poisson": 0.0}, "brick": soft}), ("loads", both), ("supports", {"bottom": {"fix": "y"}, "left": {"fix": "x"}, "right": {"fix": "x"}}),
                  ("stages", [{"one": {"loads": ["more"]}}, {"two": {"loads": ["warm", "more"]}}]))  # fmt: skip
    result = case.run(mesh, one)
    for stage, low in (("one", 4.0), ("two", 14.0)):
        case.check(f"two groups, stage {stage}: uy at the top [m]", result.probe(stage, "top_left")[1], 4 * ALPHA * low + 4 * 2e-5 * 4, relative=1e-6)
        now = result.stage(stage)
        case.check("... sxx of both [Pa]", [now.stress[mesh.block_group == g, 0].mean() for g in (0, 1)], [-E * ALPHA * low, -5e9 * 2e-5 * 4], relative=1e-6)


def trials(case):
    """A load factor multiplies temperatures: a row between fixed ends; stresses are those of the last stable trial."""
    ends = [renamed(rectangle(-1, 0, 1, 2, group="end", rigid=True), {}, {}), renamed(rectangle(4, 0, 1, 2, group="end", rigid=True), {}, {})]
    mesh = join([renamed(rectangle(0, 0, 4, 2, 4, 2, group="stone"), {}, {"mark": "top_left"})] + ends)
    loads = {"warm": {"type": "temperature", "groups": ["stone"], "change": T}, "push": {"type": "point_force", "point": "mark", "value": [0, 1.0]}}
    one = changed(scene(), ("materials.end", {"density": 2400.0, "rigid": True}), ("supports", {"end": {"fix": "xy"}, "mark": {"fix": "y"}}), ("joints.default", {"k_n": 1e10, "k_s": 1.0, "law": "elastic"}), ("loads", loads), ("relaxation", {"tolerance": 1e-8, "velocity_tolerance": 1e-8}),
                  ("stages", [{"factor": {"type": "load_factor", "loads": ["warm", "push"], "raises": ["warm"], "start": 2, "step": 1, "limit": 4}}]))  # fmt: skip
    result = case.run(mesh, one)
    now, facts = result.stage("factor"), result.stage_summary("factor")
    case.check("load factor to 4: change [K]", [facts["temperature"]["max"], facts["load_factor"]["stable"]], [4 * T, 4.0])
    C = (1 - NU**2) / E * 4  # of the blocks, free across
    closed = 4 * 4 * T * ALPHA * (1 + NU) / (C + 2 / 1e10)
    case.check("... mean force in the joints [N]", 0.5 * -now.contacts.force[..., 0].sum(), 2 * closed, relative=1e-6)


def in_time(case):
    """A change that comes at once in time shakes a bar: its end goes to twice the thermal strain and back; the account closes."""
    mesh = rectangle(0, 0, 10, 1, 20, 2, group="stone")
    for measure in ("small", "large"):
        one = changed(scene(), ("strain", measure), ("materials.stone", STONE | {"poisson": 0.0}), ("supports", {"left": {"fix": "xy"}}), ("relaxation.history_every", 1), ("plane", "stress"),
                      ("stages", [{"cold": {"type": "dynamic", "loads": ["warm"], "duration": 0.02, "dt_factor": 0.5}}]))  # fmt: skip
        result = case.run(mesh, one)
        h = result.history
        tip = h["bottom_right_ux_m"]
        case.check(f"in time, {measure} strain: the end reaches [m], at [s]", [tip.min(), h["time_s"][np.argmin(tip)]], [-2 * ALPHA * T * 10, 2 * 10 / math.sqrt(E / 2400)], relative=0.02)
        scale = 0.5 * E * (ALPHA * T) ** 2 * 10
        balance = h["balance_J"]
        case.check("... balance over the energy of the bar held", balance[np.isfinite(balance)] / scale, 0.0, absolute=1e-9 if measure == "small" else 2e-2)
        rest = changed(one, ("stages", [{"winter": {"loads": ["warm"]}}, {"still": {"type": "dynamic", "loads": ["warm"], "duration": 0.01, "dt_factor": 0.5}}]))
        result = case.run(mesh, rest)
        case.check("... from rest it stays: drift over alpha T L", (result.probe("still", "bottom_right")[0] - result.probe("winter", "bottom_right")[0]) / (ALPHA * T * 10), 0.0, absolute=1e-6)


def anchored(case):
    """Soft ties in a block that is free to shrink: their ends move with it, their steel stays as warm as it was. A grouted bar is strained all along."""
    e, k, spring = -ALPHA * T * (1 + NU), 1e3, 1e4
    (x0, y0), (x1, y1) = (0.3, 0.2), (3.7, 1.8)
    length = math.hypot(x1 - x0, y1 - y0)
    ties = {"bar": {"head": [x0, y0], "root": [x1, y1], "area": k * length / 200e9, "young": 200e9, "compression": True},
            "tendon": {"head": [x0, y0], "root": [x1, y1], "area": k * length / 200e9, "young": 200e9, "prestress": 1e4, "lock": "lock"},
            "bonded": {"head": [x0, y0], "root": [x1, y1], "area": spring / 200e9, "young": 200e9, "bond_stiffness": 16 * spring, "segment": 0.02}}  # fmt: skip
    stages = [{"lock": {"loads": ["none"]}}, {"winter": {"loads": ["warm"]}}]
    loads = {"warm": {"type": "temperature", "change": -T}, "none": {"type": "temperature", "change": 0}}
    for name, keys in (("full", {}), ("condensed", {"condensed": True})):
        for measure in ("small", "large"):
            for method in ("explicit", "preconditioned"):
                one = changed(scene(stages=stages, loads=loads, anchors=ties), ("strain", measure), ("relaxation.method", method), ("materials.stone", STONE | keys))
                result = case.run(rectangle(0, 0, 4, 2, 8, 6, group="stone") if name == "condensed" else block(), one)
                lock, winter = (result.stage_summary(stage)["anchors"] for stage in ("lock", "winter"))
                what = f"ties in a block that shrinks, {name}, {measure} strain, {method}"
                case.check(f"{what}: bar, and what a tendon loses [N]", [winter[tie]["force"] - lock[tie]["force"] for tie in ("bar", "tendon")], [k * e * length] * 2, relative=1e-3 if measure == "large" else 2e-6)
                case.check("... a grouted bar in the middle, ends free [N]", winter["bonded"]["force"] - lock["bonded"]["force"], spring * e * (1 - 1 / math.cosh(4 * length / 2)), relative=2e-3)


def wall():
    """A wall of two bodies on a rock, quadrilaterals and triangles."""
    lower, upper = (quad_patch((0, y), (w0, y), (w1, y + 4), (0, y + 4), 6, 4, group="stone") for y, w0, w1 in ((0, 6, 4.5), (4, 4.5, 3)))
    mesh = join([renamed(rectangle(-6, -6, 18, 6, 9, 3, group="rock"), {"bottom": "bottom"}), renamed(split_triangles(lower), {}), renamed(upper, {}, {"crest": "top_left"})])
    faces = outer_faces(mesh)
    mesh.face_sets["air"] = faces[mesh.block_group[faces[:, 0]] == mesh.group_names.index("stone")]
    return mesh


def ranks_and_restart(case):
    mesh = wall()
    (case.folder / "wall.csv").write_text("0 0 3\n6 0 -2\n0 8 -4\n3 8 -6\n")
    loads = {"weight": {"type": "self_weight"}, "warm": {"type": "temperature", "groups": ["stone"], "amplitude": 12, "day": 170, "faces": "air"}, "measured": {"type": "temperature", "points": str(case.folder / "wall.csv")}}
    stages = [{"own": {"loads": ["weight"]}}, {"winter": {"loads": ["weight", "warm"]}}, {"measured": {"loads": ["weight", "measured"]}},
              {"factor": {"type": "load_factor", "loads": ["weight", "warm"], "raises": ["warm"], "start": 1, "step": 1, "limit": 3}},
              {"shake": {"type": "dynamic", "loads": ["weight", "warm"], "duration": 0.01, "dt_factor": 0.3}}]  # fmt: skip
    for measure in ("small", "large"):
        one = changed(scene(), ("strain", measure), ("materials.rock", STONE | {"young": 1e10, "expansion": 8e-6}), ("supports", {"bottom": {"fix": "xy"}}), ("loads", loads), ("stages", stages),
                      ("relaxation", {"tolerance": 1e-6, "velocity_tolerance": 1e-6, "method": "explicit"}), ("checkpoint", {"every": 300, "keep": 1000}))  # fmt: skip
        folder = case.prepare(mesh, one)
        first = case.again(folder)
        case.again(folder, "-output", "kept")
        def answers(result):
            return [[stage["checksum"], stage["temperature"]] for stage in result.summary["stages"]] + [result.stage(name).gauss_stress[:, :1].tobytes() for name in result.stages]
        case.check(f"{measure} strain: all stages run", [stage["verdict"] for stage in first.summary["stages"]], ["converged"] * 4 + ["completed"])
        for ranks in case.ranks(*((2, 3, 4) if measure == "small" else (2,))):
            case.check(f"... the same on {ranks} ranks", answers(case.run(mesh, one, ranks=ranks)) == answers(first), True)
        kept = sorted((folder / "kept" / "checkpoints").iterdir())
        for i, at in enumerate((len(kept) // 6, len(kept) // 3, len(kept) // 2, 3 * len(kept) // 4, len(kept) - 2)):
            again = case.again(folder, "-restart", kept[at], ranks=1 + i % 2)
            case.check(f"... restart from checkpoint {at} of {len(kept)}: the same", answers(again) == answers(first), True)
