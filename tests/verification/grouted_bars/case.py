"""Bars that are grouted into blocks (anchors with bond_stiffness): pull-out, slip in the grout, joints that open, yield, dowels.

By hand: a bar on elastic bond, u = P cosh(l (L - x))/(EA l sinh(l L)), l = sqrt(bond_stiffness/EA); behind slip of constant bond strength the same."""

import math

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, split_triangles
from scipy.optimize import brentq

WHAT = "grouted bars: pull-out (VA01), slip in the grout (VA02), an opening joint (VA03), a column in time (VA10), dowels (VA08), ranks, restart"
SOURCE = "a bar on elastic bond, closed forms; a beam on an elastic foundation"
BY = "closed forms of elastic bond and of a beam on a foundation, by hand"

AREA, YOUNG = 8.0425e-4, 200e9
EA = AREA * YOUNG
BOND = 2e9
LAMBDA = math.sqrt(BOND / EA)


def scene(anchors, stages, **more):
    return {
        "relaxation": {"tolerance": 1e-10, "velocity_tolerance": 1e-10, "allow_floating": True},
        "materials": {"block": {"density": 2400, "rigid": True}, "base": {"density": 2400, "rigid": True}},
        "joints": {"default": {"k_n": 4e9, "k_s": 4e9, "friction": 45}}, "supports": {"base": {"fix": "xy"}, "block": {"fix": "x"}},
        "anchors": anchors, "stages": stages,
    } | more  # fmt: skip


def bar(head, root, **keys):
    return {"head": list(head), "root": list(root), "area": AREA, "young": YOUNG, "bond_stiffness": BOND} | keys


def told(result, stage, name="a"):
    return result.stage_summary(stage)["anchors"][name]


def run(case):
    pull_out(case)


# ---- VA01, VA02


def pulled(forces, triangles=False, rigid=True):
    """A bar in a base, from 0 to 3 m deep; its head is in a block above, 1.5 m higher, which is pulled up in stages."""
    base, block = rectangle(-1, -3, 2, 3, 1, 4, group="base", rigid=rigid), rectangle(-1, 1, 2, 2, group="block", rigid=True)
    if triangles:
        base = split_triangles(base)
    mesh = join([renamed(base, {}), renamed(block, {"top": "top"}, {"mark": "bottom_left"})])
    loads = {f"P{i}": {"type": "traction", "faces": "top", "value": [0, force / 2]} for i, force in enumerate(forces)}
    stages = [{f"at{i}": {"loads": [f"P{i}"]}} for i in range(len(forces))]
    return mesh, stages, loads


def pull_out(case):
    """Elastic bond, pieces of 62.5 mm."""
    P = 150e3
    mesh, stages, loads = pulled([P])
    k = EA * LAMBDA * math.tanh(3 * LAMBDA)
    case.check("VA01, by hand against the reference: head stiffness [N/m]", k, 5.67185e8, relative=1e-5)
    for method in ("explicit", "preconditioned"):
        for strain in ("small", "large"):
            a = {"a": bar((0, 1.5), (0, -3), free_length=1.5, segment=0.0625)}
            result = case.run(mesh, changed(scene(a, stages, loads=loads, strain=strain), ("relaxation.method", method)))
            head = result.probe("at0", "mark")[1] - P * 1.5 / EA
            case.check(f"VA01, {method}, {strain} strain: displacement of the head [m]", head, P / k, relative=0.01)
            case.check("... force at the head [N]", told(result, "at0")["force"], P, relative=1e-6)
            bars = result.stage("at0").bars
            below = bars.from_head - 1.5
            along = P * np.sinh(LAMBDA * (3 - below[1:])) / math.sinh(3 * LAMBDA)
            case.check("... force along the bar, over that at the head", bars.force[1:] / P, along / P, absolute=0.005)
            case.check("... by hand against the reference at 0.25, 0.5, 1, 2 m [N]", [along[np.argmin(abs(below[1:] - at))] for at in (0.25, 0.5, 1, 2)], [62121, 25727, 4412.5, 129.7], relative=1e-3)
            case.check("... bond [N/m]: bond_stiffness times the slip", bars.bond[1:-1], BOND * bars.slip[1:-1, 0], relative=1e-9)
            case.check("... stiffness [N/m]", told(result, "at0")["stiffness"], EA / (1 / LAMBDA + 1.5), relative=1e-9)
    slip(case)
    opening(case)
    breaks(case)
    column(case)
    dowel(case)
    dowels_by_newton(case)
    stressing(case)
    ranks_and_restart(case)
    refused(case)


def slip(case):
    """Bond strength 400 kN/m: the front of slip goes down the bar; unloaded, what slips back is Masing's rule."""
    strength, u_y, L = 400e3, 400e3 / BOND, 3.0
    def at(a):  # length that has slipped -> load, displacement of the head, by hand
        F = EA * LAMBDA * u_y * math.tanh(LAMBDA * (L - a))  # at the front
        return F + strength * a, u_y + (F * a + strength * a * a / 2) / EA
    reference = {0.5: (313.44e3, 0.86347e-3), 1: (513.44e3, 2.14863e-3), 1.5: (713.43e3, 4.05545e-3), 2: (913.24e3, 6.58163e-3)}
    for a, (P, u) in reference.items():
        case.check(f"VA02, by hand against the reference, {a} m slipped: load [N]", at(a)[0], P, relative=1e-4)
        case.check("... head [m]", at(a)[1], u, relative=1e-4)
    front = brentq(lambda a: at(a)[0] - 600e3, 0, 3)
    half = brentq(lambda a: at(a)[0] - 300e3, 0, 3)
    stays = at(front)[1] - 2 * at(half)[1]
    case.check("... 600 kN: slipped, head, what stays [m]", [front, at(front)[1], stays], [1.21641, 2.89765e-3, 1.2989e-3], relative=1e-4)
    forces = [at(a)[0] for a in reference]
    for method, triangles in (("explicit", False), ("preconditioned", False), ("preconditioned", True)):
        mesh, stages, loads = pulled([*forces, 600e3, 0.0, 600e3], triangles)
        stages = stages[:4] + [{"own": {"loads": ["P4"]}}, *stages[4:]]
        a = {"a": bar((0, 1.5), (0, -3), free_length=1.5, segment=0.02, bond_strength=strength)}
        result = case.run(mesh, changed(scene(a, stages[:4], loads=loads, strain="small"), ("relaxation.method", method)))
        what = f"VA02, {method}{', triangles' if triangles else ''}"
        heads = [result.probe(f"at{i}", "mark")[1] - P * 1.5 / EA for i, P in enumerate(forces)]
        case.check(f"{what}: displacement of the head [m]", heads, [at(a)[1] for a in reference], relative=0.01)
        result = case.run(mesh, changed(scene(a, stages[5:], loads=loads, strain="small"), ("relaxation.method", method)))
        case.check(f"{what}: 600 kN, let go, 600 kN: head [m]", [result.probe(f"at{i}", "mark")[1] - P * 1.5 / EA for i, P in ((4, 600e3), (5, 0), (6, 600e3))],
                   [at(front)[1], stays, at(front)[1]], relative=0.01)
        at600 = told(result, "at4")
        case.check("... slipped length [m], use of the bond", [at600["slipped_length"], at600["bond_use"]], [front, 1], absolute=0.02)
        case.check("... let go: lost in the bond, and stored between bar and grout [J]", told(result, "at5")["lost"] + told(result, "at5")["stored"], work_of_cycle(at, front, half), relative=0.01)


def work_of_cycle(at, front, half):
    """Work of the load over 0, P, 0: the area under the first curve less that under the curve back, the first one twice as large (Masing)."""
    def under(a):
        load, head = np.array([(0, 0), *(at(x) for x in np.linspace(0, a, 2001))]).T
        return np.trapezoid(load, head)
    load, back = at(front)[0], 2 * at(half)[1]
    return under(front) - (load * back - 4 * under(half))


# ---- VA03


def opening(case):
    """A bar across a joint, 2 m in one block and 1 m in the other, ends free; the joint opens."""
    k = [EA * LAMBDA * math.tanh(LAMBDA * length) for length in (2, 1)]
    both = k[0] * k[1] / (k[0] + k[1])
    T_y = 500e6 * AREA
    case.check("VA03, by hand against the reference [N/m]", [*k, both], [5.67184e8, 5.66204e8, 2.83347e8], relative=1e-5)
    mesh = join([renamed(rectangle(-1, -3, 2, 3, 1, 2, group="base", rigid=True), {}), renamed(rectangle(-1, 0, 2, 2, group="block", rigid=True), {"top": "top"}, {"mark": "bottom_left"})])
    yields = T_y / both
    case.check("... yields at (reference 1.4192) [m]", yields, 1.4192e-3, relative=1e-4)
    forces = [0.0002 * both, 0.99 * T_y]
    for head, root in (((0, 1), (0, -2)), ((0, -2), (0, 1))):
        for method in ("explicit", "preconditioned"):
            loads = {f"P{i}": {"type": "traction", "faces": "top", "value": [0, force / 2]} for i, force in enumerate(forces)}
            stages = [{f"at{i}": {"loads": [f"P{i}"]}} for i in range(2)]
            a = {"a": bar(head, root) | {"yield": 500e6}}
            result = case.run(mesh, changed(scene(a, stages, loads=loads), ("relaxation.method", method)))
            case.check(f"VA03, head at {head[1]} m, {method}: opening [m]", [result.probe(f"at{i}", "mark")[1] for i in range(2)], [0.0002, 0.99 * yields], relative=0.01)
            case.check("... largest force [N]", [told(result, f"at{i}")["force"] for i in range(2)], forces, relative=1e-6)
            case.check("... the joint may open until the bar yields, embedments long [m]", told(result, "at0")["reserve"], (T_y - forces[0]) * 2 / EA / LAMBDA, relative=1e-6)


def breaks(case):
    """Two bars across a joint; the weak one breaks, what it carried goes to the other; in time a bar breaks as the joint opens."""
    k = [EA * LAMBDA * math.tanh(LAMBDA * length) for length in (2, 1)]
    both = k[0] * k[1] / (k[0] + k[1])
    mesh = join([renamed(rectangle(-1, -3, 2, 3, 1, 2, group="base", rigid=True), {}), renamed(rectangle(-1, 0, 2, 2, group="block", rigid=True), {"top": "top"}, {"mark": "bottom_left"})])
    limit = 150e3
    for plate in (False, True):  # held at its head, too, where it carries nothing
        bars = {"weak": bar((-0.5, 1), (-0.5, -2), breaking_force=limit, plate=plate, dowel_stiffness=1e7), "strong": bar((0.5, 1), (0.5, -2))}
        for method in ("explicit", "preconditioned"):
            for pull, broken in ((0.97 * limit, False), (1.06 * limit, True)):
                loads = {"P": {"type": "traction", "faces": "top", "value": [0, pull]}}
                whole = scene(bars, [{"pulled": {"loads": ["P"]}}, {"after": {"loads": ["P"]}}], loads=loads, strain="small", relaxation={"method": method, "tolerance": 1e-9, "allow_floating": True})
                result = case.run(mesh, whole)
                what = f"two bars pulled with {2 * pull:g} N, {method}{', a plate' if plate else ''}"
                state = told(result, "after", "weak")
                case.check(f"{what}: state", state["state"], "broken" if broken else "elastic")
                case.check("... forces [N]", [told(result, "after", name)["force"] for name in bars], [0, 2 * pull] if broken else [pull, pull], absolute=0.01 * pull)
                if not broken:
                    continue
                case.check("... reported", result.stdout.count("anchor weak breaks at 159"), 1)
                if not plate:
                    broken_is_not_pulled(case, mesh, whole)
                case.check("... largest so far [N]", state["largest"], pull, relative=0.01)
                case.check("... lost [J]", state["lost"], pull * pull / both / 2, relative=0.02)
                case.check("... opening [m]", result.probe("after", "mark")[1], 2 * pull / both, relative=0.02)
                rows = result.stage("after").bars
                case.check("... nothing along it", np.abs(rows.force[rows.of(0)]).max() + np.abs(rows.bond[rows.of(0)]).max(), 0.0, absolute=1e-9)
    opens = limit / both
    for end, broken in ((0.97, False), (1.1, True)):
        apart = {"head": bar((0, 1), (0, -2), breaking_force=limit)}
        clock = renamed(rectangle(9, 0, 1, 1, group="clock"), {})
        stages = [{"opens": {"type": "dynamic", "loads": [], "duration": 0.1, "dt_factor": 0.2}}, {"on": {"type": "dynamic", "loads": [], "duration": 0.05, "dt_factor": 0.2}}]
        moving = scene(apart, stages, supports={"base": {"fix": "xy"}, "block": {"fix": "xy", "motion": "path.csv"}}, relaxation={"allow_floating": True, "history_every": 100},
                       joints={"default": {"k_n": 4e9, "k_s": 4e9, "friction": 0}})  # fmt: skip
        moving["materials"]["clock"] = {"density": 2400, "young": 20e9, "poisson": 0.2}
        folder = case.prepare(join([mesh, clock]), moving)
        v = end * opens / 0.1
        (folder / "path.csv").write_text(f"t,x,y\n0,0,{v:.17g}\n0.1,0,{v:.17g}\n0.1000001,0,0\n1,0,0\n", encoding="utf-8")
        result = case.again(folder)
        state = told(result, "on", "head")
        case.check(f"in time, opened to {end} of where it breaks: state", state["state"], "broken" if broken else "elastic")
        case.check("... force [N]", state["force"], 0 if broken else end * limit, absolute=0.01 * limit)
        work = min(end, 1) ** 2 * limit * opens / 2
        energy = result.stage_summary("opens")["energy"]
        case.check("... work of the support [J]", energy["supports"], work, relative=0.01)
        case.check("... lost and stored [J]", state["lost"] + state["stored"], work, relative=0.01)
        case.check("... balance over that work, both stages", [result.stage_summary(stage)["energy"]["balance"] / work for stage in ("opens", "on")], [0, 0], absolute=2e-3)


def broken_is_not_pulled(case, mesh, whole):
    """A tendon that has broken is refused where the pull of anchors is asked for; where a jack should stress it again that is reported."""
    tendon = {"head": [-0.5, 1], "root": [-0.5, -2], "area": AREA, "young": YOUNG, "breaking_force": 7e4, "prestress": [5e4, 6e4], "lock": ["pulled", "again"]}
    stages = [{name: {"loads": ["weight"] if name == "pulled" else ["weight", "P"]}} for name in ("pulled", "over", "again")]
    asks = {"force": {"type": "anchor_force", "loads": ["weight"], "anchors": ["weak"], "start": 1, "step": 0.5, "limit": 0.1, "bracket": 0.1}}
    loads = whole["loads"] | {"weight": {"type": "self_weight", "groups": ["block"]}}
    keys = [("anchors", whole["anchors"] | {"weak": tendon}), ("loads", loads), ("stages", [*stages, asks])]
    for ranks in (1, 2):
        result = case.run(mesh, changed(whole, *keys), ranks=ranks)
        case.check(f"a broken tendon, {ranks} ranks: stressed again, reported", result.stderr.count("warning: stage again: anchor weak has broken before: it is not stressed again"), 1)
        case.check("... asked for its force, refused in one line", [result.exit_code, result.stderr.count("stages.force.anchors: 'weak' has broken before: no jack can pull it\n")], [2, 1])


# ---- VA10


def column(case):
    """24 blocks of 0.5 m with a bar every 2 m, in time: the bond shortens the step once by bond_stiffness h, whatever the pieces of the bar."""
    mesh = join([renamed(rectangle(0, 0, 1, 12, 1, 24, group="block", rigid=False), {"bottom": "bottom"}, {"top": "top_left"})])
    soft = {"density": 2400, "young": 20e9, "poisson": 0.0, "velocity": [0, 0.1]}
    a = {"a": bar((0.5, 11.9), (0.5, 0.1), spacing=2.0, segment=0.5)}
    stages = [{"moves": {"type": "dynamic", "loads": [], "duration": 1e5 * 0.95 * 1.72e-4, "dt_factor": 0.95}}]
    moving = scene({}, stages, materials={"block": soft}, supports={"bottom": {"fix": "xy"}}, strain="small", relaxation={"history_every": 10000, "check_every": 1000})
    def moves(anchors, duration, ranks=1):
        stage = {"type": "dynamic", "loads": [], "duration": duration, "dt_factor": 0.95}
        return case.run(mesh, changed(moving, ("anchors", anchors), ("stages", [{"moves": stage}])), ranks=ranks)
    def step(anchors):
        return moves(anchors, 1.7).stage_summary("moves")["dt"]
    alone, tied = step({}), step(a)
    case.check("VA10: step with the bar over that without (reference, in one dimension, 1.7294/1.7321)", tied / alone, 1.7294 / 1.7321, relative=1e-3)
    case.check("... pieces ten times shorter, which steel masses of their own would make 10 times shorter steps: over that", step({"a": a["a"] | {"segment": 0.05}}) / tied, 1.0, relative=1e-12)
    steps = 100000
    for what, anchors, part in (("", a, 1), (", bond a thousand times stiffer", {"a": a["a"] | {"bond_stiffness": 1000 * BOND}}, 0.1)):
        result = moves(anchors, part * steps * tied)
        stage = result.stage_summary("moves")
        energy = stage["energy"]
        case.check(f"... {part * steps:g} steps at 0.95 of the bound{what}: balance over what moves", energy["balance"] / (energy["kinetic"] + energy["strain"]), 0, absolute=1e-10)
        case.check("... the bar works: its largest force [N]", told(result, "moves")["largest"] > 1e3, True)
    one = [stage["checksum"] for stage in moves(a, 0.2).summary["stages"]]
    for ranks in case.ranks(2, 3, 4):
        result = moves(a, 0.2, ranks)
        case.check(f"... {ranks} ranks, the bar across all: same bits", [stage["checksum"] for stage in result.summary["stages"]], one)


# ---- VA08


def turned(mesh, angle):
    c, s = math.cos(angle), math.sin(angle)
    mesh.vertices = np.array(mesh.vertices) @ [[c, s], [-s, c]]
    return mesh


def dowel(case):
    """A joint without friction that one bar crosses, sheared in legs; along x and turned by 30 degrees, small and large strain."""
    reference = {2e9: (14.8454, 3.36804e7, 74.07e3, 2.199e-3), 10e9: (22.1991, 1.12617e8, 110.76e3, 0.9835e-3)}
    path = [(0, 0), (0.1, 0.5e-3), (0.2, 4e-3), (0.3, 3.5e-3), (0.4, 0), (0.5, -0.5e-3)]
    for foundation, (beta, K, V_y, limit) in reference.items():
        bending = YOUNG * math.pi / 64 * 0.032**4
        b = (foundation / 4 / bending) ** 0.25
        by_hand = [b, bending * b**3, 500e6 * math.pi / 32 * 0.032**3 * b / (math.exp(-math.pi / 4) * math.sin(math.pi / 4))]
        case.check(f"VA08, foundation {foundation:g}, by hand against the reference: beta, K, V_y, slip", [*by_hand, by_hand[2] / by_hand[1]], [beta, K, V_y, limit], relative=2e-4)
        K, V_y = by_hand[1:]
        V, plastic, wanted, lost = 0.0, 0.0, [], [0.0]
        for _, slip in path[1:]:
            V = min(max(K * (slip - plastic), -V_y), V_y)
            lost.append(lost[-1] + abs(V * (slip - V / K - plastic)))
            plastic = slip - V / K
            wanted.append(V)
        upright = None
        for angle, strain, head in ((0, "small", 0.5), (math.pi / 6, "small", -0.5), (0, "large", 0.5), (math.pi / 6, "large", 0.5)):
            base, block = rectangle(-1, -2, 2, 2, 1, 1, group="base", rigid=True), rectangle(-1, 0, 2, 2, group="block", rigid=True)
            clock = rectangle(9, 0, 1, 1, group="clock")  # where all is held nothing sets the step
            mesh = join([renamed(turned(base, angle), {}), renamed(turned(block, angle), {}), renamed(clock, {})])
            across = np.array([-math.sin(angle), math.cos(angle)])
            a = {"a": bar(0.9 * across * np.sign(head), -0.9 * across * np.sign(head), dowel_foundation=foundation) | {"yield": 500e6}}
            stages = [{f"leg{i}": {"type": "dynamic", "loads": [], "duration": 0.1, "dt_factor": 0.5}} for i in range(1, 6)]
            sheared = scene(a, stages, supports={"base": {"fix": "xy"}, "block": {"fix": "xy", "motion": "path.csv"}}, strain=strain,
                            joints={"default": {"k_n": 4e9, "k_s": 4e9, "friction": 0}}, relaxation={"allow_floating": True, "history_every": 1000})  # fmt: skip
            sheared["materials"]["clock"] = {"density": 2400, "young": 20e9, "poisson": 0.2}
            folder = case.prepare(mesh, sheared)
            rows = []
            for (t0, y0), (t1, y1) in zip(path, path[1:]):
                v = (y1 - y0) / (t1 - t0)
                rows += [f"{t:.17g},{v * math.cos(angle):.17g},{v * math.sin(angle):.17g}" for t in (t0, t1)]
            (folder / "path.csv").write_text("t,x,y\n" + "\n".join(rows) + "\n", encoding="utf-8")
            result = case.again(folder)
            what = f"VA08, foundation {foundation:g}, joint at {math.degrees(angle):.0f} degrees, {strain} strain"
            found = [told(result, f"leg{i}")["dowels"][0] for i in range(1, 6)]
            forces = np.array([dowel["force"] for dowel in found]) * np.sign(found[0]["force"])
            if strain == "large" and angle:  # the bar, bent by the slip, is pulled as well: no closed form
                case.check(f"{what}: force after each leg as upright [N]", forces, upright, relative=1e-7)
                continue
            upright = forces
            case.check(f"{what}: force after each leg [N]", forces, wanted, absolute=(1e-2 if strain == "large" else 1e-5) * V_y)
            if strain == "large":
                continue
            case.check("... slip [m]", [abs(dowel["slip"]) for dowel in found], [abs(slip) for _, slip in path[1:]], absolute=1e-8)
            case.check("... lost [J]", [told(result, f"leg{i}")["lost_dowel"] for i in range(1, 6)], lost[1:], absolute=1e-4 * max(lost))
            energy = result.stage_summary("leg2")["energy"]
            case.check("... work of the support in leg 2 [J]", energy["supports"], lost[2] + wanted[1] ** 2 / 2 / K - wanted[0] ** 2 / 2 / K, relative=2e-3)


def dowels_by_newton(case):
    """Bars and their dowels yield together, most of all where a block is lifted and pushed: Newton's method finds what explicit cycles find, in few iterations."""
    mesh = join([renamed(rectangle(-1, -2, 2, 2, 4, 4, group="base"), {"bottom": "bottom"}), renamed(rectangle(-1, 0, 2, 2, 4, 4, group="block"), {"top": "top"})])
    pushes = [(1.5e5, 3e5), (2e5, 3.2e5), (-1e5, 2e5)]
    loads = {f"P{i}": {"type": "traction", "faces": "top", "value": [x / 2, y / 2]} for i, (x, y) in enumerate(pushes)}
    for strain, triangles, tilt in (("small", False, 0.0), ("small", True, 0.6), ("large", False, 0.0), ("large", False, 0.6)):
        bars = {name: bar((x + tilt, 1.2), (x - tilt, -1.2), dowel_foundation=2e9, segment=0.1) | {"yield": 400e6} for name, x in (("a", -0.31), ("b", 0.33))}
        soft = {"density": 2400, "young": 10e9, "poisson": 0.2}
        whole = scene(bars, [{f"at{i}": {"loads": [f"P{i}"]}} for i in range(len(pushes))], strain=strain, loads=loads, supports={"bottom": {"fix": "xy"}},
                      materials={"base": soft, "block": soft}, joints={"default": {"k_n": 2e7, "k_s": 2e7, "cohesion": 1e8, "tension": 1e8, "friction": 30}})  # fmt: skip
        pieces = split_triangles(mesh) if triangles else mesh
        newton, explicit = (case.run(pieces, changed(whole, ("relaxation.method", method))) for method in ("preconditioned", "explicit"))
        what = f"dowels by Newton's method, {strain} strain{', triangles' if triangles else ''}, bars {'leaning' if tilt else 'upright'}"
        def forces(result, name):
            return [[told(result, f"at{i}", name)["force"], told(result, f"at{i}", name)["dowels"][0]["force"]] for i in range(len(pushes))]
        for name in bars:
            case.check(f"{what}: forces of bar and dowel {name} as by explicit cycles [N]", forces(newton, name), forces(explicit, name), absolute=1.0)
        case.check("... bar and dowel yield together: use", told(newton, "at1")["dowels"][0]["use"], 1.0, relative=1e-9)
        case.check("... and both have a share: force over strength", [abs(told(newton, "at1")["force"]) / (400e6 * AREA) > 0.3, abs(told(newton, "at1")["dowels"][0]["force"]) > 1e3], [True, True])
        if strain == "small":  # in large strain the tangent leaves out that blocks turn, with bars and without
            case.check("... in at most 9 iterations; the first took 18 without what couples bar and dowel", [newton.stage_summary(f"at{i}")["cycles"] <= 9 for i in range(len(pushes))], [True] * len(pushes))


# ---- stressing


def stressing(case):
    """A tendon with a bonded root: what it is stressed to is what it has as it is locked, whatever the bond gives; draw-in takes by bar, bond and joint in series."""
    T, K, slip = 200e3, 8e9, 1e-4
    L_free, L = 1.5, 3.0
    base = renamed(rectangle(-3, -6, 6, 6, group="base", rigid=True), {"joint": "top"})
    mesh = join([base, renamed(rectangle(-1, 0, 2, 2, 4, 4, group="block", rigid=True), {"top": "top"}, {"mark": "bottom_left"})])
    loads = {"weight": {"type": "self_weight", "groups": ["block"]}}
    stages = [{name: {"loads": ["weight"]}} for name in ("own", "lock", "after", "again", "last")]
    x = LAMBDA * 0.05
    bond = EA * LAMBDA * math.tanh(L * LAMBDA) / (1 + x * x / 8)
    for method in ("explicit", "preconditioned"):
        for strain in ("small", "large"):
            a = {"a": bar((0, 0.5), (0, 0.5 - L_free - L), free_length=L_free, segment=0.05, prestress=[T, 1.3 * T], lock=["lock", "again"], bond_strength=400e3)}
            whole = scene(a, stages, loads=loads, strain=strain, supports={"base": {"fix": "xy"}})
            whole["joints"]["default"] |= {"k_n": K / 2, "k_s": K / 2}
            result = case.run(mesh, changed(whole, ("relaxation.method", method)))
            case.check(f"stressed, {method}, {strain} strain: force [N]", [told(result, stage)["force"] for stage in ("lock", "after", "again", "last")], [T, T, 1.3 * T, 1.3 * T], relative=1e-8)
            case.check("... states", [told(result, stage)["state"] for stage in ("own", "lock", "after")], ["absent", "stressed", "slipped" if T > 113e3 else "elastic"])
            own = 4 * 2400 * 9.81
            case.check("... the joint bears [N]", [result.stage_summary(stage)["joints"]["default"]["N"] for stage in ("lock", "after", "last")], [own + T, own + T, own + 1.3 * T], relative=1e-8)
            a = {"a": bar((0, 0.5), (0, 0.5 - L_free - L), free_length=L_free, segment=0.05, prestress=T, lock="lock", draw_in=slip)}
            result = case.run(mesh, changed(whole, ("anchors", a), ("relaxation.method", method)))
            series = 1 / (L_free / EA + 1 / bond + 1 / K)
            case.check("... elastic bond, its head slips back by 0.1 mm: force [N]", told(result, "after")["force"], T - slip * series, relative=2e-4)


# ---- ranks, restart


def everything():
    """A dam of two bodies on ground, tied by bars that cross all of it: grouted all along, with a plate, stressed above a bonded root; slip in the grout, yield, trials, time."""
    lower, upper = (renamed(quad_patch((0, y), (w0, y), (w1, y + 4), (0, y + 4), 6, 4, group=group), {"upstream": "left"}, {}) for y, w0, w1, group in ((0, 6, 4.5, "lower"), (4, 4.5, 3, "upper")))
    mesh = join([renamed(rectangle(-6, -6, 18, 6, 9, 3, group="base"), {"bottom": "bottom"}), lower, upper])
    anchors = {"tendon": bar((0.7, 7.6), (0.7, -5.3), free_length=8.0, prestress=[1.5e5, 2e5], lock=["first", "again"], bond_strength=1.5e5, spacing=2.0),
               "bolt": bar((1.3, 7.2), (3.1, -4.1), plate=True, bond_strength=2e3, segment=0.25), "bar": bar((2.9, 5.5), (2.2, -2.2), segment=0.2, **{"yield": 1e3 / AREA, "from": "second"})}
    soft = {"density": 2400, "young": 5e9, "poisson": 0.2}
    stages = [{name: {"loads": ["weight"]}} for name in ("own", "first", "second", "again")]
    stages += [{"full": {"loads": ["weight", "water"]}}, {"flood": {"type": "flood", "loads": ["weight", "water"], "step": 4, "limit": 24, "bracket": 2}},
               {"less": {"type": "strength_reduction", "loads": ["weight", "water"], "start": 44, "step": 6, "limit": 25, "bracket": 2}},
               {"shake": {"type": "dynamic", "loads": ["weight", "water"], "duration": 0.02, "dt_factor": 0.3}}]  # fmt: skip
    return mesh, scene(anchors, stages, strain="large", supports={"bottom": {"fix": "xy"}}, relaxation={"tolerance": 1e-5, "velocity_tolerance": 1e-5, "method": "explicit"},
                       joints={"default": {"k_n": 10e9, "k_s": 5e9, "friction": 45}}, materials={"lower": soft, "upper": soft, "base": soft | {"density": 2600}},
                       loads={"weight": {"type": "self_weight", "groups": ["lower", "upper"]}, "water": {"type": "reservoir", "faces": "upstream", "level": 8}})  # fmt: skip


def numbers_of(result):
    stages = [stage for stage in result.summary["stages"] if "anchors" in stage]
    stages += [trial for stage in result.summary["stages"] for trial in stage.get("flood", {}).get("trials", []) if trial["outcome"] == "stable"]
    return [[value for one in stage["anchors"].values() for value in one.values()] for stage in stages]


def ranks_and_restart(case):
    """The same bits on 1 to 4 ranks, and from checkpoints within stressing, trials and motion; what is reported too; other kinds of bodies, the other method."""
    mesh, whole = everything()
    folder = case.prepare(mesh, changed(whole, ("checkpoint", {"every": 700, "keep": 1000})))
    first = case.again(folder)
    case.again(folder, "-output", "kept")
    def checksums(result):
        return [stage["checksum"] for stage in result.summary["stages"]]
    case.check("all stages run", {stage["verdict"] for stage in first.summary["stages"]}, {"converged", "completed"})
    case.check("the tendon is stressed [N]", [told(first, "first", "tendon")["force"], told(first, "again", "tendon")["force"]], [1.5e5, 2e5])
    case.check("... grout slips, a bar yields: states", [told(first, "less", name)["state"] for name in ("tendon", "bolt", "bar")], ["slipped", "slipped", "yielded"])
    for ranks in case.ranks(2, 3, 4):
        result = case.run(mesh, whole, ranks=ranks)
        case.check(f"checksums on {ranks} ranks", checksums(result), checksums(first))
        case.check("... the same numbers of all bars", numbers_of(result) == numbers_of(first), True)
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    for i, at in enumerate((len(kept) // 8, len(kept) // 3, 2 * len(kept) // 3, len(kept) - 2)):
        again = case.again(folder, "-restart", kept[at], ranks=1 + i % 2)
        case.check(f"restart from checkpoint {at} of {len(kept)}: checksums", checksums(again), checksums(first))
        case.check("... the same numbers of all bars", numbers_of(again) == numbers_of(first), True)
    small = changed(whole, ("strain", "small"), ("stages", [stage for stage in whole["stages"] if set(stage) <= {"own", "first", "second", "again", "full"}]), ("relaxation.tolerance", 1e-8))
    reference = case.run(mesh, small)
    for what, changes in (("Newton's method", [("relaxation.method", "preconditioned")]), ("a condensed upper body", [("materials.upper.condensed", True)]),
                          ("the same by Newton's method", [("materials.upper.condensed", True), ("relaxation.method", "preconditioned")])):  # fmt: skip
        result = case.run(mesh, changed(small, *changes))
        for name in ("tendon", "bolt", "bar"):
            case.check(f"{what}: force of {name} [N]", told(result, "full", name)["force"], told(reference, "full", name)["force"], relative=1e-4)


def refused(case):
    """What only the mesh shows."""
    mesh = join([renamed(rectangle(-1, -3, 2, 3, group="base", rigid=True), {}), renamed(rectangle(-1, 0, 2, 2, group="block", rigid=True), {"top": "top"})])
    loads = {"P": {"type": "traction", "faces": "top", "value": [0, -1]}}
    for keys, words in (({"dowel_stiffness": 1e7, "head": [0, -0.5]}, "anchors.a: a dowel needs a joint: the bonded length lies in one body"),
                        ({"head": [-0.5, 0], "root": [0.5, 0]}, "anchors.a: 0 m from its head the bar runs along a joint, in two bodies"),
                        ({"head": [0, 0], "plate": True}, "anchors.a.head: (0, 0) lies between two bodies"), ({"root": [0, -9]}, "anchors.a.root: (0, -9) lies in no block")):  # fmt: skip
        result = case.run(mesh, scene({"a": bar((0, 1), (0, -2)) | keys}, [{"own": {"loads": ["P"]}}], loads=loads))
        case.check(f"refused: {words}", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])
    apart = join([renamed(rectangle(-1, -3, 2, 3, group="base", rigid=True), {}), renamed(rectangle(-1, 0.5, 2, 2, group="block", rigid=True), {"top": "top"})])
    result = case.run(apart, scene({"a": bar((0, 1), (0, -2), dowel_stiffness=1e7)}, [{"own": {"loads": ["P"]}}], loads=loads))
    words = "anchors.a: the bar crosses a gap of 0.5 m, 0.5 m from its head: a dowel needs a joint there"
    case.check(f"refused: {words}", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])
