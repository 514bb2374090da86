"""Energy in time (V25): an elastic block in free motion, a block that slides, and a rocking block by all six stress models."""

import re

import numpy as np
from driver import MODELS, changed
from quoin_tools.base.results import energy_account
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "energy of a free elastic block, of a sliding one, and of rocking ones by the six stress models (V25)"
SOURCE = ("E = 1/2 v-.M v+ + strain + joints is constant without damping; work in = stored + lost in friction; "
          "Housner: an impact without rebound leaves (1 - 3/2 sin^2 alpha)^2 of the energy")
BY = "by hand; closed form of Housner"

G, RHO = 9.81, 2400.0
SCENE = {
    "relaxation": {"allow_floating": True, "tolerance": 1e-9, "velocity_tolerance": 1e-9},
    "materials": {"block": {"density": RHO, "young": 1e9, "poisson": 0.2}, "base": {"density": RHO, "rigid": True}},
    "joints": {"default": {"k_n": 1e9, "k_s": 1e9, "friction": 60}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"none": {"type": "point_force", "point": "mark", "value": [0, 0]},
              "weight": {"type": "self_weight", "groups": ["block"]},
              "pull": {"type": "traction", "faces": "top", "value": [2e5, 5e5]},
              "press": {"type": "traction", "faces": "top", "value": [0, -5e5]}},
}
LEVEL = ("kinetic_J", "strain_J", "joints_J")


def base(width=3.0):
    return renamed(rectangle(-0.5 * width, -1, width, 1, group="base", rigid=True), {})


def history(result, stage):
    mine = (result.history["stage"] == stage) & np.isfinite(result.history["balance_J"])
    return {name: column[mine] for name, column in result.history.items() if name != "stage"}


LONG = ("heap",)  # parts that the short form leaves out


def run(case):
    free_block(case)
    on_a_joint(case)
    sliding(case)
    rocking(case)
    leaning(case)
    over_a_corner(case)
    there_and_back(case)
    heap(case)


def free_block(case):
    """Pulled at the top while an elastic joint holds it; then the joint lets go, and it flies off, spins and shakes."""
    mesh = join([base(), renamed(rectangle(-0.5, 0, 1, 1, 4, 4, group="block"), {"top": "top"}, {"mark": "top_right"})])
    stages = [{"pull": {"loads": ["pull"]}},
              {"fly": {"type": "dynamic", "loads": ["none"], "duration": 0.1, "dt_factor": 0.5,
                       "joints": {"default": {"law": "mohr_coulomb", "friction": 60}}}}]
    for strain in ("small", "large"):
        scene = changed(SCENE, ("stages", stages), ("strain", strain), ("joints.default.law", "elastic"),
                        ("materials.block.spin", 5.0), ("materials.block.velocity", [0.0, 2.0]), ("relaxation.history_every", 20))
        h = history(case.run(mesh, scene), "fly")
        total = sum(h[name] for name in LEVEL)
        shakes = np.ptp(h["strain_J"]) / h["strain_J"].max()
        case.check(f"free elastic block, {strain} strain: the strain energy comes and goes, part of it", bool(shakes > 0.3), True)
        if strain == "small":  # a linear system; history.csv has ten digits, the balance is of all
            case.check("... change of the energy", h["balance_J"] / total[0], 0.0, absolute=1e-10)
            free = total[h["time_s"] > 0.05]  # the joint has let go
            case.check("... once it is free, as printed in history.csv", free / free[0] - 1, 0.0, absolute=1e-9)
    free_block_large(case, mesh, scene)


def free_block_large(case, mesh, scene):
    """In large strain the potential is not quadratic: what the scheme keeps exactly is an energy that differs from this one by
    terms of dt^2, so the error stays and is of second order (at a twentieth of the bound 1e-7)."""
    fly = scene["stages"][1]["fly"]
    steps, errors = [0.5, 0.25, 0.05], []
    jobs = [(mesh, changed(scene, ("relaxation.history_every", 10), ("stages", [scene["stages"][0], {"fly": fly | {"dt_factor": part}}])))
            for part in steps]
    for result in case.run_all(jobs):
        h = history(result, "fly")
        errors.append(np.abs(h["balance_J"]).max() / sum(h[name][0] for name in LEVEL))
    case.check("... change of the energy at 0.5 of the stability bound", errors[0], 0.0, absolute=2e-5)
    case.check("... at 0.05, the default", errors[2], 0.0, absolute=2e-7)
    case.check("... order in the time step", np.log(errors[0] / errors[2]) / np.log(steps[0] / steps[2]), 2.0, absolute=0.15)


def on_a_joint(case):
    """Pulled at the top, let go: swings on an elastic joint, a linear system."""
    mesh = join([base(), renamed(rectangle(-0.5, 0, 1, 1, 4, 4, group="block"), {"top": "top"}, {"mark": "top_right"})])
    stages = [{"pull": {"loads": ["pull"]}},
              {"swing": {"type": "dynamic", "loads": ["none"], "duration": 0.2, "dt_factor": 0.5}}]
    scene = changed(SCENE, ("stages", stages), ("strain", "small"), ("joints.default.law", "elastic"))
    for alpha in (0.0, 5.0):
        stages[1]["swing"]["alpha"] = alpha
        h = history(case.run(mesh, changed(scene, ("stages", stages))), "swing")
        total = sum(h[name] for name in LEVEL)
        case.check(f"elastic block swings on an elastic joint, alpha = {alpha:g}: balance", h["balance_J"] / total[0], 0.0,
                   absolute=1e-10)
        case.check("... stored and lost in damping, as printed", (total + h["damping_J"]) / total[0] - 1, 0.0, absolute=1e-9)
        case.check("... kinetic at times", bool((h["kinetic_J"] / total).max() > 0.5), True)


def sliding(case):
    """An elastic block slides to rest by friction, in large strain."""
    v, mu = 2.0, 0.5
    block = rectangle(-0.5, 0, 1, 0.25, 4, 1, group="block")
    mesh = join([base(4.0), renamed(block, {"top": "top"}, {"corner": "bottom_left", "mark": "top_right"})])
    stages = [{"rest": {"loads": ["weight"]}}, {"slide": {"type": "dynamic", "loads": ["weight"], "duration": 0.6}}]
    row = {"k_n": 1e9, "k_s": 1e9, "friction": float(np.degrees(np.arctan(mu))), "damping": 1e-4}
    scene = changed(SCENE, ("stages", stages), ("joints.default", row), ("materials.block.velocity", [v, 0.0]),
                    ("contact", {"connectivity": "variable", "tolerance": 0.005}))
    result = case.run(mesh, scene)
    h, kinetic = history(result, "slide"), 0.5 * RHO * 0.25 * v**2
    moved = result.probe("slide", "corner") - result.probe("rest", "corner")
    case.check("elastic block slides to rest: v^2 / 2 mu g [m]", moved[0], v**2 / (2 * mu * G), relative=0.005)
    case.check("... lost in friction: m v^2 / 2 [J]", h["friction_J"][-1], kinetic, relative=0.01)
    case.check("... balance over m v^2 / 2", h["balance_J"] / kinetic, 0.0, absolute=0.01)


def rocking(case):
    """A slender block set rocking from rest on one contact without shear: pt and tptm keep its energy."""
    width, height, spin = 0.5, 2.0, -0.5
    mesh = join([base(4.0), renamed(rectangle(0, 0, width, height, group="block", rigid=True), {"top": "top"}, {"mark": "top_left"})])
    material = {"density": RHO, "rigid": True, "spin": spin, "velocity": [0.0, -spin * width / 2]}
    stages = [{"rest": {"loads": ["weight"]}}, {"rock": {"type": "dynamic", "loads": ["weight"], "duration": 4.0, "dt_factor": 0.02}}]
    jobs = [(mesh, changed(SCENE, ("stages", stages), ("materials.block", material),
                           ("contact", {"connectivity": "variable", "tolerance": 0.005}),
                           ("joints.default", {"k_n": 1e8, "k_s": 0, "friction": 60, "stress_model": model}))) for model in MODELS]
    for model, result in zip(MODELS, case.run_all(jobs)):
        h = history(result, "rock")
        total = sum(h[name] for name in LEVEL) - h["outside_J"]
        drift = (total - total[0]) / h["kinetic_J"][0]
        what = f"rocking block for 4 s, {model}: change of the energy over that given to it"
        if model in ("pt", "tptm"):
            case.check(what, drift, 0.0, absolute=0.01)
        else:
            case.report(what, drift[np.argmax(np.abs(drift))], 0.0)
        case.check(f"... {model}: a warning", "create or destroy energy" in result.stdout, model not in ("pt", "tptm"))
        case.check("... that says where it pivots", "pivot inside the base" in result.stdout, model not in ("pt", "tptm"))
        case.check(f"... {model}: reported at the end", "energy account is out by" in result.stdout, model not in ("pt", "tptm"))
    behind_prestress(case, *jobs[MODELS.index("t2pt")])


def behind_prestress(case, mesh, scene):
    """A tendon between two held blocks stores T^2/2k = 5 MJ, or a million times as much, and keeps it: energy that the rocking block
    makes is reported as without it, by the program and by who reads its results."""
    far = [renamed(rectangle(x, -1, 1, 1, group="base", rigid=True), {}) for x in (-9, -5)]

    def account(mesh, scene):
        result = case.run(mesh, scene)
        told = float(re.search(r"of (?:the )?([-+.e\d]+) J moved", result.stage_summary("rock")["evidence"])[1])
        return told, *energy_account(result.stage_summary("rock")), "energy account is out by" in result.stdout

    told, *alone, out = account(mesh, scene)
    case.check("... moved, as the summary and the evidence have it [J]", told, alone[2], relative=1e-2)
    for prestress in (1e6, 1e9):
        tied = {"anchors": {"a": {"head": [-8.5, -0.5], "root": [-4.5, -0.5], "area": 2e-6, "young": 2e11, "prestress": prestress, "lock": "rest"}}}
        told, *beside, also = account(join([mesh, *far]), scene | tied)
        case.check(f"... beside a tendon that keeps {prestress**2 / 2e5:g} J: made and moved [J]", beside[::2], alone[::2], relative=1e-3)
        case.check("... it is reported too", also, out)


WIDTH, HEIGHT, LEAN = 0.5, 2.0, 1 / 3  # of a block let go from a lean of a third of its slenderness


def leaning_mesh():
    lean = LEAN * np.arctan(WIDTH / HEIGHT)
    c, s = np.cos(lean), np.sin(lean)
    block = rectangle(0, 0, WIDTH, HEIGHT, group="block", rigid=True)
    block.vertices = (block.vertices - [WIDTH, 0]) @ np.array([[c, -s], [s, c]]) + [WIDTH, 0]
    return join([base(4.0), renamed(block, {"top": "top"}, {"mark": "top_left"})])


def leaning(case):
    """Impacts on corners, contacts made and lost: what friction takes it never gives back, and finding contacts again makes
    nothing. Without friction and dashpots nothing is lost; with dashpots that let no corner rebound, what Housner says."""
    alpha = np.arctan(WIDTH / HEIGHT)
    given = RHO * WIDTH * HEIGHT * G * np.hypot(WIDTH, HEIGHT) / 2 * (np.cos((1 - LEAN) * alpha) - np.cos(alpha))
    rows = [(model, k_s, 0.0) for model in ("pt", "tptm") for k_s in (0.0, 1e8)] + [("pt", 1e9, 4e-3)]
    scene = changed(SCENE, ("materials.block.rigid", True), ("contact", {"connectivity": "variable", "tolerance": 0.005}),
                    ("relaxation.history_every", 20),
                    ("stages", [{"rock": {"type": "dynamic", "loads": ["weight"], "duration": 2.0, "dt_factor": 0.05}}]))
    jobs = [(leaning_mesh(), changed(scene, ("joints.default", {"k_n": k_s or 1e8, "k_s": k_s, "friction": 75, "stress_model": model,
                                                                "damping": damping}))) for model, k_s, damping in rows]
    for (model, k_s, damping), result in zip(rows, case.run_all(jobs)):
        h = history(result, "rock")
        total = (sum(h[name] for name in LEVEL) - h["outside_J"]) / given
        lost = h["friction_J"] / given
        what = f"let go from a lean, {model}, k_s = {k_s:g} Pa/m"
        case.check(f"{what}: balance of the account, over the energy of the lean", h["balance_J"] / given, 0.0, absolute=1e-5)
        case.check("... made by finding contacts again", h["detection_J"] / given, 0.0, absolute=2e-3)
        case.check("... given back by friction", (np.maximum.accumulate(lost) - lost).max(), 0.0, absolute=1e-4)
        if damping:
            at = [np.searchsorted(h["time_s"], t) for t in (0.25, 0.6, 1.2)]  # before the first impact, after it, after the second
            left = 1 + total[at] - total[0]
            case.check("... no rebound: left by the first and second impact, over what was there", left[1:] / left[:-1],
                       (1 - 1.5 * np.sin(alpha)**2)**2, relative=0.015)
        elif k_s == 0.0:
            case.check("... change of the energy", total - total[0], 0.0, absolute=0.002)
        else:
            case.report("... lost in friction, all impacts of 2 s", lost[-1], 0.0)


def over_a_corner(case):
    """A block is pressed 11 mm into another by its lower corner, 50 mm from the edge, and slides off over it, without friction: the
    corner that carries it is nearer to the side of the other, in the end, than to its top, and must not be thrown out by it."""
    t = np.linspace(0, 2, 201)
    speed = 0.5 * np.pi * np.abs(np.sin(np.pi * t))
    motion = np.column_stack([t, np.where(t > 1, 0.08 * speed, 0), np.where(t < 1, -0.012 * speed, 0)])
    scene = changed(SCENE, ("contact", {"connectivity": "variable", "tolerance": 0.005}), ("relaxation.history_every", 20),
                    ("joints.default", {"k_n": 1e9, "k_s": 1e9, "friction": 0}), ("materials.ram", {"density": RHO}),
                    ("supports.ram", {"fix": "xy", "motion": "motion.csv"}),
                    ("stages", [{"pass": {"type": "dynamic", "loads": ["none"], "duration": 2.0, "dt_factor": 0.5}}]))
    for tilt in (0, 10, 19, 30):
        c, s = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
        ram = rectangle(0, 0, 1, 0.5, group="ram", rigid=True)
        ram.vertices = ram.vertices @ np.array([[c, s], [-s, c]]) + [-0.05, 0.001]
        mesh = join([renamed(rectangle(-1, -0.5, 1, 0.5, group="base", rigid=True), {}), renamed(ram, {}),
                     renamed(rectangle(-4, 0, 1, 1, group="block", rigid=True), {"top": "top"}, {"mark": "top_right"})])
        folder = case.prepare(mesh, scene)
        np.savetxt(folder / "motion.csv", motion, delimiter=",")
        h = history(case.again(folder), "pass")
        made = np.max(h["detection_J"] - np.minimum.accumulate(h["detection_J"]))
        what = f"pressed in and pushed off over a corner, leaning by {tilt} degrees"
        case.check(f"{what}: balance of the account, over what the joint stored", h["balance_J"] / h["joints_J"].max(), 0.0, absolute=1e-6)
        case.check("... made by finding contacts again, over that", made / h["joints_J"].max(), 0.0, absolute=1e-9)
        case.check("... left in the joint at the end, over that", h["joints_J"][-1] / h["joints_J"].max(), 0.0, absolute=1e-9)


def there_and_back(case):
    """A square block rocks to 30 degrees and back, to either side: each time its face contact becomes a vertex at 20 degrees and the
    vertex a face contact again. The spin takes the weight from upright to 30 degrees about the corner."""
    side, top = 1.0, np.radians(30)
    R, mass = side / np.sqrt(2), RHO * side**2
    given = mass * G * R * (np.cos(np.pi / 4 - top) - np.cos(np.pi / 4))
    spin = np.sqrt(2 * given / (4 / 3 * mass * R**2))
    mesh = join([base(9.0), renamed(rectangle(0, 0, side, side, group="block", rigid=True), {"top": "top"}, {"mark": "bottom_right"})])
    scene = changed(SCENE, ("contact", {"connectivity": "variable", "tolerance": 0.005}), ("relaxation.history_every", 20),
                    ("materials.block", {"density": RHO, "rigid": True, "spin": -spin, "velocity": [spin * side / 2] * 2}),
                    ("stages", [{"rock": {"type": "dynamic", "loads": ["weight"], "duration": 2.0, "frames": 60}}]))
    rows = [("pt", 1e9), ("tptm", 1e9)]
    jobs = [(mesh, changed(scene, ("joints.default", {"k_n": k, "k_s": k, "friction": 60, "stress_model": model}))) for model, k in rows]
    for (model, k), result in zip(rows, case.run_all(jobs)):
        h = history(result, "rock")
        lean = np.degrees([np.nanmin(result.stage(name).rotation) for name in result.frames("rock")])
        what = f"rocks to 30 degrees and back, {model}, k_n = {k:g} Pa/m"
        case.check(f"{what}: goes through 20 degrees and back", bool(lean.min() < -25 and lean[np.argmin(lean):].max() > -15), True)
        case.check("... balance of the account, over the energy given", h["balance_J"] / given, 0.0, absolute=1e-5)
        case.check("... made by finding contacts again, over that", h["detection_J"] / given, 0.0, absolute=1e-3)


def heap(case):
    """Eight blocks fall onto a wall in a shaken tray and tumble off it: hundreds of contacts come, go and change kind."""
    bodies = [rectangle(-1, -1, 4, 1, group="base", rigid=True), *(rectangle(x, -1, 0.5, 8, group="base", rigid=True) for x in (-1.5, 3))]
    bodies += [rectangle(0, 0, 2, 1, 4, 2, group="wall")]
    bodies += [rectangle(0.1 * i, 1.05 + 0.55 * i, 1, 0.5, group="block", rigid=True) for i in range(8)]
    t = np.linspace(0, 3.66, 184)
    scene = changed(SCENE, ("contact", {"connectivity": "variable", "tolerance": 0.005}), ("relaxation.history_every", 1000),
                    ("materials.wall", SCENE["materials"]["block"]), ("materials.block", {"density": RHO}),
                    ("joints.default", {"k_n": 1e9, "k_s": 1e9, "friction": 20, "damping": 5e-4}),
                    ("supports.base", {"fix": "xy", "motion": "motion.csv"}),
                    ("loads", {"weight": {"type": "self_weight", "groups": ["block", "wall"]}}),
                    ("stages", [{"fall": {"type": "dynamic", "loads": ["weight"], "duration": 3.6}}]))
    folder = case.prepare(join([renamed(body, {}) for body in bodies]), scene)
    np.savetxt(folder / "motion.csv", np.column_stack([t, 0.5 * np.sin(3 * np.pi * t), 0 * t]), delimiter=",")
    results = [case.again(folder, ranks=n) for n in (1, 2)]
    h = history(results[0], "fall")
    moved = np.abs(h["outside_J"]).max() + np.abs(h["supports_J"]).max()
    case.check("heap of eight blocks in a shaken tray: balance of the account, over what was moved", h["balance_J"] / moved, 0.0, absolute=1e-6)
    case.check("... made by finding contacts again, over that", h["detection_J"] / moved, 0.0, absolute=2e-3)
    case.check("... checksum on two ranks", results[1].stage_summary("fall")["checksum"], results[0].stage_summary("fall")["checksum"])
