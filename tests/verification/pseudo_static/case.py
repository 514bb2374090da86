"""An earthquake as a load at rest, and loads raised by trials: resultants, yield coefficients, tilt tests, pushes.

By hand: a dam on a plane (N, T, resultant, crack, toe stress, sliding), Westergaard's 7/12 rho g k H^2 and Zangar's pressure, a block
that slides at tan(phi) or overturns at b/h, a column pushed at its head. An arch tilted: limit analysis (linear programming)."""

import math

import numpy as np
from driver import changed
from driver import load as other_case
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.dam import G1, dam_mesh
from quoin_tools.mesh.meshing import face_set_on, join, quad_patch, rectangle, renamed, split_triangles, vertex_at
from quoin_tools.mesh.stacks import column
from quoin_tools.mesh.walls import arch
from scipy.optimize import linprog
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

WHAT = "pseudo-static load and load factor: resultants, Westergaard, Zangar, yield coefficients of dams, tilted block and arch, pushed column"
SOURCE = "statics of a plane, Westergaard 1933, Zangar 1952, potential flow (finite elements), limit analysis"
BY = "by hand; Westergaard 1933; Zangar 1952; independent potential flow of this project"

sliding = other_case("sliding")
G, B, H, PHI = 9.81, 40.0, 30.0, 25.0
WEIGHT, THRUST, INERTIA = B * H * 2400 * G, 9810 * H**2 / 2, 7 / 12 * 9810 * H**2  # [N], the last for k_h = 1
DAM = ["weight", "water", "quake"]


def ground(left, right):
    return renamed(rectangle(left, -10, right - left, 10, group="base", rigid=True), {"joint": "top"})


def block(width=B, height=H, nx=1, ny=1, rigid=True, triangles=False):
    dam = renamed(rectangle(0, 0, width, height, nx, ny, group="dam", rigid=rigid), {"bottom": "bottom", "upstream": "left", "downstream": "right"})
    dam = split_triangles(dam) if triangles else dam
    return join([ground(-width, 2 * width), dam])


def wet(**keys):
    return {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["dam"], "faces": "upstream", "level": H} | keys


def scene(quake, friction=PHI, dam=None, k=10e9, **more):
    return {
        "relaxation": {"tolerance": 1e-8}, "strain": "small",
        "materials": {"dam": {"density": 2400, "rigid": True} | (dam or {}), "base": {"density": 2400, "rigid": True}},
        "joints": {"default": {"k_n": k, "k_s": k, "friction": friction}}, "supports": {"base": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": H}, "quake": quake},
        "stages": [{"full": {"loads": ["weight", "water"]}}, {"shaken": {"loads": DAM}}],
    } | more  # fmt: skip


def raised(loads=DAM, raises=("quake",), **keys):
    return {"type": "load_factor", "loads": list(loads), "raises": list(raises), "start": 0, "limit": 2, "bracket": 1e-4} | keys


def yields(quake, friction=PHI, before=("weight", "water"), **keys):
    """Scene of a stage that raises the earthquake."""
    return scene(quake, friction, stages=[{"full": {"loads": list(before)}}, {"yield": raised([*before, "quake"], **keys)}])


def limit(result, stage="yield"):
    found = result.stage_summary(stage)["load_factor"]
    return [found["stable"], found["failing"]]


LONG = ("tilted_arch", "ranks_and_restart")  # parts that the short form leaves out


def run(case):
    resultants(case)
    bodies(case)
    leaning(case)
    wet_block(case)
    triangle(case)
    section_g1(case)
    tilts(case)
    tilted_arch(case)
    other_loads(case)
    ranks_and_restart(case)
    told(case)


# ---- the load


def resultants(case):
    """A rigid block on its base, both strains: what acts is what the base bears."""
    jobs = [(k, strain) for k in ([0.1, 0.05], [-0.1, -0.2], [0, 0.5]) for strain in ("small", "large")]
    runs = case.run_all([(block(), scene(wet(coefficient=k), 60, strain=strain)) for k, strain in jobs])
    for (k, strain), result in zip(jobs, runs):
        joint = result.stage_summary("shaken")["joints"]["default"]
        thrust, water = THRUST + k[0] * WEIGHT, k[0] * INERTIA
        about_toe = WEIGHT * (1 - k[1]) * B / 2 - (THRUST * H / 3 + k[0] * WEIGHT * H / 2 + water * 0.4 * H)
        wanted = [WEIGHT * (1 - k[1]), thrust + water, WEIGHT * (1 - k[1]) * B / 2 - about_toe]
        case.check(f"k = {k}, {strain} strain: N, T [N], moment about the middle [N m]", [joint["N"], joint["T"], -joint["M"]], wanted,
                   relative=1e-5 if strain == "small" else 1e-4)  # fmt: skip
    lower, upper = (renamed(rectangle(0, y, B, H / 2, group=group, rigid=True), {"upstream": "left"}) for y, group in ((0, "dam"), (H / 2, "top")))
    two = changed(scene(wet(coefficient=[0.2, 0]), 60), ("materials.top", {"density": 2400, "rigid": True}), ("loads.weight.groups", ["dam", "top"]))
    result = case.run(join([ground(-B, 2 * B), lower, upper]), two).stage_summary("shaken")["applied"]
    case.check("k_h on one group of two: applied x, y [N]", [result["x"], result["y"]], [THRUST + 0.2 * (WEIGHT / 2 + INERTIA), -WEIGHT], relative=1e-12)


def bodies(case):
    """Rigid, deformable and condensed bodies get the same forces, quadrilaterals and triangles, explicit and by Newton's method."""
    soft = {"rigid": False, "young": 20e9, "poisson": 0.2}
    wanted, load = [WEIGHT * 0.95, THRUST + 0.15 * (WEIGHT + INERTIA)], wet(coefficient=[0.15, 0.05])
    for what, mesh, dam in (("deformable", block(nx=8, ny=6, rigid=False), soft), ("triangles", block(nx=8, ny=6, rigid=False, triangles=True), soft),
                            ("condensed", block(nx=8, ny=6, rigid=False), soft | {"condensed": True})):
        for method in ("explicit", "preconditioned"):
            result = case.run(mesh, changed(scene(load, 60, dam), ("relaxation.method", method)))
            stage = result.stage_summary("shaken")
            case.check(f"{what}, {method}: applied x, y [N]", [stage["applied"]["x"], -stage["applied"]["y"]], wanted[::-1], relative=1e-10)
            joint = stage["joints"]["default"]
            about = WEIGHT * 0.15 * H / 2 + THRUST * H / 3 + 0.15 * INERTIA * 0.4 * H
            case.check("... N, T [N], moment about the middle [N m] of the base", [joint["N"], joint["T"], -joint["M"]], [*wanted, about], relative=1e-5)


def potential_flow(lean, rows=60, columns=120, reach=8.0):
    """Normal force over rho a H^2 on a straight wall: Laplace's equation on triangles, p = 0 at the surface and far away."""
    foot = math.tan(math.radians(lean))
    y = 1 - (1 - np.linspace(0, 1, rows + 1)) ** 1.5
    wall, far = -(1 - y) * foot, np.expm1(4 * np.linspace(0, 1, columns + 1)) / np.expm1(4)
    x = wall[:, None] + far * (-reach - wall[:, None])
    xy, node = np.column_stack([x.ravel(), np.repeat(y, columns + 1)]), np.arange(x.size).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]))
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    edge = [xy[triangles[:, (k + 2) % 3]] - xy[triangles[:, (k + 1) % 3]] for k in range(3)]
    area = np.abs(edge[0][:, 0] * edge[1][:, 1] - edge[0][:, 1] * edge[1][:, 0]) / 2
    entries = [(triangles[:, k], triangles[:, m], (edge[k] * edge[m]).sum(axis=1) / (4 * area)) for k in range(3) for m in range(3)]
    row, column_, value = (np.concatenate(part) for part in zip(*entries))
    matrix = coo_array((value, (row, column_)), shape=(x.size, x.size)).tocsr()
    faces = np.hypot(*np.diff(xy[node[:, 0]], axis=0).T)
    share = np.zeros(x.size)  # of the wall at its nodes
    np.add.at(share, node[1:, 0], faces / 2)
    np.add.at(share, node[:-1, 0], faces / 2)
    free = np.setdiff1d(node, np.concatenate([node[-1], node[:, -1]]))
    pressure = np.zeros(x.size)
    pressure[free] = spsolve(matrix[free][:, free], math.cos(math.radians(lean)) * share[free])
    return share @ pressure


def leaning(case):
    """Walls that lean by 0 to 60 degrees: the force normal to them, by both rules; where westergaard warns."""
    for lean in (0, 10, 30, 45, 60):
        foot, rad = -H * math.tan(math.radians(lean)), math.radians(lean)
        dam = renamed(quad_patch((foot, 0), (B, 0), (B, H), (0, H), 3, 7, group="dam", rigid=True), {"upstream": "left"})
        mesh = join([ground(-100, 100), dam])
        for rule, wanted in (("westergaard", 7 / 12), ("zangar", (0.7412 - 0.0073 * lean) * (1 / 3 + math.pi / 8) / math.cos(rad))):
            load = {"quake": wet(coefficient=[0.1, 0], groups="none", rule=rule)}
            result = case.run(mesh, changed(scene(load["quake"], 60), ("loads.weight.groups", ["dam"])))
            applied = {stage: result.stage_summary(stage)["applied"] for stage in ("full", "shaken")}
            x, y = (applied["shaken"][at] - applied["full"][at] for at in "xy")
            case.check(f"{rule} on a wall that leans by {lean} degrees: normal force over rho k g H^2", (x * math.cos(rad) - y * math.sin(rad)) / (981 * H**2),
                       wanted, absolute=1e-7)  # fmt: skip
            case.check("... along the wall", (x * math.sin(rad) + y * math.cos(rad)) / (981 * H**2), 0, absolute=1e-7)
            case.check("... lean reported [degree]", result.stage_summary("shaken")["pseudo_static"]["quake"]["lean"], lean, absolute=1e-9)
            flow = potential_flow(lean)
            excess = round(100 * (7 / 12 / flow - 1))
            words = f"its faces lean {lean} degrees from the vertical, where westergaard gives {excess} % more than potential flow"
            case.check("... warned", words in result.stderr, rule == "westergaard" and lean > 15)
            if rule == "zangar":
                case.check("... potential flow (finite elements)", wanted, flow, relative=0.05 if lean > 45 else 0.02)


# ---- yield coefficients


def wet_block(case):
    """VS10: a rigid block of 40 x 30 m with a vertical face and a full reservoir."""
    tangent = math.tan(math.radians(PHI))
    sides = {"downstream": ([1, 0], (WEIGHT * tangent - THRUST) / (WEIGHT + INERTIA)), "upstream": ([-1, 0], (WEIGHT * tangent + THRUST) / (WEIGHT + INERTIA))}
    case.check("k_y of the plan, downstream and upstream", [found for _, found in sides.values()], [0.26225, 0.52657], absolute=6e-6)
    for name, (k, wanted) in sides.items():
        for options in ((), ("-relaxation_method", "preconditioned"), ("-strain", "large")):
            result = case.run(block(), yields(wet(coefficient=k)), *options)
            case.check(f"k_y {name} {' '.join(options)}: bracket", limit(result), [wanted, wanted], absolute=1e-4)
            found = result.stage_summary("yield")["load_factor"]["raises"]["quake"]
            case.check("... as k_h of the load", [found["k_h_stable"], found["k_h_failing"]], [k[0] * value for value in limit(result)], absolute=1e-12)
        case.check("... mechanism", result.stage_summary("yield")["mechanism"]["default"]["moves"], "slides")
    dry = {key: value for key, value in wet().items() if key not in ("faces", "level")}
    case.check("k_y without the water's inertia", limit(case.run(block(), yields(dry))), [(WEIGHT * tangent - THRUST) / WEIGHT] * 2, absolute=1e-4)
    half = wet(coefficient=[0.1, 0.05])  # k_v = k_h / 2 lifts; the factor is on both
    wanted = (WEIGHT * tangent - THRUST) / (0.1 * (WEIGHT + INERTIA) + 0.05 * WEIGHT * tangent)
    result = case.run(block(), yields(half, limit=20, step=1, bracket=1e-3))
    case.check("factor on k = [0.1, 0.05], by steps", limit(result), [wanted, wanted], absolute=1e-3)
    values = [trial["value"] for trial in result.stage_summary("yield")["load_factor"]["trials"]]
    case.check("... steps", values[:4], [0, 1, 2, 3])
    lifted = case.run(block(), yields(dry | {"coefficient": [0, 1]}))
    wanted = 1 - THRUST / tangent / WEIGHT
    case.check("k_v alone, lifted until it slides", limit(lifted), [wanted, wanted], absolute=1e-4)


def triangle(case):
    """VS14: triangle of 40 x 50 m, reservoir 50 m: N, T, resultant, crack, toe stress, sliding factor; sliding and overturning."""
    dam = BlockMesh(np.array([[0.0, 0], [40, 0], [0, 50]]), np.array([[0, 1, 2, -1]]), np.zeros(1), ["dam"], [True])
    # a triangle's faces are those between its vertices in their order
    dam.face_sets = {"bottom": np.array([[0, 0]]), "upstream": np.array([[0, 2]])}
    mesh, water = join([ground(-40, 80), dam]), {"level": 50}
    base = changed(scene(wet(**water), 45, k=1e12), ("loads.water.level", 50))
    for k, N, T, at, toe, crack, factor in (((0, 0), 23544, 12262.5, 17.986, 766.4, 0, 1.920), ((0.1, 0), 23544, 16047.5, 15.104, 1020.9, 0, 1.467),
                                            ((0.1, 0.05), 22366.8, 16047.5, 14.496, 1020.9, 0, 1.394), ((0.1, -0.05), 24721.2, 16047.5, 15.655, 1020.9, 0, 1.541),
                                            ((0.2, 0), 23544, 19832.5, 12.222, 1284.2, 3.333, 1.187)):  # fmt: skip
        joint = case.run(mesh, changed(base, ("loads.quake.coefficient", list(k)))).stage_summary("shaken")["joints"]["default"]
        resultant = joint["length"] / 2 + joint["M"] / joint["N"]  # from the toe
        case.check(f"triangle, k = {k}: N, T [kN], resultant from the toe [m]", [joint["N"] / 1e3, joint["T"] / 1e3, resultant], [N, T, at], relative=4e-5)
        case.check("... toe [kPa], crack [m], sliding factor", [-joint["sigma_min"]["sigma"] / 1e3, joint["open_length"], joint["sliding_factor_peak"]],
                   [toe, crack, factor], absolute=0.06 if crack else 0.051)  # fmt: skip
    reduction = {"type": "strength_reduction", "loads": DAM, "bracket": 0.05}
    found = case.run(mesh, changed(base, ("loads.quake.coefficient", [0.1, 0]), ("stages", [{"full": {"loads": ["weight", "water"]}}, {"reduced": reduction}])))
    factors = found.stage_summary("reduced")["strength_reduction"]
    case.check("triangle, k_h = 0.1: factor by strength reduction", [factors["safety_factor_stable"], factors["safety_factor_failing"]], [1.467, 1.467], absolute=3e-3)
    stages = ("stages", [{"full": {"loads": ["weight", "water"]}}, {"yield": raised()}])
    case.check("triangle: k_y, it slides", limit(case.run(mesh, changed(base, stages))), [0.29806] * 2, absolute=1e-4)
    result = case.run(mesh, changed(base, stages, ("joints.default.friction", 85)), "-relaxation_method", "preconditioned")
    case.check("triangle that cannot slide: overturns at", limit(result), [0.6241] * 2, relative=5e-3)
    case.check("... mechanism opens", "opens" in result.stage_summary("yield")["mechanism"]["default"]["moves"], True)


def section_g1(case):
    """VS15: section G1 with the uplift of S1, rigid: k_y on the plane of its base. The plan's water pushes along x alone; ours along the
    normal of the upstream face, which leans by 1 in 20, so a twentieth of it presses on the base."""
    mesh, slope = dam_mesh(G1, columns=4), np.arctan2(G1.toe[1], G1.toe[0])
    normal, shear = sliding.plane_forces()
    x, y = G1.corners().T
    mass, water, lean = 2400 * G / 2 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum(), 7 / 12 * 9810 * 33**2, math.atan(0.05)
    uplift = {"type": "uplift", "faces": "base", "level": 33, "rule": "npb", "drain": 4.70 / np.cos(slope), "component": "vertical"}
    loads = {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": 33}, "uplift": uplift,
             "quake": wet(level=33)}  # fmt: skip
    for friction, wanted, dry in ((45, 0.2766, 0.4543), (40, 0.1779, 0.2922), (35, 0.0955, 0.1568)):
        for quake, k in ((loads["quake"], wanted), ({"type": "pseudo_static", "coefficient": [1, 0], "groups": ["dam"]}, dry)):
            g1 = {"strain": "small", "relaxation": {"tolerance": 1e-7, "groups": ["dam"]}, "loads": loads | {"quake": quake},
                  "materials": {name: {"density": 2400, "rigid": True} for name in ("dam", "rock")}, "supports": {"rock": {"fix": "xy"}},
                  "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": friction}, "base": {}},
                  "stages": [{"full": {"loads": ["weight", "water", "uplift"]}},
                             {"yield": raised(["weight", "water", "uplift", "quake"], bracket=2e-4, limit=1)}]}  # fmt: skip
            push, down = (mass + water * math.cos(lean), water * math.sin(lean)) if "faces" in quake else (mass, 0)  # for k_h = 1
            more_T, more_N = push * math.cos(slope) - down * math.sin(slope), push * math.sin(slope) + down * math.cos(slope)
            hand = (normal * math.tan(math.radians(friction)) - shear) / (more_T - more_N * math.tan(math.radians(friction)))
            found, words = limit(case.run(mesh, g1)), "with" if down else "without"
            case.check(f"G1, friction {friction} degrees, {words} the water's inertia: k_y by hand", found, [hand, hand], absolute=2e-4)
            case.report("... of the plan, water along x", found[0], k)


# ---- tilt tests and pushes


def tilts(case):
    """A block that slides at tan(phi), whatever it weighs; one that overturns at b/h; gravity tilted either way."""
    tilt = {"type": "pseudo_static", "coefficient": [1, 0]}
    for name, (width, height), friction, wanted in (("slides", (2, 2), 25, math.tan(math.radians(25))), ("overturns", (1, 4), 60, 0.25)):
        for sign in (1, -1):
            for options in ((), ("-relaxation_method", "preconditioned"))[wanted == 0.25 and sign < 0:]:
                case_scene = changed(yields(tilt | {"coefficient": [sign, 0]}, friction, before=("weight", )), ("joints.default.k_n", 1e12))
                result = case.run(block(width, height), case_scene, *options)
                case.check(f"tilt of a block that {name}, k_h {sign:+d} {' '.join(options)}", limit(result), [wanted] * 2, relative=3e-3)
    back = yields(tilt, 25, before=("weight", ))
    back["stages"] += [{"back": {"loads": ["weight"]}}, {"moves": {"type": "dynamic", "loads": ["weight", "quake"], "duration": 0.5}}]
    result = case.run(block(2, 2), changed(back, ("loads.quake.coefficient", [0.6, 0])))
    joint = result.stage_summary("back")["joints"]["default"]
    case.check("behind the load factor, without the load: N, T over the weight", [joint["N"] / 94176, joint["T"] / 94176], [1, 0], absolute=1e-4)
    field = result.stage("moves").displacement - result.stage("back").displacement
    case.check("tilted in a dynamic stage, k_h = 0.6: way [m]", np.abs(field[:, 0]).max(), (0.6 - math.tan(math.radians(25))) * G * 0.5**2 / 2, relative=0.03)
    result = case.run(block(2, 2), yields(tilt, 25, before=("weight", ), limit=0.3))
    case.check("tilted up to the limit, nothing fails", [*limit(result), result.exit_code], [0.3, None, 0])


def arch_limit(n, radius, thickness, friction):
    """Largest k_h of an arch of n voussoirs on a half circle: equilibrium of each with joints that bear no tension, by linear programming."""
    angles = np.linspace(math.pi, 0, n + 1)
    inner, outer = radius - thickness / 2, radius + thickness / 2
    rows, right = [], []
    for i in range(n):  # unknown: N, T, M of each joint about its middle, and k
        a, b = angles[i], angles[i + 1]
        area = (outer**2 - inner**2) / 2 * math.sin(a - b)
        corners = np.array([[r * math.cos(t), r * math.sin(t)] for r, t in ((inner, a), (outer, a), (outer, b), (inner, b))])
        x, y = corners.T
        cross = x * np.roll(y, -1) - np.roll(x, -1) * y
        centre = np.array([((x + np.roll(x, -1)) * cross).sum(), ((y + np.roll(y, -1)) * cross).sum()]) / (3 * cross.sum())
        row = np.zeros((3, 3 * (n + 1) + 1))
        for joint, t, sign in ((i, a, 1), (i + 1, b, -1)):
            push, along = np.array([math.sin(t), -math.cos(t)]), np.array([math.cos(t), math.sin(t)])  # N clockwise, T outwards
            middle = radius * along - centre
            for column_, force in ((3 * joint, sign * push), (3 * joint + 1, sign * along)):
                row[:2, column_] = force
                row[2, column_] = middle[0] * force[1] - middle[1] * force[0]
            row[2, 3 * joint + 2] = sign
        row[0, -1] = area
        rows.append(row)
        right += [0, area, 0]
    inequality = np.zeros((4 * (n + 1), 3 * (n + 1) + 1))
    for joint in range(n + 1):
        for k, (column_, sign, factor) in enumerate(((1, 1, math.tan(math.radians(friction))), (1, -1, math.tan(math.radians(friction))),
                                                     (2, 1, thickness / 2), (2, -1, thickness / 2))):  # fmt: skip
            inequality[4 * joint + k, [3 * joint, 3 * joint + column_]] = -factor, sign
    goal = np.zeros(3 * (n + 1) + 1)
    goal[-1] = -1
    found = linprog(goal, inequality, np.zeros(len(inequality)), np.concatenate(rows), right, [(0, None), (None, None), (None, None)] * (n + 1) + [(0, None)])
    return -found.fun


def tilted_arch(case):
    """A half circle of voussoirs, tilted until four hinges open: rigid blocks come near the limit from below, as hinges get narrower."""
    n, radius, thickness = 15, 10.0, 2.0
    wanted = arch_limit(n, radius, thickness, 60)
    mesh = arch(n, radius - thickness / 2, thickness)
    base = {"strain": "small", "relaxation": {"tolerance": 1e-6}, "materials": {name: {"density": 2400, "rigid": True} for name in ("voussoir", "abutment")},
            "joints": {"default": {"k_n": 1e12, "k_s": 1e12, "friction": 60}}, "supports": {"abutment": {"fix": "xy"}},
            "loads": {"weight": {"type": "self_weight", "groups": ["voussoir"]}, "tilt": {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["voussoir"]}},
            "stages": [{"own": {"loads": ["weight"]}}, {"tilt": raised(["weight", "tilt"], ["tilt"], bracket=2e-3, limit=1)}]}  # fmt: skip
    for sign in (1, -1):
        result = case.run(mesh, changed(base, ("loads.tilt.coefficient", [sign, 0])))
        case.check(f"arch of {n} voussoirs, k_h {sign:+d}: tangent of the tilt (limit analysis)", limit(result, "tilt"), [wanted] * 2, relative=0.03)
        case.report("... the same, last stable", limit(result, "tilt")[0], wanted)


def other_loads(case):
    """A column of 3 blocks pushed at its head, by a point force and by a traction; and the thrust of a fluid on a wall."""
    mesh = column(3, 1.0, 1.0)
    mesh.points["head"] = vertex_at(mesh, 0.0, mesh.vertices[:, 1].max())
    groups = [name for name in mesh.group_names if name != "base"]
    top = mesh.vertices[:, 1].max()
    mesh.face_sets["side"] = face_set_on(mesh, (0.0, top), (0.0, top - 1))
    weight = 2000 * G
    for what, load, arm in (("point force", {"type": "point_force", "point": "head", "value": [1000, 0]}, 3.0),
                            ("traction", {"type": "traction", "faces": "side", "value": [1000, 0]}, 2.5)):
        for friction, wanted in ((70, 3 * weight * 0.5 / arm), (5, math.tan(math.radians(5)) * weight)):
            pushed = {"strain": "small", "relaxation": {"tolerance": 1e-8}, "materials": {name: {"density": 2000, "rigid": True} for name in mesh.group_names},
                      "joints": {"default": {"k_n": 1e11, "k_s": 1e11, "friction": friction}}, "supports": {"base": {"fix": "xy"}},
                      "loads": {"weight": {"type": "self_weight", "groups": groups}, "push": load},
                      "stages": [{"own": {"loads": ["weight"]}}, {"push": raised(["weight", "push"], ["push"], step=4, limit=40, bracket=1e-3, displacement_limit="inf")}]}  # fmt: skip
            found = np.array(limit(case.run(mesh, pushed, "-relaxation_method", "preconditioned"), "push")) * 1000
            case.check(f"column pushed by a {what}, friction {friction}: largest force [N]", found, [wanted] * 2, relative=5e-3)
    fluid = changed(scene(wet(), 40), ("stages", [{"full": {"loads": ["weight", "water"]}}, {"yield": raised(["weight", "water"], ["water"], start=1, limit=20)}]))
    wanted = WEIGHT * math.tan(math.radians(40)) / THRUST
    case.check("reservoir of a denser fluid: factor", limit(case.run(block(), fluid)), [wanted] * 2, absolute=1e-4)
    both = changed(fluid, ("stages", [{"full": {"loads": ["weight", "water"]}}, {"yield": raised(["weight", "water"], ["weight", "water"], start=0.5, limit=4)}]))
    result = case.run(block(), both)
    case.check("weight and water together: nothing fails", limit(result), [4, None])
    joint = result.stage_summary("yield")["joints"]["default"]
    case.check("... N, T at the limit [N]", [joint["N"], joint["T"]], [4 * WEIGHT, 4 * THRUST], relative=1e-6)


# ---- ranks, restart, what is reported


def checksums(result):
    return [stage["checksum"] for stage in result.summary["stages"]]


def ranks_and_restart(case):
    """A deformable dam with water, its trials on 1 to 4 ranks and from checkpoints: the same bits."""
    soft = {"rigid": False, "young": 20e9, "poisson": 0.2}
    mesh = block(nx=8, ny=6, rigid=False)
    trials = changed(yields(wet(coefficient=[1, 0.2]), bracket=0.02, limit=1, step=0.1), ("materials.dam", {"density": 2400} | soft), ("strain", "large"),
                     ("relaxation.tolerance", 1e-6), ("relaxation.method", "explicit"))
    folder = case.prepare(mesh, changed(trials, ("checkpoint", {"every": 300, "keep": 1000})))
    first = case.again(folder)
    case.again(folder, "-output", "kept")
    case.check("k_y, k_v = k_h / 5, deformable, large strain", limit(first),
               [(WEIGHT * math.tan(math.radians(PHI)) - THRUST) / (WEIGHT + INERTIA + 0.2 * WEIGHT * math.tan(math.radians(PHI)))] * 2, absolute=0.02)
    for ranks in case.ranks(2, 3, 4):
        case.check(f"checksums on {ranks} ranks", checksums(case.run(mesh, trials, ranks=ranks)), checksums(first))
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    for number in (len(kept) // 3, 2 * len(kept) // 3, len(kept) - 2):
        again = case.again(folder, "-restart", kept[number], ranks=2 if number == len(kept) - 2 else 1)
        case.check("restart within the trials: checksums", checksums(again), checksums(first))
        case.check("... trials", [[t["value"], t["outcome"], t["cycles"]] for t in again.stage_summary("yield")["load_factor"]["trials"]],
                   [[t["value"], t["outcome"], t["cycles"]] for t in first.stage_summary("yield")["load_factor"]["trials"]])  # fmt: skip
    condensed = case.run(mesh, changed(trials, ("materials.dam.condensed", True)))
    case.check("condensed: bracket", limit(condensed), limit(first), absolute=0.02)


def told(case):
    """Suction; loads that the mesh refuses."""
    result = case.run(block(), scene(wet(coefficient=[-0.3, 0]), 60))
    depth = (7 / 8 * 0.3) ** 2 * H
    case.check("suction down to [m]", result.stage_summary("shaken")["pseudo_static"]["quake"]["suction_depth"], depth, absolute=1e-9)
    case.check("... warned", f"down to {depth:.3g} m below the level its water pulls at the faces" in result.stderr, True)
    result = case.run(block(), yields(wet(coefficient=[-1, 0])))
    depth = (7 / 8 * limit(result)[0]) ** 2 * H
    case.check("suction of a load factor: as raised, once", [f"down to {depth:.3g} m below" in result.stderr, result.stderr.count("pulls")], [True, 1])
    wall = block()
    wall.face_sets["both"] = np.concatenate([wall.face_sets["upstream"], wall.face_sets["downstream"]])
    for keys, words in (({"level": 0}, "loads.quake.level: 0 is not above the lowest point of the faces, 0 [m]"),
                        ({"bottom": 2}, "loads.quake.bottom: 2 is above the lowest point of the faces, 0 [m]"),
                        ({"faces": "both", "rule": "zangar"}, "some of these look upstream, some downstream"),
                        ({"faces": "pond"}, "loads.quake: the mesh has no face set 'pond'")):  # fmt: skip
        refused = case.run(wall, scene(wet(**keys)))
        case.check(f"refused: {words}", [refused.exit_code, words in refused.stderr, len([line for line in refused.stderr.splitlines() if not line.startswith("quoin: warning: ")])], [2, True, 1])
    refused = case.run(block(), yields(wet(coefficient=[1, 0]), start=1))
    case.check("a start that does not stand", [refused.exit_code, "stages.yield: it does not stand at its start (1)" in refused.stderr], [2, True])
