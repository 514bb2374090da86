"""Silt, ice and uniform pressures as loads of their own: forces and moments by hand, and those of the gravity method.

A rigid trapezium on an elastic base: openings of heel and toe give N and M about the middle of the base."""

import math

import numpy as np
from driver import changed
from quoin_tools.assess import section_cut
from quoin_tools.base import scene as scenes
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, split_triangles

WHAT = "silt (Rankine's active pressure sideways, its weight on a face that leans) ice (a line load at its level) and uniform pressure (a face that leans, a ring): forces, moments, trials, both strains, ranks, refusals"
SOURCE = "K = (1 - sin)/(1 + sin), K g' h^2/2 at h/3, g' times the area above the face; statics; N = p R in a ring"
BY = "by hand, with Rankine's coefficient"

G, H, BATTER, B, K_N = 9.81, 12.0, 3.0, 9.0, 1e10  # height, how far the heel stands out upstream, base
SILT, TOP, PHI, ICE, LEVEL, THICK = 950.0, 8.0, 28.0, 150e3, 10.5, 2.0
GAS = 40e3  # [Pa]
RANKINE = (1 - math.sin(math.radians(PHI))) / (1 + math.sin(math.radians(PHI)))


def mesh(rigid=True, triangles=False, n=6):
    dam = quad_patch((0, 0), (B, 0), (6, H), (BATTER, H), 3, n, group="dam")
    dam = split_triangles(dam) if triangles else dam
    found = join([renamed(rectangle(-2, -2, 13, 2, 1, 1, group="base", rigid=True), {}), renamed(dam, {"up": "left", "crest": "top", "base_joint": "bottom"}, {"top": "top_left"})])
    found.group_rigid[found.group_names.index("dam")] = rigid
    return found


def scene(*stages, **more):
    loads = {"weight": {"type": "self_weight", "groups": ["dam"]}, "silt": {"type": "silt", "faces": "up", "level": TOP, "density": SILT, "friction": PHI},
             "ice": {"type": "ice", "faces": "up", "level": LEVEL, "force": "150 kN/m"},
             "gas": {"type": "pressure", "faces": "up", "pressure": "40 kPa"}}  # fmt: skip
    return {
        "thickness": THICK, "strain": "small", "relaxation": {"tolerance": 1e-10, "velocity_tolerance": 1e-10, "method": "explicit"},
        "materials": {"dam": {"density": 2400, "young": 1e11, "poisson": 0.2}, "base": {"density": 0, "rigid": True}},
        "joints": {"default": {"k_n": K_N, "k_s": K_N, "law": "elastic"}}, "supports": {"base": {"fix": "xy"}}, "loads": loads, "stages": list(stages),
    } | more  # fmt: skip


def by_hand(names):
    """(X, Y, M about the origin) of the loads: weight, silt, ice, gas."""
    found = np.zeros(3)
    width = BATTER * TOP / H
    parts = {"weight": [(0, -2400 * G * 0.5 * BATTER * H, 2 * BATTER / 3, 0), (0, -2400 * G * 3 * H, BATTER + 1.5, 0), (0, -2400 * G * 0.5 * 3 * H, 7, 0)],
             "silt": [(RANKINE * SILT * G * TOP**2 / 2, 0, 0, TOP / 3), (0, -SILT * G * TOP * width / 2, width / 3, 0)], "ice": [(ICE, 0, 0, LEVEL)],
             "gas": [(GAS * H, -GAS * BATTER, BATTER / 2, H / 2)]}
    for name in names:
        for x, y, at, height in parts[name]:
            found += THICK * np.array([x, y, at * y - height * x])
    return found


def resultants(result, stage):
    """(X, Y, M) that the base joint bears, from its openings."""
    now = result.stage(stage)
    x, opening = now.contacts.point[..., 0].ravel(), now.contacts.opening.ravel()
    slope, middle = np.polyfit(x - B / 2, opening, 1)
    n, m = -K_N * middle * B * THICK, -K_N * slope * B**3 / 12 * THICK  # pressure, and its moment about the middle
    return np.array([-result.stage_summary(stage)["reaction"]["x"], -n, -(n * B / 2 + m)])


def voussoirs(n=12, inner=3.0, outer=4.0):
    """A closed ring of n stones whose outer faces are the sides of a regular polygon."""
    angle = 2 * np.pi * np.arange(n + 1) / n + 0.1
    spoke = np.column_stack([np.cos(angle), np.sin(angle)])
    vertices = np.concatenate([[inner * a, outer * a, outer * b, inner * b] for a, b in zip(spoke, spoke[1:])])
    skin = np.column_stack([np.arange(n), np.ones(n, dtype=int)])
    beds = np.column_stack([np.arange(n), np.zeros(n, dtype=int)])
    return BlockMesh(vertices, np.arange(4 * n).reshape(n, 4), np.zeros(n, dtype=int), ["ring"], [True], {"skin": skin, "beds": beds}, {})


def ring(case):
    """Free stones under an outer pressure p: the loads are in balance, and half a ring has 2 N = p 2 R, N = p R in each joint."""
    one, p, outer = voussoirs(), 50e3, 4.0
    of_ring = {"thickness": THICK, "strain": "small", "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "allow_floating": True},
               "materials": {"ring": {"density": 2400}}, "joints": {"beds": {"k_n": 1e9, "k_s": 1e9, "friction": 35}},
               "loads": {"round": {"type": "pressure", "faces": "skin", "pressure": p}}, "stages": [{"pressed": {"loads": ["round"]}}]}  # fmt: skip
    for strain in ("small", "large"):
        result = case.run(one, of_ring | {"strain": strain})
        now = result.stage("pressed").contacts
        facts = result.stage_summary("pressed")["joints"]["beds"]
        case.check(f"ring, {strain} strain: N in all joints over their number [N]", facts["N"] / 12, p * outer * THICK, relative=1e-5 if strain == "small" else 1e-3)
        case.check("... every joint is closed and shears nothing", [facts["open_length"], float(abs(now.tau).max()) / p < 1e-3], [0.0, True], absolute=1e-9)
        applied = result.stage_summary("pressed")["applied"]
        case.check("... the pressure has no resultant [N]", [applied["x"] / (p * outer), applied["y"] / (p * outer)], [0, 0], absolute=1e-9)
    case.check("... gravity method: X, Y, M", section_cut.on_faces(result.stage("pressed").loads, section_cut.WHOLE) / (p * outer), np.zeros(3), absolute=1e-12)


def run(case):
    stages = [{"own": {"loads": ["weight"]}}, {"silted": {"loads": ["weight", "silt"]}}, {"frozen": {"loads": ["weight", "silt", "ice"]}}, {"pressed": {"loads": ["weight", "gas"]}}]
    names = {"own": ["weight"], "silted": ["weight", "silt"], "frozen": ["weight", "silt", "ice"], "pressed": ["weight", "gas"]}
    size = np.abs(by_hand(names["frozen"]))
    for what, one in (("rigid", mesh()), ("one face", mesh(n=1)), ("deformable", mesh(rigid=False)), ("triangles", mesh(rigid=False, triangles=True))):
        result = case.run(one, scene(*stages))
        for stage in names if what == "rigid" or what == "one face" else ():
            case.check(f"{what}, {stage}: X, Y, M at the base [N, N m]", resultants(result, stage) / size, by_hand(names[stage]) / size, absolute=2e-6)
        reaction = result.stage_summary("frozen")["reaction"]
        case.check(f"{what}: reactions [N]", [-reaction["x"], -reaction["y"]], by_hand(names["frozen"])[:2], relative=1e-6)
        reaction = result.stage_summary("pressed")["reaction"]
        case.check(f"{what}, pressed: reactions [N]", [-reaction["x"], -reaction["y"]], by_hand(names["pressed"])[:2], relative=1e-6)
        used = scenes.read(case.folder / f"run_{case.runs:03d}" / "out" / "scene_echo.yaml")
        pressed, _ = section_cut.stage_forces(one, used, "pressed", pressed=result.stage("pressed").loads)
        case.check("... gravity method, gas: X, Y, M [N, N m]", pressed["gas"] / size, by_hand(["gas"]) / size, absolute=1e-12)
        forces, left_out = section_cut.stage_forces(one, used, "frozen", pressed=result.stage("frozen").loads)
        for name in ("silt", "ice"):
            case.check(f"... gravity method, {name}: X, Y, M [N, N m]", forces[name] / size, by_hand([name]) / size, absolute=1e-12)
        case.check("... knows all loads", left_out, [])
    for ranks in case.ranks(2, 3, 4):
        result = case.run(mesh(rigid=False), scene(*stages), ranks=ranks)
        case.check(f"{ranks} ranks, pressed: reaction x [N]", -result.stage_summary("pressed")["reaction"]["x"], by_hand(names["pressed"])[0], relative=1e-6)
        case.check(f"{ranks} ranks: reaction x [N]", -result.stage_summary("frozen")["reaction"]["x"], by_hand(names["frozen"])[0], relative=1e-6)
    large = case.run(mesh(rigid=False), scene(*stages, strain="large"))
    case.check("large strain: reactions [N]", [-large.stage_summary("frozen")["reaction"][x] for x in "xy"], by_hand(names["frozen"])[:2], relative=1e-3)
    case.check("... of the pressure", [-large.stage_summary("pressed")["reaction"][x] for x in "xy"], by_hand(names["pressed"])[:2], relative=1e-3)
    factor = {"pushed": {"type": "load_factor", "loads": ["weight", "silt", "ice"], "raises": ["silt", "ice"], "start": 1, "step": 1, "limit": 3}}
    result = case.run(mesh(), scene(*stages, factor))
    wanted = by_hand(["weight"]) + 3 * by_hand(["silt", "ice"])
    case.check("a load factor of 3 on both: X, Y, M [N, N m]", resultants(result, "pushed") / size, wanted / size, absolute=1e-5)
    used = scenes.of_run(case.folder / f"run_{case.runs:03d}" / "out", result.summary)
    case.check("... gravity method", section_cut.total(section_cut.stage_forces(mesh(), used, "pushed", pressed=result.stage("pushed").loads)[0]) / size, wanted / size, absolute=1e-12)
    inflated = {"inflated": {"type": "load_factor", "loads": ["weight", "gas"], "raises": ["gas"], "start": 1, "step": 1, "limit": 3}}
    result = case.run(mesh(), scene(*stages, inflated))
    wanted = by_hand(["weight"]) + 3 * by_hand(["gas"])
    case.check("a load factor of 3 on the pressure: X, Y, M [N, N m]", resultants(result, "inflated") / size, wanted / size, absolute=1e-5)
    used = scenes.of_run(case.folder / f"run_{case.runs:03d}" / "out", result.summary)
    case.check("... gravity method", section_cut.total(section_cut.stage_forces(mesh(), used, "inflated", pressed=result.stage("inflated").loads)[0]) / size, wanted / size, absolute=1e-12)
    ring(case)
    one = changed(scene(*stages), ("loads.silt", {"type": "silt", "faces": "up", "level": TOP, "density": f"{SILT * G / 1e3} kN/m3", "lateral": RANKINE}))
    case.check("lateral in place of friction, its weight in place of a density: reaction [N]", -case.run(mesh(), one).stage_summary("frozen")["reaction"]["x"], by_hand(names["frozen"])[0], relative=1e-6)
    on_node = changed(scene(*stages), ("loads.ice.level", 6.0))
    result = case.run(mesh(), on_node)
    case.check("ice at a vertex: X, Y, M [N, N m]", resultants(result, "frozen") / size, (by_hand(["weight", "silt"]) + THICK * np.array([ICE, 0, -6.0 * ICE])) / size, absolute=2e-6)
    doubtful = case.run(mesh(n=1), changed(scene(stages[0]), ("loads.silt.density", 1900.0), ("loads.ice.force", 150.0)))
    case.check("silt with its water in it, ice in kN/m: reported", [line in doubtful.stderr for line in ("loads.silt.density: 1900 kg/m3 is not within 200 to 1500", "loads.ice.force: 150 N/m is not within 1000 to 1e+07")], [True, True])
    for change, words in (
        (("loads.ice.level", 12.0), "loads.ice.level: 0 faces of up are at 12 m: expected one, where the ice is below their upper end"),
        (("loads.ice.faces", "crest"), "loads.ice.level: 0 faces of crest are at 10.5 m"),
        (("loads.ice.faces", "side"), "loads.ice: the mesh has no face set 'side'"),
        (("loads.silt.faces", "side"), "loads.silt: the mesh has no face set 'side'"),
        (("loads.gas.faces", "side"), "loads.gas: the mesh has no face set 'side'"),
        (("loads.gas.pressure", "40 kN"), "loads.gas.pressure: '40 kN' has another unit than this key"),
        (("loads.gas", {"type": "pressure", "faces": "up"}), "loads.gas.pressure: missing [Pa]"),
        (("loads.silt.lateral", 0.5), "silt needs lateral [-] or friction [degree], one of them"),
        (("loads.silt", {"type": "silt", "faces": "up", "level": TOP, "density": SILT}), "silt needs lateral [-] or friction [degree], one of them"),
        (("loads.silt", {"type": "silt", "faces": "up", "level": TOP, "friction": 30}), "loads.silt.density: missing [kg/m3]"),
        (("loads.ice.force", "150 kPa"), "loads.ice.force: '150 kPa' has another unit than this key: expected one of: N/m, kN/m"),
    ):  # fmt: skip
        result = case.run(mesh(), changed(scene(*stages), change), ranks=1)
        case.check(f"refused: {words}", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])
