"""Slopes that come to rest on a cushion or a tendon, and joints of several strengths and residuals: the methods against each other, and by hand."""

import numpy as np
from quoin_tools.mesh.meshing import face_set_on, join, quad_patch, rectangle, renamed
from runs import Scene, bracket, elastic, frame, gap_of, joint, solved
from scipy.optimize import brentq
from twins import mirror

G = 9.81


# ---- slopes ----------------------------------------------------------------------------------------------

def comes_to_rest(rng):
    """A block on a slope whose friction is lowered below the slope: W (sin - tan(phi) cos) is what the stop takes, with friction of what it presses on the slope."""
    dip, scale = float(rng.uniform(15, 35)), float(10 ** rng.uniform(-1, 0.3))
    angle = np.radians(dip)
    down, up = np.array([np.cos(angle), -np.sin(angle)]), np.array([np.sin(angle), np.cos(angle)])
    length, height = 20 * scale, float(rng.uniform(2, 6)) * scale
    def body(at, to, nx=1, ny=1, group="base", stiff=True):
        corner = [s * down + h * up for s, h in ((at[0], at[1]), (to[0], at[1]), (to[0], to[1]), (at[0], to[1]))]
        return quad_patch(*corner, nx, ny, group, stiff)
    rigid, nx = bool(rng.random() < 0.4), int(rng.integers(2, 12))
    block = renamed(body((0, 0), (length, height), nx, 1 if rigid else max(1, nx // 4), "block", rigid), {}, {"toe": "bottom_right"})
    bodies = [renamed(body((-0.5 * length, -4 * scale), (2 * length, 0))), block]
    friction = float(dip - rng.uniform(0.3, 4))
    k_n = float(10 ** rng.uniform(9.5, 10.5)) / scale
    stuff = {"density": 2400.0} if rigid else {"density": 2400.0, "young": 10e9, "poisson": 0.2}
    mu = np.tan(np.radians(friction))
    drives = 2400 * G * length * height * (np.sin(angle) - mu * np.cos(angle))
    way = float(10 ** rng.uniform(-3.5, -1.0)) * scale * 5  # [m] that the stop is to give: up to 2.5 % of the length
    keys = frame(materials={"block": stuff, "base": {"density": 0}}, joints={"default": {"k_n": k_n, "k_s": 0.5 * k_n, "friction": dip + 15}}, supports={"base": {"fix": "xy"}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}},
                 stages=[{"rest": {"loads": ["weight"]}}, {"go": {"loads": ["weight"], "joints": {"default": {"friction": friction}}}}])
    if rng.random() < 0.5:
        deep, high = 2 * scale, height * 0.7
        young = drives * deep / (way * high)
        bodies += [renamed(body((length, 0.1 * height), (length + deep, 0.8 * height), 1, 2, "cushion", False)), renamed(body((length + deep, 0), (length + 2 * deep, height), group="stop"))]
        keys["materials"] |= {"stop": {"density": 0}, "cushion": {"density": 0, "young": young, "poisson": 0.0}}
        keys["joints"] |= {"block+cushion": {"friction": 0}, "cushion+stop": {"law": "elastic"}, "base+stop": {"law": "elastic"}}
        keys["supports"]["stop"] = {"fix": "xy"}
        # St Venant-Kirchhoff, no Poisson's ratio: force over E and height as the cushion is squeezed by e
        squeeze = brentq(lambda e: (1 - e) * (e - e * e / 2) - drives / (young * high), 0, 0.42) if drives / (young * high) < 0.19 else np.nan
        expected = deep * squeeze + 2 * drives / (k_n * high)
    else:
        head, root = 0.05 * length * down + 0.1 * height * up, -0.45 * length * down - 1.0 * scale * up
        far = np.hypot(*(head - root))
        pull = (root - head) / far
        along, into = -pull @ down, -pull @ up
        k = drives / (along * (along + mu * into) * way)
        keys["anchors"] = {"a": {"head": head.tolist(), "root": root.tolist(), "area": float(k * far / 200e9), "young": 200e9}}
        expected = way
    mesh = join(bodies)
    if rigid or expected > 0.05 * scale:
        keys["contact"] = {"tolerance": 0.005 * scale}
    def by_hand(run):
        if not expected < 0.08 * length / nx:  # a tenth of a face farther a stage has collapsed, by its rule
            return
        stages = run.stages()
        if "go" not in stages or stages["go"]["verdict"] == "undecided":
            return
        if stages["go"]["verdict"] != "converged":
            yield f"go: {stages['go']['verdict']}, by hand it comes to rest", np.inf
            return
        u = [run.results.stage(name).displacement[mesh.points["toe"]] for name in ("rest", "go")]
        # within 1 %: the block gives a little, the tendon turns
        yield f"way by hand {expected:.4g} m", max(0.0, abs((u[1] - u[0]) @ down / expected - 1) - (0.005 if rigid else 0.01))
    scene = solved(Scene("comes to rest", mesh, keys, by_hand=by_hand if rigid else None), ranks=(2, 3) if rng.random() < 0.3 else (2,))
    scene.ways["mirrored"] = mirror(scene)
    scene.by_hand = by_hand
    if not rigid:
        scene.by_hand = verdict_only(by_hand)
    return scene


def verdict_only(by_hand):
    """Blocks that deform: the way to 3 %."""
    def wider(run):
        for what, off in by_hand(run):
            yield what, off if np.isinf(off) else max(0.0, off - 0.02)
    return wider


# ---- several strengths -----------------------------------------------------------------------------------

def strengths(rng):
    """A body on a base of pieces, each with its friction, cohesion, tension and residuals, pushed from one side to its limit."""
    rigid, width, height = bool(rng.random() < 0.5), float(rng.uniform(3, 20)), float(rng.uniform(1, 8))
    pieces, per = int(rng.integers(2, 4)), int(rng.integers(1, 4))
    n, tilt = pieces * per, float(rng.choice([0.0, 0.0, 0.08]))
    def turn(mesh):
        mesh.vertices[:, 1] += tilt * mesh.vertices[:, 0]
        return mesh
    ground = turn(rectangle(-width, -0.5 * width, 3 * width, 0.5 * width, 3 * n, 1, "base", True))
    body = turn(renamed(rectangle(0, 0, width, height, n, 1 if rigid else max(1, round(n * height / width)), "block", rigid), {"left": "left"}, {"crest": "top_left"}))
    mesh = join([renamed(ground), body])
    brittle = rng.random() < 0.6
    joints = {"default": joint(rng, (9, 10.5), (35, 50))}
    for i in range(pieces):
        a, b = (np.array([x, tilt * x]) for x in (width * i / pieces, width * (i + 1) / pieces))
        mesh.face_sets[f"piece_{i}"] = np.concatenate([face_set_on(mesh, a, b, group=group) for group in ("base", "block")])
        row = {"friction": float(rng.uniform(25, 55))}
        if brittle:
            row["friction_residual"] = float(row["friction"] * rng.uniform(0.6, 1))
            if rng.random() < 0.7:
                row["cohesion"] = float(10 ** rng.uniform(3, 5))
                row["cohesion_residual"] = float(row["cohesion"] * rng.choice([0.0, rng.uniform(0, 1)]))
                row["tension"] = float(row["cohesion"] * rng.choice([0.0, rng.uniform(0.1, 0.7)]))
        joints[f"piece_{i}"] = row
    weight = 2400 * G * width * height
    push = 0.2 * weight / height
    keys = frame(materials={"base": {"density": 0}, "block": {"density": 2400.0} if rigid else elastic(rng)}, joints=joints, supports={"base": {"fix": "xy"}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "traction", "faces": "left", "value": [float(push), 0.0]}},
                 stages=[{"sw": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}},
                         {"limit": {"type": "load_factor", "loads": ["weight", "push"], "raises": ["push"], "step": 0.5, "limit": 20, "bracket": 0.02}}])
    rows = [joints[f"piece_{i}"] for i in range(pieces)]
    def of(name, residual):
        return np.array([row.get(name + residual, row.get(name, 0.0) if name == "friction" else 0.0) for row in rows])
    def factor(residual):
        """Rigid and level, nothing opens: stresses on a line; F tan-weighted."""
        mu, c = np.tan(np.radians(of("friction", residual))), of("cohesion", residual)
        edges = np.linspace(-0.5, 0.5, pieces + 1) * width
        parts, at = np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
        even, lean = weight / width, 12 * (0.5 * height) / width**3  # stress without the push, and of a push of 1 N per m from the middle
        limit = (c @ parts + even * mu @ parts) / (1 - lean * (mu * at) @ parts)
        return limit / (push * height), limit * 0.5 * height < weight * width / 6
    def by_hand(run):
        stage = run.stages().get("limit")
        if stage is None or stage["verdict"] != "converged" or bracket(stage) is None or tilt:
            return
        low, high = sorted(factor(residual) for residual in ("_residual", ""))
        if not (low[1] and high[1]):  # it opens
            return
        least, most = bracket(stage)[1], bracket(stage)[0]
        if most is not None:
            yield f"limit by hand {low[0]:.4f} to {high[0]:.4f}", gap_of((least, most), (low[0], high[0]))
    scene = solved(Scene("strengths", mesh, keys, by_hand=by_hand if rigid else None), ranks=(2, 3) if rng.random() < 0.3 else (2,))
    scene.ways["mirrored"] = mirror(scene)
    scene.ways["mirrored, variable"] = mirror(scene)
    scene.ways["mirrored, variable"].options = ("-contact_connectivity", "variable")
    return scene


KINDS = (comes_to_rest, strengths)
