"""A rigid block 1 m by 0.2 m on a plane of 30 degrees whose friction is lowered, stage by stage (V05, static part)."""

import json

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed
from quoin_tools.mesh.stacks import block_on_plane

WHAT = "block on an incline of 30 degrees: stays above, slides below (V05, static part); what only carries has not failed"
SOURCE = "N = W cos(30), T = W sin(30); slides when the friction angle is less than 30 degrees"
BY = "by hand"

WEIGHT = 2400 * 9.81 * 1.0 * 0.2
SCENE = {
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 1000},
    "materials": {"block": {"density": 2400}, "base": {"density": 0}},
    "joints": {"default": {"k_n": 10e9, "k_s": 10e9, "friction": 45}, "joint": {}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}


def run(case):
    mesh = block_on_plane()
    for angles in ((31, 29), (30.01, 29.99)):
        stages = [{"rough": {"loads": ["weight"]}}]
        stages += [{f"phi_{i}": {"loads": ["weight"], "joints": {"joint": {"friction": phi}}}} for i, phi in enumerate(angles)]
        result = case.run(mesh, changed(SCENE, ("stages", stages)))
        joint = result.stage_summary("phi_0")["joints"]["joint"]
        case.check(f"phi = {angles[0]}: stays", result.stage("phi_0").verdict, "converged")
        case.check("... N and T on the plane [N]", [joint["N"], abs(joint["T"])],
                   WEIGHT * np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)]), relative=1e-6)
        case.check(f"phi = {angles[1]}: slides", result.stage("phi_1").verdict, "collapsed")
    unbroken(case)
    side_by_side(case)


def planes(angles):
    """A plane of each slope [degree], cut in four, 20 m from the next; on each two blocks of 2 x 0.5 m across the cuts."""
    bodies = []
    for i, angle in enumerate(np.radians(angles)):
        origin, e, n = np.array([20.0 * i, 0.0]), np.array([np.cos(angle), -np.sin(angle)]), np.array([np.sin(angle), np.cos(angle)])
        for x in (-4, -2, 0, 2):
            p, q = origin + x * e, origin + (x + 2) * e
            bodies.append(renamed(quad_patch(p - 2 * n, q - 2 * n, q, p, 1, 1, "base", True), {}))
        for k, x in enumerate((-3.0, 0.5)):
            p, q = origin + x * e, origin + (x + 2) * e
            bodies.append(renamed(quad_patch(p, q, q + 0.5 * n, p + 0.5 * n, 1, 1, "block", True), {}, {f"at_{i}_{k}": "bottom_left"}))
    return join(bodies)


def unbroken(case):
    """Blocks whose joints carry their weight have not failed: not by the rounding of contacts that do not match, nor as they are verified.
    A rigid block sinks by W cos(slope) / k_n b in its middle and slides by W sin(slope) / k_s b."""
    for what, row, angles in (("cohesion 100 kPa, no tension", {"cohesion": 100e3}, (0, 5, 10, 17, 25, 30, 38, 46)),
                              ("friction 45, residual 30", {"friction_residual": 30}, (0, 3, 7, 10, 13, 17, 20, 25))):
        scene = changed(SCENE, ("joints", {"default": SCENE["joints"]["default"] | row}), ("contact", {"connectivity": "variable"}),
                        ("stages", [{"sw": {"loads": ["weight"]}}, {"again": {"loads": ["weight"]}}]))
        results = [case.run(planes(angles), scene, ranks=ranks) for ranks in (1, 2)]
        contacts = results[0].stage("again").contacts
        case.check(f"16 blocks on planes of 8 slopes, {what}: broken by weight alone", int(np.count_nonzero(contacts.broken)), 0)
        slopes, k_n = np.radians(angles), 10e9
        slid = [[-np.dot(results[0].probe("again", f"at_{i}_{k}"), [-np.cos(a), np.sin(a)]) for k in (0, 1)] for i, a in enumerate(slopes)]
        middle = 2400 * 9.81 * 0.5 * np.sin(slopes) / k_n  # of the plane of contact
        case.check("... slides by W sin / k_s b [m]", slid, np.repeat(middle[:, None], 2, 1), absolute=1e-10)
        case.check("... on two ranks", *(json.dumps([s["checksum"] for s in r.summary["stages"]]) for r in results[::-1]))


def side_by_side(case):
    """A block of 1 m in a slot, cohesion 13 kPa on both sides, which bears nothing while the block weighs on the floor; then a pull of 10 kPa
    more than its weight is carried by cohesion alone: 5 kPa on each side. So it does when its weight has come in a stage before."""
    at = (0.0, 1 / 3, 100 / 7)
    bodies = []
    for i, x in enumerate(at):
        x += 10 * i
        walls = [rectangle(x - 1, -1, 3, 1, group="base", rigid=True), rectangle(x - 1, 0, 1, 1, group="base", rigid=True),
                 rectangle(x + 1, 0, 1, 1, group="base", rigid=True)]
        block = renamed(rectangle(x, 0, 1, 1, group="block", rigid=True), {"top": "top", "left": "left", "right": "right"}, {f"at_{i}": "top_left"})
        bodies += [*(renamed(wall, {}) for wall in walls), block]
    row, sides = SCENE["joints"]["default"], {"left": {"cohesion": 13e3}, "right": {"cohesion": 13e3}}
    for how in ("fixed", "variable"):
        scene = changed(SCENE, ("joints", {"default": row} | sides), ("contact", {"connectivity": how}),
                        ("relaxation", {"tolerance": 1e-6}),
                        ("loads.pull", {"type": "traction", "faces": "top", "value": [0, 2400 * 9.81 + 10e3]}),
                        ("stages", [{"sw": {"loads": ["weight"]}}, {"pull": {"loads": ["weight", "pull"]}}]))
        for first in (0, 1):
            result = case.run(join(bodies), changed(scene, ("stages", scene["stages"][first:])))
            what = f"three blocks in slots, {how}, pulled {'at once' if first else 'after a stage of weight'}"
            case.check(f"{what}: verdict", result.stage("pull").verdict, "converged")
            if result.exit_code == 0:
                case.check("... rise by pull / 2 k_s h [m]", [result.probe("pull", f"at_{i}")[1] for i in range(3)], 10e3 / (2 * 10e9),
                           relative=1e-4)
