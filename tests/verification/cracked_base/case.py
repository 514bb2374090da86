"""A rigid triangle on a joint without tension, reservoir full: open length, toe stress, rotation (V15); uplift in the crack."""

from functools import partial

import numpy as np
from driver import MODELS, changed
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "cracked base of a rigid triangular dam, without uplift (V15) and with uplift that follows the crack"
SOURCE = "gravity method: ligament 3 x_r, toe stress 2 N / ligament; crack and uplift by iteration of the same"
BY = "by hand, with the gravity method"

H, RHO, WATER, G, K_N = 50.0, 2400.0, 1000.0, 9.81, 10e9
SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-10, "velocity_tolerance": 1e-10, "history_every": 5000},
    "materials": {"dam": {"density": RHO}, "ground": {"density": 0}},
    "joints": {"base": {"k_n": K_N, "k_s": 3e9, "friction": 45}},
    "supports": {"ground": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": H}},
    "stages": [{"weight": {"loads": ["weight"]}}, {"full": {"loads": ["weight", "water"]}}],
}
STIFF = changed(SCENE, ("joints.base.k_n", 1e13), ("joints.base.k_s", 3e12))
UPLIFT = {"type": "uplift", "faces": "base", "level": H, "rule": "linear", "cracked": True, "crack_tolerance": 1e-5}


def triangle(width, n):
    """A fan of n triangles from the apex above the heel, on one wide block."""
    vertices = np.array([[width * i / n, 0.0] for i in range(n + 1)] + [[0.0, H]])
    blocks = np.array([[i, i + 1, n + 1, -1] for i in range(n)])
    sets = {"base": np.array([[i, 0] for i in range(n)]), "upstream": np.array([[0, 2]])}
    dam = BlockMesh(vertices, blocks, np.zeros(n), ["dam"], [1], sets, {"heel": 0, "toe": n})
    ground = renamed(rectangle(-5.0, -10.0, width + 10.0, 10.0, group="ground", rigid=True), {"base": "top"})
    return join([dam, ground])


def gravity_method(width, uplift=False):
    """Open length, toe stress and N; None when the iteration crack -> uplift -> crack runs away."""
    weight, thrust = RHO * G * width * H / 2, WATER * G * H**2 / 2
    crack = 0.0
    for _ in range(10000):
        p = WATER * G * H * uplift
        force = p * crack + p * (width - crack) / 2
        about_toe = p * crack * (width - crack / 2) + p * (width - crack) ** 2 / 3
        normal = weight - force
        arm = (weight * width * 2 / 3 - thrust * H / 3 - about_toe) / normal
        if normal <= 0 or arm <= 0:
            return None
        opened = max(0.0, width - 3 * arm)
        if abs(opened - crack) < 1e-12:
            return opened, 2 * normal / (width - opened), normal
        crack = opened
    return None


def toe_stress(base):
    return -min(base["start"]["sigma"], base["end"]["sigma"])


def run(case):
    for width in (30.0, 32.25):
        crack, toe, normal = gravity_method(width)
        result = case.run(triangle(width, 1), STIFF)
        base = result.stage_summary("full")["joints"]["base"]
        what = f"B = {width:g} m, one tptm contact, k_n = 1e13 Pa/m"
        case.check(f"{what}: open length [m]", base["open_length"], crack, relative=1e-5)
        case.check("... toe stress [Pa]", toe_stress(base), toe, relative=1e-6)
        case.check("... N [N]", base["N"], normal, relative=1e-6)
        dry = result.stage_summary("full")["dry_joints"]["base"]
        case.check("... which has no water: open length [m], force of water in it [N], reported", [dry["length"], dry["force"]], [crack, WATER * G * H * crack], relative=1e-5)
        if width == 30.0:
            base = case.run(triangle(width, 1), SCENE).stage_summary("full")["joints"]["base"]
            case.check("B = 30 m, k_n = 10 GPa/m: N [kN], crack [m], toe [kPa]; the dam leans by 0.2 mm",
                       [base["N"] / 1e3, base["open_length"], toe_stress(base) / 1e3], [17658, 4.722, 1397.1], relative=2e-4)
            gap = base["start"]["opening"] - base["end"]["opening"]
            case.check("... rotation [rad], toe closure and heel gap [mm]",
                       [gap / width, -base["end"]["opening"] * 1e3, base["start"]["opening"] * 1e3],
                       [5.527e-6, 0.1397, 0.0261], relative=2e-3)
            case.check("... friction needed [degree]", base["friction_needed"], 34.78, relative=1e-4)
    cohesion_on_closed_length(case)
    many_contacts(case)
    with_uplift(case)
    up_to_the_limit(case)
    behind_a_closed_heel(case)
    in_an_earthquake(case)


def cohesion_on_closed_length(case):
    """Sliding factors: no cohesion where the joint is open."""
    crack, _, normal = gravity_method(30.0)
    strong = changed(STIFF, ("joints.base.cohesion", 1e6), ("joints.base.cohesion_residual", 4e5))
    base = case.run(triangle(30.0, 1), strong).stage_summary("full")["joints"]["base"]
    thrust = WATER * G * H**2 / 2
    case.check("cohesion 1 MPa, residual 0.4 MPa: closed length [m]", base["closed_length"], 30.0 - crack, relative=1e-5)
    case.check("... sliding factors peak and residual, cohesion on the closed length", [base["sliding_factor_peak"], base["sliding_factor_residual"]],
               [(normal + c * (30.0 - crack)) / thrust for c in (1e6, 4e5)], relative=1e-5)
    trials = {"type": "strength_reduction", "what": "strengths", "loads": ["weight", "water"], "factor": 0.9, "limit": 0.1, "bracket": 0.005}
    kept = changed(strong, ("joints.base.cohesion_residual", 1e6), ("stages", [*SCENE["stages"], {"slide": trials}]))
    result = case.run(triangle(30.0, 1), kept)
    found = result.stage_summary("slide")["strength_reduction"]
    case.check("... trials that reduce all strengths: factor between the last stable and the first failing one",
               0.5 * (found["safety_factor_stable"] + found["safety_factor_failing"]),
               result.stage_summary("full")["joints"]["base"]["sliding_factor_peak"], relative=0.01)


def many_contacts(case):
    crack, toe, normal = gravity_method(30.0)
    jobs = [(triangle(30.0, n), changed(STIFF, ("joints.base.stress_model", model))) for n in (1, 30) for model in MODELS]
    bases = [result.stage_summary("full")["joints"]["base"] for result in case.run_all([jobs[0]] + jobs[6:])]
    eccentricity = 15.0 - (30.0 - crack) / 3
    case.check("one pt contact: toe stress of two forces, 2 N (1/2 + e/B) / B [Pa]", toe_stress(bases[0]),
               2 * normal * (0.5 + eccentricity / 30) / 30, relative=1e-6)
    case.check("30 contacts, six models: open length [m], within one contact", [base["open_length"] for base in bases[1:]], crack,
               absolute=1.0)
    case.check("... tptm: open length [m]", bases[6]["open_length"], crack, relative=1e-5)
    case.check("... tptm: toe stress [Pa]", toe_stress(bases[6]), toe, relative=1e-5)


def with_uplift(case):
    wet = changed(STIFF, ("joints.base.friction", 80), ("loads.uplift", UPLIFT), ("stages", [*SCENE["stages"][:1],
                  {"full": {"loads": ["weight", "water", "uplift"], "ramp": 3000}}]))
    for width in (42.0, 41.0, 40.0):
        crack, toe, normal = gravity_method(width, uplift=True)
        result = case.run(triangle(width, 1), wet)
        stage = result.stage_summary("full")
        what = f"B = {width:g} m, full head in the crack"
        case.check(f"{what}: open length [m]", stage["uplift"]["uplift"]["open_length"], crack, absolute=1e-3)
        case.check("... toe stress [Pa] and N [N]", [toe_stress(stage["joints"]["base"]), stage["joints"]["base"]["N"]],
                   [toe, normal], relative=1e-4)
        case.report("... rounds of the iteration", stage["uplift"]["uplift"]["rounds"], np.nan)
    case.check("B = 37 m: the gravity method runs away", gravity_method(37.0, uplift=True), None)
    case.check("... and the stage ends as collapsed", case.run(triangle(37.0, 1), wet).verdict, "collapsed")


def statics_of_crack(width, level, k_h=0.0):
    """Open length of the triangle with water up to a level and an earthquake k_h, full head in the crack: the iteration of the gravity method,
    crack -> uplift -> crack, from a closed base; None: it has no end, or the resultant leaves the base. It knows no cycles and no stiffness."""
    weight, p, crack = RHO * G * width * H / 2, WATER * G * level, 0.0
    top = min(level, H)  # the face ends there
    turning = WATER * G * (level * top**2 / 2 - top**3 / 3) + k_h * weight * H / 3  # of water and earthquake about the base
    for _ in range(100000):
        normal = weight - p * (width + crack) / 2
        arm = (weight * width * 2 / 3 - turning - p * crack * (width - crack / 2) - p * (width - crack) ** 2 / 3) / normal
        if normal <= 0 or arm <= 0:
            return None
        if abs(max(0.0, width - 3 * arm) - crack) < 1e-10:
            return crack
        crack = max(0.0, width - 3 * arm)
    return None


def largest(carried, low, high):
    """The largest number that is carried, by bisection."""
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if carried(middle) is not None else (low, middle)
    return low


def up_to_the_limit(case):
    """Trials find the limit of statics between their last stable and first failing one, and a stage just below it converges. Before, a crack grew
    with blocks that still moved: the first failing trials were 0.5 to 2.3 % too low in the level and 4 % in k_h."""
    loads, low = ["weight", "water", "uplift"], 0.8 * H
    for width, shaken in ((37.0, False), (33.0, False), (40.0, True)):
        carried = partial(statics_of_crack, width, low) if shaken else partial(statics_of_crack, width)
        limit = largest(carried, 0.0, 1.0 if shaken else 1.2 * H)
        level, below = low if shaken else 0.83 * limit, 0.997 * limit
        step = {"step": 0.09 * limit, "limit": 1.3 * limit, "bracket": 0.002 * limit}
        trials = {"type": "flood", "rises": ["water", "uplift"], "loads": loads, **step}
        just_below = ["weight", "high", "high_uplift"]
        if shaken:
            trials = {"type": "load_factor", "raises": ["quake"], "loads": [*loads, "quake"], "start": 0.83 * limit, **step}
            just_below = [*loads, "shakes"]
        scene = changed(STIFF, ("joints.base", {"k_n": 1e12, "k_s": 3e11, "friction": 85}), ("relaxation", {}), ("loads.uplift", UPLIFT | {"level": level, "in_earthquake": "full"}),
                        ("loads.water.level", level), ("loads.high_uplift", UPLIFT | {"level": below}),
                        ("loads.high", {"type": "reservoir", "faces": "upstream", "level": below}),
                        ("loads.quake", {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["dam"]}),
                        ("loads.shakes", {"type": "pseudo_static", "coefficient": [below, 0], "groups": ["dam"]}),
                        ("stages", [{"weight": {"loads": ["weight"]}}, {"below": {"loads": just_below}}, {"empty": {"loads": ["weight"]}}, {"trials": trials}]))  # fmt: skip
        result = case.run(triangle(width, 6), scene)
        what = f"B = {width:g} m, " + (f"earthquake at a level of {low:g} m" if shaken else "level")
        stage = result.stage_summary("below")
        case.check(f"{what}: 0.997 of the limit of statics converges", stage["verdict"], "converged")
        case.check("... open length [m]", stage["uplift"]["uplift" if shaken else "high_uplift"]["open_length"],
                   carried(below), absolute=0.05)  # fmt: skip
        found = result.stage_summary("trials")["load_factor" if shaken else "flood"]
        case.report("... limit of statics, and of the trials", 0.5 * (found["stable"] + found["failing"]), limit)
        case.check("... which is above the last stable and below the first failing trial, nearer than 0.002 to each other",
                   [found["stable"] <= limit * 1.0005, found["failing"] >= limit * 0.9995, found["failing"] - found["stable"] <= 0.0021 * limit],
                   [True, True, True])  # fmt: skip


def shaken(width, k_h, how):
    """Crack before the earthquake, crack in it and N, of a straight line of uplift with the full head in the crack before: what the earthquake opens keeps its
    pressure (unchanged), has none (zero), or the full head (full: None where that runs away)."""
    weight, thrust, p = RHO * G * width * H / 2, WATER * G * H**2 / 2, WATER * G * H
    before = gravity_method(width, uplift=True)[0]

    def opened(crack):
        full = crack if how == "full" else before
        pieces = [(0.0, full, p, p), (full, width, p, 0.0)]  # from, to, pressure there
        if how == "zero" and crack > before:  # without what acts from `before` to `crack`
            end = p * (width - crack) / (width - before)
            pieces += [(before, crack, -p, -end)]
        force = sum((b - a) * (q + r) / 2 for a, b, q, r in pieces)
        about_toe = sum((b - a) * (q * (width - a - (b - a) / 3) + r * (width - a - 2 * (b - a) / 3)) / 2 for a, b, q, r in pieces)
        normal = weight - force
        arm = (weight * width * 2 / 3 - (thrust + k_h * weight) * H / 3 - about_toe) / normal
        return max(0.0, width - 3 * arm) if normal > 0 and arm > 0 else np.inf, normal

    low, high = before, width
    if how == "full":
        crack = before
        while np.isfinite(crack) and abs(opened(crack)[0] - crack) > 1e-12:
            crack = opened(crack)[0]
        return (before, crack, opened(crack)[1]) if np.isfinite(crack) else None
    for _ in range(100):  # it opens the less the more it has lost
        middle = 0.5 * (low + high)
        low, high = (middle, high) if opened(middle)[0] > middle else (low, middle)
    return before, low, opened(low)[1]


def in_an_earthquake(case):
    """The crack that k_h opens, by rule: after the same loads without it, which have a crack of their own."""
    quake = {"type": "pseudo_static", "coefficient": [0.04, 0], "groups": ["dam"]}
    width = 41.0
    for how, rule in (("unchanged", "linear"), ("zero", "usbr"), ("full", "usace"), ("unchanged", "ferc")):
        keys = UPLIFT | {"rule": rule} | ({"in_earthquake": "full"} if how == "full" else {})
        loads = ["weight", "water", "uplift"]
        wet = changed(STIFF, ("joints.base.friction", 80), ("loads.uplift", keys), ("loads.quake", quake), ("stages", [*SCENE["stages"][:1],
                      {"full": {"loads": loads, "ramp": 3000}}, {"shaken": {"loads": [*loads, "quake"], "ramp": 3000}}, {"after": {"loads": loads, "ramp": 3000}}]))
        result = case.run(triangle(width, 1), wet)
        wanted = shaken(width, 0.04, how)
        what = f"earthquake, rule {rule}, {how} in the crack that it opens"
        if wanted is None:
            case.check(f"{what}: by statics it runs away, and the stage collapses", result.verdict, "collapsed")
            continue
        before, crack, normal = wanted
        stage, base = result.stage_summary("shaken"), result.stage_summary("shaken")["joints"]["base"]
        case.check(f"{what}: open before it, in it [m]", [result.stage_summary("full")["uplift"]["uplift"]["open_length"], base["open_length"]], [before, crack], absolute=2e-3)
        case.check("... N [N]", base["N"], normal, relative=2e-4)
        case.check("... crack that has the full head [m]", stage["uplift"]["uplift"]["open_length"], crack if how == "full" else before, absolute=2e-3)
        case.check("... after it [m]", result.stage_summary("after")["uplift"]["uplift"]["open_length"], before, absolute=2e-3)


FOOT = 0.2  # [m] width of a heavy block at the heel, 0.02 m in front of the dam


def behind_a_foot(width, reaches):
    """Crack of the dam, with the water of a joint that begins at the foot: straight from its heel, or full as far as the crack is open."""
    before, weight, thrust = FOOT + 0.02, RHO * G * width * H / 2, WATER * G * H**2 / 2
    length, crack, head = width + before, 0.0, WATER * G * H
    x = np.linspace(0.0, width, 400001)
    for _ in range(200):
        wet = before + crack if reaches == "any" else 0.0
        p = head * np.minimum(1.0, (length - before - x) / (length - wet))
        normal = weight - np.trapezoid(p, x)
        arm = (weight * width * 2 / 3 - thrust * H / 3 - np.trapezoid(p * (width - x), x)) / normal
        crack = max(0.0, width - 3 * arm)
    return crack, normal


def behind_a_closed_heel(case):
    """What closes the heel keeps the water out, which is reported; reaches: any lets it in."""
    width = 42.0
    foot = rectangle(-FOOT - 0.02, 0.0, FOOT, 5.0, group="foot", rigid=True)
    mesh = join([triangle(width, 1), renamed(foot, {"base": "bottom"})])
    for reaches in ("heel", "any"):
        crack, normal = behind_a_foot(width, reaches)
        wet = changed(STIFF, ("materials.foot", {"density": 50000}), ("joints.base.friction", 80), ("loads.weight", {"type": "self_weight", "groups": ["dam", "foot"]}),
                      ("loads.uplift", UPLIFT | {"reaches": reaches}),
                      ("stages", [*SCENE["stages"][:1], {"full": {"loads": ["weight", "water", "uplift"], "ramp": 3000}}]))  # fmt: skip
        result = case.run(mesh, wet)
        found = result.stage_summary("full")["uplift"]["uplift"]
        tip = FOOT + 0.02 + crack
        case.check(f"crack behind a closed heel, reaches: {reaches}: full head over [m]", found["open_length"], tip if reaches == "any" else 0.0, absolute=2e-3)
        case.check("... stretches that are open without it", len(found["dry"]), int(reaches == "heel"))
        for dry in found["dry"]:
            case.check("... from, to, closed before [m]", [dry["from"], dry["to"], dry["closed_from"]], [FOOT, tip, 0.0], absolute=2e-3)
        case.check("... N of foot and dam [N]", result.stage_summary("full")["joints"]["base"]["N"] - weight_of_foot(tip if reaches == "any" else 0.0, width),
                   normal, relative=2e-4)
        case.check("... a warning says so", "reaches: any lets it in" in result.stderr, reaches == "heel")


def weight_of_foot(wet, width):
    """Of which its own water is taken off."""
    head, length = WATER * G * H, width + FOOT + 0.02
    lost = head * FOOT if wet else head * FOOT * (1 - 0.5 * FOOT / length)
    return 50000 * G * FOOT * 5.0 - lost
