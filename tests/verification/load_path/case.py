"""A body that is loaded a little and pressed a lot: nothing holds it along its joints, and the unbalanced ratio does not see it.

Light blocks between frictionless jaws, one or two that stick together, and a light cap on a slope steeper than its friction: none of them is
in equilibrium, whatever they weigh. With friction enough, and with no weight at all, they are. Weightless caps stay with what they stand on."""

import json
import math

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed

WHAT = "what nothing holds is not reported as converged, however little it is loaded (explicit and by Newton's method)"
SOURCE = "statics: W = 0 along frictionless joints; a block on a plane slides where tan(friction) < tan(slope)"
BY = "by hand"

METHODS = ("explicit", "preconditioned")
G, PRESS = 9.81, 1e5
JAWS = {
    "strain": "small",
    "materials": {"block": {"density": 2.4e-4, "young": 10e9, "poisson": 0.2}, "base": {"density": 0}, "jaw": {"density": 0}},
    "joints": {"default": {"k_n": 10e9, "k_s": 5e9, "friction": 0}, "glue": {"law": "elastic"}},
    "supports": {"base": {"fix": "xy"}, "jaw": {"fix": "y"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}, "press": {"type": "traction", "faces": "right", "value": [-PRESS, 0]}},
    "stages": [{"all": {"loads": ["weight", "press"]}}],
}


def jaws(rigid, blocks=1):
    """One block of 1 by 0.5 m, or two of half the width that are glued, between a fixed jaw and one that is pressed."""
    width = 1.0 / blocks
    middle = [renamed(rectangle(i * width, 0.25, width, 0.5, 2, 1, group="block", rigid=rigid), {"glue": "left"} if i else {}, {}) for i in range(blocks)]
    sides = [rectangle(-2, 0, 2, 1, group="base", rigid=True), rectangle(1, 0, 1, 1, group="jaw", rigid=True)]
    return join([renamed(sides[0], {}), *middle, renamed(sides[1], {"right": "right"})])


def verdict(result, stage):
    row = result.stage_summary(stage)
    return [result.verdict, "are not held against" in row["evidence"]]


def between_jaws(case):
    found, held = [], []
    weight = JAWS["materials"]["block"]["density"] * G * 0.5
    for method in METHODS:
        for rigid, blocks in ((True, 1), (False, 1), (True, 2)):
            scene = changed(JAWS, ("relaxation", {"method": method}))
            if blocks == 1:
                del scene["joints"]["glue"]
            found.append(verdict(case.run(jaws(rigid, blocks), scene), "all"))
            # jaws that carry it: friction 1e-3 is enough for W/(2 P) = 6e-9; Poisson's ratio makes all of the joint slip, both ways
            if not rigid:
                held.append(verdict(case.run(jaws(rigid), changed(scene, ("joints.default.friction", 1e-3))), "all"))
    wrong = [row for row in found if row != ["collapsed", True]]
    case.check(f"{weight:.3g} N between frictionless jaws under {PRESS:g} Pa, rigid, deformable, two that stick; both methods: not reported to fall", len(wrong), 0)
    case.check("... friction of 0.001 degrees: reported otherwise than converged", len([row for row in held if row != ["converged", False]]), 0)


def slope(rigid):
    """A cap of 4 by 2 m on a body of 20 m with a slope of 20 degrees."""
    angle = math.radians(20)
    down, up = np.array([math.cos(angle), -math.sin(angle)]), np.array([math.sin(angle), math.cos(angle)])
    a = np.array([5, 20 + 15 * math.tan(angle)])
    large = quad_patch((0, 0), (20, 0), (20, 20), (0, 20 + 20 * math.tan(angle)), 4, 4, "block", False)
    cap = quad_patch(a, a + 4 * down, a + 4 * down + 2 * up, a + 2 * up, 1, 1, "cap", rigid)
    return join([renamed(rectangle(-5, -5, 30, 5, group="base", rigid=True), {}), renamed(large, {}), renamed(cap, {"joint": "bottom"}, {"cap": "bottom_left"})])


def cap(case):
    elastic = {"young": 10e9, "poisson": 0.2}
    scene = {"strain": "small", "relaxation": {"max_cycles": 5000, "method": "preconditioned"},
             "materials": {"block": elastic | {"density": 2400}, "cap": elastic | {"density": 1e-6}, "base": {"density": 0}},
             "joints": {"default": {"k_n": 10e9, "k_s": 5e9, "friction": 40}, "joint": {"friction": 10}}, "supports": {"base": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight"}}, "stages": [{"sw": {"loads": ["weight"]}}]}
    light, none, rough = (case.run(slope(False), one) for one in (scene, changed(scene, ("materials.cap.density", 0)), changed(scene, ("materials.cap.density", 1e-4), ("joints.joint.friction", 30))))
    case.check("a cap of 1e-6 kg/m3 on a slope of 20 degrees, friction 10: reported converged", light.verdict == "converged", False)
    case.check("... of 1e-4 kg/m3 with friction 30, and without weight: verdicts", json.dumps([rough.verdict, none.verdict]), json.dumps(["converged"] * 2))
    case.check("... without weight: goes down with what it stands on, no farther than the body by 5 % [m]",
               abs(none.probe("sw", "cap")).max() < 1.05 * abs(none.stage("sw").displacement).max(), True)  # fmt: skip


def courses(nx, ny, size, width):
    """Stones of size by size/2 in courses that are offset by half a stone, a cap of size/4 on the last; its first stone can be pushed."""
    parts = [renamed(rectangle(-5, -1, 10 + nx * size, 1, group="base", rigid=True), {})]
    for j in range(ny):
        for i in range(nx):
            faces = {"pushed": "left"} if not i and j == ny - 1 else {}
            parts.append(renamed(rectangle((i + j % 2 / 2) * size, j * size / 2, size, size / 2, group="stone", rigid=True), faces, {}))
    left = (size * nx - width) / 2 + (ny - 1) % 2 * size / 2
    return join([*parts, renamed(rectangle(left, ny * size / 2, width, size / 4, group="cap", rigid=True), {"cap": "bottom"}, {"cap": "bottom_left"})])


def drift(case):
    """A weightless cap without friction may be anywhere; stones that settle by centimetres and are pushed a little do not send it away."""
    rows = ((6, 4, 0.5, 3.0, 40, (33600, 4966), 1e-4), (6, 4, 0.5, 3.0, 20, (3399,), 1e-4), *((3, 4, 0.5, 0.75, friction, (1236,), 1e-6) for friction in (30, 33)))
    # with 33 degrees iterations of Newton's method may jump, by the rounding of the processor's BLAS, to an equilibrium a quarter of a stone away
    verdicts, farther = [], []
    for nx, ny, size, width, friction, pushes, tolerance in case.some(rows, 2):
        scene = {"relaxation": {"method": "preconditioned", "tolerance": tolerance}, "materials": {"base": {"density": 0}, "stone": {"density": 2400}, "cap": {"density": 0}},
                 "joints": {"default": {"k_n": 1e9, "k_s": 4e8, "friction": friction}, "cap": {"k_n": 1e9, "k_s": 4e8, "friction": 0}}, "supports": {"base": {"fix": "xy"}},
                 "loads": {"weight": {"type": "self_weight", "groups": ["stone"]}} | {f"by_{push}": {"type": "traction", "faces": "pushed", "value": [push, 0]} for push in pushes},
                 "stages": [{"weight": {"loads": ["weight"]}}, *({f"by_{push}": {"from": "weight", "loads": ["weight", f"by_{push}"]}} for push in pushes)]}  # fmt: skip
        mesh = courses(nx, ny, size, width)
        result = case.run(mesh, scene)
        of_cap = mesh.vertices[:, 1] > ny * size / 2
        of_cap[np.unique(mesh.blocks[-1][mesh.blocks[-1] >= 0])] = True
        for push in pushes:
            moved = abs(result.stage(f"by_{push}").displacement - result.stage("weight").displacement).max(axis=1)
            verdicts.append(result.stage_summary(f"by_{push}")["verdict"])
            farther.append(bool(moved[of_cap].max() > 1.5 * moved[~of_cap].max()))
    case.check("weightless caps without friction on courses that are pushed a little: verdicts", json.dumps(verdicts), json.dumps(["converged"] * len(verdicts)))
    case.check("... move farther than what they stand on", json.dumps(farther), json.dumps([False] * len(farther)))


def taken_off(case):
    """A stage without loads is measured by the loads that it takes off, not by its rounding; behind such a one nothing measures it, which is reported."""
    scene = changed(JAWS, ("materials.block.density", 2400), ("joints.default.friction", 40), ("relaxation", {"max_cycles": 3000}),
                    ("stages", [{"all": {"loads": ["weight", "press"]}}, {"off": {"loads": []}}, {"again": {"loads": ["weight", "press"]}}, {"none": {"loads": []}}, {"still": {"loads": []}}]))  # fmt: skip
    del scene["joints"]["glue"]
    for method in METHODS:
        for strain in ("small", "large"):
            result = case.run(jaws(False), changed(scene, ("relaxation.method", method), ("strain", strain)))
            size = abs(result.stage("all").displacement).max()
            case.check(f"all loads taken off, {method}, {strain} strain: verdicts", [result.stage_summary(stage)["verdict"] for stage in ("off", "again", "none")], ["converged"] * 3)
            case.check("... comes back: displacement over that under the loads", abs(result.stage("off").displacement).max() / size, 0.0, absolute=1e-4)
            last = result.stage_summary("still")
            case.check("... once more without loads: converged, or says why not", last["verdict"] == "converged" or "no load acts" in last["evidence"], True)


def ranks(case):
    sums = [case.run(jaws(False, 2), JAWS, ranks=n).stage_summary("all")["checksum"] for n in (1, 2)]
    case.check("explicit, 1 and 2 ranks: the same verdict in the same cycle: checksums", sums[1], sums[0])


def run(case):
    between_jaws(case)
    cap(case)
    drift(case)
    taken_off(case)
    ranks(case)
