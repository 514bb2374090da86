"""Flood on section G1 (the paper's S4): the reservoir rises by 1 m a step, with the uplift from heel to drain.

Rigid dam and rock: the linear diagram without tension, crack and toe stress by hand. Elastic: finite elements with a joint
without tension that is elastic in shear where it is closed (friction 80 degrees stands for that here), and friction 45."""

import math

import numpy as np
from driver import REFERENCE, changed, load
from quoin_tools.mesh.dam import G1
from reference_mesh import from_reference

WHAT = "flood on G1 (S4): crack length and toe compression against the level, limit level"
SOURCE = "hand values and finite elements of the plan (part C); gravity method without tension"
BY = "by hand; independent finite elements of this project; Bretas, Lemos and Lourenco 2014 (paper)"

SLIDING = load("sliding")
RHO_G, SLOPE, LENGTH = 9810.0, SLIDING.SLOPE, np.hypot(*G1.toe)
STAGES = SLIDING.SCENE["stages"][:2]
UPLIFT = SLIDING.UPLIFT | {"raise": "to_drain"}


def flood(friction, **keys):
    stage = {"type": "flood", "loads": SLIDING.ALL, "step": 1, "joints": {"base": {"law": "mohr_coulomb", "friction": friction}}}
    return changed(SLIDING.SCENE, ("loads.uplift", UPLIFT), ("stages", STAGES + [{"s4": stage | keys}]),
                   ("relaxation.tolerance", 1e-6))


def table(result):
    return {round(trial["value"] - 33, 6): trial for trial in result.stage_summary("s4")["flood"]["trials"]}


def by_hand(rise, in_crack=False):
    """Crack [m] along the base, toe stress [Pa], N, T: plane of the base, no tension, shear where it belongs.

    in_crack: the full head acts in the crack, the drain is lost when the crack has passed it; iterated to rest."""
    crack = 0.0
    for _ in range(1000):
        found = section(rise, crack if in_crack else 0.0)
        if abs(found[0] - crack) < 1e-10 or not in_crack:
            break
        crack = found[0]
    return found


def section(rise, crack):
    """The same with the full head as far as `crack` along the base."""
    x, y = G1.corners().T
    x2, y2 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y2 - x2 * y
    weight, centroid = 2400 * 9.81 * cross.sum() / 2, ((x + x2) * cross).sum() / (3 * cross.sum())
    depth = np.array([rise, 33 + rise])  # at the crest, at the heel
    thrust = RHO_G * (depth[1] ** 2 - depth[0] ** 2) / 2
    height = 33 - (depth[1] ** 3 - depth[0] ** 3) / 3 / ((depth[1] ** 2 - depth[0] ** 2) / 2) + rise  # of the resultant
    down, at = thrust * 1.65 / 33, height * 1.65 / 33
    heel, drain = RHO_G * (33 + rise), RHO_G * 11
    at_crack = crack * math.cos(SLOPE)
    corners = [(0.0, heel), (at_crack, heel), (4.70, drain), (22.80, 0.0)]
    if at_crack >= 4.70:
        del corners[2]
    parts = [((p + q) / 2 * (b - a), a + (b - a) / 3 * (p + 2 * q) / (p + q)) for (a, p), (b, q) in zip(corners, corners[1:])]
    lift = sum(force for force, _ in parts)
    vertical = weight + down - lift
    moment = weight * (22.8 - centroid) + down * (22.8 - at) - thrust * (height - 2.28) - sum(f * (22.8 - x) for f, x in parts)
    normal = vertical * math.cos(SLOPE) + thrust * math.sin(SLOPE)
    shear = thrust * math.cos(SLOPE) - vertical * math.sin(SLOPE)
    arm = moment / normal
    ligament = min(LENGTH, 3 * arm)
    toe = 2 * normal / ligament if ligament < LENGTH else normal / LENGTH * (1 + 6 * (LENGTH / 2 - arm) / LENGTH)
    return LENGTH - ligament, toe, normal, shear


def run(case):
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    rigid = changed(flood(80, limit=39), ("materials", {name: {"density": 2400, "rigid": True} for name in ("dam", "rock")}),
                    ("supports", {"rock": {"fix": "xy"}}), ("relaxation.groups", ["dam"]), ("relaxation.tolerance", 1e-8))
    stiff, elastic, slips = case.run_all([(mesh, rigid), (mesh, flood(80, limit=41)), (mesh, flood(45, limit=50, bracket=0.25))])
    case.check("exit code, although the last trial collapses", slips.exit_code, 0)
    hand_values(case, table(stiff))
    finite_elements(case, table(elastic), table(slips))
    full_head(case, mesh, rigid)
    limit(case, slips)


def hand_values(case, trials):
    for rise, crack, toe in ((0, 0.0, 700e3), (2, 2.26, 825e3), (5, 7.41, 1109e3), (6, 9.10, 1248e3)):
        base, wanted = trials[rise]["joints"]["base"], by_hand(rise)
        case.check(f"rigid, +{rise} m: open length [m]", base["open_length"], wanted[0], absolute=2e-3)
        case.check("... toe stress [Pa]", -base["end"]["sigma"], wanted[1], relative=1e-4)
        case.check("... N and T [N]", [base["N"], base["T"]], wanted[2:], relative=1e-5)
        case.check("... crack and toe stress of the plan", [base["open_length"], -base["end"]["sigma"] / 1e5], [crack, toe / 1e5],
                   absolute=0.02)


def finite_elements(case, trials, slips):
    for rise, crack, toe in ((2, 3.8, 1.30), (4, 6.8, 1.55), (5, 7.9, 1.70), (6, 9.5, 1.89), (8, 12.7, 2.40)):
        base, sliding = (rows[rise]["joints"]["base"] for rows in (trials, slips))
        case.check(f"elastic, +{rise} m: open length [m]", base["open_length"], crack, absolute=0.4)
        case.check("... toe stress [MPa]", -base["sigma_min"]["sigma"] / 1e6, toe, relative=0.03)
        case.report("... open length with friction 45 degrees [m]", sliding["open_length"], crack)
        case.report("... toe stress with friction 45 degrees [MPa]", -sliding["sigma_min"]["sigma"] / 1e6, toe)


def full_head(case, mesh, rigid):
    """The full head follows the crack: at +1 m it comes to rest, at +2 m it runs to 19 m and the dam slides on what is left."""
    cracked = changed(rigid, ("loads.uplift", UPLIFT | {"cracked": True, "crack_tolerance": 1e-3}))
    slides = changed(cracked, ("stages", flood(45, limit=36)["stages"]))
    rough, smooth = case.run_all([(mesh, changed(cracked, ("stages", flood(80, limit=35)["stages"]))), (mesh, slides)])
    for rise in (1, 2):
        trial, wanted = table(rough)[rise], by_hand(rise, in_crack=True)
        base = trial["joints"]["base"]
        case.check(f"full head in the crack, +{rise} m, friction 80 degrees: open length [m]", base["open_length"], wanted[0], absolute=0.02)
        case.check("... toe stress [Pa]", -base["end"]["sigma"], wanted[1], relative=5e-3)
    case.check("... crack of the plan at +1 m and +2 m [m]", [table(rough)[rise]["joints"]["base"]["open_length"] for rise in (1, 2)],
               [1.15, 19.0], absolute=0.5)
    factor = by_hand(2, in_crack=True)
    case.check("... sliding factor N tan(45) / T at +2 m by hand, as in the plan", factor[2] / factor[3], 0.59, absolute=0.01)
    found = smooth.stage_summary("s4")["flood"]
    case.check("friction 45 degrees: stands up to +1 m, fails at +2 m", [found["stable"] - 33, found["failing"] - 33], [1, 2], absolute=1e-9)


def limit(case, result):
    found = result.stage_summary("s4")["flood"]
    low, high = 0.0, 20.0
    while high - low > 1e-9:  # T = N tan(45)
        middle = (low + high) / 2
        normal, shear = by_hand(middle)[2:]
        low, high = (middle, high) if shear < normal else (low, middle)
    case.check("friction 45 degrees: highest stable level above the crest [m], sliding by hand", found["stable"] - 33, low,
               absolute=0.3)
    case.check("... lowest failing one [m]", found["failing"] - 33, low, absolute=0.3)
    case.report("... stable in the paper [m]", found["stable"] - 33, 5.0)
