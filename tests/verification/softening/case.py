"""Joints that soften: force over a given displacement of a slider, of a joint that is pulled apart and of a joint that is peeled."""

import numpy as np
from driver import changed, check_restarts, load
from quoin_tools.mesh.meshing import join, rectangle, renamed
from scipy.optimize import brentq

WHAT = "joints that soften: slip, opening, unloading, reloading, work that they take, a joint peeled off, a dam that cracks under uplift, steps, ranks, restarts"
SOURCE = "strength that falls linearly over 2 G / strength; equilibrium of a rigid block on points of this law, solved beside the program"
BY = "by hand"

cracked_base = load("cracked_base")
LONG = ("shorter_steps", "mixed")

G, RHO, LIGHT, K_N, K_S, PHI, COHESION, TENSION = 10.0, 2000.0, 50.0, 1e9, 1e8, 35.0, 8e3, 5e3
WEIGHT, SLOPE = 0.2 * RHO * G, np.tan(np.radians(PHI))  # of a block of 1 m by 0.2 m
SHEAR, OPEN = 1.0, 0.05  # [N/m] fracture energies: three and four times what the springs store
SCENE = {
    "gravity": G, "strain": "small", "contact": {"connectivity": "fixed"}, "relaxation": {"tolerance": 1e-10, "velocity_tolerance": 1e-10},
    "materials": {"block": {"density": RHO}, "base": {"density": 0}},
    "joints": {"default": {"stress_model": "pt", "k_n": K_N, "k_s": K_S, "friction": PHI, "cohesion": COHESION, "tension": TENSION,
                           "fracture_energy": OPEN, "fracture_energy_shear": SHEAR}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}


def run(case):
    slides(case)
    parts(case)
    peels(case)
    dam(case)
    shorter_steps(case)
    mixed(case)
    steep(case)
    one_at_once(case)
    refused(case)


def block(width, height, n=1):
    return join([renamed(rectangle(0, -1, width, 1, n, 1, group="base", rigid=True)),
                 renamed(rectangle(0, 0, width, height, n, 1, group="block", rigid=True), {}, {"top": "top_left", "foot": "bottom_left"})])


def push(path, **keys):
    return ("stages", [{"rest": {"loads": ["weight"]}}, {"push": {"type": "pushover", "loads": ["weight"], "path": [float(u) for u in path], "step": 1.0} | keys}])


def curve(result):
    found = result.stage_summary("push")["pushover"]
    return np.array(found["displacement"]), np.array(found["force"])


def work(result):
    """Work of the push less the energy that the joint has taken up [J]."""
    u, force = curve(result)
    stored = [result.stage_summary(stage)["energy"]["joints"] for stage in ("rest", "push")]
    return np.sum(np.diff(u) * (force[1:] + force[:-1]) / 2) - (stored[1] - stored[0])


def sliding_way():
    """Path and forces of the slider: to the peak, half way down the slope, unloaded, reloaded, down to friction alone and on."""
    slip = 2 * SHEAR / COHESION * np.array([0, 0.25, 0.5, 0.75, 1, 1.5])
    force = WEIGHT * SLOPE + COHESION * np.maximum(0, 1 - slip * COHESION / (2 * SHEAR))
    u = force / K_S + slip
    path = [u[0] / 2, u[0], u[1], u[2], u[2] - 0.4 * force[2] / K_S, u[2], u[3], u[4], u[5]]
    return path, [force[0] / 2, force[0], force[1], force[2], 0.6 * force[2], force[2], force[3], force[4], force[5]], slip[-1]


def slides(case):
    """A block of 1 m by 0.2 m, pushed at its foot."""
    path, expected, slip = sliding_way()
    folder = case.prepare(block(1.0, 0.2), changed(SCENE, push(path, point="foot"), ("checkpoint", {"every": 700, "keep": 1000})))
    result = case.again(folder)
    case.check("a slider: F up to the peak, down the slope, unloaded, reloaded, down to friction [N]", curve(result)[1][1:], expected, relative=1e-7)
    case.check("... work beyond that of friction over G_II", (work(result) - WEIGHT * SLOPE * slip) / SHEAR, 1.0, relative=1e-6)
    contacts = result.stage("push").contacts
    case.check("... part that has failed, slip [m]", [contacts.broken.min(), np.abs(contacts.slip).min()], [0.5, slip], relative=1e-7)
    check_restarts(case, folder, result)


def parts(case):
    """The same block lifted by its group: up the springs, down the slope, back along the line to the origin, pressed, and up again until it is free."""
    e = np.array([0, 0.25, 0.5, 1.0])  # kappa
    u = TENSION * (1 - e) / K_N + 2 * OPEN / TENSION * e
    sunk = WEIGHT / K_N
    path = np.array([0.5 * u[0], u[0], u[1], u[2], 0.3 * u[2], -sunk, 0.3 * u[2], u[2] * (1 - 1e-9), u[3], 1.2 * u[3]])
    half = TENSION / 2
    sigma = np.array([TENSION / 2, TENSION, 0.75 * TENSION, half, 0.3 * half, -WEIGHT, 0.3 * half, half, 0, 0])
    result = case.run(block(1.0, 0.2), changed(SCENE, push(path + sunk, group="block", direction=[0, 1])))
    case.check("a joint pulled apart: F over the weight, on the slope, back to the origin, pressed, and up again", curve(result)[1][1:] / WEIGHT, sigma / WEIGHT + 1, absolute=1e-7)
    taken = work(result) - WEIGHT * (1.2 * u[3] + sunk)
    case.check("... work that it takes over G_I", taken / OPEN, 1.0, relative=1e-6)


def law(u, energy, k_n=K_N, tension=TENSION):
    """Normal stress of a point that opens for the first time."""
    u_0, u_1 = tension / k_n, 2 * energy / tension
    return np.where(u < u_0, k_n * u, np.clip(tension * (u_1 - u) / (u_1 - u_0), 0, None))


def peeled(n, path, energy):
    """Force at the upper left corner of a rigid block of 1 m by 2 m that moves by each of path from where it rests under its weight."""
    x, share = np.linspace(0, 1, n + 1) - 0.5, np.full(n + 1, 1 / n)
    share[[0, -1]] /= 2
    height, weight, turns = 2.0, 2 * LIGHT * G, np.linspace(0, path[-1] / 1.9, 2001)
    lifts, forces, moved = [-weight / K_N], [0.0], [0.0]  # lifts of the centre of the joint
    for turn in turns[1:]:
        near = lifts[-1] + np.array([-1, 1]) * 2 * turns[1]
        lifts.append(brentq(lambda v, turn=turn: share @ law(v - turn * x, energy) + weight, *near, xtol=1e-18, rtol=1e-14))
        opening = lifts[-1] - turn * x
        forces.append(-(share * x) @ law(opening, energy) / height)
        moved.append(forces[-1] / (K_S * share @ (opening < 2 * energy / TENSION)) + turn * height)  # what is free bears no shear
    return np.interp(path, moved, forces)


def peels(case):
    """A block of 1 m by 2 m on a joint of 16 contacts, pushed over: the more energy, the larger the peak; with hardly any that of a brittle joint."""
    n, path, curves = 16, np.linspace(2e-5, 40e-5, 20), []
    for energy in (0.0, 0.0126, 0.05, 1.0):
        keys = {"cohesion": 1e6, "friction": 60, "fracture_energy_shear": 1e5, "fracture_energy": energy}
        result = case.run(block(1.0, 2.0, n), changed(SCENE, ("joints.default", SCENE["joints"]["default"] | keys), ("relaxation.tolerance", 1e-8), ("materials.block.density", LIGHT), push(path, point="top")))
        forces = curve(result)[1][1:]
        if energy > 0.02:
            case.check(f"a joint peeled off, G_I {energy:g} N/m: F over the largest", forces / forces.max(), peeled(n, path, energy) / forces.max(), absolute=2e-6)
        curves.append(forces)
    case.check("... hardly any, 1.008 times what the springs store: F over that of a brittle joint", curves[1] / curves[0], 1.0, absolute=1e-6)
    case.check("... the peaks grow with the energy", bool(curves[3].max() > 1.1 * curves[2].max() > 1.21 * curves[1].max()), True)


def factor_of_dam(width, n, energy, tension):
    """Largest factor of the thrust that a rigid triangle of 50 m bears, with uplift that has its full pressure where the joint is free: over the turn of the dam.

    An end that is free opens the half of its contacts that it owns. Next to the least energy, 4.5 N/m, one turn has several lifts, and this finds one of them."""
    height, rho, water, g, k_n = cracked_base.H, cracked_base.RHO, cracked_base.WATER, cracked_base.G, cracked_base.K_N
    arm, share = width - np.linspace(0, width, n + 1), np.full(n + 1, width / n)  # arm: to the toe
    share[[0, -1]] /= 2
    weight, thrust, full = rho * g * width * height / 2, water * g * height**2 / 2, water * g * height
    lift, most = -weight / width / k_n, 0.0  # lift: of the toe
    for turn in np.linspace(0, 4e-5 if energy < 100 else 2e-4, 2001):
        crack = 0.0
        while True:
            up, about = full * (width + crack) / 2, full * (crack * (width - crack / 2) + (width - crack) ** 2 / 3)
            near = lift + np.array([-1, 1]) * 2e-4
            if np.prod([share @ law(v + turn * arm, energy, k_n, tension) + weight - up for v in near]) > 0:
                return most  # no lift bears the weight
            lift = brentq(lambda v, turn=turn, up=up: share @ law(v + turn * arm, energy, k_n, tension) + weight - up, *near, xtol=1e-16)
            free = np.count_nonzero(lift + turn * arm >= 2 * energy / tension)
            if max(free - 0.5, 0) * width / n <= crack:
                break
            crack = (free - 0.5) * width / n
        most = max(most, (weight * width * 2 / 3 - about + (share * law(lift + turn * arm, energy, k_n, tension)) @ arm) / (thrust * height / 3))
    return most


def dam(case):
    """The dam of case `cracked_base` on a joint with tension: the factor of the thrust between its last stable and its first failing trial grows with the energy."""
    width, n, tension, limits = 45.0, 40, 3e5, []
    for energy in case.some((6.0, 20.0, 100.0, 1000.0)):
        keys = {"stress_model": "pt", "k_n": cracked_base.K_N, "k_s": 3e9, "friction": 60, "tension": tension, "cohesion": 1e8, "fracture_energy": energy, "fracture_energy_shear": 1e8}
        stages = [{"full": {"loads": ["weight", "uplift"]}},
                  {"push": {"type": "load_factor", "loads": ["weight", "water", "uplift"], "raises": ["water"], "step": 0.2, "limit": 5.0, "bracket": 0.002}}]
        result = case.run(cracked_base.triangle(width, n), changed(cracked_base.SCENE, ("joints.base", keys), ("relaxation", {}), ("loads.uplift", cracked_base.UPLIFT), ("stages", stages)))
        found = result.stage_summary("push")["load_factor"]
        limits.append((found["stable"] + found["failing"]) / 2)
        case.check(f"a dam that cracks, with uplift in the crack, G_I {energy:g} N/m: factor of the water", limits[-1], factor_of_dam(width, n, energy, tension), absolute=0.0015)
    if not case.short:
        case.check("... it grows with the energy", sorted(limits), limits)


def shorter_steps(case):
    """The way of the slider in steps of a twentieth: the same forces."""
    path, expected, _ = sliding_way()
    for parts_ in (20,):
        u, force = curve(case.run(block(1.0, 0.2), changed(SCENE, push(path, point="foot", step=float(path[-1] / parts_)))))
        at = [np.abs(u - place).argmin() for place in path]
        case.check(f"a slider in {len(u) - 1} steps: F at the same places [N]", force[at], expected, relative=1e-7)


def mixed(case):
    """Pulled upwards aslant, where tension and cohesion soften together: a step ten times shorter leaves a tenth of the error."""
    path = [4e-5, 6e-5]
    forces = [curve(case.run(block(1.0, 0.2), changed(SCENE, ("joints.default.fracture_energy_shear", 2.0), push(path, group="block", direction=[1, 1], step=step))))[1][-1]
              for step in (2e-6, 2e-7, 2e-8)]
    case.check("steps of 2, 0.2 and 0.02 um in mixed softening: change by the first over that by the second", (forces[1] - forces[0]) / (forces[2] - forces[1]), 10.0, relative=0.05)
    case.check("... F by the first over that by the last", forces[0] / forces[2], 1.0, relative=0.005)


def steep(case):
    """A slider whose friction falls too, to 25 degrees: along a slope under little pressure, at once, and with a warning, beyond the closed form."""
    fall, energy = SLOPE - np.tan(np.radians(25)), 0.345
    most, wanted = (2 * K_S * energy / COHESION - COHESION) / fall, COHESION * (COHESION + WEIGHT * fall) / (2 * K_S)
    for given, falls in ((energy, True), (1.01 * wanted, False), (0.99 * wanted, True)):
        keys = {"friction_residual": 25, "fracture_energy_shear": given}
        result = case.run(block(1.0, 0.2), changed(SCENE, ("joints.default", SCENE["joints"]["default"] | keys), push([1.2e-4, 5e-4], point="foot")))
        case.check(f"friction falls too, G_II {given:.4g} N/m: residual friction [N]", curve(result)[1][-1], WEIGHT * np.tan(np.radians(25)), relative=1e-7)
        case.check("... a warning that strength falls at once", "at once, because friction falls too" in result.stderr, falls)
        if given == energy:
            case.check("... the pressure and the energy of the closed form", f"from {most:.4g} Pa on" in result.stderr and f"above {wanted:.4g} N/m" in result.stderr, True)


def one_at_once(case):
    """A slider beside a spring, whose cohesion is lost at once: Newton's method says that its contacts fail together, also where tension softens."""
    mesh = join([renamed(rectangle(0, -1, 1, 1, group="base", rigid=True)), renamed(rectangle(0, 0, 1, 0.2, 4, 1, group="block", rigid=True), {"side": "left", "stop": "right"}),
                 rectangle(1, 0, 1, 0.2, group="base", rigid=True)])
    scene = changed(SCENE, ("joints.stop", {"law": "elastic", "k_n": 1e8, "k_s": 0}), ("relaxation", {"method": "preconditioned"}),
                    ("loads.push", {"type": "traction", "faces": "side", "value": [3e5, 0]}), ("stages", [{"rest": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"]}}]))
    warned = ["4 contacts fail within" in case.run(mesh, changed(scene, ("joints.default.fracture_energy", opening), ("joints.default.fracture_energy_shear", slip))).stderr
              for opening, slip in ((0, 0), (OPEN, 0), (OPEN, SHEAR))]
    case.check("a slider beside a spring that fails at once, also where tension softens, and that softens: a warning", warned, [True, True, False])


def refused(case):
    """An energy that the springs store at the strength, a stress model whose ends are not points, a strength that is not there."""
    for keys, words in (({"fracture_energy": 0.0125}, "fracture_energy 0.0125 N/m is not above (tension - tension_residual)^2 / (2 k_n) = 0.0125 N/m"),
                        ({"stress_model": "tptm"}, "fracture_energy needs stress_model: pt"), ({"tension": 0}, "fracture_energy needs tension above tension_residual")):
        done = case.run(block(1.0, 0.2), changed(SCENE, ("joints.default", SCENE["joints"]["default"] | keys), push([1e-5], point="foot")))
        case.check(f"refused: {words}", (done.exit_code, words in done.stderr), (2, True))
