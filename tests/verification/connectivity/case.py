"""Variable connectivity where nothing slides off: it must answer as fixed connectivity does. And `auto`, which goes from one to the other.

A corner that is pressed in lies level with the sides of its neighbours and at the end of faces that are flush: none of that is a
contact. What has met in motion never pulls, and a crack that opens stays in the account of its joint."""

import json
import re

import numpy as np
from driver import MODELS, changed
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed

WHAT = "variable = fixed while nothing slides off; corners at flush faces; symmetry; cracks wider than the tolerance; auto goes from one to the other"
SOURCE = "fixed connectivity; rho g h / k_n + rho g h^2 / 2 E; T / k_s L; contact length 3 (b/2 - e); a base that holds a residual tension"
BY = "by hand; Quoin itself, fixed connectivity"

G, RHO = 9.81, 2400.0
ELASTIC = {"young": 10e9, "poisson": 0.2}
SCENE = {
    "contact": {"connectivity": "variable", "tolerance": 0.005},
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9},
    "materials": {"block": {"density": RHO}, "base": {"density": RHO}},
    "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "law": "elastic"}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
    "stages": [{"sw": {"loads": ["weight"]}}],
}
FIXED = ("contact.connectivity", "fixed")


LONG = ("as_fixed",)  # parts that the short form leaves out


def run(case):
    smallest(case)
    counted_twice(case)
    as_fixed(case)
    unmoved(case)
    mirrored(case)
    path(case)
    never_pulls(case)
    holds_together(case)
    wide_crack(case)
    outgrown(case)
    out_of_range(case)


def smallest(case):
    """A block of 1 m on three flush rigid blocks, one body or three; nu = 0. The second stage finds its contacts under load."""
    young, k_n = 10e9, 10e9
    one = [rectangle(-1, -1, 3, 1, 3, 1, group="base", rigid=True)]
    three = [rectangle(x, -1, 1, 1, group="base", rigid=True) for x in (-1, 0, 1)]
    scene = changed(SCENE, ("materials.block", {"density": RHO, "young": young, "poisson": 0.0}),
                    ("stages", [{"sw": {"loads": ["weight"]}}, {"again": {"loads": ["weight"]}}]))
    closed = -(RHO * G / k_n + RHO * G / (2 * young))
    for what, base, x in (("in the middle of one body", one, 0), ("at its end", one, -1), ("across two of three", three, 0.5)):
        block = rectangle(x, 0, 1, 1, 2, 2, group="block")
        mesh = join([*(renamed(body, {}) for body in base), renamed(block, {}, {"left": "top_left", "right": "top_right"})])
        off = []
        for model in MODELS:
            result = case.run(mesh, changed(scene, ("joints.default.stress_model", model)))
            off.append(np.array([result.probe("again", point) for point in ("left", "right")]) - [0, closed])
        case.check(f"block on three flush blocks, {what}, six stress models: top, off rho g h / k_n + rho g h^2 / 2 E by [m]",
                   off, 0.0, absolute=1e-5 * -closed)


def counted_twice(case):
    """A rigid block of 4 x 2 m pushed by 20 kN on a base with nodes exactly under its corners."""
    mesh = join([renamed(rectangle(-4, -1, 16, 1, 4, 1, group="base", rigid=True), {}),
                 renamed(rectangle(0, 0, 4, 2, group="block", rigid=True), {"side": "left"}, {"foot": "bottom_left"})])
    scene = changed(SCENE, ("joints.default.k_n", 1e8), ("joints.default.k_s", 5e7),
                    ("loads.push", {"type": "traction", "faces": "side", "value": [10e3, 0]}),
                    ("stages", [{"sw": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"]}}]))
    for model in MODELS:
        result = case.run(mesh, changed(scene, ("joints.default.stress_model", model)))
        case.check(f"corners at nodes of the base, {model}: slides by [m]", result.probe("push", "foot")[0], 20e3 / (5e7 * 4),
                   relative=2e-3)
    # one step for both: that of auto is longer where contacts stay
    swing = changed(scene, ("stages", [{"push": {"type": "dynamic", "loads": ["push", "weight"], "duration": 0.2, "dt_factor": 0.05}}]))
    both = [case.run(mesh, changed(swing, ("contact.connectivity", how))).probe("push", "foot") for how in ("fixed", "variable")]
    case.check("... in motion, variable as fixed [m]", both[1], both[0], relative=1e-6)


def pushed(shape, elastic, mirror=False, turned=False):
    """Mesh and scene of a block of 2 m that is pressed and pushed on a base with nodes under its corners."""
    base, block = "base" in elastic, "block" in elastic
    bodies = [renamed(rectangle(-2, -1, 6, 1, 3, 2, group="base", rigid=not base), {"bottom": "bottom"})]
    if shape == "stepped":
        bodies.append(renamed(rectangle(2, 0, 2, 0.5, group="base", rigid=not base), {}))
    n = 2 if block else 1
    bodies.append(renamed(rectangle(0.3 if shape == "offset" else 0.0, 0, 2, 2, n, n, group="block", rigid=not block),
                          {"side": "left", "top": "top"}, {"a": "top_left", "b": "top_right", "c": "bottom_left"}))
    if shape == "three blocks":
        bodies[:1] = [renamed(rectangle(x, -1, 2, 1, group="base", rigid=not base), {"bottom": "bottom"}) for x in (-2, 0, 2)]
    mesh = join(bodies[::-1] if turned else bodies)
    if mirror:
        mesh.vertices = mesh.vertices * [-1, 1]
        mesh.blocks = np.where(mesh.blocks[:, 3:] < 0, mesh.blocks, mesh.blocks[:, [1, 0, 3, 2]])
        mesh.face_sets = {name: np.column_stack([rows[:, 0], np.array([0, 3, 2, 1])[rows[:, 1]]])
                          for name, rows in mesh.face_sets.items()}
    scene = changed(SCENE, ("loads.push", {"type": "traction", "faces": "side", "value": [-100e3 if mirror else 100e3, 0]}),
                    ("loads.press", {"type": "traction", "faces": "top", "value": [0, -1e6]}),
                    ("stages", [{"sw": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push", "press"]}}]))
    for name in elastic:
        scene = changed(scene, (f"materials.{name}", {"density": RHO, **ELASTIC}))
    return mesh, changed(scene, ("supports", {"bottom": {"fix": "xy"}})) if base else scene


def probes(result, stage="push"):
    return np.array([result.probe(stage, point) for point in "abc"])


def as_fixed(case):
    rigid, one, both = (), ("block",), ("base", "block")
    rows = [(shape, elastic, "tptm") for shape in ("flush", "stepped", "offset", "three blocks") for elastic in (rigid, one, both)]
    rows += [("stepped", one, model) for model in MODELS if model != "tptm"]
    for law in ({"law": "elastic"}, {"law": "mohr_coulomb", "friction": 45}):
        off = []
        for shape, elastic, model in rows:
            mesh, scene = pushed(shape, elastic)
            joint = {"k_n": 10e9, "k_s": 3e9, "stress_model": model, **law}
            scene = changed(scene, ("joints.default", joint))
            fixed, variable = case.run(mesh, changed(scene, FIXED)), case.run(mesh, scene)
            off.append(np.abs(probes(variable) - probes(fixed)).max() / np.abs(probes(fixed)).max())
        case.check(f"variable and fixed, {law['law']}: {len(rows)} bases, bodies and stress models, difference", off, 0.0,
                   absolute=1e-6)


def unmoved(case):
    """With friction both take the same damping: verification of what has not slid changes no bit."""
    mesh, scene = pushed("stepped", ("base", "block"))
    scene = changed(scene, ("joints.default", {"k_n": 10e9, "k_s": 3e9, "friction": 45}))
    results = [case.run(mesh, changed(scene, FIXED)), case.run(mesh, scene), case.run(mesh, scene, ranks=2)]
    sums = [json.dumps([stage["checksum"] for stage in result.summary["stages"]]) for result in results]
    case.check("verified in place: checksums of fixed connectivity", sums[1], sums[0])
    case.check("... on two ranks", sums[2], sums[0])
    case.check("... verifications", results[1].stage_summary("push")["verifications"] > 0, True)


def mirrored(case):
    """n and s are those of one of two faces, in a mirrored mesh of the other: by the angle between them answers differ."""
    for shape in ("flush", "stepped", "three blocks"):
        u = []
        for how in ({}, {"mirror": True}, {"turned": True}):
            mesh, scene = pushed(shape, ("base", "block"), **how)
            u.append(probes(case.run(mesh, scene)) * ([-1, 1] if "mirror" in how else [1, 1]))
        case.check(f"{shape} base: mirrored, difference over displacement", np.abs(u[1] - u[0]).max() / np.abs(u[0]).max(), 0.0,
                   absolute=1e-5)
        case.check("... bodies in another order", np.abs(u[2] - u[0]).max() / np.abs(u[0]).max(), 0.0, absolute=1e-7)


def path(case):
    """A dam and its rock begin to weigh at once: on the way the contacts part by centimetres."""
    rock = rectangle(-96, -96, 240, 96, 60, 24, group="base")
    dam = quad_patch((0, 0), (48, 0), (5, 60), (0, 60), 12, 15, group="block")
    mesh = join([renamed(rock, {"bottom": "bottom", "left": "left", "right": "right"}),
                 renamed(dam, {}, {"crest": "top_left"})])
    scene = changed(SCENE, ("relaxation", {"tolerance": 1e-6}), ("materials.block", {"density": RHO, **ELASTIC, "young": 20e9}),
                    ("materials.base", {"density": 2500, **ELASTIC, "young": 5e9}), ("joints.default",
                    {"k_n": 10e9, "k_s": 3e9, "friction": 45}), ("loads.weight", {"type": "self_weight"}),
                    ("supports", {"bottom": {"fix": "xy"}, "left": {"fix": "x"}, "right": {"fix": "x"}}))
    fixed = case.run(mesh, changed(scene, FIXED)).probe("sw", "crest")
    for ramp in (1, 100):
        loaded = changed(scene, ("stages", [{"sw": {"loads": ["weight"], "ramp": ramp}}]))
        case.check(f"dam on rock that weighs, loaded in {ramp} cycles: crest, variable as fixed [m]",
                   case.run(mesh, loaded).probe("sw", "crest"), fixed, relative=1e-4)


def never_pulls(case):
    """A block falls on its corner and topples: joints that hold together where they began may not hold what meets later."""
    block = rectangle(0, 0, 1, 1, group="block", rigid=True)
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    block.vertices = block.vertices @ np.array([[c, s], [-s, c]]) + [0.2, 0.02]
    mesh = join([renamed(rectangle(-3, -1, 6, 1, 3, 1, group="base", rigid=True), {}), renamed(block, {})])
    for name, law in (("elastic", {"law": "elastic"}), ("residual tension", {"friction": 30, "tension": 250e3,
                                                                            "tension_residual": 250e3})):
        scene = changed(SCENE, ("relaxation", {"allow_floating": True}), ("joints.default", {"k_n": 1e9, "k_s": 1e9, **law}),
                        ("stages", [{"fall": {"type": "dynamic", "loads": ["weight"], "duration": 1.0, "dt_factor": 0.1,
                                              "frames": 40}}]))
        result = case.run(mesh, scene)
        force = [contact[:, 0].sum() for frame in [*result.frames("fall"), "fall"] for contact in result.stage(frame).contacts.force]
        case.check(f"block falls on its corner, {name}: a contact that pulls, most of 41 frames [N]", max(force), 0.0, absolute=1e-6)
        case.check("... verdict", result.verdict, "converged")


def tilt(b, h, k_n, tension, weight, push, most=0.2):
    """Opening at the heel [m] of a rigid block b by h whose base is pressed elastically and pulls by no more than tension, as `push` at
    half its height tilts it; None: nothing below a rotation of `most` holds it."""
    x = (np.arange(4000) + 0.5) * b / 4000  # from the toe

    def off(theta):  # moment about the toe that is missing, once weight and base balance
        low, high = -b, b
        for _ in range(60):
            d = 0.5 * (low + high)
            low, high = (d, high) if -b * np.minimum(k_n * (theta * x - d), tension).mean() < weight else (low, d)
        arm, lift = b / 2 * np.cos(theta) - h / 2 * np.sin(theta), h / 2 * np.cos(theta) + b / 2 * np.sin(theta)
        held = weight * arm + b * (np.minimum(k_n * (theta * x - d), tension) * x).mean()
        return push * lift - held, theta * b - d

    angles = np.geomspace(1e-4, most, 60)
    first = next((i for i, theta in enumerate(angles) if off(theta)[0] < 0), None)
    if not first:
        return None
    low, high = angles[first - 1], angles[first]
    for _ in range(40):
        theta = 0.5 * (low + high)
        low, high = (theta, high) if off(theta)[0] > 0 else (low, theta)
    return off(theta)[1]


def holds_together(case):
    """A joint with a residual tension in a static stage: a tilted block opens at its heel, slides on to the next face of the base
    and, pressed in deeper than contact.overlap there, goes on with a face contact; past its limit it falls and no corner holds it."""
    b, h, tension = 2.0, 4.0, 250e3
    mesh = join([renamed(rectangle(-2, -1, 6, 1, 3, 1, group="base", rigid=True), {}),
                 renamed(rectangle(0, 0, b, h, group="block", rigid=True), {"side": "left"})])

    def pushed_by(pressure, k_n, tolerance, how):
        joint = {"k_n": k_n, "k_s": k_n, "friction": 45, "cohesion": tension, "tension": tension, "tension_residual": tension}
        scene = changed(SCENE, ("contact", {"connectivity": how, "tolerance": tolerance, "overlap": tolerance}),
                        ("relaxation", {"tolerance": 1e-8, "velocity_tolerance": 1e-8, "allow_floating": True}),
                        ("joints.default", joint),
                        ("loads.push", {"type": "traction", "faces": "side", "value": [pressure, 0]}),
                        ("stages", [{"sw": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"], "ramp": 500}}]))
        return case.run(mesh, scene)

    for pressure in (50e3, 55e3):
        contacts = pushed_by(pressure, 1e8, 1e-3, "variable").stage("push").contacts
        case.check(f"residual tension of 250 kPa, pushed by {pressure / 1e3:g} kPa: the heel opens [mm]", 1e3 * contacts.opening.max(),
                   1e3 * tilt(b, h, 1e8, tension, b * h * RHO * G, pressure * h), relative=0.02)
        case.check("... faces in contact, corners", [int(np.sum(contacts.klass != 4)), int(np.sum(contacts.klass == 4))], [2, 0], absolute=0)
    case.check("... by 60 kPa on 20 MPa/m: closed form", tilt(b, h, 2e7, tension, b * h * RHO * G, 60e3 * h), None)
    for how in ("fixed", "variable"):
        case.check(f"... {how}", pushed_by(60e3, 2e7, 5e-3, how).verdict, "collapsed")


def wide_crack(case):
    """A rigid block of b = 4 m whose weight has the eccentricity e opens b - 3 (b/2 - e) of its base, 16 mm at the heel."""
    b, e, pressure, k_n = 4.0, 1.2, 1e6, 1.736e8
    top = b - 2 * e  # the load lies on this much of the top, at its right end
    mesh = join([renamed(rectangle(-1, -1, 6, 1, 12, 1, group="base", rigid=True), {}),
                 renamed(quad_patch((0, 0), (b, 0), (b, 0.5), (0, 0.5), 10, 1, group="block", rigid=True), {"top": "top"})])
    right = mesh.vertices[mesh.blocks[mesh.face_sets["top"][:, 0]]].mean(axis=1)[:, 0] > b - top
    mesh.face_sets["top"] = mesh.face_sets["top"][right]
    scene = changed(SCENE, ("joints.default", {"k_n": k_n, "k_s": k_n, "friction": 45}), ("materials.block.density", 1e-3),
                    ("loads.press", {"type": "traction", "faces": "top", "value": [0, -pressure]}),
                    ("stages", [{"press": {"loads": ["press"]}}, {"again": {"loads": ["press"]}}]))
    length = [case.run(mesh, changed(scene, ("contact.connectivity", how))).stage_summary("again")["joints"]["default"]["open_length"]
              for how in ("fixed", "variable")]
    case.check("crack wider than the tolerance: open length [m]", length[1], b - 3 * (b / 2 - e), relative=0.01)
    case.check("... of fixed connectivity [m]", length[1], length[0], relative=1e-6)


SLOPE = np.radians(30.0)
DOWN, UP = np.array([np.cos(SLOPE), -np.sin(SLOPE)]), np.array([np.sin(SLOPE), np.cos(SLOPE)])


def on_slope(at, to, group, points=None):
    """A rigid rectangle between two corners (down the slope, above it)."""
    corner = [s * DOWN + h * UP for s, h in ((at[0], at[1]), (to[0], at[1]), (to[0], to[1]), (at[0], to[1]))]
    return renamed(quad_patch(*corner, 1, 1, group, True), {}, points or {})


def summary(result, name):
    return result.stage_summary(name)


def outgrown(case):
    """A block of 2 m on 30 degrees, 0.6 m above another one: friction falls below the slope, so it slides, whatever it meets."""
    block, slope = on_slope((0, 0), (2, 1), "block", {"toe": "bottom_right"}), on_slope((-4, -2), (6, 0), "base")
    stops = join([slope, block, on_slope((2.6, 0), (3.6, 1.5), "base")])
    lower = [{name: {"loads": ["weight"], "joints": {"default": {"friction": friction}}}} for name, friction in (("rest", 35), ("go", 20))]
    scene = changed(SCENE, ("joints.default", {"k_n": 1e10, "k_s": 5e9, "friction": 35}), ("relaxation", {}), ("stages", lower))
    auto = changed(scene, ("contact.connectivity", "auto"))
    variable, found, again, fixed = case.run(stops, scene), case.run(stops, auto), case.run(stops, auto, ranks=2), case.run(stops, changed(scene, FIXED))
    case.check("a block slides 0.6 m to another one, variable: it rests there [m]", np.linalg.norm(variable.probe("go", "toe")), 0.6, absolute=2e-6)
    for how, result, most in (("auto", found, 0.5), ("fixed", fixed, 0.16)):  # auto allows half of the face while the load rises, and as long again
        says = re.match(r"macroblock 1 has slid along macroblock 0 by (\S+) m, (\S+) of a length of 2 m, at .*; macroblock 1 has moved most, by (\S+) m", summary(result, "go")["evidence"])
        case.check(f"... {how}: collapsed, by its own motion", [result.verdict, says is not None], ["collapsed", True])
        case.check("... slid [m], and moved most", [float(says[1]), float(says[3])], [2 * float(says[2])] * 2, relative=0.01)
        case.check("... part of its face", 0.1 <= float(says[2]) < most, True)
    sums = [[stage["checksum"] for stage in result.summary["stages"]] for result in (found, again)]
    case.check("... auto, checksums on two ranks", json.dumps(sums[1]), json.dumps(sums[0]))
    case.check("... at rest: checksum of fixed", summary(found, "rest")["checksum"], summary(fixed, "rest")["checksum"])
    search = {"type": "strength_reduction", "loads": ["weight"], "limit": 25, "step": 4, "bracket": 1.0, "displacement_limit": float("inf")}
    ends = [case.run(stops, changed(scene, ("contact.connectivity", how), ("stages", [lower[0], {"search": search}]))) for how in ("variable", "auto", "fixed")]
    trials = [summary(end, "search")["strength_reduction"] for end in ends]
    case.check("trials without displacement_limit, variable: the other block stops it [degree]", [trials[0]["stable"], trials[0]["failing"]], [25, None])
    case.check("... auto: the slope decides [degree]", [trials[1]["stable"], trials[1]["failing"]], [30, 29], absolute=0)
    fails = next(trial for trial in trials[1]["trials"] if trial["outcome"] == "fails")
    case.check("... what fails", "macroblock 1 has slid along macroblock 0" in fails["evidence"] and "since the trial began" in fails["evidence"], True)
    case.check("... checksum of fixed", summary(ends[1], "search")["checksum"], summary(ends[2], "search")["checksum"])


def out_of_range(case):
    """A block over 5 mm of a second stone slides by 1 mm on soft joints and comes to rest: auto finds its contacts again then."""
    block = renamed(rectangle(-1.995, 0, 2, 1, group="block", rigid=True), {"side": "left"}, {"top": "top_left"})
    mesh = join([renamed(rectangle(-3, -1, 3, 1, group="base", rigid=True), {}), renamed(rectangle(0, -1, 3, 1, group="base", rigid=True), {}), block])
    stages = [{name: {"loads": ["weight", *(["push"] if name != "sw" else [])]}} for name in ("sw", "push", "stay")]
    scene = changed(SCENE, ("joints.default", {"k_n": 1e8, "k_s": 1e7, "friction": 45}), ("relaxation", {"tolerance": 1e-8}), ("stages", stages),
                    ("loads.push", {"type": "traction", "faces": "side", "value": [20e3, 0]}))
    auto = changed(scene, ("contact.connectivity", "auto"))
    variable, fixed = case.run(mesh, scene), case.run(mesh, changed(scene, FIXED))
    short = [1e3 * result.stage("push").contacts.length.min() for result in (fixed, variable)]
    case.check("a contact of 5 mm slides by 1.15 mm: length, fixed [mm]", short[0], 5, relative=1e-6)
    case.check("... variable, found again a millimetre before the end at most", 5.15 < short[1] <= 6.16, True)
    for method in ("explicit", "preconditioned", "stiffness_mass"):
        runs = [case.run(mesh, changed(auto, ("relaxation.method", method)), ranks=ranks) for ranks in (1, 2)]
        for name in ("push", "stay"):
            case.check(f"... auto, {method}, {name}: as variable [m]", runs[0].probe(name, "top"), variable.probe(name, "top"), relative=1e-4)
        case.check("... contacts", [summary(runs[0], name)["connectivity"] for name in ("sw", "push", "stay")], ["fixed", "fixed, then variable", "fixed"])
        case.check("... says where", "contact.connectivity auto found contacts again" in summary(runs[0], "push")["evidence"] and summary(runs[0], "push")["outgrown"]["moved"] > 0.1, True)
        case.check("... on two ranks [m]", runs[1].probe("stay", "top"), runs[0].probe("stay", "top"), relative=1e-8)
    small = case.run(mesh, changed(auto, ("strain", "small")))
    case.check("... strain small keeps contacts and warns", [summary(small, "push")["connectivity"], "beyond the range of fixed connectivity" in small.stderr + small.stdout], ["fixed", True])
