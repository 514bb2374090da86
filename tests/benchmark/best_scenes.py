"""The scenes of best.py: every example, Fig. 6, section G1, Voronoi dams, walls, arches, an earthquake.

A scene is a scene file or the keys of one, a function that makes its mesh, and options. No scene says how it is solved."""

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent.parent
EXAMPLES = ROOT / "examples"
sys.path[:0] = [str(ROOT / "tools"), str(EXAMPLES / "fig6")]

from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.dam import dam_mesh  # noqa: E402
from quoin_tools.mesh.voronoi import Options, voronoi_mesh  # noqa: E402
from quoin_tools.mesh.walls import arch, slope, wall  # noqa: E402
from triangle_dam import triangle_dam  # noqa: E402


@dataclass
class Scene:
    """name: in the table; scene: path below examples/ or keys; mesh: () -> BlockMesh, or the words of a command that writes model.h5;
    exact: what statics or another method say of the bracket of a stage; kind: many, large (with a flag) or short (of the check) beside usual."""

    name: str
    scene: str | dict
    mesh: Callable | tuple
    options: tuple = ()
    exact: dict = field(default_factory=dict)
    kind: str = "usual"
    stages: str = ""

    def keys(self):
        return yaml.safe_load((EXAMPLES / self.scene).read_text(encoding="utf-8")) if isinstance(self.scene, str) else self.scene

    def run_stages(self):
        """(name, keys) of the stages that run."""
        stages = [item for entry in self.keys()["stages"] for item in entry.items()]
        return [item for item in stages if not self.stages or item[0] in self.stages.split(",")]

    def types(self):
        return {stage.get("type", "static") for _, stage in self.run_stages()}

    def condensable(self):
        """Groups of elastic blocks that deform."""
        rigid = {word.split("_")[1] for word in self.options if word.endswith("_rigid")}
        return [name for name, keys in self.keys()["materials"].items() if "young" in keys and "law" not in keys and name not in rigid]

    def prepare(self, folder):
        """Writes model.h5 and, where the keys are here, scene.yaml; returns the words behind the program."""
        if isinstance(self.mesh, tuple):
            for command in self.mesh:
                done = subprocess.run([sys.executable, *command], cwd=folder, env={"PYTHONPATH": str(ROOT / "tools"), "PATH": "/usr/bin:/bin"}, capture_output=True, text=True)
                if done.returncode:
                    raise RuntimeError(f"{self.name}: {done.stderr}")
        else:
            write(str(folder / "model.h5"), self.mesh())
        path = EXAMPLES / self.scene if isinstance(self.scene, str) else folder / "scene.yaml"
        if not isinstance(self.scene, str):
            path.write_text(yaml.safe_dump(self.scene, sort_keys=False), encoding="utf-8")
        words = ("-options_file", str(path), "-model", str(folder / "model.h5"), "-output", "out", "-checkpoint_minutes", "0", *self.options)
        return (*words, "-stages", self.stages) if self.stages else words


def made(example, *arguments, script="mesh.py", also=()):
    """The command of an example's mesh, and further commands."""
    return ((str(EXAMPLES / example / script), "model.h5", *arguments), *also)


def from_section(example):
    return (("-m", "quoin_tools", "import", str(EXAMPLES / example / "section.yaml"), "-o", "model.h5"), )


RECORD = (str(EXAMPLES / "guilhofrei_earthquake" / "record.py"), "quake.csv")
STONE = {"density": 2400, "young": 10e9, "poisson": 0.2}
WEIGHT = {"weight": {"type": "self_weight"}}
DAM = {"materials": {"dam": STONE, "facing": STONE}, "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 60}},
       "supports": {"base": {"fix": "xy"}}, "loads": WEIGHT, "stages": [{"sw": {"loads": ["weight"]}}]}  # fmt: skip
RIGID = ("-materials_dam_rigid", "true", "-materials_facing_rigid", "true")
SIDES = {150: (1.6, 5), 597: (0.6, 3), 2003: (0.3, 3), 7776: (0.15, 3), 20032: (0.0929, 5)}  # stones: side [m], seed
# stones: options of joints so stiff that none of small stones leaves its range
STIFF = {7776: ("-joints_default_k_n", "50e9", "-joints_default_k_s", "15e9"), 20032: ("-joints_default_k_n", "100e9", "-joints_default_k_s", "30e9")}


def wall_scene(young=False, **joint):
    return {"materials": {"block": STONE if young else {"density": 2400}, "base": {"density": 0}},
            "joints": {"default": {"k_n": 10e9, "k_s": 4e9, "friction": 35} | joint}, "supports": {"base": {"fix": "xy"}},
            "loads": {"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "traction", "faces": "left", "value": [20e3, 0]}},
            "stages": [{"sw": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}}]}  # fmt: skip


ARCH = {"materials": {"voussoir": {"density": 2400}, "abutment": {"density": 0}}, "joints": {"default": {"k_n": 10e9, "k_s": 4e9, "friction": 40}},
        "supports": {"abutment": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight", "groups": ["voussoir"]}, "crown": {"type": "point_force", "point": "crown_extrados", "value": [0, -10e3]}},
        "stages": [{"sw": {"loads": ["weight"]}}, {"crown": {"type": "load_factor", "loads": ["weight", "crown"], "raises": ["crown"], "step": 4, "limit": 400, "bracket": 0.5}}]}  # fmt: skip
SLOPE = {"materials": {"block": {"density": 2500}, "base": {"density": 0}}, "joints": {"default": {"k_n": 1e9, "k_s": 4e8, "friction": 45}},
         "supports": {"base": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
         "stages": [{"sw": {"loads": ["weight"]}}, {"less": {"type": "strength_reduction", "loads": ["weight"], "bracket": 0.25, "limit": 10}}]}  # fmt: skip


def voronoi(stones):
    side, seed = SIDES[stones]
    return voronoi_mesh(options=Options(seed=seed, side=side))


def voronoi_scenes():
    """Dams under their own weight, and one with its reservoir."""
    for stones in SIDES:
        for rigid in (True, False):
            for friction in (60, 45, 35):
                if stones > 2003 and (friction != 60 or not rigid):
                    continue
                name = f"Voronoi dam, {stones} stones, {'rigid' if rigid else 'elastic'}, friction {friction}"
                yield Scene(name, DAM, partial(voronoi, stones), (*(RIGID if rigid else ()), "-joints_default_friction", str(friction), *STIFF.get(stones, ())),
                            kind="large" if stones > 2003 else "usual")  # fmt: skip
    for stones in (150, 2003):
        yield Scene(f"Voronoi dam, {stones} stones, elastic joints", DAM, partial(voronoi, stones), ("-joints_default_law", "elastic"))
    full = Scene("Voronoi dam, 2003 stones, reservoir, friction 45", "guilhofrei_voronoi/scene.yaml", partial(voronoi, 2003), stages="sw,swhp")
    yield full
    yield Scene("the same, friction reduced to 0.25 degree", full.scene, full.mesh, ("-stages_reduction_start", "45", "-stages_reduction_step", "10", "-stages_reduction_bracket", "0.25"),
                kind="large")  # fmt: skip


def example_scenes():
    """Every example, as its run.sh runs it."""
    yield Scene("Fig. 6", "fig6/scene.yaml", partial(triangle_dam, 16, "M"))
    yield Scene("Fig. 6, 64 columns", "fig6/scene.yaml", partial(triangle_dam, 64, "M"))
    yield Scene("Fig. 6, 64 columns, friction 45", "fig6/scene.yaml", partial(triangle_dam, 64, "M"), ("-joints_base_law", "mohr_coulomb", "-joints_base_friction", "45"))
    yield Scene("G1", "guilhofrei/scene.yaml", made("guilhofrei"))
    yield Scene("G1, 96 columns", "guilhofrei/scene.yaml", partial(dam_mesh, columns=96))
    yield Scene("G1, local factors", "guilhofrei_local/scene.yaml", made("guilhofrei_local"))
    slides = made("guilhofrei_sliding")
    yield Scene("S1", "guilhofrei_sliding/scene.yaml", slides, stages="sw,swhp,swhpu,s1", exact={"s1": 28.102})
    yield Scene("S2", "guilhofrei_sliding/scene_s2.yaml", made("guilhofrei_sliding", script="mesh_s2.py"), exact={"s2": 25.61})
    yield Scene("S3", "guilhofrei_sliding/scene.yaml", slides, stages="sw,swhp,swhpuk,s3")
    brittle = ("-stages_swhpuk_joints_key_cohesion_residual", "0", "-stages_swhpuk_joints_key_tension_residual", "0")
    yield Scene("S3, brittle", "guilhofrei_sliding/scene.yaml", slides, brittle, stages="sw,swhp,swhpuk,s3")
    yield Scene("S4", "guilhofrei_sliding/scene.yaml", slides, stages="sw,swhp,swhpu,s4", exact={"s4": 46.266})
    for seed in "123":
        yield Scene(f"G1 in polygons, seed {seed}", "guilhofrei_voronoi/scene.yaml", made("guilhofrei_voronoi", seed))
    yield Scene("G1 in polygons with cohesion", "guilhofrei_continuum/scene.yaml", made("guilhofrei_continuum", "1"))
    yield Scene("G1, continuum of the polygons", "guilhofrei_continuum/scene_continuum.yaml", made("guilhofrei_continuum", "1", "--continuous", "--refine", "1"))
    quake, shaken = made("guilhofrei_sliding", also=(RECORD, )), "guilhofrei_earthquake/scene.yaml"
    record = ("-motions_quake_file", "quake.csv")
    yield Scene("Earthquake, pseudo-static", shaken, quake, record, stages="sw,full,pseudo")
    yield Scene("Earthquake, yield coefficient", shaken, quake, record, stages="sw,full,yield", exact={"yield": 0.2948})
    for seconds in "48":
        yield Scene(f"Earthquake, {seconds} s of record", shaken, quake, (*record, "-stages_shake_duration", seconds, "-stages_shake_frames", "0"), stages="sw,full,shake")
    yield Scene("G1 on jointed rock, seepage", "guilhofrei_seepage/scene.yaml", made("guilhofrei_seepage"), stages="rock,sw,rule,present,grouted,drained,clogged")
    yield Scene("G1 that yields", "guilhofrei_yielding/scene.yaml", made("guilhofrei_yielding"))
    yield Scene("G1 that cracks at its heel", "guilhofrei_yielding/scene_heel.yaml", made("guilhofrei_yielding"))
    for name, file, exact in (("tendons", "scene", {}), ("without", "scene_without", {"flood": 48.933}), ("grouted bars", "scene_grouted", {}), ("force of tendons", "scene_force", {})):
        yield Scene(f"Anchored dam, {name}", f"anchored_dam/{file}.yaml", made("anchored_dam"), exact=exact)
    yield Scene("Engineer's dam", "engineers_dam/scene.yaml", from_section("engineers_dam"), exact={"sliding": 29.19})
    yield Scene("Keyed dam", "keyed_dam/scene.yaml", from_section("keyed_dam"))
    yield Scene("Lifts and winter", "lifts_and_winter/scene.yaml", made("lifts_and_winter"))
    yield Scene("Lifts and winter, in one piece", "lifts_and_winter/scene_whole.yaml", made("lifts_and_winter"))
    yield Scene("A block that falls", "motion/scene.yaml", made("motion", "edge"))


def other_scenes():
    """Walls, arches, a slope that topples."""
    yield Scene("Wall, 256 rigid stones, pushed", wall_scene(), partial(wall, 16, 16))
    yield Scene("Wall, 256 elastic stones, pushed", wall_scene(True), partial(wall, 16, 16, rigid=False))
    yield Scene("Wall, 1800 rigid stones, pushed", wall_scene(), partial(wall, 45, 40))
    yield Scene("Wall, 1800 elastic stones, pushed", wall_scene(True), partial(wall, 45, 40, rigid=False))
    yield Scene("Arch of 21 voussoirs, load at its crown", ARCH, arch)
    yield Scene("Arch of 101 voussoirs, load at its crown", ARCH, partial(arch, 101))
    yield Scene("Columns that topple, friction reduced", SLOPE, slope)


def short_scenes():
    """Of the check that the table is made."""
    yield Scene("Fig. 6, 6 columns", "fig6/scene.yaml", partial(triangle_dam, 6, "M"), kind="short")
    yield Scene("Wall, 9 stones, pushed", wall_scene(friction=60), partial(wall, 3, 3), kind="short")
    block = {"materials": {"block": {"density": 2400}, "base": {"density": 0}}, "joints": {"default": {"k_n": 10e9, "k_s": 4e9, "friction": 45}},
             "supports": {"base": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "traction", "faces": "left", "value": [5886.0, 0]}},
             "stages": [{"sw": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}},
                        {"less": {"type": "strength_reduction", "loads": ["weight", "push"], "step": 10, "limit": 5, "bracket": 0.5}}]}  # fmt: skip
    # a block of 1 m by 0.5 m, 11 772 N, pushed by 2943 N: slides at tan(phi) = 1/4
    yield Scene("A block that is pushed", block, partial(wall, 1, 1), exact={"less": 14.036}, kind="short")


def scenes(kinds):
    everything = [*short_scenes(), *example_scenes(), *other_scenes(), *voronoi_scenes()]
    return [scene for scene in everything if scene.kind in kinds]
