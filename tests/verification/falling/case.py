"""Blocks that fall: a column of ten drops and comes to rest; a block slides off an edge, falls and lands on another."""

import hashlib
import json

import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "restitution by dashpots; a column of ten falls and comes to rest; a block slides off an edge, falls and lands"
SOURCE = "at rest: closure = weight above / k_n; energy: none gained, what is lost went into joints; the run on one rank"
BY = "by hand; Quoin itself, one rank"

G, RHO, K_N = 9.81, 2400.0, 1e9
SCENE = {
    "contact": {"connectivity": "variable", "tolerance": 0.005, "initial_gaps": "real"},
    "relaxation": {"allow_floating": True, "history_every": 200},
    "materials": {"block": {"density": RHO}, "base": {"density": RHO}},
    "joints": {"default": {"k_n": K_N, "k_s": K_N, "friction": 35, "damping": 5e-4}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}
WIDTH, HEIGHT, GAP, N = 1.0, 0.5, 0.05, 10


def run(case):
    restitution(case)
    on_a_sharp_edge(case)
    beside_a_heavy_body(case)
    column(case)
    off_the_edge(case)
    pushed(case)
    spun(case)


def pushed(case):
    """A free block under a force or traction that a file changes: up to F at T, gone at 2 T, after a pause; velocity and way are its integrals."""
    width, height, F, T = 1.0, 0.5, 6e3, 0.1
    mass = RHO * width * height
    way = F / mass * (T**2 / 6 + T / 2 * T + T**2 / 3 + T * T)  # ramp up; on at F T / 2 m; ramp down; on at F T / m
    loads = {"force": {"type": "point_force", "point": "mark", "value": [F, 0], "history": "push.csv"},
             "traction": {"type": "traction", "faces": "left", "value": [F / height, 0], "history": "push.csv"},
             "pressure": {"type": "pressure", "faces": "left", "pressure": F / height, "history": "push.csv"}}
    soft = {"density": RHO, "young": 1e9, "poisson": 0.2}
    for strain in ("small", "large"):
        for what, material in (("rigid", {"density": RHO}), ("deformable", soft)):
            for load in ("pressure", "traction") if what != "rigid" else loads:
                n = 1 if what == "rigid" else 4
                mesh = join([renamed(rectangle(0, 0, width, height, n, n if n > 1 else 2, group="block", rigid=what == "rigid"), {"left": "left"})])
                mesh.points = {"mark": int(np.flatnonzero((mesh.vertices == [0, height / 2]).all(axis=1))[0])}
                stage = {"type": "dynamic", "loads": [load], "duration": 4 * T, "dt_factor": 0.2}
                scene = {"strain": strain, "relaxation": {"allow_floating": True}, "materials": {"block": material}, "joints": SCENE["joints"],
                         "loads": {load: loads[load]}, "stages": [{"push": stage}]}
                results = []
                for ranks in (1, 2) if n > 1 and what == "deformable" else (1,):
                    folder = case.prepare(mesh, scene)
                    (folder / "push.csv").write_text(f"0, 0\n{T}, 0\n{2 * T}, 1\n{3 * T}, 0\n")
                    results.append(case.again(folder, ranks=ranks))
                result = results[0].stage_summary("push")
                centre = results[0].stage("push").displacement.mean(axis=0)
                case.check(f"{what}, {strain} strain, {load} in time: way of the centre [m]", centre, [way, 0], absolute=2e-3 * way)
                case.check("... kinetic energy [J]", result["energy"]["kinetic"], 0.5 * mass * (F * T / mass) ** 2, relative=5e-3)
                if len(results) > 1:
                    case.check("... the same bits on 2 ranks", results[1].stage_summary("push")["checksum"], result["checksum"])
    standing = join([mesh, renamed(rectangle(0, -0.5, width, 0.5, 4, 1, group="base", rigid=True), {})])
    found = []
    for keys in ({}, {"condensed": True, "highest_frequency": 1e9}):
        one = {"strain": "small", "materials": {"block": soft | keys, "base": {"density": RHO}}, "supports": {"base": {"fix": "xy"}},
               "joints": {"default": {"k_n": K_N, "k_s": K_N, "law": "elastic"}}, "loads": scene["loads"], "stages": [{"push": stage | {"dt_factor": 0.05}}]}
        folder = case.prepare(standing, one)
        (folder / "push.csv").write_text(f"0, 0\n{T}, 0\n{2 * T}, 1\n{3 * T}, 0\n")
        found.append(case.again(folder).history["mark_ux_m"])
    times = [np.linspace(0, 1, len(u)) for u in found]
    apart = abs(np.interp(times[0], times[1], found[1]) - found[0]).max() / abs(found[0]).max()
    case.check("on an elastic joint, condensed with all modes: displacement over the largest", apart, 0.0, absolute=5e-3)
    still = case.prepare(mesh, changed(scene, ("stages", [{"push": {"loads": ["traction"]}}])))
    (still / "push.csv").write_text("0, 0\n1, 1\n")
    case.check("a static stage refuses a load in time", "followed in dynamic stages only" in case.again(still).stderr, True)


def spun(case):
    """A uniform pressure on the lower half of the left side of a free rigid block: the moment stays, and the force turns with the face.
    turned = M t^2 / 2 I; velocity = force / m times the integral of (cos, sin)(turned), by Simpson's rule. In small strain the force stays."""
    width, height, p, duration = 1.0, 0.5, 6e3, 1.2
    force, mass = p * height / 2, RHO * width * height
    alpha = force * height / 4 / (mass * (width**2 + height**2) / 12)
    t = np.linspace(0, duration, 2001)
    weights = np.array([1, *([4, 2] * 999), 4, 1]) * (t[1] - t[0]) / 3
    mesh = join([renamed(rectangle(0, 0, width, height, 1, 2, group="block", rigid=True), {})])
    mesh.face_sets = {"low": np.array([[0, 3]])}
    for strain, turned in (("large", alpha * t**2 / 2), ("small", 0 * t)):
        scene = {"strain": strain, "relaxation": {"allow_floating": True}, "materials": {"block": {"density": RHO}}, "joints": SCENE["joints"],
                 "loads": {"gas": {"type": "pressure", "faces": "low", "pressure": p}}, "stages": [{"spin": {"type": "dynamic", "loads": ["gas"], "duration": duration, "dt_factor": 0.2}}]}  # fmt: skip
        result = case.run(mesh, scene)
        velocity = force / mass * np.array([weights @ np.cos(turned), weights @ np.sin(turned)])
        energy = 0.5 * mass * velocity @ velocity + 0.5 * mass * (width**2 + height**2) / 12 * (alpha * duration) ** 2
        found = result.stage_summary("spin")
        case.check(f"a pressure off the centre, {strain} strain: kinetic energy [J]", found["energy"]["kinetic"], energy, relative=2e-3)
        case.check("... it is the work of the pressure [J]", found["energy"]["outside"], energy, relative=2e-3)


def restitution(case):
    """A block flies flat onto a joint with a dashpot, m x'' + 2 zeta w m x' + w^2 m x = 0 with w^2 = k_n L / m, zeta = damping w / 2,
    until the joint would pull: x'' = 0. With x(0) = 0, x'(0) = v that is at w_d t = atan2(2 zeta r, 2 zeta^2 - 1), r^2 = 1 - zeta^2,
    w_d = r w, and the speed is then e v, e = exp(-zeta w t); beyond zeta = 1 with the hyperbolic functions. The blow comes anywhere within a step."""
    width, height, v = 1.0, 0.5, -1.0
    w = np.sqrt(K_N * width / (RHO * width * height))

    def found(zeta, factor, gap):
        mesh = join([renamed(rectangle(-1, -1, 3, 1, group="base", rigid=True), {}),
                     renamed(rectangle(0, gap, width, height, group="block", rigid=True), {}, {"mark": "top_right"})])
        return mesh, changed(SCENE, ("loads", {"none": {"type": "point_force", "point": "mark", "value": [0, 0]}}),
                             ("materials.block.velocity", [0.0, v]), ("joints.default.damping", float(2 * zeta / w)),
                             ("stages", [{"hit": {"type": "dynamic", "loads": ["none"], "duration": 0.008, "dt_factor": factor}}]))

    for z in case.some((0.05, 0.2, 0.5, 0.8, 0.95, 2.0), 3):
        r = np.sqrt(abs(1 - z**2))
        e = np.exp(-z / r * (np.arctan2(2 * z * r, 2 * z**2 - 1) if z < 1 else np.arctanh(2 * z * r / (2 * z**2 - 1))))
        results = case.run_all([found(z, factor, gap) for factor, gap in ((0.005, 1e-3), (0.1, 1e-3), (0.1, 1.03e-3), (0.1, 1.07e-3))])
        ours = np.sqrt([result.stage_summary("hit")["energy"]["kinetic"] / (0.5 * RHO * width * height * v**2) for result in results])
        case.check(f"restitution of a flat fall on a joint with dashpot, zeta = {z:g}", ours[0], e, relative=1e-4)
        case.check("... 0.1 of the bound, three phases of the blow within a step", ours[1:], e, relative=2e-3)


def on_a_sharp_edge(case):
    """A square comes down corner first on a level top whose sides lean below it. In front of the top it stands behind the line of a
    side, and abreast of that side: it is not in the body. It moves as on a top with upright sides, and so does a mesh of the square."""
    def found(lean, at, inner=False, ranks=1):
        k, h, a = np.tan(np.radians(lean)), 0.4, np.radians(40.0)
        base = BlockMesh(np.array([[-1 + k * h, -h], [1 - k * h, -h], [1.0, 0.0], [-1.0, 0.0]]), np.array([[0, 1, 2, 3]]), np.zeros(1), ["base"], [1], {}, {})
        square = renamed(rectangle(0, 0, 1, 1, *((2, 2) if inner else (1, 1)), group="block", rigid=not inner), {}, {"a": "bottom_left", "b": "bottom_right"})
        square.vertices[:] = square.vertices @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) + [at, 0.1]
        young = {"young": 1e8, "poisson": 0.2} if inner else {}
        return join([base, square]), changed(SCENE, ("materials.block", {"density": RHO, "rigid": not inner} | young), ("materials.base.rigid", True),
            ("joints.default.damping", 5e-5), ("stages", [{"fall": {"type": "dynamic", "loads": ["weight"], "duration": 0.4, "dt_factor": 0.2}}]))  # fmt: skip

    def turn(result):
        (xa, ya), (xb, yb) = (result.probe("fall", name) for name in "ab")
        a = np.radians(40.0)
        return np.arctan2(np.sin(a) + yb - ya, np.cos(a) + xb - xa) - a

    for inner in (False, True):
        runs = [found(lean, at, inner) for lean, at in ((0, 0.6), (5, 0.6), (20, 0.75), (40, -0.5), (60, 0.9))]
        results = case.run_all(runs)
        what = "square of four blocks" if inner else "rigid square"
        case.check(f"{what}, corner first near an edge of 85 to 30 degrees: turned [rad]", [turn(r) for r in results[1:]], turn(results[0]), absolute=1e-6)
        made = [abs(r.stage_summary("fall")["energy"]["detection"]) / r.stage_summary("fall")["energy"]["outside"] for r in results]
        case.check("... made by finding contacts again, over the work of the weight", made, 0.0, absolute=1e-3)
        other = case.run(*runs[2], ranks=2)
        case.check("... on 2 ranks: checksum", other.stage_summary("fall")["checksum"], results[2].stage_summary("fall")["checksum"])


def beside_a_heavy_body(case):
    """A square that is too fast for its step sinks in between two searches, and its contact begins with energy from nothing. That is
    reported whatever else moves: a body of 1200 t that falls far away has 6e9 J, of which it is a millionth part."""
    a = np.radians(40.0)
    base = renamed(rectangle(-1, -1, 4, 1, group="base", rigid=True), {})
    square = renamed(rectangle(0, 0, 0.5, 0.5, group="block", rigid=True), {})
    square.vertices[:] = square.vertices @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) + [1, 0.1]
    heavy = renamed(rectangle(50, 50, 20, 20, group="heavy", rigid=True), {})
    for speed in (0.5, 40.0, 60.0):
        scene = changed(SCENE, ("materials.block.velocity", [0.0, -speed]), ("joints.default", {"k_n": 1e10, "k_s": 1e10, "friction": 30, "stress_model": "pt"}),
                        ("stages", [{"fall": {"type": "dynamic", "loads": ["weight"], "duration": 0.02 if speed > 1 else 0.2, "dt_factor": 0.9}}]))
        alone = case.run(join([base, square]), scene)
        both = case.run(join([base, square, heavy]), changed(scene, ("materials.heavy", {"density": 3000, "velocity": [0.0, -100.0]})))
        wanted = "completed" if speed < 1 else "diverged"
        case.check(f"square at {speed:g} m/s, alone and beside a heavy body that falls elsewhere", json.dumps([r.stage_summary("fall")["verdict"] for r in (alone, both)]), json.dumps([wanted] * 2))


def digest(stage):
    """A hash of all bits of a frame: displacements, rotations, and of every contact its place, history and forces."""
    c = stage.contacts
    arrays = [stage.displacement, stage.rotation, c.face, c.length, c.opening, c.sliding, c.slip, c.sigma, c.tau, c.force, c.state]
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()


def on_ranks(case, what, mesh, scene, stage, *ranks):
    """The first part of the run on several ranks: at every frame the bits of one rank."""
    ranks = case.ranks(*ranks)
    results = [case.run(mesh, scene, ranks=n) for n in (1, *ranks)]
    frames = [[digest(result.stage(name)) for name in [*result.frames(stage), stage]] for result in results]
    others = [sum(a == b for a, b in zip(frames[0], other)) for other in frames[1:]]
    case.check(f"{what}: frames of {len(frames[0])} with the bits of one rank, on {', '.join(map(str, ranks))} ranks",
               json.dumps(others), json.dumps([len(frames[0])] * len(ranks)))
    case.check("... checksum of the state at the end", json.dumps(sorted({r.stage_summary(stage)["checksum"] for r in results})),
               json.dumps([results[0].stage_summary(stage)["checksum"]]))


def energy_of(case, what, result, stage):
    """Nothing is gained on the way, and the account is closed."""
    h = result.history
    mine = (h["stage"] == stage) & np.isfinite(h["balance_J"])
    moved = np.abs(h["outside_J"][mine]).max()
    stored = sum(h[name][mine] for name in ("kinetic_J", "strain_J", "joints_J"))
    gained = stored - h["outside_J"][mine]
    gained = gained - gained[0]
    case.check(f"{what}: energy never more than the weight has worked, over that work", max(0.0, gained.max() / moved), 0.0,
               absolute=1e-3)
    case.check(f"{what}: balance of the account, over that work", h["balance_J"][mine] / moved, 0.0, absolute=1e-2)
    case.check(f"{what}: made by finding contacts again, over that work", np.abs(h["detection_J"][mine]).max() / moved, 0.0,
               absolute=1e-2)
    return moved


def deepest(result, stage):
    """Deepest closure of a contact over all frames [m]."""
    return max(-min(result.stage(name).contacts.opening.min(initial=0.0), 0.0) for name in [*result.frames(stage), stage])


def column(case):
    bodies = [rectangle(-0.5, -1, 2, 1, group="base", rigid=True)]
    for i in range(N):
        bodies.append(rectangle(0, (i + 1) * GAP + i * HEIGHT, WIDTH, HEIGHT, group="block", rigid=True))
    mesh = join([renamed(body, {}, {f"block_{i}": "bottom_left"} if i else {}) for i, body in enumerate(bodies)])
    fall = {"type": "dynamic", "loads": ["weight"], "duration": 3.0, "frames": 100, "dt_factor": 0.1}
    scene = changed(SCENE, ("stages", [{"fall": fall | {"duration": 0.3, "frames": 49}}]))
    on_ranks(case, "column of ten", mesh, scene, "fall", 2, 3, 4)
    result = case.run(mesh, changed(SCENE, ("stages", [{"fall": fall}])))
    weight = RHO * G * WIDTH * HEIGHT
    energy_of(case, "column of ten", result, "fall")
    y = np.array([result.probe("fall", f"block_{i}") for i in range(1, N + 1)])
    closure = np.cumsum(weight * np.arange(N, 0, -1) / (K_N * WIDTH))
    case.check("column of ten at rest: closure of the joints [m]", -y[:, 1] - GAP * np.arange(1, N + 1), closure, relative=0.01)
    case.check("... moved sideways [m]", y[:, 0], 0.0, absolute=1e-6)
    energy = result.stage_summary("fall")["energy"]
    case.check("... lost in joints over the work of the weight", energy["friction"] / energy["outside"], 1.0, relative=0.001)
    # ten blocks together that stop from the fall of the whole column press no deeper than a spring that takes all its energy
    fall = N * weight * GAP * (N + 1) / 2
    case.check("... overlap no deeper than k_n explains", bool(deepest(result, "fall") < np.sqrt(2 * fall / (K_N * WIDTH))), True)


def off_the_edge(case):
    high = rectangle(0, 0, 1.5, 1.0, group="base", rigid=True)
    low = [rectangle(x, 0, 1.5, 0.3, group="base", rigid=True) for x in (1.7, 3.2)]
    block = rectangle(0.9, 1.0, 0.5, 0.25, group="block", rigid=True)
    mesh = join([*(renamed(body, {}) for body in (high, *low)), renamed(block, {}, {"block": "bottom_left", "top": "top_right"})])
    slide = {"type": "dynamic", "loads": ["weight"], "duration": 2.0, "frames": 100, "dt_factor": 0.1,
             "joints": {"default": {"friction": 10}}}
    scene = changed(SCENE, ("stages", [{"rest": {"loads": ["weight"]}}, {"slide": slide}]), ("materials.block.velocity", [2.0, 0.0]),
                    ("joints.default.damping", 4e-3))
    first = [{"rest": {"loads": ["weight"]}}, {"slide": slide | {"duration": 0.8, "frames": 49}}]
    on_ranks(case, "off the edge, until it has landed", mesh, changed(scene, ("stages", first)), "slide", 2, 3, 4)
    result = case.run(mesh, scene)
    moved = energy_of(case, "off the edge", result, "slide")
    kinetic = 0.5 * RHO * 0.125 * 2.0**2
    # a corner of tptm stores k_n delta^3 cot(20 degrees)/6, and its dashpot has only what of it is closed
    case.check("off the edge: overlap no deeper than a spring of one corner that takes all its energy",
               bool(deepest(result, "slide") < np.cbrt(6 * (moved + kinetic) / K_N * np.tan(np.radians(20)))), True)
    mid = result.stage("slide").displacement[-4:] + result.mesh.vertices[-4:]
    case.check("... it has landed on the lower block: height of its lowest corner [m]", mid[:, 1].min(), 0.3, absolute=1e-3)
    case.report("... kinetic energy left [J]", result.stage_summary("slide")["energy"]["kinetic"], 0.0)
