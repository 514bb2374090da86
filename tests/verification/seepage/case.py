"""Steady water in joints of given width: plates, wedges, loops, a dam base with drain and curtain, a free surface.

Blocks are rigid and held, so apertures are what the scene says, but in a wedge, which two forces open. The reference is
in closed form or a network of resistances of its own (numpy). Every run: what enters leaves, at each node to 1e-8."""

import json

import h5py
import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed

WHAT = "water in joints: plates, wedge, bridge, dam base with drain and curtain, jointed dam with a free surface (V18, W01-W04, W07)"
SOURCE = "cubic law in closed form; resistances in series and parallel; exact discharge of a jointed rectangle"
BY = "closed forms by hand"

GW, MU = 9810.0, 1e-3
SCENE = {
    "strain": "small",
    "materials": {"rock": {"density": 0}},
    "joints": {"default": {"k_n": 1e10, "k_s": 1e10, "law": "elastic"}},
    "supports": {"rock": {"fix": "xy"}},
    "loads": {"up": {"type": "head", "faces": "upstream", "level": 0}, "down": {"type": "head", "faces": "downstream", "level": 0}},
    "stages": [{"flow": {"loads": ["up", "down"]}}],
}


def wide(aperture):
    """Keys of a joint of one aperture whatever happens."""
    return {"aperture": aperture, "aperture_residual": aperture, "aperture_max": aperture}


def transmissivity(aperture):
    return GW * aperture**3 / (12 * MU)


# ---- what a run has found

def flow_of(result, stage="flow"):
    return result.stage_summary(stage)["flow"]


def discharge(result, load, stage="flow"):
    """[m2/s] that leaves the joints by a head or a drain."""
    return flow_of(result, stage)["conditions"][load]["discharge"]


def pieces(result, stage="flow"):
    """Columns of stages/<stage>/flow, a row each piece of a joint."""
    with h5py.File(result.path) as file:
        return {name: column[...] for name, column in file[f"stages/{stage}/flow"].items()}


def at(result, place, what="head", stage="flow"):
    """Head [m], or another quantity of the nodes, at a place."""
    flow = pieces(result, stage)
    off = np.hypot(*(flow["point"].reshape(-1, 2) - place).T)
    assert off.min() < 1e-6, (place, off.min())
    return flow[what].ravel()[off.argmin()]


def balanced(case, what, results):
    """No node and no stage gains or loses water."""
    flows = [stage["flow"] for result in results for stage in result.summary["stages"] if "flow" in stage]
    most = max(flow["error"] for flow in flows)
    sums = [abs(sum(condition["discharge"] for condition in flow["conditions"].values())) / flow["inflow"] for flow in flows]
    case.check(f"{what}: mass error of the worst node, of in and out, over the inflow ({len(flows)} stages)", [most, max(sums)], 0.0,
               absolute=1e-8)


def same_bits(case, what, results):
    """Of the state after each stage, and of all that is known of the water."""
    sums = {json.dumps([stage["checksum"] for stage in result.summary["stages"]]) for result in results}
    first = results[0]
    equal = all(np.array_equal(column, pieces(other, stage)[name])
                for stage in first.stages for name, column in pieces(first, stage).items() for other in results[1:])
    case.check(f"{what}: bits of state and water on {', '.join(str(result.summary['ranks']) for result in results)} ranks", [len(sums), equal], [1, True])


# ---- bodies

def joint_line(start, length, dip, n=1, breaks=(), names=("joint",)):
    """Two rigid bodies and the straight joint between them, which dips (degrees) from its start; upstream is there.

    n: contacts, equally long, or, with breaks [m], one contact to each break; names: of each stretch between the breaks."""
    s = np.unique(np.concatenate([np.linspace(0, length, n + 1), breaks]))
    bodies = []
    for group, y in (("rock", (-1.0, 0.0)), ("dam", (0.0, 1.0))):
        body = rectangle(0, y[0], length, y[1] - y[0], len(s) - 1, 1, group=group, rigid=True)
        body.vertices[:, 0] = np.tile(s, 2)
        bodies.append(body)
    low, high = (body.face_sets for body in bodies)
    stretch = np.searchsorted(breaks, 0.5 * (s[1:] + s[:-1]))
    base = {name: high["bottom"][stretch == i] for i, name in enumerate(names)}
    dam = BlockMesh(bodies[1].vertices, bodies[1].blocks, bodies[1].block_group, ["dam"], [1],
                    base | {"upstream": high["left"], "downstream": high["right"]}, bodies[1].points)
    mesh = join([renamed(bodies[0], {"rock_bottom": "bottom"}), dam])
    c, t = np.cos(np.radians(dip)), np.sin(np.radians(dip))
    mesh.vertices = mesh.vertices @ np.array([[c, -t], [t, c]]) + start
    return mesh


HELD = changed(SCENE, ("materials.dam", {"density": 0}), ("supports.dam", {"fix": "xy"}))


def run(case):
    plates(case)
    wedge(case)
    column(case)
    bridge(case)
    dam_base(case)
    drain_states(case)
    jointed(case)
    after_failure(case)


# ---- single joints

def joints(*apertures):
    """Keys of the joints joint_0, joint_1, ... of given apertures."""
    return ("joints", {"default": SCENE["joints"]["default"]} | {f"joint_{i}": wide(a) for i, a in enumerate(apertures)})


def levels(up, down):
    return ("loads.up.level", up), ("loads.down.level", down)


def two_drains(case):
    """Drains that resist, at one place: c_1 (h - g_1) + c_2 (h - g_2) leave there; the second one's gallery stands higher and may feed the joint."""
    c, gallery, T = np.array([2e-7, 5e-8]), np.array([2.0, 12.0]), transmissivity(1e-4)
    one = {"type": "drain", "joint": "joint_0", "distance": 5}
    scene = changed(HELD, joints(1e-4), *levels(31, 0), ("loads.drain", {**one, "gallery": gallery[0], "conductance": float(c[0])}),
                    ("loads.older", {**one, "gallery": gallery[1], "conductance": float(c[1])}),
                    ("stages", [{"flow": {"loads": ["up", "down", "drain", "older"]}}]))  # fmt: skip
    found = case.run(joint_line((0, 0), 24, 0, 12, names=["joint_0"]), scene)
    head = (T / 5 * 31 + c @ gallery) / (T / 5 + T / 19 + c.sum())
    case.check("base joint of 24 m, two drains that resist at 5 m: head there [m]", at(found, (5, 0)), head, relative=1e-9)
    case.check("... in, to the toe, to either drain [m2/s]", [-discharge(found, "up"), *(discharge(found, name) for name in ("down", "drain", "older"))],
               [T / 5 * (31 - head), T / 19 * head, *(c * (head - gallery))], relative=1e-9)  # fmt: skip
    clean = changed(scene, ("loads.older", {**one, "gallery": gallery[1]}))  # one that holds a head, and one that resists: which head?
    refused = case.run(joint_line((0, 0), 24, 0, 12, names=["joint_0"]), clean)
    case.check("... one of them clean: refused", [refused.exit_code, "expected one head there" in refused.stderr], [2, True])


def plates(case):
    """V18 a) to c) and W01: one joint, stretches in series, a line of drains held at a third of the head, a joint that dips."""
    one = case.run(joint_line((0, 0), 10, 0, 5, names=["joint_0"]), changed(HELD, joints(2e-4), *levels(100e3 / GW, 0)))
    case.check("10 m, 0.2 mm, 100 kPa: discharge [m2/s]", discharge(one, "down"), 1e5 * 2e-4**3 / (12 * MU * 10), relative=1e-10)
    case.check("... of the plan", discharge(one, "down"), 6.6667e-6, relative=1e-5)
    a, length, p = np.array([1e-4, 2e-4, 4e-4]), np.array([4, 3, 3]), 300e3
    mesh = joint_line((0, 0), 10, 0, breaks=[4, 7], names=["joint_0", "joint_1", "joint_2"])
    series = case.run(mesh, changed(HELD, joints(*a), *levels(p / GW, 0)))
    q = p / np.sum(12 * MU * length / a**3)
    case.check("4, 3 and 3 m of 0.1, 0.2 and 0.4 mm, 300 kPa: discharge [m2/s]", [-discharge(series, "up"), discharge(series, "down")], q, relative=1e-10)
    between = [at(series, (x, 0), "pressure") for x in (4, 7)]
    case.check("... pressures between them [Pa]", between, [p - q * 12 * MU * 4 / a[0]**3, q * 12 * MU * 3 / a[2]**3], relative=1e-9)
    case.check("... of the plan: discharge, pressures [m2/s, Pa]", [discharge(series, "down"), *between], [5.6537e-6, 28.62e3, 3.180e3], relative=2e-4)
    line = changed(HELD, joints(1e-4), *levels(31, 0), ("loads.drain", {"type": "drain", "joint": "joint_0", "distance": 5, "gallery": 31 / 3}),
                   ("stages", [{"flow": {"loads": ["up", "down", "drain"]}}]))
    drained = case.run(joint_line((0, 0), 24, 0, 12, names=["joint_0"]), line)
    flows = [-discharge(drained, "up"), discharge(drained, "down"), discharge(drained, "drain")]
    into, out = transmissivity(1e-4) * np.array([31 * 2 / 3 / 5, 31 / 3 / 19])
    case.check("base joint of 24 m, drain at 5 m held at a third of 31 m: in, to the toe, to the drain [m2/s]", flows, [into, out, into - out], relative=1e-9)
    case.check("... of the plan", flows, [3.3790e-6, 4.4461e-7, 2.9344e-6], relative=2e-4)
    two_drains(case)
    dips = inclined(case, 35.0), inclined(case, 0.0)
    rough = case.run(joint_line((0, 0), 10, 0, 5, names=["joint_0"]),
                     changed(HELD, joints(2e-4), ("joints.joint_0.roughness", 1.5), *levels(100e3 / GW, 0)))
    case.check("10 m, 0.2 mm, 100 kPa, roughness 1.5: discharge [m2/s]", discharge(rough, "down"), 1e5 * 2e-4**3 / (12 * MU * 10) / 1.5, relative=1e-10)
    pumped = changed(HELD, joints(2e-4), *levels(0, 0), ("loads.pump", {"type": "inflow", "faces": "upstream", "discharge": 5e-6}),
                     ("stages", [{"flow": {"loads": ["pump", "down"]}}]))
    pumped = case.run(joint_line((0, 0), 10, 0, 5, names=["joint_0"]), pumped)
    case.check("5e-6 m2/s pumped into it: head where it enters [m]", at(pumped, (0, 0)), 5e-6 * 10 / transmissivity(2e-4), relative=1e-10)
    case.check("... discharge in and out [m2/s]", [-discharge(pumped, "pump"), discharge(pumped, "down")], 5e-6, relative=1e-10)
    balanced(case, "plates", [one, series, drained, rough, pumped, *dips])


def inclined(case, dip):
    """W01: 20 kPa at the upper end, none at the lower one."""
    length, a, p, fall = 12.0, 1.5e-4, 20e3, 12 * np.sin(np.radians(dip))
    result = case.run(joint_line((0, 0), length, dip, 6, names=["joint_0"]), changed(HELD, joints(a), *levels(p / GW, -fall)))
    q = a**3 * (p + GW * fall) / (12 * MU * length)
    case.check(f"12 m, dip {dip:g}: discharge [m2/s]", discharge(result, "down"), q, relative=1e-8)
    case.check("... of the plan", discharge(result, "down"), {35.0: 2.05128e-6, 0.0: 4.6875e-7}[dip], relative=3e-6)
    middle = at(result, (length / 2 * np.cos(np.radians(dip)), -fall / 2), "pressure")
    case.check("... pressure at half its length [Pa]", middle, p / 2, relative=1e-8)
    return result


def wedge(case):
    """W02: a joint that two forces have opened by 0.1 mm at one end and closed by 0.1 mm at the other."""
    length, k_n, a, p = 8.0, 1e9, np.array([3e-4, 1e-4]), 200e3
    force = k_n * length / 6 * (a[0] - a[1]) / 2
    scene = changed(SCENE, joints(a.mean()), ("materials.dam", {"density": 2400}), *levels(p / GW, 0), ("flow", {"coupling": "one_way"}),
                    ("relaxation", {"tolerance": 1e-12, "velocity_tolerance": 1e-12}),
                    ("loads.lift", {"type": "point_force", "point": "top_left", "value": [0, force]}),
                    ("loads.press", {"type": "point_force", "point": "top_right", "value": [0, -force]}),
                    ("stages", [{"open": {"loads": ["lift", "press"]}}, {"flow": {"loads": ["lift", "press", "up", "down"]}}]))
    scene["joints"]["joint_0"] = {"k_n": k_n, "k_s": k_n, "aperture": a.mean(), "aperture_residual": 1e-5}
    cube = 2 * np.prod(a)**2 / a.sum()

    def pressure(s):
        here = a[0] + s * (a[1] - a[0])
        return p * (1 - (here**-2 - a[0]**-2) / (a[1]**-2 - a[0]**-2))

    results = []
    for n in (1, 2, 4, 8):
        result = case.run(joint_line((0, 0), length, 0, n, names=["joint_0"]), scene)
        base = flow_of(result)["joints"]["joint_0"]
        s = np.linspace(0, 1, n + 1)
        nodes = pressure(s)
        parts = (nodes[1:] + nodes[:-1]) / 2 * length / n
        middles = length * (s[:-1] + (nodes[:-1] + 2 * nodes[1:]) / (3 * n * (nodes[:-1] + nodes[1:])))
        case.check(f"wedge of 0.3 to 0.1 mm, {n} contact{'s' * (n > 1)}: discharge [m2/s]", discharge(result, "down"),
                   p * cube / (12 * MU * length), relative=1e-8)
        case.check("... force of a diagram linear between exact pressures [N], its centre [m]", [base["uplift"], base["centre_x"]],
                   [parts.sum(), (parts * middles).sum() / parts.sum()], relative=1e-6)
        exact = {1: 0.667, 2: 0.896, 4: 0.971, 8: 0.993}[n]
        case.check("... over the exact force of 1200 kN, of the plan", base["uplift"] / 1200e3, exact, absolute=5e-4)
        results.append(result)
    case.check("... discharge of the plan [m2/s], pressure at half the length [kPa]",
               [discharge(results[3], "down"), at(results[3], (4, 0), "pressure") / 1e3], [9.3750e-6, 168.75], relative=1e-6)
    case.report("... 8 contacts: force [N] and its centre [m], of the integral", [base["uplift"], base["centre_x"]], [1200e3, 3.29584])
    clipped = case.run(joint_line((0, 0), length, 0, 8, names=["joint_0"]),
                       changed(scene, ("joints.joint_0.aperture_residual", 1.6e-4), ("joints.joint_0.aperture_max", 2.4e-4)))
    line = np.clip(a[0] + np.linspace(0, 1, 800001) * (a[1] - a[0]), 1.6e-4, 2.4e-4)  # it bends within contacts
    resistance = np.trapezoid(12 * MU / line**3, dx=length / 800000)
    case.check("... between a least aperture of 0.16 mm and a largest of 0.24 mm: discharge [m2/s]", discharge(clipped, "down"), p / resistance, relative=1e-8)
    base = flow_of(clipped)["joints"]["joint_0"]
    case.check("... parts of its length at the least, at the largest; widest [mm]", [base["at_residual"], base["at_max"], 1e3 * base["widest"]],
               [5 / 16, 5 / 16, 0.24], relative=1e-9)
    opened = case.run(joint_line((0, 0), length, 0, 7, names=["joint_0"]),
                      changed(scene, ("joints.joint_0.flow", "after_failure"), ("stages", [scene["stages"][0], {"flow": {"loads": ["lift", "press", "up"]}}])))
    base = flow_of(opened)["joints"]["joint_0"]
    case.check("... water only where it has opened, no way out: length [m], uplift [N]", [base["length"], base["uplift"]], [32 / 7, 32 / 7 * p], relative=1e-9)
    results += [clipped]
    balanced(case, "wedge", results)


def column(case):
    """V18 d): still water in ten contacts one on the other, closed below; then under one level on both sides."""
    mesh = joint_line((0, 0), 10, 90, 10, names=["joint_0"])
    still = case.run(mesh, changed(HELD, joints(1e-4), ("loads.up.level", 3.0), ("stages", [{"flow": {"loads": ["up"]}}])))
    flow = pieces(still)
    case.check("column of ten, head at its top only: p = rho g z [Pa]", flow["pressure"], GW * (3 - flow["point"][:, 1::2]), relative=1e-12)
    case.check("... discharge [m2/s]", np.abs(flow["discharge"]).max(), 0.0, absolute=1e-18)
    pool = case.run(jointed_dam(2.0), changed(jointed_scene(0.5), *levels(24, 24)))
    case.check("jointed dam between two waters of one level: discharge [m2/s]", np.abs(pieces(pool)["discharge"]).max(), 0.0, absolute=1e-18)
    case.check("... mass error of water that stands still", flow_of(pool)["error"], 0.0, absolute=1e-8)


# ---- a network with two loops

def bridge_mesh():
    """W03 of four blocks: A (0,1), B (3,0), C (4.5,3), D (4.5,0); a bend gives each joint but CD its length."""
    place = {"A": (0, 1), "B": (3, 0), "C": (4.5, 3), "D": (4.5, 0)}
    for bend, (start, end), length, side in (("P", "AB", 5, -1), ("Q", "BD", 6, -1), ("R", "AC", 5, 1), ("S", "BC", 4, 1)):
        a, b = np.array(place[start], float), np.array(place[end], float)
        half = np.hypot(*(b - a)) / 2
        place[bend] = (a + b) / 2 + side * np.sqrt(length**2 / 4 - half**2) / (2 * half) * np.array([a[1] - b[1], b[0] - a[0]])
    place |= {"E": (8, 0), "F": (8, 5), "G": (0, 5), "H": (0, -5), "I": (4.5, -5)}
    bodies = [["APS", "PBS", "ASR", "SCR"], ["BQD", "BDS", "DCS"], ["ARG", "RCG", "CFG", "CDE", "CEF"], ["AHP", "PHQ", "PQB", "HIQ", "IDQ"]]
    vertices, blocks, edge = [], [], {}
    for body in bodies:
        number = {name: len(vertices) + i for i, name in enumerate(sorted(set("".join(body))))}
        vertices += [place[name] for name in sorted(number)]
        for block in body:
            for k in range(3):
                edge.setdefault(frozenset(block[k] + block[(k + 1) % 3]), []).append((len(blocks), k))
            blocks.append([*(number[name] for name in block), -1])
    sets = {"ab": "AP PB", "ac": "AR RC", "bc": "BS SC", "bd": "BQ QD", "cd": "CD", "upstream": "AG", "downstream": "DE"}
    faces = {name: np.array([face for pair in pairs.split() for face in edge[frozenset(pair)]]) for name, pairs in sets.items()}
    return BlockMesh(np.array(vertices, float), np.array(blocks), np.zeros(len(blocks)), ["rock"], [1], faces)


BRIDGE = {"ab": (2e-4, 5), "ac": (1e-4, 5), "bc": (1.5e-4, 4), "bd": (1e-4, 6), "cd": (2.5e-4, 3)}  # aperture, length [m]


def bridge(case):
    """W03: two loops; water rises from B to C."""
    scene = changed(SCENE, *levels(1 + 300e3 / GW, 0),
                    ("joints", {"default": SCENE["joints"]["default"]} | {name: wide(a) for name, (a, _) in BRIDGE.items()}))
    results = [case.run(bridge_mesh(), scene, ranks=ranks) for ranks in case.ranks(1, 2, 3, 4)]
    result = results[0]
    c = {name: transmissivity(a) / length for name, (a, length) in BRIDGE.items()}
    A, head = np.array([[c["ab"] + c["bc"] + c["bd"], -c["bc"]], [-c["bc"], c["ac"] + c["bc"] + c["cd"]]]), 1 + 300e3 / GW
    b, c_head = np.linalg.solve(A, [c["ab"] * head, c["ac"] * head])
    q = {"ab": c["ab"] * (head - b), "ac": c["ac"] * (head - c_head), "bc": c["bc"] * (b - c_head), "bd": c["bd"] * b, "cd": c["cd"] * c_head}
    found = [at(result, (3, 0)), at(result, (4.5, 3))]
    case.check("bridge of five joints: heads at B and C [m]", found, [b, c_head], relative=1e-9)
    case.check("... pressures of the plan [kPa]", [at(result, (3, 0), "pressure") / 1e3, at(result, (4.5, 3), "pressure") / 1e3],
               [201.902, 7.7283], relative=1e-5)
    flow = pieces(result)
    names = sorted(BRIDGE)
    ours = [np.abs(flow["discharge"][flow["joint"] == row]) for row in np.unique(flow["joint"])]
    case.check("... lengths of the joints [m]", [flow["length"][flow["joint"] == row].sum() for row in np.unique(flow["joint"])],
               [BRIDGE[name][1] for name in names], relative=1e-12)
    case.check("... discharge of each, in both of its halves [m2/s]", [[each.min(), each.max()] for each in ours], [[q[name]] * 2 for name in names],
               relative=1e-9)
    case.check("... of the plan [m2/s]", [each[0] for each in ours], [1.43877e-5, 4.54419e-6, 1.15835e-5, 2.80419e-6, 1.61277e-5], relative=1e-5)
    up = flow["point"][:, 3] > flow["point"][:, 1]
    rising = (flow["discharge"] > 0) == up
    case.check("... it rises through BC and falls through CD", [bool(rising[flow["joint"] == np.unique(flow["joint"])[i]].all()) for i in (2, 4)], [True, False])
    case.check("... in [m2/s]", -discharge(result, "up"), 1.89319e-5, relative=1e-5)
    same_bits(case, "bridge", results)
    balanced(case, "bridge", results)


# ---- base of a dam: curtain and drain

LENGTH, UP, DOWN = 30.0, 40.0, 3.0
T2 = transmissivity(2e-4)
BASE = changed(HELD, joints(2e-4), *levels(UP, DOWN),
               ("loads.drain", {"type": "drain", "joint": "joint_0", "distance": 4, "gallery": 5}),
               ("loads.curtain", {"type": "curtain", "from": [1.75, -1], "to": [1.75, 1], "width": 1.5, "factor": 0.2}))


def base_mesh(n=15):
    return joint_line((0, 0), LENGTH, 0, n, names=["joint_0"])


def base_by_hand(curtain, drain, conductance=np.inf, gallery=5.0):
    """In, to the toe, to the drain [m2/s]; corners (x [m], head [m]) of the heads along the base."""
    x, t = np.array([0, 1, 2.5, 4, LENGTH]), T2 * np.array([1, curtain**3, 1, 1])
    c = t / np.diff(x)
    before = 1 / np.sum(1 / c[:3])  # conductance from the heel to the drain
    at_drain = (before * UP + c[3] * DOWN) / (before + c[3])
    if drain:
        at_drain = gallery if conductance == np.inf else (before * UP + c[3] * DOWN + conductance * gallery) / (before + c[3] + conductance)
    into, out = before * (UP - at_drain), c[3] * (at_drain - DOWN)
    return into, out, into - out, x, np.array([*(UP - into * np.cumsum([0, *(1 / c[:3])])), DOWN])


def resultant(x, head):
    """Force [N] and its centre [m] under a bent line of heads, at z = 0."""
    p, d = GW * head, np.diff(x)
    parts = d * (p[1:] + p[:-1]) / 2
    return parts.sum(), np.sum(d * (x[:-1] * (p[:-1] + p[1:]) / 2 + d * (p[:-1] + 2 * p[1:]) / 6)) / parts.sum()


def dam_base(case):
    """W04: curtain and drain, one, both or none of them; stages of one run."""
    acts = {"none": [], "drain": ["drain"], "curtain": ["curtain"], "both": ["curtain", "drain"]}
    plan = {"none": (38.7667, 36.9167, 35.0667, 8.0660e-6, 8.0660e-6, 0, 6327.45, 10.6977),
            "drain": (31.2500, 18.1250, 5.0000, 5.7225e-5, 5.0308e-7, 5.6722e-5, 1903.14, 9.2199),
            "curtain": (39.8287, 7.7106, 7.4537, 1.1203e-6, 1.1203e-6, 0, 2186.06, 9.7496),
            "both": (39.8158, 5.2763, 5.0000, 1.2047e-6, 5.0308e-7, 7.0166e-7, 1819.11, 9.4534)}
    scene = changed(BASE, ("stages", [{name: {"loads": ["up", "down", *more]}} for name, more in acts.items()]))
    results = [case.run(base_mesh(), scene, ranks=ranks) for ranks in case.ranks(1, 2, 3, 4)]
    result = results[0]
    for name, numbers in plan.items():
        into, out, drained, x, heads = base_by_hand(0.2 if name in ("curtain", "both") else 1.0, name in ("drain", "both"))
        ours = [-discharge(result, "up", name), discharge(result, "down", name)] + ([discharge(result, "drain", name)] if drained > 1e-12 else [])
        base = flow_of(result, name)["joints"]["joint_0"]
        case.check(f"dam base, {name}: in, to the toe, to the drain [m2/s]", ours, [into, out, drained][:len(ours)], relative=1e-9)
        case.check("... uplift [N], its centre [m]", [base["uplift"], base["centre_x"]], resultant(x, heads), relative=1e-9)
        flow = pieces(result, name)
        case.check("... heads along it [m]", flow["head"].ravel(), np.interp(flow["point"][:, 0::2].ravel(), x, heads), relative=1e-9)
        order = np.argsort(flow["point"][:, 0::2].ravel(), kind="stable")
        known = np.interp([1, 2.5, 4], flow["point"][:, 0::2].ravel()[order], flow["head"].ravel()[order])
        case.check("... of the plan: heads at 1, 2.5, 4 m", known, numbers[:3], absolute=1e-4)
        case.check("... discharges", ours, numbers[3:3 + len(ours)], relative=1e-4)
        case.check("... uplift [kN], its centre [m]", [base["uplift"] / 1e3, base["centre_x"]], numbers[6:], relative=1e-5)
    same_bits(case, "dam base", results)
    balanced(case, "dam base", results)


def drain_states(case):
    """From clogged to clean: the drain's conductance beside that of the joint, by hand; and other ways to say the same."""
    states = {"clogged": 0.0, "worse": 1e-8, "poor": 1e-6, "fair": 1e-5, "good": 1e-3, "clean": "inf"}
    loads = [(f"loads.{name}", BASE["loads"]["drain"] | {"conductance": value}) for name, value in states.items()]
    crossing = {key: value for key, value in BASE["loads"]["drain"].items() if key not in ("joint", "distance")}
    line = crossing | {"from": [4, -3], "to": [4, 3]}
    scene = changed(BASE, *loads, ("loads.line", line), ("loads.leans", line | {"from": [3, -1], "to": [5, 1], "conductance": 1e-6}),
                    ("loads.heel_side", BASE["loads"]["drain"] | {"heel": "start", "conductance": 1e-6}),
                    ("loads.free", {"type": "drain", "joint": "joint_0", "distance": 4}),
                    ("loads.aperture", {key: value for key, value in BASE["loads"]["curtain"].items() if key != "factor"} | {"aperture": 4e-5}))
    names = [*states, "line", "leans", "heel_side", "free"]
    stages = [{name: {"loads": ["up", "down", name]}} for name in names] + [{"grouted": {"loads": ["up", "down", "aperture", "poor"]}}]
    result = case.run(base_mesh(), changed(scene, ("stages", stages)))
    for name in [*names, "grouted"]:
        conductance = float(states.get(name, {"leans": 1e-6, "heel_side": 1e-6, "grouted": 1e-6}.get(name, np.inf)))
        *wanted, x, heads = base_by_hand(0.2 if name == "grouted" else 1.0, conductance > 0, conductance, 0.0 if name == "free" else 5.0)
        drain = "poor" if name == "grouted" else name
        ours = [-discharge(result, "up", name), discharge(result, "down", name), discharge(result, drain, name)]
        if conductance == 0:
            case.check("a clogged drain takes [m2/s]", ours.pop(), 0.0, absolute=0.0)
        case.check(f"drain, {name} ({conductance:g} m2/s): in, to the toe, to the drain [m2/s]", ours, wanted[:len(ours)], relative=1e-9)
        base = flow_of(result, name)["joints"]["joint_0"]
        case.check("... uplift [N], its centre [m]", [base["uplift"], base["centre_x"]], resultant(x, heads), relative=1e-9)
    balanced(case, "drains", [result])


# ---- a jointed dam with a free surface

WIDTH, HIGH, LOW, TOP = 16.0, 24.0, 4.0, 26.0


def jointed_dam(s):
    """W07: rigid blocks of s by s on rock, each a body of its own; no joint in the faces."""
    xs, rows = np.arange(0, WIDTH, s), np.arange(0, TOP, s)
    rock = rectangle(0, -1, WIDTH, 1, len(xs), 1, group="rock", rigid=True)
    dam = rectangle(0, 0, WIDTH, len(rows) * s, len(xs), len(rows), group="dam", rigid=True)
    return join([renamed(rock, {}), renamed(dam, {"upstream": "left", "downstream": "right", "joint_0": "bottom"})])


def jointed_scene(base):
    a = 2e-4
    scene = changed(HELD, ("materials.dam.macroblocks", False), ("joints.default", SCENE["joints"]["default"] | wide(a)), *levels(HIGH, LOW))
    return changed(scene, ("joints.joint_0", wide(a * base ** (1 / 3))))


def free_surface(flow, x, s):
    """[m] Where the pressure ends in the column at x: by hydrostatic pressure above the highest wet node."""
    nodes, p = flow["point"].reshape(-1, 2), flow["pressure"].ravel()
    wet = (np.abs(nodes[:, 0] - x) < 1e-6) & (p > 0)
    top = np.argmax(np.where(wet, nodes[:, 1], -1))
    return nodes[top, 1] + min(p[top] / GW, s)


def jointed(case):
    """W07: the discharge does not depend on where the free surface is; the seepage face and the surface by the plan."""
    sizes, highest = (2.0, 1.0, 0.5), {2.0: 14.0, 1.0: 14.0, 0.5: 13.5}
    results = {s: case.run(jointed_dam(s), jointed_scene(0.5)) for s in sizes}
    for s, result in results.items():
        flow = pieces(result)
        case.check(f"jointed dam, blocks of {s:g} m: discharge, in and out [m2/s]", [-discharge(result, "up"), discharge(result, "down")],
                   T2 / s * (HIGH**2 - LOW**2) / (2 * WIDTH), relative=1e-8)
        base = flow_of(result)["joints"]["joint_0"]["uplift"]
        case.check("... uplift on the base [kN]", base / 1e3, 2335, relative=5e-4) if s <= 1 else case.report("... uplift on the base [kN]", base / 1e3, 2335)
        ends, node = seepage_face(flow)
        case.check("... highest node of the seepage face that gives off water, of the plan [m]", node, highest[s], absolute=1e-9)
        case.report("... its part of the discharge, of the plan (s = 1)", ends / discharge(result, "down"), 0.54)
        surface = [free_surface(flow, x, s) for x in (4, 8, 12)]
        wanted = [22.58, 20.41, 17.43]
        if s <= 1:
            case.check("... free surface at 4, 8, 12 m, of s = 0.125 in the plan [m]", surface, wanted, absolute=0.2)
        else:
            case.report("... free surface at 4, 8, 12 m, of s = 0.125 in the plan [m]", surface, wanted)
        p = flow["pressure"]
        case.check("... pressures from 0 to full head, saturations from 0 to 1", [p.min(), max(p.max() / GW, HIGH), flow["saturation"].min() >= 0, flow["saturation"].max()],
                   [0, HIGH, 1, 1], absolute=0.0)
        both = (1 - flow["saturation"]) * p
        case.check("... pressure only where joints are full [Pa]", both.max(), 0.0, absolute=0.0)
    whole = case.run(jointed_dam(1.0), jointed_scene(1.0))
    case.check("... base joint as wide as the others: discharge [m2/s]", discharge(whole, "down"), 18.125 * T2, relative=1e-8)
    others = [case.run(jointed_dam(1.0), jointed_scene(0.5), ranks=ranks) for ranks in case.ranks(2, 3, 4)]
    same_bits(case, "jointed dam", [results[1.0], *others])
    balanced(case, "jointed dam", [*results.values(), whole, *others])


def seepage_face(flow):
    """[m2/s] What leaves above the lower water, and [m] the highest node where it does."""
    end = flow["point"].reshape(-1, 2, 2)
    out = np.where(np.abs(end[:, 1, 0] - WIDTH) < 1e-6, 1, -1) * flow["discharge"]
    at_face = np.abs(end[:, :, 0] - WIDTH) < 1e-6
    z = np.where(at_face[:, 1], end[:, 1, 1], end[:, 0, 1])
    mine = at_face.any(axis=1) & (z > LOW) & (out > 1e-9 * T2)
    return out[mine].sum(), z[mine].max()


def after_failure(case):
    """A closed base with `flow: after_failure` stays dry, level or rising, also where nodes do not match and contacts are verified."""
    length, height = 10.0, 8.0
    weight = {"density": 2400, "rigid": True}
    loads = {"weight": {"type": "self_weight", "groups": ["dam"]}} | {f"{side}_{i}": {"type": "head", "faces": f"{side}_{i}", "level": height * (side == "up")}
                                                                     for i in range(3) for side in ("up", "down")}
    scene = changed(SCENE, ("materials", {"dam": weight, "rock": weight}), ("supports", {"rock": {"fix": "xy"}}), ("loads", loads),
                    ("joints", {"default": SCENE["joints"]["default"] | {"friction": 45},
                                "base": wide(1e-3) | {"flow": "after_failure", "cohesion": 1e5}}),
                    ("stages", [{"wet": {"loads": list(loads)}}]))
    bodies = []
    for i, rise in enumerate((0, 1 / 8, 1 / 5)):
        x = 40.0 * i + np.linspace(-2, length + 2, 6)
        y = rise * (x - 40.0 * i)
        bodies += [renamed(quad_patch((a, c - 3), (b, d - 3), (b, d), (a, c), 1, 1, "rock", True), {}) for a, b, c, d in zip(x[:-1], x[1:], y[:-1], y[1:])]
        at = 40.0 * i
        dam = quad_patch((at, 0), (at + length, rise * length), (at + length, height), (at, height), 1, 1, "dam", True)
        bodies.append(renamed(dam, {"base": "bottom", f"up_{i}": "left", f"down_{i}": "right"}))
    for how in ("fixed", "variable"):
        result = case.run(join(bodies), changed(scene, ("strain", "large"), ("contact", {"connectivity": how})))
        base = flow_of(result, "wet")["joints"].get("base", {"length": 0.0, "uplift": 0.0})  # none where no water gets in
        case.check(f"closed bases, flow: after_failure, {how} connectivity: length with water [m], uplift [N]", [base["length"], base["uplift"]], 0.0, absolute=1e-9)
