"""Explicit relaxation makes no energy: 598 Voronoi stones under their own weight, friction 45 to 75 degrees. Friction counted
from the last equilibrium is a force that depends on place alone, with a curl; on the way to the equilibrium it must not be. Nor does
slip that is kept as it comes chatter: the stage ends."""

from driver import changed
from quoin_tools.mesh.voronoi import Options, voronoi_mesh

WHAT = "stones that slide, steep friction: explicit relaxation makes no energy, and its ramp leaves nothing behind"
SOURCE = "work of the weight"
BY = "by hand"

STONE = {"density": 2400, "young": 10e9, "poisson": 0.2}
SCENE = {
    "relaxation": {"method": "explicit", "tolerance": 1e-6, "max_cycles": 60000, "history_every": 100},
    "materials": {"dam": STONE, "facing": STONE},
    "joints": {"default": {"stress_model": "tptm", "k_n": 10e9, "k_s": 3e9, "friction": 75}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight"}},
    "stages": [{"sw": {"loads": ["weight"]}}],
}


def run(case):
    mesh = voronoi_mesh(options=Options(seed=5, side=0.6))
    scenes = {"friction 75": SCENE, "joints that can crush": changed(SCENE, ("joints.default.compression", 10e6))}
    if not case.short:
        scenes |= {"... a ramp of 5000 cycles": changed(SCENE, ("relaxation.ramp", 5000)),
                   "friction 45, slip let go on the way": changed(SCENE, ("joints.default.friction", 45))}  # fmt: skip
    results = dict(zip(scenes, case.run_all([(mesh, scene) for scene in scenes.values()])))
    weight = 2400 * 9.81 * 411.96
    for what, result in results.items():
        kinetic = result.history["kinetic_J"]
        down = -result.probe("sw", "crest_upstream")[1]
        case.check(f"{what}: verdict", result.verdict, "converged")
        case.check("... kinetic energy is less than a hundredth of the work of the weight, 0.5 x weight x crest",
                   bool(kinetic.max() < 0.01 * 0.5 * weight * down), True)
    crest, crushes, *ramped = [result.probe("sw", "crest_upstream") for result in results.values()]
    case.check("crest, whatever a compressive strength that nothing reaches [m]", crushes, crest, relative=1e-9)
    if ramped:
        case.check("... whatever the ramp [m]", ramped[0], crest, relative=5e-3)
