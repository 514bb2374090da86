"""Hinges of rigid blocks: the compressed length that tptm gives them, and the limit that falls short by it (docs/rigid_blocks.md)."""

import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed
from quoin_tools.mesh.stacks import block_on_plane

WHAT = "hinges of rigid blocks: compressed length, and limits of columns and arches as k_n goes"
SOURCE = "a = (12 W h / k_n)^(1/3): a column of weight W, its centre h above the base, tips at 1 - a/b of the rigid limit; Milankovitch: t/R = 0.1075"
BY = "by hand; Milankovitch"

G, RHO, B, H = 9.81, 2400.0, 1.0, 10.0
SCENE = {
    "materials": {"block": {"density": RHO}, "base": {"density": RHO}},
    "joints": {"default": {"k_n": 1e10, "k_s": 1e10, "friction": 60}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
    "stages": [{"rest": {"loads": ["weight"]}}],
}


def hinge_length(weight, height, k_n):
    """Compressed length at which a column tips: what its lean takes from the moment that is left is largest there."""
    return np.cbrt(12 * weight * height / k_n)


def tilted(slope):
    return block_on_plane(B, H, np.degrees(slope), plane_length=6 * B, start=2 * B)


def run(case):
    compressed_length(case)
    tipping(case)
    flooded(case)
    arches(case)


def compressed_length(case):
    """Small strain: three times the distance of the resultant from the edge."""
    slope = np.arctan(0.8 * B / H)
    found = case.run(tilted(slope), changed(SCENE, ("strain", "small"), ("joints.default.k_n", 1e12), ("joints.default.k_s", 1e12)))
    case.check("column of 1 x 10 m on a slope, small strain: compressed length over the face", found.stage_summary("rest")["hinges"]["least"],
               3 * (B / 2 - H / 2 * np.tan(slope)) / B, relative=1e-3)  # fmt: skip
    down, up = np.array([np.cos(slope), -np.sin(slope)]), np.array([np.sin(slope), np.cos(slope)])
    place = lambda along, above: (along - 6 * B) * down + above * up  # noqa: E731
    feather = quad_patch(place(4.5, 0), place(5.5, 0), place(5.5, 1.2 * H), place(4.5, 1.2 * H), 1, 1, "feather", True)
    beside = changed(SCENE, ("strain", "small"), ("joints.default.k_n", 1e12), ("joints.default.k_s", 1e12), ("materials.feather", {"density": 0.01 * RHO}),
                     ("loads.weight.groups", ["block", "feather"]))
    both = case.run(join([tilted(slope), renamed(feather, {})]), beside).stage_summary("rest")["hinges"]
    case.check("... beside one of 12 m that bears a hundredth: hinges that count, compressed length over the face", [both["n"], both["least"]],
               [1, 3 * (B / 2 - H / 2 * np.tan(slope)) / B], relative=1e-3)  # fmt: skip
    flat = case.run(tilted(np.arctan(0.2 * B / H)), SCENE)
    case.check("... closed over more than half of its face: no hinge", "hinges" in flat.stage_summary("rest"), False)


def tipping(case):
    for k_n in (1e10, 1e11):
        slope, verdicts = 0.0, []
        for side in (0.996, 1.004):
            slope = np.arctan(B / H)
            for _ in range(5):  # the weight square to the base is that on the slope
                slope = np.arctan(B / H * (1 - hinge_length(RHO * G * B * H * np.cos(slope), H / 2, k_n) / B))
            run = case.run(tilted(np.arctan(side * np.tan(slope))), changed(SCENE, ("joints.default.k_n", k_n), ("joints.default.k_s", k_n)))
            verdicts.append(run.verdict)
        case.check(f"column, k_n {k_n:g}: 0.4 % before and behind 1 - a/b = {np.tan(slope) / (B / H):.4f} of the rigid limit", verdicts,
                   ["converged", "collapsed"])


def flooded(case):
    """Trials with water on a column: level at which it tips, and what each trial says of its hinge."""
    width, k_n = 2.0, 1e10
    mesh = join([renamed(rectangle(0.0, 0.0, width, H, group="block", rigid=True), {"upstream": "left"}),
                 renamed(rectangle(-3.0, -1.0, 9.0, 1.0, group="base", rigid=True))])
    weight = RHO * G * width * H
    stages = [{"rest": {"loads": ["weight", "water"]}}, {"flood": {"type": "flood", "loads": ["weight", "water"], "limit": 7, "bracket": 0.05}}]
    scene = changed(SCENE, ("joints.default.k_n", k_n), ("joints.default.k_s", k_n), ("stages", stages),
                    ("loads.water", {"type": "reservoir", "faces": "upstream", "level": 5}))
    run = case.run(mesh, scene)
    found, length = run.stage_summary("flood")["flood"], hinge_length(weight, H / 2, k_n)
    rigid = np.cbrt(3 * weight * width / (1000 * G))
    level = rigid * np.cbrt(1 - length / width)
    case.report("column of 2 x 10 m, water: rigid limit [m], of which the last stable level is", found["stable"] / rigid, 1.0)
    case.check("... the bracket holds the level with the hinge, within 0.5 % [m]", [found["stable"] <= 1.005 * level, found["failing"] >= 0.995 * level], [True, True])
    last = next(t for t in found["trials"] if t["value"] == found["stable"])
    case.check("... compressed length at the last stable level, 1 to 1.4 of that at the limit", 1.0 <= last["hinges"]["least"] * width / length <= 1.4, True)
    case.check("... of the mechanism the same", run.stage_summary("flood")["hinges"]["governing"], last["hinges"]["least"], relative=1e-9)
    beside = renamed(rectangle(-9.0, 0.0, width, H / 2, group="block", rigid=True), {"pushed": "left"})
    ground = renamed(rectangle(-12.0, -1.0, 8.9, 1.0, group="base", rigid=True))
    push = {"type": "traction", "faces": "pushed", "value": [0.95 * weight * width / 2 / (H / 2) ** 2, 0.0]}  # of W b/2: pressed over 0.06 b
    loads = ["weight", "water", "push"]
    both = case.run(join([mesh, beside, ground]),
                    changed(scene, ("loads.push", push), ("stages", [{"rest": {"loads": loads}}, {"flood": stages[1]["flood"] | {"loads": loads}}])))
    hinges, alone = both.stage_summary("flood")["hinges"], last["hinges"]["least"]
    case.check("... beside a column that stands on less of its face: it is no part of the mechanism", [hinges["least"] < 0.9 * alone, abs(hinges["governing"] - alone) < 0.05 * alone],
               [True, True])  # fmt: skip
    case.report("... compressed lengths over the face: least of all, of the mechanism [-]", hinges["least"], hinges["governing"])
    case.check("... it is printed", f"hinges pressed over {last['hinges']['least']:.2g} of the face" in run.stdout, True)


def arch(ratio, n=30, radius=10.0):
    """A semicircle of voussoirs between two blocks, thickness over radius of its middle line: ratio."""
    at, half, parts = np.linspace(0, np.pi, n + 1), 0.5 * ratio * radius, []
    for a, b in zip(at[:-1], at[1:]):
        corners = [[r * np.cos(x), r * np.sin(x)] for x, r in ((a, radius - half), (a, radius + half), (b, radius + half), (b, radius - half))]
        parts.append(BlockMesh(np.array(corners), np.array([[0, 1, 2, 3]]), np.zeros(1), ["block"], [1], {}, {}))
    parts += [renamed(rectangle(x, -1.0, 8 * half, 1.0, group="base", rigid=True)) for x in (-radius - 4 * half, radius - 4 * half)]
    return join(parts)


def arches(case):
    """t/R = 0.115 stands by statics (0.1075): with k_n 1e12, not with 1e10."""
    verdicts = [case.run(arch(0.115), changed(SCENE, ("joints.default", {"k_n": k_n, "k_s": k_n, "friction": 70}),
                                              ("relaxation", {"tolerance": 1e-5}))).verdict for k_n in (1e10, 1e12)]  # fmt: skip
    case.check("arch of 30 stones, t/R = 0.115, k_n 1e10 and 1e12", verdicts, ["collapsed", "converged"])
