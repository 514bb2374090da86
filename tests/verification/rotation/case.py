"""Blocks in free flight that turn: a deformable bar by 90 degrees (V26), rigid ones 1000 times."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, rectangle, renamed
from scipy.special import ellipk

WHAT = "blocks turn in free flight: no false stress, momentum kept (V26), rigid shapes exact over 1000 turns, loads off the centre"
SOURCE = "steady spin: stress rho w^2 L^2 / 8 at the middle of the bar, twice that after a sudden start; angular momentum I w"
BY = "by hand"

RHO, E, G = 2400.0, 1e9, 9.81
SIDE, HEIGHT, SPIN, V, NX = 1.0, 0.125, 10.0, np.array([1.5, -0.5]), 16
STEADY = RHO * SPIN**2 * SIDE**2 / 8  # [Pa] s(0) of s(x) = rho w^2 (L^2/4 - x^2) / 2, x from the middle of the bar
ZETA_3 = 1.2020569031595942
# Spun up all of a sudden the bar has not got its steady stretch: it is the steady state less a free vibration that starts
# with the steady stress, s(x, t) = sum over odd n of a_n cos(n pi x / L) (1 - cos(w_n t)), a_n = +-4 rho w^2 L^2 / (n pi)^3.
# Exact bar: w_n = n pi c / L. s(x, t) = s(x) - [S(x + ct) + S(x - ct)] / 2 with S the odd continuation of s over the free
# ends, so s <= 2 s(0), reached at the middle at t = L / c. A mesh has other w_n (dispersion), its modes fall out of step, and
# all that holds is s <= s(0) + sum of abs(a_n) = s(0) (1 + 28 zeta(3) / pi^3) = 2.0855 s(0).
DISPERSED = 1 + 28 * ZETA_3 / np.pi**3
PERIOD = 2 * SIDE / np.sqrt(E / RHO)  # [s] of the first stretching vibration


def bar():
    """The bar, 16 x 2 squares, with a point at each vertex; the base is far below."""
    block = rectangle(0, 5, SIDE, HEIGHT, NX, 2, group="block")
    mesh = join([renamed(rectangle(-1, -1, 3, 1, group="base", rigid=True), {}), renamed(block, {}, {"mark": "top_right"})])
    nodes = np.unique(mesh.blocks[mesh.block_group == mesh.group_names.index("block")])
    mesh.points |= {f"at_{i}": int(v) for i, v in enumerate(nodes)}
    mass = np.zeros(len(nodes))  # lumped: a quarter of every square
    for ring in mesh.blocks[mesh.block_group == mesh.group_names.index("block")]:
        mass[np.searchsorted(nodes, ring)] += RHO * (SIDE / NX)**2 / 4
    return mesh, nodes, mass


def spinning(duration, frames, **keys):
    return {
        "relaxation": {"allow_floating": True, "history_every": 50, "tolerance": 1e-10, "velocity_tolerance": 1e-10},
        "materials": {"block": {"density": RHO, "young": E, "poisson": 0.0, "spin": SPIN, "velocity": V.tolist()},
                      "base": {"density": RHO, "rigid": True}},
        "joints": {"default": {"k_n": 1e9, "k_s": 1e9, "friction": 30}},
        "supports": {"base": {"fix": "xy"}},
        "loads": {"none": {"type": "point_force", "point": "mark", "value": [0, 0]}},
        "stages": [{"turn": {"type": "dynamic", "loads": ["none"], "duration": duration, "dt_factor": 0.2, "frames": frames} | keys}],
    }


def frames_of(result):
    return [result.stage(name) for name in [*result.frames("turn"), "turn"]]


def stress_of(result, frames):
    """Larger principal stress at the centres of the bar's blocks [Pa] (frames, blocks)."""
    mine = result.mesh.block_group == result.mesh.group_names.index("block")
    return np.array([f.s1[mine] for f in frames])


def run(case):
    sudden(case)
    a_quarter(case)
    steady(case)
    momentum(case)
    thousand_turns(case)
    pendulums(case)


def sudden(case):
    """The first two stretching vibrations, 100 frames each."""
    mesh, _, _ = bar()
    result = case.run(mesh, spinning(2 * PERIOD, 199))
    frames = frames_of(result)
    stress, t = stress_of(result, frames).max(axis=1), np.array([f.time for f in frames]) / PERIOD
    at_centres = STEADY * (1 - 1 / NX**2)  # steady stress at the block centre nearest the middle
    case.check("sudden spin: first peak of the stress, twice that of steady spin [Pa]", stress[t < 0.75].max(), 2 * at_centres,
               relative=0.02)
    case.check("... after half a period of the wave", t[stress == stress[t < 0.75].max()][0], 0.5, absolute=0.02)
    case.check("... gone after a whole period, over that of steady spin", stress[np.argmin(abs(t - 1))] / STEADY, 0.0, absolute=0.06)


def a_quarter(case):
    duration = np.pi / 2 / SPIN
    mesh, nodes, mass = bar()
    results = [case.run(mesh, spinning(duration, 200), ranks=ranks) for ranks in (1, 2)]
    result, frames = results[0], frames_of(results[0])
    stress = stress_of(result, frames)
    case.check("sudden spin, a quarter turn (50 vibrations): largest stress over that of steady spin, at most 2.0855",
               bool(1.9 < stress.max() / STEADY < DISPERSED), True)
    case.report("... it is", stress.max() / STEADY, DISPERSED)
    case.check("... its mean over time at the middle, that of steady spin [Pa]",
               stress[1:].mean(axis=0).max(), STEADY, relative=0.03)
    X = mesh.vertices[nodes]
    end = X + frames[-1].displacement[nodes]
    centre = (mass @ end) / mass.sum()
    case.check("mass centre [m]", centre - (mass @ X) / mass.sum(), V * duration, absolute=1e-9)
    # angle of the best rotation from the first to the last shape
    a, b = X - (mass @ X) / mass.sum(), end - centre
    turned = np.arctan2(mass @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), mass @ (a * b).sum(axis=1))
    case.check("angle [rad]", turned, np.pi / 2, relative=1e-3)
    case.check("same bits on 2 ranks", results[1].stage_summary("turn")["checksum"], result.stage_summary("turn")["checksum"])


def steady(case):
    """Stretched by its centrifugal forces first, at rest, and then let go with the spin: it only turns."""
    mesh, nodes, mass = bar()
    X = mesh.vertices[nodes]
    arm = X - (mass @ X) / mass.sum()
    pull = {f"pull_{i}": {"type": "point_force", "point": f"at_{i}", "value": (mass[i] * SPIN**2 * arm[i]).tolist()}
            for i in range(len(nodes))}
    scene = spinning(np.pi / 2 / SPIN, 40)
    scene["loads"] |= pull
    scene["stages"].insert(0, {"stretch": {"loads": list(pull)}})
    result = case.run(mesh, scene)
    stress = stress_of(result, frames_of(result))
    case.check("started in its steady spin, a quarter turn: stress at the middle, as at rest under centrifugal forces [Pa]",
               stress.max(axis=1), stress_of(result, [result.stage("stretch")]).max(), relative=1e-3)
    case.check("... that is rho w^2 L^2 / 8 less what the block centre is off the middle [Pa]", stress[-1].max(),
               STEADY * (1 - 1 / NX**2), relative=0.01)
    across = [f.s2[result.mesh.block_group == result.mesh.group_names.index("block")] for f in frames_of(result)]
    case.check("... across the bar rho w^2 H^2 / 8 at most, over that of the bar", np.abs(across).max() / STEADY,
               (HEIGHT / SIDE)**2, absolute=0.5 * (HEIGHT / SIDE)**2)


def momentum(case):
    """Every step is a frame: m (x(t + dt) - x(t)) / dt and m x(t) x (x(t + dt) - x(t)) / dt are kept by the scheme itself."""
    mesh, nodes, mass = bar()
    scene = spinning(1e-3, 0)
    steps = case.run(mesh, scene).stage_summary("turn")["cycles"]
    result = case.run(mesh, changed(scene, ("stages", [{"turn": scene["stages"][0]["turn"] | {"frames": steps - 1}}])))
    x = [mesh.vertices[nodes] + f.displacement[nodes] for f in frames_of(result)]
    linear = np.array([mass @ (b - a) for a, b in zip(x, x[1:])])
    angular = np.array([mass @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) for a, b in zip(x, x[1:])])
    case.check(f"momentum, every step of {len(linear)}, over the first", linear / linear[0], 1.0, absolute=1e-9)
    case.check("angular momentum, likewise", angular / angular[0], 1.0, absolute=1e-9)


def thousand_turns(case):
    """A rigid block and a rigid body of three, 1000 turns a second while they fly: shape, angle and energy."""
    turns = 1000
    ell = [rectangle(x, y, 0.5, 0.25, group="body", rigid=True) for x, y in ((2, 5), (2.5, 5), (2, 5.25))]
    vertices = np.unique(np.vstack([b.vertices for b in ell]), axis=0)
    body = ell[0]
    body.blocks = np.array([[np.flatnonzero((vertices == v).all(axis=1))[0] for v in b.vertices[ring]]
                            for b in ell for ring in b.blocks])
    body.vertices, body.block_group = vertices, np.zeros(3, dtype=body.block_group.dtype)
    mesh = join([renamed(rectangle(-1, -1, 3, 1, group="base", rigid=True), {}),
                 renamed(rectangle(0, 5, 0.5, 0.25, group="block", rigid=True), {}, {"mark": "top_right"}),
                 renamed(body, {})])
    scene = spinning(1.0, 0, dt_factor=1.0)
    flying = {"density": RHO, "rigid": True, "spin": 2 * np.pi * turns}
    scene["materials"] |= {"block": flying | {"velocity": V.tolist()}, "body": flying | {"velocity": (-V).tolist()}}
    result = case.run(mesh, scene)
    end = result.stage("turn")
    off, angle = 0.0, []
    for name in ("block", "body"):
        mine = mesh.block_group == mesh.group_names.index(name)
        nodes = np.unique(mesh.blocks[mine])
        X, x = mesh.vertices[nodes], mesh.vertices[nodes] + end.displacement[nodes]
        distance = [np.hypot(*(a[:, None] - a[None, :]).reshape(-1, 2).T) for a in (X, x)]
        off = max(off, np.abs(distance[1] - distance[0]).max())
        angle.append(end.rotation[mine][0])
    case.check("rigid, 1000 turns: change of any distance between vertices [m]", off, 0.0, absolute=1e-13)
    case.check("... angle [turns]", np.array(angle) / (2 * np.pi), turns, relative=1e-10)
    case.check("... kinetic energy over the first", history_of(result)["kinetic_J"] / history_of(result)["kinetic_J"][0], 1.0,
               relative=1e-9)


def pendulums(case):
    """Dead loads off the mass centre of a free rigid body turn it like a pendulum, I theta'' = -F r sin(theta), while it falls:
    the weight of one half only, a force on a corner. Half a period later it has swung over, a period later it is back."""
    width, height, mass = 0.5, 0.25, RHO * 0.125
    half = [rectangle(x, 5, width, height, group=name, rigid=True) for x, name in ((5, "weighty"), (5.5, "other"))]
    both = join([renamed(half[0], {}, {"mark": "top_right"}), renamed(half[1], {})])
    both.vertices, row = np.unique(both.vertices, axis=0, return_inverse=True)
    both.blocks, both.points = row.ravel()[both.blocks].astype(np.int32), {"mark": 0}
    one = renamed(rectangle(5, 5, width, height, group="weighty", rigid=True), {}, {"mark": "bottom_left"})
    cases = [("weight of one half", both, {"type": "self_weight", "groups": ["weighty"]}, mass * G, width / 2, np.pi / 2,
              2 * mass, 2 * mass * (4 * width**2 + height**2) / 12),
             ("force on a corner", one, {"type": "point_force", "point": "mark", "value": [0, -1000.0]}, 1000.0,
              np.hypot(width, height) / 2, np.arctan2(width, height), mass, mass * (width**2 + height**2) / 12)]
    for what, body, load, force, arm, start, m, inertia in cases:
        period = 4 * ellipk(np.sin(start / 2)**2) / np.sqrt(force * arm / inertia)
        mesh = join([renamed(rectangle(-1, -1, 3, 1, group="base", rigid=True), {}), body])
        scene = spinning(period, 1, dt_factor=1.0)
        scene["materials"] = {name: {"density": RHO, "rigid": True} for name in mesh.group_names}
        scene["joints"]["default"] |= {"k_n": 1e6, "k_s": 1e6}
        scene["loads"] = {"none": load}
        result = case.run(mesh, scene)
        mine = mesh.block_group == mesh.group_names.index("weighty")
        angle = [f.rotation[mine][0] for f in frames_of(result)]
        case.check(f"pendulum, {what}: angle after half a period and a period [rad]", angle, [2 * start, 0.0], absolute=1e-4)
        fallen = -result.stage("turn").displacement[np.unique(mesh.blocks[1:])].mean(axis=0)
        case.check("... its centre has fallen F T^2 / 2m [m]", fallen, [0.0, force * period**2 / (2 * m)], absolute=1e-9)
        case.check("... energy balance over the work of the load", result.stage_summary("turn")["energy"]["balance"]
                   / result.stage_summary("turn")["energy"]["outside"], 0.0, absolute=1e-5)


def history_of(result):
    mine = np.isfinite(result.history["balance_J"])
    return {name: column[mine] for name, column in result.history.items() if name != "stage"}
