"""Scenes whose runs are interrupted: each keeps something else in memory. name -> (mesh, scene)."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.mesh.dam import G1, dam_mesh  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402
from quoin_tools.mesh.stacks import block_grid, one_contact  # noqa: E402

MATERIALS = {"dam": {"density": 2400, "young": 10e9, "poisson": 0.2}, "rock": {"density": 2500, "young": 10e9, "poisson": 0.2}}
BASE = {"stress_model": "tptm", "k_n": 10e9, "k_s": 3e9}
DAM = {  # explicit cycles: the same bits on 1 and 2 ranks
    "model": "model.h5", "output": "out", "relaxation": {"method": "explicit", "tolerance": 1e-6, "groups": ["dam"]}, "materials": MATERIALS,
    "joints": {"base": {"law": "elastic", **BASE}},
    "supports": {"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "y"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]},
              "water": {"type": "reservoir", "faces": "upstream", "level": 33.0}},
}
UPLIFT = {"type": "uplift", "faces": "base", "level": 33.0, "rule": "linear", "component": "vertical"}
FRICTION = {"joints": {"base": {"law": "mohr_coulomb", "friction": 45}}}


def static(columns=8):
    """Elastic, then frictional stages."""
    return dam_mesh(G1, columns), DAM | {"stages": [{"sw": {"loads": ["weight"]}}, {"hp": {"loads": ["weight", "water"]} | FRICTION}]}


def cracked(columns=12):
    """Uplift that follows the open part of the base."""
    loads = DAM["loads"] | {"uplift": UPLIFT | {"cracked": True}}
    loads["water"] = loads["water"] | {"level": 34.0}
    stages = [{"sw": {"loads": ["weight"]}}, {"hpu": {"loads": ["weight", "water", "uplift"]} | FRICTION}]
    return dam_mesh(G1, columns), DAM | {"loads": loads, "stages": stages}


def reduction(columns=8):
    """Trials and bisection of a strength reduction."""
    loads = DAM["loads"] | {"uplift": UPLIFT}
    stages = [{"hp": {"loads": ["weight", "water", "uplift"]} | FRICTION},
              {"s1": {"type": "strength_reduction", "loads": ["weight", "water", "uplift"], "step": 4, "limit": 10, "bracket": 1}}]
    return dam_mesh(G1, columns), DAM | {"loads": loads, "stages": stages}


def flood(columns=8):
    """Trials of a flood."""
    stages = [{"hp": {"loads": ["weight", "water"]} | FRICTION},
              {"s4": {"type": "flood", "loads": ["weight", "water"], "step": 2, "limit": 39}}]
    return dam_mesh(G1, columns), DAM | {"stages": stages}


def condensed(columns=8):
    """The dam's blocks condensed onto its base; trials."""
    mesh, scene = reduction(columns)
    return mesh, scene | {"materials": MATERIALS | {"dam": MATERIALS["dam"] | {"condensed": True}}}


def newton(columns=12):
    """Newton's method: many increments of the load, a cracked base, trials, of which the explicit loop judges some."""
    mesh, scene = cracked(columns)
    trials = {"type": "strength_reduction", "loads": ["weight", "water", "uplift"], "step": 4, "limit": 30, "bracket": 1}
    return mesh, scene | {"relaxation": scene["relaxation"] | {"method": "preconditioned", "increments": 8},
                          "stages": scene["stages"] + [{"s1": trials}]}


def variable():
    """Trials with variable connectivity: a row of blocks, pushed, slides on."""
    bodies = [rectangle(-2, -1, 14, 1, group="base", rigid=True)]
    bodies += [rectangle(2 * i, 0, 2, 1, 4, 2, group="wall") for i in range(5)]
    bodies += [rectangle(1 + 2 * i, 1, 2, 0.5, group="stone", rigid=True) for i in range(4)]
    mesh = join([renamed(body, {"pushed": "left"} if i == 1 else {}, {}) for i, body in enumerate(bodies)])
    scene = {
        "model": "model.h5", "output": "out", "contact": {"connectivity": "variable"}, "relaxation": {"tolerance": 1e-5},
        "materials": {"base": {"density": 2000}, "wall": {"density": 2000, "young": 1e8, "poisson": 0.2}, "stone": {"density": 2500}},
        "joints": {"default": {"k_n": 1e8, "k_s": 5e7, "friction": 35}}, "supports": {"base": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight"}, "push": {"type": "traction", "faces": "pushed", "value": [1e5, 0]}},
        "stages": [{"stand": {"loads": ["weight"]}},
                   {"slide": {"type": "strength_reduction", "loads": ["weight", "push"], "step": 10, "limit": 1, "bracket": 2}}],
    }
    return mesh, scene


def stages(n=120):
    """Many short stages: files and checkpoints of several at once. Four blocks: 4 ranks can restart it."""
    mesh = join([renamed(rectangle(0, i, 1, 1, 2, 1, group=name, rigid=True), {"pushed": "left"} if i else {}, {})
                 for i, name in enumerate("ab")])
    scene = {
        "model": "model.h5", "output": "out", "materials": {name: {"density": 2000} for name in "ab"},
        "joints": {"default": {"k_n": 1e8, "k_s": 1e8, "friction": 30}}, "supports": {"a": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight"}, "push": {"type": "traction", "faces": "pushed", "value": [5e3, 0]}},
        "stages": [{f"s{i}": {"loads": ["weight", "push"][:1 + i % 2]}} for i in range(n)],
    }
    return mesh, scene


def dynamic(duration=0.6, n=8):
    """Blocks that fall on deformable ones and slide off: contacts come and go; energies and frames."""
    bodies = [rectangle(-1, -1, 4, 1, group="base", rigid=True), rectangle(0, 0, 2, 1, 4, 2, group="wall")]
    bodies += [rectangle(0.1 * i, 1.05 + 0.55 * i, 1, 0.5, group="block", rigid=True) for i in range(n)]
    mesh = join([renamed(body, {}, {f"block_{i}": "bottom_left"} if i else {}) for i, body in enumerate(bodies)])
    scene = {
        "model": "model.h5", "output": "out", "contact": {"connectivity": "variable", "tolerance": 0.005},
        "relaxation": {"allow_floating": True, "history_every": 100},
        "materials": {"block": {"density": 2400}, "base": {"density": 2400},
                      "wall": {"density": 2400, "young": 1e9, "poisson": 0.2}},
        "joints": {"default": {"k_n": 1e9, "k_s": 1e9, "friction": 20, "damping": 5e-4}}, "supports": {"base": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight", "groups": ["block", "wall"]}},
        "stages": [{"fall": {"type": "dynamic", "loads": ["weight"], "duration": duration, "dt_factor": 0.05, "frames": 5}}],  # many steps
    }
    return mesh, scene


def crushed():
    """A joint pressed past its strength, the force at its edge, then in its middle, then a block that jumps on it in time: closures."""
    n, strength = 1e6, 4e6
    loads = {f"{name}_{where}": {"type": "point_force", "point": f"bottom_{name}", "value": [0, -n * (0.5 + side * e)]}
             for where, e in (("edge", 0.35), ("middle", 0)) for name, side in (("left", -1), ("right", 1))}
    stages = [{"edge": {"loads": ["left_edge", "right_edge"]}}, {"middle": {"loads": ["left_middle", "right_middle"]}},
              {"jump": {"type": "dynamic", "loads": [], "duration": 0.02, "dt_factor": 0.01}}]
    stages[2]["jump"]["loads"] = ["left_edge", "right_edge"]
    return one_contact(), {
        "model": "model.h5", "output": "out", "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 500, "allow_floating": True},
        "strain": "small", "materials": {"block": {"density": 1000}, "base": {"density": 0}}, "loads": loads, "stages": stages,
        "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 45, "compression": strength}}, "supports": {"base": {"fix": "xy"}},
    }


def guarded():
    """Rigid-plastic joints without damping, at the bound of the time step: cycles make energy, the guard starts again. No verdict."""
    scene = {
        "model": "model.h5", "output": "out", "relaxation": {"damping": "none", "safety": 1.0, "max_cycles": 6000},
        "materials": {"block": {"density": 2400, "young": 10e9, "poisson": 0.2}}, "supports": {"bottom": {"fix": "xy"}},
        "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 75}}, "loads": {"weight": {"type": "self_weight"}},
        "stages": [{"all": {"loads": ["weight"], "ramp": 0}}],
    }
    return block_grid(12, 12, 1, 1), scene


def pulled(damping="adaptive"):
    """Stones of a leaning column that slip for long: springs drawn towards the law of friction; with local damping slip as it comes."""
    mesh, scene = variable()
    stages = [scene["stages"][0], {"push": {"loads": ["weight", "push"]}}]
    return mesh, scene | {"relaxation": {"tolerance": 1e-6, "damping": damping}, "contact": {"connectivity": "fixed"}, "stages": stages}


# ---- short runs of every kind that files are written by (calls.py)


def trials():
    """Trials of a strength reduction, two rigid blocks."""
    mesh, scene = stages(1)
    return mesh, scene | {"stages": [{"rest": {"loads": ["weight"]}},
                                     {"less": {"type": "strength_reduction", "loads": ["weight", "push"], "step": 10, "limit": 1, "bracket": 5}}]}


def transient():
    """Water that flows in time in a joint between rigid blocks, with frames."""
    mesh = join([renamed(rectangle(0, -1, 3, 1, 3, 1, group="rock", rigid=True)),
                 *(renamed(rectangle(i, 0, 1, 5, group="block", rigid=True), ({"near_end": "left"}, {}, {"far_end": "right"})[i]) for i in range(3))])
    return mesh, {
        "model": "model.h5", "output": "out", "strain": "small", "materials": {name: {"density": 2400} for name in ("rock", "block")},
        "joints": {"default": {"k_n": 1e3, "k_s": 1e3, "law": "elastic"}, "block+rock": {"k_n": 20e9, "k_s": 20e9, "law": "elastic", "aperture": 2e-4, "aperture_residual": 1e-5}},
        "relaxation": {"ramp": 0}, "supports": {"rock": {"fix": "xy"}}, "flow": {"bulk_modulus": 2e9},
        "loads": {"weight": {"type": "self_weight"}, "rest": {"type": "head", "faces": "near_end", "level": 0},
                  "head": {"type": "head", "faces": "near_end", "level": 0.5}},
        "stages": [{"own": {"loads": ["weight", "rest"]}}, {"rise": {"type": "transient", "loads": ["weight", "head"], "duration": 0.2, "time_step": 0.1, "frames": 1}}],
    }  # fmt: skip


def lifts():
    """A column of two lifts, the second with a bar through it."""
    mesh = join([renamed(rectangle(0, i, 1, 1, 2, 2, group=name), {"bottom": "bottom"} if not i else {}, {}) for i, name in enumerate(("low", "high"))])
    return mesh, {
        "model": "model.h5", "output": "out", "strain": "small", "materials": {name: {"density": 2400, "young": 20e9, "poisson": 0} for name in ("low", "high")},
        "joints": {"default": {"k_n": 1e10, "k_s": 1e10, "friction": 45}}, "supports": {"bottom": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}},
        "anchors": {"bar": {"head": [0.4, 1.9], "root": [0.4, 0.1], "area": 8e-4, "young": 200e9, "from": "second"}},
        "stages": [{"first": {"loads": ["weight"]}}, {"second": {"loads": ["weight"], "build": ["high"]}}],
    }


# restarted from checkpoints all along: name -> (scene, cycles between these, exit code)
EVERYWHERE = {"crushed": (crushed, 400, 0), "guarded": (guarded, 500, 4), "pulled": (pulled, 100, 0),
              "local": (lambda: pulled("local"), 500, 0), "variable": (variable, 500, 0), "left_place": (lambda: dynamic(0.3, 4), 1500, 0)}

ALL = {"static": static, "newton": newton, "reduction": reduction, "variable": variable, "dynamic": dynamic,
       "condensed": condensed, "cracked": cracked, "flood": flood, "stages": stages}
ROUNDED = ("newton",)  # on several ranks MUMPS adds up in another order each time: the last digits of each run differ

def shake(scene, duration):
    """The base of the dynamic scene moves to and fro for the whole stage."""
    scene["supports"]["base"]["motion"] = "motion.csv"
    scene["stages"][0]["fall"] |= {"duration": duration, "frames": 0}
    scene["relaxation"]["history_every"] = 1000
    scene["joints"]["default"]["friction"] = 40


def motion(duration, amplitude=0.15, frequency=1.5):
    """Velocity of the base [m/s]: a sine, as rows of t, x, y."""
    from math import pi, sin
    n = max(2, int(duration * 50))
    times = [duration * i / n for i in range(n + 1)]
    return "".join(f"{t:.6f}, {amplitude * sin(2 * pi * frequency * t):.6f}, 0\n" for t in times)


SOAK_STEP = 1.633e-5  # s, about, of the tray


def tray(duration):
    """A tray moves to and fro: a row of deformable blocks and stones on it slide and hit each other and its sides, for ever.
    Friction takes what the supports bring; contacts come and go; no block leaves."""
    bodies = [rectangle(-1, -1, 6.1, 1, group="base", rigid=True)]
    bodies += [rectangle(x, 0, 1, 2, group="base", rigid=True) for x in (-1, 4.1)]
    bodies += [rectangle(0.05 + i, 0, 1, 0.5, 2, 1, group="wall") for i in range(4)]
    bodies += [rectangle(0.3 + 1.3 * i, 0.5, 0.8, 0.4, group="block", rigid=True) for i in range(3)]
    mesh = join([renamed(body, {}, {}) for body in bodies])
    scene = dynamic()[1]
    shake(scene, duration)
    scene["joints"]["default"]["friction"] = 15
    return mesh, scene
