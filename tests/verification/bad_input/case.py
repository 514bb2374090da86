"""Bad input at the command line: one line on stderr that names file, key and value; exit code 2; older results stay.

tests/unit/scene/test_read.c has all faults of a scene; here are those a user meets first, those of the mesh and of the run."""

import copy
import os
from unittest.mock import patch

import h5py
import numpy as np
from driver import changed
from quoin_tools.mesh.stacks import column, two_bodies

WHAT = "bad input: one line on stderr, exit code 2, results of an older run untouched"
SOURCE = "docs/scene.md, docs/mesh_format.md"

GOOD = {
    "materials": {name: {"density": 2400, "young": 10e9, "poisson": 0.2} for name in ("lower", "upper")},
    "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 35}},
    "supports": {"bottom": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight"}},
    "stages": [{"weight": {"loads": ["weight"]}}],
}


def without(scene, key):
    scene = copy.deepcopy(scene)
    *path, last = key.split(".")
    at = scene
    for word in path:
        at = at[word]
    del at[last]
    return scene


def wet(*keys):
    """Water in the joint between the two bodies."""
    load = {"type": "uplift", "faces": "joint", "level": 5} | dict(keys)
    return changed(GOOD, ("loads.wet", load), ("stages", [{"weight": {"loads": ["weight", "wet"]}}]))


def pushed(start):
    """The upper body, of 23.5 kN, is pushed along the joint with 10 kN; its friction is lowered from start."""
    push = {"type": "point_force", "point": "upper_bottom_left", "value": [10e3, 0]}
    less = {"type": "strength_reduction", "loads": ["weight", "push"], "start": start, "step": 1}
    return changed(GOOD, ("loads.push", push), ("stages", [{"weight": {"loads": ["weight"]}}, {"less": less}]))


# what is wrong, scene (dict or text), options, words the line must have
SCENES = [
    ("no such mesh", changed(GOOD, ("model", "no_mesh.h5")), (), ["no_mesh.h5: no such file in the working directory or beside the scene", "mesh.py", "docs/generators.md"]),
    ("malformed YAML", "model: model.h5\nmaterials: {lower: {density: 1\n", (), ["scene.yaml:"]),
    ("unknown key", changed(GOOD, ("colour", "grey")), (), ["scene.yaml:", "colour"]),
    ("misspelt key", changed(GOOD, ("materials.upper.desity", 1)), (), ["scene.yaml:", "desity", "did you mean", "density"]),
    ("missing property", without(GOOD, "materials.upper.young"), (), ["scene.yaml:", "materials.upper", "young", "missing"]),
    ("missing material", without(GOOD, "materials.upper"), (), ["upper"]),
    ("negative density", changed(GOOD, ("materials.upper.density", -5)), (), ["scene.yaml:", "density", "-5"]),
    ("Poisson's ratio 0.5", changed(GOOD, ("materials.upper.poisson", 0.5)), (), ["scene.yaml:", "poisson", "0.5"]),
    ("unknown stress model", changed(GOOD, ("joints.default.stress_model", "t4pt")), (), ["stress_model", "t4pt", "tptm"]),
    ("stage without loads", changed(GOOD, ("stages", [{"weight": {"ramp": 10}}])), (), ["stages.weight.loads", "missing"]),
    ("load that does not exist", changed(GOOD, ("stages", [{"weight": {"loads": ["water"]}}])), (), ["stages.weight", "water"]),
    ("no supports: bodies float", without(GOOD, "supports"), (), ["scene.yaml: supports", "hangs on nothing"]),
    ("body held in x only floats", changed(GOOD, ("supports.bottom.fix", "x")), (), ["scene.yaml: supports"]),
    ("quiet boundary that is no face set", changed(GOOD, ("supports.bottom", {"fix": "xy", "target": "lower", "boundary": "quiet"})), (), ["supports.bottom.boundary", "no face set"]),
    ("quiet boundary of a rigid body", changed(GOOD, ("supports.bottom.boundary", "quiet"), ("materials.lower", {"density": 2400, "rigid": True})), (), ["supports.bottom.boundary", "group lower", "density > 0"]),
    ("quiet boundary and other loads in time", changed(GOOD, ("supports.bottom.boundary", "quiet"), ("stages", [{"rest": {"loads": ["weight"]}}, {"shake": {"type": "dynamic", "loads": [], "duration": 1}}])), (), ["stages.shake.loads", "stage before"]),
    ("quiet boundary and loads that nothing has stood under", changed(GOOD, ("supports.bottom.boundary", "quiet"), ("stages", [{"shake": {"type": "dynamic", "loads": ["weight"], "duration": 1}}])), (), ["stages.shake.loads", "no stage runs before this one"]),
    ("a stage in time in which nothing moves", changed(GOOD, ("supports.top", {"target": "upper", "fix": "xy"}), ("supports.lower", {"fix": "xy"}), ("stages", [{"shake": {"type": "dynamic", "loads": ["weight"], "duration": 1}}])), (), ["stages.shake", "supports hold all blocks"]),
    ("waves and a support that is moved", changed(GOOD, ("supports.bottom", {"fix": "xy", "boundary": "quiet", "motion": "model.h5"}), ("supports.top", {"target": "upper", "fix": "x", "motion": "model.h5"})), (), ["motion"]),
    ("a wave that comes in through a boundary that holds", changed(GOOD, ("supports.bottom.input", "incident")), (), ["scene.yaml:", "supports.bottom.input", "boundary: quiet"]),
    ("support of nothing", changed(GOOD, ("supports.cellar", {"fix": "xy"})), (), ["scene.yaml:", "cellar"]),
    ("unknown option", GOOD, ("-gravty", "3"), ["command line", "-gravty", "-gravity"]),
    ("uplift on a set that is no joint", wet(("faces", "left")), (), ["loads.wet.faces", "'left' is not a joint"]),
    ("drain outside the base", wet(("rule", "npb"), ("drain", 3)), (), ["loads.wet.drain", "3 m from the heel", "1 m long"]),
    ("unknown rule", wet(("rule", "icold")), (), ["loads.wet.rule", "'icold'", "npb, usbr, usace, ferc"]),
    ("drain without a rule for it", wet(("drain", 0.2)), (), ["loads.wet.drain", "linear knows no drain"]),
    ("rule without its efficiency", wet(("rule", "ferc"), ("drain", 0.2)), (), ["loads.wet.efficiency", "missing"]),
    ("reduction that starts above the friction there is", pushed(50), (), ["stages.less.start", "50 is out of range", "35 [degree]"]),
    ("reduction of an elastic joint", changed(pushed(30), ("joints.default", {"k_n": 10e9, "k_s": 3e9, "law": "elastic"})), (),
     ["stages.less", "elastic", "no strength"]),
    ("modes of what is condensed", changed(GOOD, ("materials.upper.condensed", True), ("stages", [{"weight": {"loads": ["weight"]}}, {"swing": {"type": "modes"}}])), (), ["materials.upper", "swing", "highest_frequency is missing"]),
    ("water that moves, and nothing else does", changed(GOOD, ("loads.hydro", {"type": "added_mass", "faces": "left", "level": 1}), ("stages", [{"weight": {"loads": ["weight", "hydro"]}}])), (), ["scene.yaml:", "loads.hydro", "dynamic"]),
    ("water that moves below the faces", changed(GOOD, ("loads.hydro", {"type": "added_mass", "faces": "left", "level": -1}), ("stages", [{"shake": {"type": "dynamic", "loads": ["weight", "hydro"], "duration": 1}}])), (), ["loads.hydro.level", "lowest point"]),
    ("bad value of an option", GOOD, ("-gravity", "much"), ["command line", "gravity", "much"]),
]


def mesh_faults():
    """Name, what to do to the HDF5 file, words the line must have."""
    def reversed_block(file):
        file["blocks"][2] = file["blocks"][2][::-1]
    def not_a_number(file):
        file["vertices"][3] = [np.nan, 0]
    def out_of_range(file):
        file["blocks"][1, 2] = 1000
    def no_blocks(file):
        del file["blocks"]
    def version(file):
        file.attrs["version"] = 9
    def overlap(file):
        upper = np.unique(file["blocks"][()][file["block_group"][()] == 1])
        file["vertices"][upper] = file["vertices"][upper] - [0, 0.25]
    return [("clockwise block", reversed_block, ["model.h5", "2"]), ("NaN coordinate", not_a_number, ["model.h5", "3"]),
            ("vertex out of range", out_of_range, ["model.h5", "1"]), ("no blocks", no_blocks, ["model.h5", "blocks"]),
            ("version 9", version, ["model.h5", "version", "9"]), ("bodies that overlap", overlap, ["model.h5", "overlap"])]


def refused(case, what, folder, options, words, ranks_list=(1, 2)):
    """Run in a folder that holds an older result."""
    (folder / "out").mkdir(exist_ok=True)
    old = folder / "out" / "summary.json"
    old.write_text("an older run", encoding="utf-8")
    faults = []
    for ranks in case.some(ranks_list):
        result = case.again(folder, *options, ranks=ranks, short=True)
        lines = result.stderr.splitlines()
        if result.exit_code != 2:
            faults.append(f"exit code {result.exit_code} on {ranks} ranks")
        if len(lines) != 1 or not lines[0].startswith("quoin: error: "):
            faults.append(f"stderr on {ranks} ranks: {result.stderr[:300]!r}")
        elif not all(word in lines[0] for word in words):
            faults.append(f"{lines[0]!r} lacks one of {words}")
        if [path.name for path in (folder / "out").iterdir()] != ["summary.json"] or old.read_text() != "an older run":
            faults.append("older results touched")
    case.check(f"{what}: `{lines[0].removeprefix('quoin: error: ') if lines else ''}`", "; ".join(faults) or "refused", "refused")


def run(case):
    mesh = two_bodies()
    for what, scene, options, words in SCENES:
        refused(case, what, case.prepare(mesh, scene), options, words)
    folder = case.prepare(None, None)
    refused(case, "no such scene", folder, ("-options_file", "no_scene.yaml"), ["no_scene.yaml"])
    refused(case, "no scene at all", folder, (), ["model", "missing", "-options_file", "-help"])
    for what, break_it, words in mesh_faults():
        folder = case.prepare(mesh, GOOD)
        with h5py.File(folder / "model.h5", "r+") as file:
            break_it(file)
        refused(case, "mesh: " + what, folder, (), words)
    folder = case.prepare(mesh, GOOD)
    whole = (folder / "model.h5").read_bytes()
    (folder / "model.h5").write_bytes(whole[:len(whole) // 2])
    refused(case, "mesh: file cut off", folder, (), ["model.h5"])
    (folder / "model.h5").write_text("no HDF5", encoding="utf-8")
    refused(case, "mesh: not an HDF5 file", folder, (), ["model.h5"])
    more_ranks_than_blocks(case)
    does_not_stand(case, mesh)
    options_of_petsc(case, mesh)


def options_of_petsc(case, mesh):
    """PETSc reads petscrc and .petscrc where it runs: they could write any file and start any program."""
    for name in ("petscrc", ".petscrc"):
        folder = case.prepare(mesh, GOOD)
        (folder / name).write_text("-log_view :written.txt\n-gravity 1\n", encoding="utf-8")
        exit_codes = [case.again(folder, ranks=ranks).exit_code for ranks in (1, 2)]
        case.check(f"a file {name} beside the scene is not read", [exit_codes, (folder / "written.txt").exists()], [[0, 0], False])
    folder = case.prepare(mesh, GOOD)
    with patch.dict(os.environ, PETSC_OPTIONS="-log_view -options_left 0"):
        case.check("options of PETSc in PETSC_OPTIONS", "Event" in case.again(folder).stdout, True)
    for options in ("-gravity 1", "-log_view -gravty 3"):
        key = options.split()[-2]
        with patch.dict(os.environ, PETSC_OPTIONS=options):
            refused(case, f"key of a scene in PETSC_OPTIONS ({key})", case.prepare(mesh, GOOD), (), ["PETSC_OPTIONS", key])


def does_not_stand(case, mesh):
    """Known only when the stages before have run."""
    result = case.run(mesh, pushed(5))
    lines = result.stderr.splitlines()
    case.check(f"reduction that does not stand at its start: `{lines[0].removeprefix('quoin: error: ')}`",
               [result.exit_code, len(lines), "stages.less: it does not stand at its start (5)" in lines[0]], [2, 1, True])


def more_ranks_than_blocks(case):
    scene = changed(GOOD, ("materials", {"block": {"density": 2400}, "base": {"density": 0}}), ("supports", {"base": {"fix": "xy"}}))
    refused(case, "more ranks than blocks", case.prepare(column(1), scene), (), ["model.h5", "3 ranks", "2 blocks"], (3,))
