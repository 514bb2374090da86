"""Water in the base joint of a dam, whose width follows the opening (W06): a rigid dam by hand, levels it stands, and agreement of
ways to solve it.

By hand: a rigid body on a joint without tension has two unknowns, the openings at heel and toe. Apertures follow from them, heads from
the resistances of tapered pieces in a row, uplift from the heads; N and M balance (scipy). With as many pieces as contacts it has the
solver's own discretization, with thousands it is the plan's reference."""

import json

import h5py
import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, rectangle, renamed
from scipy.optimize import root

WHAT = "water and opening of a base joint agree: rigid dam (W06), limit levels, ways to solve it, ranks, restart"
SOURCE = "two equations of a rigid dam on a joint without tension (scipy); numbers of the plan; explicit relaxation on one rank"
BY = "two equations solved apart (scipy), this project; Quoin itself, explicit"

GW, MU, G, RHO = 9810.0, 1e-3, 9.81, 2350.0
LENGTH, LEVEL, DRAIN, GALLERY = 28.0, 37.0, 4.0, 2.0
APERTURE, LEAST, MOST = 1.5e-4, 3e-5, 1e-3
OUTLINE = np.array([(0, 0), (28, 0), (4, 34), (4, 38), (0, 38)], float)


# ---- by hand

def weight():
    """[N] of the dam, [m] where it acts."""
    (x, y), (x2, y2) = OUTLINE.T, np.roll(OUTLINE, -1, axis=0).T
    cross = x * y2 - x2 * y
    return RHO * G * cross.sum() / 2, ((x + x2) * cross).sum() / (3 * cross.sum())


def heads(x, heel, toe, level, drained):
    """[m] along a row of pieces, and [m2/s] what enters at the heel and leaves at the toe. The aperture is a line, within its limits."""
    rise = (toe - heel) / LENGTH
    met = [(limit - APERTURE - heel) / rise for limit in (LEAST, MOST) if rise]
    grid = np.unique(np.concatenate([x, [place for place in met if 0 < place < LENGTH]]))
    a = np.clip(APERTURE + heel + rise * grid, LEAST, MOST)
    resistance = 12 * MU / GW * np.diff(grid) * (a[1:] + a[:-1]) / (2 * (a[1:] * a[:-1]) ** 2)
    way = np.concatenate([[0], np.cumsum(resistance)])[np.searchsorted(grid, x)]
    at = np.argmin(abs(x - DRAIN)) if drained else -1
    held = [(0, level), (way[at], GALLERY), (way[-1], 0)] if drained else [(0, level), (way[-1], 0)]
    head = np.interp(way, *np.array(held).T)
    return head, np.array([(level - held[1][1]) / held[1][0], held[-2][1] / (way[-1] - held[-2][0])])


def state(heel, toe, level, k_n, drained, n):
    """What openings [m] of heel and toe lead to: forces [N] per metre, moments about the heel; off: what is missing to balance."""
    x = np.linspace(0, LENGTH, n + 1)
    head, q = heads(x, heel, toe, level, drained)
    p, d = GW * head, LENGTH / n
    uplift = d * (p[1:] + p[:-1]).sum() / 2
    lever = d * np.sum(x[:-1] * (p[:-1] + p[1:]) / 2 + d * (p[:-1] + 2 * p[1:]) / 6)
    opened = LENGTH * heel / (heel - toe) if heel > 0 else 0.0
    ends = -k_n * np.array([min(heel, 0), toe])  # effective stress where it is closed
    bears = LENGTH - opened
    normal, turns = bears * ends.sum() / 2, opened * bears * ends.sum() / 2 + bears**2 * (ends[0] + 2 * ends[1]) / 6
    off = np.array([normal + uplift - weight()[0], (turns + lever - weight()[0] * weight()[1] - GW * level**3 / 6) / LENGTH])
    return {"off": off, "open": opened, "uplift": uplift, "centre": lever / uplift, "N": normal, "T": GW * level**2 / 2, "q": q,
            "p": np.interp([LENGTH / 4, LENGTH / 2, 3 * LENGTH / 4], x, p), "ends": -ends, "u": np.array([heel, toe])}


def by_hand(k_n, drained, n, level=LEVEL):
    for start in ((-0.05, -0.15), (0.3, -0.5), (0.15, -0.6), (-0.2, -0.7)):  # over the stress of 1 MPa
        found = root(lambda u: state(*(u * 1e6 / k_n), level, k_n, drained, n)["off"] / 1e6, start, tol=1e-13)
        if abs(found.fun).max() < 1e-9:
            return state(*(found.x * 1e6 / k_n), level, k_n, drained, n)
    raise RuntimeError(f"no equilibrium by hand at {level:g} m")


def limit_by_hand(k_n, n):
    """[m] Highest level with an equilibrium: it rises with the rotation, and falls beyond."""
    now = by_hand(k_n, False, n)
    guess, rotation, levels = np.array([now["u"][1] * k_n / 1e6, LEVEL]), now["u"][0] - now["u"][1], [LEVEL]
    while levels[-1] >= levels[max(0, len(levels) - 2)]:
        rotation *= 1.01
        found = root(lambda y: state(y[0] * 1e6 / k_n + rotation, y[0] * 1e6 / k_n, y[1], k_n, False, n)["off"] / 1e6, guess, tol=1e-13)  # noqa: B023
        guess = found.x
        levels.append(guess[1])
    return max(levels)


# ---- by the solver

def dam(n, rows=1, wall=0.0):
    """The dam of n columns on rock; its base joint of n contacts; wall: [m] that its face goes on above the crest."""
    xs, vertices, number, blocks, sets = np.linspace(0, LENGTH, n + 1), [], {}, [], {"base": [], "upstream": [], "downstream": []}

    def vertex(x, y):
        key = (round(x, 9), round(y, 9))
        if key not in number:
            number[key] = len(vertices)
            vertices.append((x, y))
        return number[key]

    def high(x):
        return 34.0 if x < 4 + 1e-9 else 34 * (28 - x) / 24

    def add(ring, **faces):
        for name, face in faces.items():
            sets[name].append((len(blocks), face))
        blocks.append([*ring, -1][:4])

    for a, b in zip(xs, xs[1:]):
        up = {"upstream": 3} if a == 0 else {}
        for j in range(rows):
            low, top = j / rows, (j + 1) / rows
            base = {"base": 0} if j == 0 else {}
            if b > LENGTH - 1e-9:
                last = {"downstream": 1} if j == rows - 1 else {}
                add([vertex(a, low * high(a)), vertex(b, 0), vertex(a, top * high(a))], **base, **last)
            else:
                slope = {"downstream": 2} if j == rows - 1 and a > 4 - 1e-9 else {}
                add([vertex(a, low * high(a)), vertex(b, low * high(b)), vertex(b, top * high(b)), vertex(a, top * high(a))], **base, **up, **slope)
        if b < 4 + 1e-9:
            add([vertex(a, 34), vertex(b, 34), vertex(b, 38), vertex(a, 38)], **up)
    n_dam = len(blocks)
    if wall:
        add([vertex(0, 38), vertex(xs[1], 38), vertex(xs[1], 38 + wall), vertex(0, 38 + wall)], upstream=3)
    group = (np.arange(len(blocks)) >= n_dam).astype(int)
    names = ["dam", "wall"] if wall else ["dam"]
    body = BlockMesh(np.array(vertices), np.array(blocks), group, names, [1] * len(names), {name: np.array(rows) for name, rows in sets.items()},
                     {"heel": number[0, 0], "toe": number[LENGTH, 0], "crest": number[0, 38]})
    return join([renamed(rectangle(0, -2, LENGTH, 2, n, 1, group="rock", rigid=True), {}), body])


SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9},
    "flow": {"tolerance": 1e-7},
    "materials": {"rock": {"density": 0}, "dam": {"density": RHO}},
    "joints": {"default": {"k_n": 20e9, "k_s": 20e9, "friction": 45, "cohesion": 1e9},
               "base": {"aperture": APERTURE, "aperture_residual": LEAST, "aperture_max": MOST}},
    "supports": {"rock": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": LEVEL},
              "up": {"type": "head", "faces": "upstream", "level": LEVEL}, "down": {"type": "head", "faces": "downstream", "level": 0},
              "drain": {"type": "drain", "joint": "base", "distance": DRAIN, "gallery": GALLERY}},
    "stages": [{"own": {"loads": ["weight"]}}, {"full": {"loads": ["weight", "water", "up", "down"]}}],
}


def scene(k_n, drained=False, *changes):
    acts = SCENE["stages"][1]["full"]["loads"] + ["drain"] * drained
    return changed(SCENE, ("joints.default.k_n", k_n), ("joints.default.k_s", k_n), ("stages", [SCENE["stages"][0], {"full": {"loads": acts}}]), *changes)


def pieces(result, stage="full"):
    with h5py.File(result.path) as file:
        return {name: column[...] for name, column in file[f"stages/{stage}/flow"].items()}


def found(result, stage="full"):
    """The same quantities as `state` has."""
    summary = result.stage_summary(stage)
    flow, base, line = summary["flow"], summary["joints"]["base"], pieces(result, stage)
    q = [-flow["conditions"]["up"]["discharge"], flow["conditions"]["down"]["discharge"]]
    x, p = line["point"][:, 0::2].ravel(), line["pressure"].ravel()
    order = np.argsort(x, kind="stable")
    return {"open": base["open_length"], "uplift": flow["joints"]["base"]["uplift"], "centre": flow["joints"]["base"]["centre_x"], "N": base["N"],
            "T": base["T"], "q": np.array(q), "p": np.interp([LENGTH / 4, LENGTH / 2, 3 * LENGTH / 4], x[order], p[order]),
            "ends": np.array([base["start"]["sigma"], base["end"]["sigma"]]),
            "u": np.array([result.probe(stage, point)[1] for point in ("heel", "toe")])}


def balanced(case, what, results):
    """No node gains or loses water, no stage, and no trial of one."""
    stages = [stage for result in results for stage in result.summary["stages"]]
    flows = [stage["flow"] for stage in stages if "flow" in stage]
    flows += [trial["flow"] for stage in stages if "flood" in stage for trial in stage["flood"]["trials"]]
    most = max(flow["error"] for flow in flows)
    sums = [abs(sum(condition["discharge"] for condition in flow["conditions"].values())) / flow["inflow"] for flow in flows]
    case.check(f"{what}: mass error of the worst node, of in and out, over the inflow ({len(flows)} stages and trials)", [most, max(sums)], 0.0,
               absolute=1e-8)


def sums(result):
    return json.dumps([stage["checksum"] for stage in result.summary["stages"]])


LONG = ("restart",)  # parts that the short form leaves out


def run(case):
    rigid(case)
    contacts(case)
    limits(case)
    friction(case)
    one_way(case)
    ways(case)
    found_anew(case)
    at_once(case)
    ranks(case)
    restart(case)


PLAN = {  # k_n, drain: u_n of heel and toe [mm], stress there [kPa], open [m], uplift [kN] at [m], N [kN], q in and out, p [kPa]
    (5e9, False): ([0.06301, -0.10420], [0, -521.0], 10.551, 8364.6, 12.178, 4545.4, [7.946e-7, 7.946e-7], [353.3, 332.9, 276.5]),
    (20e9, False): ([0.00687, -0.03109], [0, -621.7], 5.067, 5780.9, 9.960, 7129.0, [2.726e-6, 2.726e-6], [297.8, 218.7, 121.5]),
    (100e9, False): ([0.00099, -0.00636], [0, -636.1], 3.786, 5208.4, 9.449, 7701.5, [3.449e-6, 3.449e-6], [277.2, 188.3, 95.9]),
    (5e9, True): ([-0.03461, -0.13297], [-173.1, -664.9], 0, 1179.0, 5.369, 11730.9, [9.026e-6, 5.82e-9], [19.4, 18.3, 14.9]),
    (20e9, True): ([-0.00892, -0.03351], [-178.5, -670.2], 0, 1028.8, 4.114, 11881.2, [1.934e-5, 1.377e-7], [17.7, 12.6, 6.8]),
}


def compare(case, what, ours, wanted, relative):
    """What the solver finds beside what is known: by hand."""
    case.check(f"{what}: openings of heel and toe [m]", ours["u"], wanted["u"], absolute=relative * abs(wanted["u"]).max())
    case.check("... stress of heel and toe [Pa]", ours["ends"], wanted["ends"], absolute=relative * abs(wanted["ends"]).max())
    case.check("... open length [m]", ours["open"], wanted["open"], absolute=relative * LENGTH)
    case.check("... uplift [N], N, T, centre of uplift [m]", [ours[k] for k in ("uplift", "N", "T", "centre")],
               [wanted[k] for k in ("uplift", "N", "T", "centre")], relative=relative)
    case.check("... discharge in, to the toe [m2/s]", ours["q"], wanted["q"], relative=3 * relative)
    case.check("... pressures at the quarters [Pa]", ours["p"], wanted["p"], relative=relative)


def rigid(case):
    """Every row of W06, on 28 contacts: against the two equations of the same pieces, and the numbers of the plan."""
    results = []
    for (k_n, drained), (u, ends, opened, uplift, centre, normal, q, p) in PLAN.items():
        result = case.run(dam(28), scene(k_n, drained))
        ours = found(result)
        compare(case, f"k_n {k_n / 1e9:g} GPa/m{', drain' * drained}", ours, by_hand(k_n, drained, 28), 1e-5)
        case.check("... of the plan: openings [mm]", 1e3 * ours["u"], u, absolute=0.01 * np.abs(u).max())
        case.check("... stress of heel and toe [kPa]", ours["ends"] / 1e3, ends, absolute=0.01 * np.abs(ends).max())
        case.check("... open length [m]", ours["open"], opened, absolute=0.05)
        case.check("... uplift [kN] at [m], N [kN]", [ours["uplift"] / 1e3, ours["centre"], ours["N"] / 1e3], [uplift, centre, normal], relative=0.01)
        case.check("... discharge [m2/s], pressures [kPa]", [*ours["q"], *ours["p"] / 1e3], [*q, *p], relative=0.01)
        results.append(result)
    balanced(case, "W06", results)


def contacts(case):
    """7, 14 and 28 contacts, and the reference of 4032 pieces that they come to."""
    fine = by_hand(20e9, False, 4032)
    for n, opened, uplift in ((7, 5.044, 5766.5), (14, 5.061, 5777.3), (28, 5.066, 5780.0)):
        ours = found(case.run(dam(n), scene(20e9)))
        case.check(f"{n} contacts: open length [m], uplift [kN] of the plan", [ours["open"], ours["uplift"] / 1e3], [opened, uplift], relative=2e-4)
        case.check(f"... off 4032 pieces no more than (7 / {n})^2 of 0.5 % and 0.3 %", [ours["open"] / fine["open"] - 1, ours["uplift"] / fine["uplift"] - 1],
                   0.0, absolute=0.005 * (7 / n) ** 2)


def limits(case):
    """The water rises with its head until nothing holds the dam: a wall without weight carries the water above the crest."""
    for k_n, plan in ((20e9, 38.86), (100e9, 40.44)):
        flood = {"type": "flood", "loads": SCENE["stages"][1]["full"]["loads"], "rises": ["water"], "step": 1, "limit": 43, "bracket": 0.05,
                 "max_cycles": 50000}
        result = case.run(dam(28, wall=6.0), scene(k_n, False, ("materials.wall", {"density": 0}), ("relaxation.tolerance", 1e-7),
                                                   ("relaxation.velocity_tolerance", 1e-7), ("stages", [SCENE["stages"][0], {"flood": flood}])))
        trials = {trial["value"]: trial for trial in result.stage_summary("flood")["flood"]["trials"]}
        stands = max(level for level, trial in trials.items() if trial["outcome"] == "stable")
        others = min(level for level, trial in trials.items() if trial["outcome"] != "stable")
        by_two = limit_by_hand(k_n, 28)
        case.check(f"k_n {k_n / 1e9:g} GPa/m: limit level by hand, of the plan [m]", by_two, plan, absolute=0.01)
        case.check("... highest level it stands [m]", stands, by_two, absolute=0.05)
        case.check("... lowest at which it does not [m]", others, by_two, absolute=0.05)
        case.check("... the one below the limit, the other above", [bool(stands <= by_two), bool(others >= by_two)], [True, True])
        for level in (38.0, stands):
            water, wanted = trials[level]["flow"], by_hand(k_n, False, 28, level)
            base = water["joints"]["base"]
            case.check(f"... at {level:g} m: uplift [N], its centre [m], N [N], discharge [m2/s]",
                       [base["uplift"], base["centre_x"], trials[level]["joints"]["base"]["N"], water["conditions"]["down"]["discharge"]],
                       [wanted["uplift"], wanted["centre"], wanted["N"], wanted["q"][1]], relative=1e-3)
        line = pieces(result, "flood")
        last = trials[stands]["flow"]
        held = np.sum(line["length"] * line["pressure"].mean(axis=1))
        case.check("... results of the stage, of its last stable level: uplift [N], head at the heel [m], discharge [m2/s]",
                   [held, line["head"].max(), np.abs(line["discharge"]).max()],
                   [last["joints"]["base"]["uplift"], stands, last["conditions"]["down"]["discharge"]], relative=1e-9)
        balanced(case, "flood", [result])


def friction(case):
    """Strength reduction with computed water: the rigid dam slides where T = N tan(phi), with N after uplift."""
    for drained in (False, True):
        keys = scene(20e9, drained, ("joints.default", {"k_n": 20e9, "k_s": 20e9, "friction": 55}))
        least = {"type": "strength_reduction", "what": "friction", "loads": keys["stages"][1]["full"]["loads"], "limit": 1, "bracket": 0.05}
        result = case.run(dam(28), changed(keys, ("stages", [*keys["stages"], {"least": least | {"step": 5}}])))
        wanted = by_hand(20e9, drained, 28)
        phi = np.degrees(np.arctan(wanted["T"] / wanted["N"]))
        reduced = result.stage_summary("least")["strength_reduction"]
        case.check(f"friction it needs{', drain' * drained}: last that holds, first that fails [degree]", [reduced["stable"], reduced["failing"]], phi, absolute=0.06)
        water = result.stage_summary("least")["flow"]
        case.check("... uplift at the last that holds [N]", water["joints"]["base"]["uplift"], wanted["uplift"], relative=1e-4)


def one_way(case):
    """Without coupling water flows through the base as the weight alone has left it."""
    result = case.run(dam(28), scene(20e9, False, ("flow.coupling", "one_way")))
    load, at = weight()
    bears = 3 * at  # the weight alone opens the toe a little
    ends = -2 * load / bears / 20e9 * np.array([1, 1 - LENGTH / bears])
    x = np.linspace(0, LENGTH, 29)
    head, q = heads(x, *ends, LEVEL, False)
    uplift, summary = GW * (head[1:] + head[:-1]).sum() / 2, result.stage_summary("full")
    case.check("one way: discharge [m2/s]", [-summary["flow"]["conditions"]["up"]["discharge"], summary["flow"]["conditions"]["down"]["discharge"]], q, relative=1e-6)
    case.check("... uplift, N [N]", [summary["flow"]["joints"]["base"]["uplift"], summary["joints"]["base"]["N"]], [uplift, load - uplift], relative=1e-6)
    case.check("... rounds", summary["flow"]["rounds"], 0)
    balanced(case, "one way", [result])


# ---- ways to solve it

ELASTIC = {"density": RHO, "young": 20e9, "poisson": 0.2, "rigid": False}


def numbers(result):
    """Closed length, uplift, its centre, discharge, openings."""
    ours = found(result)
    return np.array([LENGTH - ours["open"], ours["uplift"], ours["centre"], ours["q"][0], *ours["u"]])


def ways(case):
    """Explicit and preconditioned relaxation, condensed bodies, variable connectivity: one equilibrium, one flow."""
    for drained in (False, True):
        name = f"{', drain' * drained}"
        bodies = {"rigid": (dam(28), {"density": RHO}), "elastic": (dam(28, rows=4), ELASTIC), "condensed": (dam(28, rows=4), ELASTIC | {"condensed": True})}
        base, results = {}, []
        for body, (mesh, material) in bodies.items():
            for method in ("explicit", "preconditioned"):
                result = case.run(mesh, scene(20e9, drained, ("materials.dam", material), ("relaxation.method", method)))
                wanted = base.setdefault("elastic" if body == "condensed" else body, numbers(result))
                case.check(f"{body} dam{name}, {method}: rounds", result.stage_summary("full")["flow"]["rounds"] > 1, True)
                if (body, method) not in (("rigid", "explicit"), ("elastic", "explicit")):
                    case.check(f"{body} dam{name}, {method} as explicit: closed length, uplift, its centre, discharge, openings", numbers(result), wanted, relative=2e-6)
                results.append(result)
        for body in ("rigid", "elastic"):
            mesh, material = bodies[body]
            large = scene(20e9, drained, ("materials.dam", material), ("strain", "large"), ("contact", {}))
            fixed, variable = (case.run(mesh, changed(large, ("contact.connectivity", how))) for how in ("fixed", "variable"))
            case.check(f"{body} dam{name}, large strain, variable connectivity as fixed", numbers(variable), numbers(fixed), relative=2e-6)
            case.check("... verifications", variable.stage_summary("full")["verifications"] > 0, True)
            results += [fixed, variable]
        balanced(case, f"ways{name}", results)


def found_anew(case):
    """The joint opens farther than contact.tolerance: contacts are found again beside it, and voids that are wide stay voids.

    Its shear is elastic, so that the way to equilibrium leaves no slip."""
    large = scene(20e9, False, ("materials.dam", ELASTIC), ("strain", "large"), ("contact", {}), ("joints.default.cohesion_residual", 1e9))
    mesh = dam(28, rows=4)
    fixed = case.run(mesh, large)
    opened = found(fixed)["u"][0]
    for tolerance in (2.5e-4, 2e-4):
        keys = {"connectivity": "variable", "tolerance": tolerance, "overlap": 2e-4}
        variable = case.run(mesh, changed(large, ("contact", keys)))
        case.check(f"heel open by {1e3 * opened:.3f} mm, contact.tolerance {1e3 * tolerance:g} mm: contacts found again", variable.stage_summary("full")["contacts_made"] > 0, True)
        case.check("... uplift [N], its centre [m], discharge [m2/s], as with fixed connectivity", numbers(variable)[1:4], numbers(fixed)[1:4], relative=1e-3)


def at_once(case):
    """Rounds leave nothing in the joint: the pressures at which they end, applied at once, open it as far."""
    mesh, level = dam(28, rows=4), 37.3
    coupled = case.run(mesh, scene(20e9, False, ("materials.dam", ELASTIC), ("loads.water.level", level), ("loads.up.level", level)))
    alone = case.run(mesh, scene(20e9, False, ("materials.dam", ELASTIC), ("loads.water.level", level), ("loads.up.level", level), ("flow", {"coupling": "one_way"})))
    effort = [run.stage_summary("full")["cycles"] for run in (coupled, alone)]
    case.check("elastic dam at 37.3 m: cycles two ways over those of one way", effort[0] / effort[1], 0.0, absolute=2.5)
    line = pieces(coupled)
    base = mesh.face_sets["base"][np.argsort(mesh.vertices[mesh.blocks[mesh.face_sets["base"][:, 0], 0], 0])]
    mesh.face_sets |= {f"base_{i}": face[None] for i, face in enumerate(base)}
    means = line["pressure"].mean(axis=1)[np.argsort(line["point"][:, 0::2].min(axis=1))]
    lift = {f"lift_{i}": {"type": "traction", "faces": f"base_{i}", "value": [0, float(p)]} for i, p in enumerate(means)}
    loads = {"weight": SCENE["loads"]["weight"], "water": SCENE["loads"]["water"] | {"level": level}} | lift
    keys = scene(20e9, False, ("materials.dam", ELASTIC), ("joints.base", {}), ("loads", loads),
                 ("stages", [SCENE["stages"][0], {"full": {"loads": list(loads)}}]))
    joints = [run.stage_summary("full")["joints"]["base"] for run in (coupled, case.run(mesh, keys))]
    case.check("... and with the pressures at which water and openings agree: N [N]", joints[0]["N"], joints[1]["N"], relative=1e-4)
    case.check("... open length [m]", joints[0]["open_length"], joints[1]["open_length"], relative=0.01)


def ranks(case):
    """Explicit runs have the same bits, and all that is known of the water too."""
    results = [case.run(dam(28), scene(20e9), ranks=n) for n in case.ranks(1, 2, 3, 4)]
    first = pieces(results[0])
    equal = all(np.array_equal(column, pieces(other)[name]) for name, column in first.items() for other in results[1:])
    case.check("bits of state and water on 1 to 4 ranks", [len({sums(result) for result in results}), equal], [1, True])


def restart(case):
    """From every checkpoint within a coupled stage: before, between and after its rounds."""
    folder = case.prepare(dam(28), changed(scene(20e9), ("checkpoint", {"every": 200, "keep": 100})))
    whole = case.again(folder)
    case.again(folder, "-output", "kept")
    water, files = pieces(whole), sorted((folder / "kept" / "checkpoints").iterdir())
    same = []
    for number, file in enumerate(files):
        again = case.again(folder, "-restart", file, ranks=2 if number == len(files) // 2 else 1)
        same.append(sums(again) == sums(whole) and all(np.array_equal(column, pieces(again)[name]) for name, column in water.items()) and
                    again.stage_summary("full")["flow"]["rounds"] == whole.stage_summary("full")["flow"]["rounds"])
    case.check("restart from each of 15 checkpoints and more: bits of state and water, rounds", [len(files) > 14, all(same)], [True, True])
    case.check("... rounds of the stage", whole.stage_summary("full")["flow"]["rounds"] > 2, True)
