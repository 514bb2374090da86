"""Bad input at the command line: one line on stderr that names file, key and value; exit code 2; older results stay.

catalogue.py has every refusal; here are some, each a run of the program in a folder with older results, and what it reads of PETSc."""

import copy
import os
from unittest.mock import patch

import h5py
import numpy as np
from driver import changed
from quoin_tools.mesh.stacks import column, two_bodies

WHAT = "bad input: one line on stderr, exit code 2, results of an older run untouched"
SOURCE = "docs/scene.md, docs/mesh_format.md"
BY = "the documents of this project"

GOOD = {
    "materials": {name: {"density": 2400, "young": 10e9, "poisson": 0.2} for name in ("lower", "upper")},
    "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 35}},
    "supports": {"bottom": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight"}},
    "stages": [{"weight": {"loads": ["weight"]}}],
}


def without_key(scene, key):
    scene = copy.deepcopy(scene)
    *path, last = key.split(".")
    at = scene
    for word in path:
        at = at[word]
    del at[last]
    return scene


def pushed(start):
    """The upper body, of 23.5 kN, is pushed along the joint with 10 kN; its friction is lowered from start."""
    push = {"type": "point_force", "point": "upper_bottom_left", "value": [10e3, 0]}
    less = {"type": "strength_reduction", "loads": ["weight", "push"], "start": start, "step": 1}
    return changed(GOOD, ("loads.push", push), ("stages", [{"weight": {"loads": ["weight"]}}, {"less": less}]))


# what is wrong, scene, options, words the line must have
SCENES = [
    ("no such mesh", changed(GOOD, ("model", "no_mesh.h5")), (), ["no_mesh.h5: no such file in the working directory or beside the scene", "mesh.py", "docs/generators.md"]),
    ("misspelt key", changed(GOOD, ("materials.upper.desity", 1)), (), ["scene.yaml:", "desity", "did you mean", "density"]),
    ("no supports: bodies float", without_key(GOOD, "supports"), (), ["scene.yaml: supports", "has no support"]),
    ("unknown option", GOOD, ("-gravty", "3"), ["command line", "-gravty", "-gravity"]),
]


def overlap(file):
    upper = np.unique(file["blocks"][()][file["block_group"][()] == 1])
    file["vertices"][upper] = file["vertices"][upper] - [0, 0.25]


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
    folder = case.prepare(mesh, GOOD)
    with h5py.File(folder / "model.h5", "r+") as file:
        overlap(file)
    refused(case, "mesh: bodies that overlap", folder, (), ["model.h5", "overlap"])
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
