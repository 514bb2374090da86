"""Runs a published problem, whose numbers by others are in problems.yaml:  PYTHONPATH=tools python examples/published/problem.py NAME [OUT]

Makes the mesh and the tables that the scene NAME.yaml names, and runs build/quoin in the folder OUT (build/published/NAME). Without NAME it lists the names."""

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def prepare(name, folder):
    """Writes scene.yaml, model.h5 and the tables of the problem into the folder."""
    import models
    from quoin_tools.mesh.blockmesh import write

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.yaml").write_text((HERE / f"{name}.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    write(str(folder / "model.h5"), models.MESHES[name]())
    for file, rows in models.TABLES.get(name, {}).items():
        (folder / file).write_text(rows(), encoding="utf-8")


def main(arguments):
    names = sorted(path.stem for path in HERE.glob("*.yaml") if path.stem != "problems")
    if not arguments or arguments[0] not in names:
        sys.exit(f"{__doc__}\n\n{' '.join(names)}")
    name = arguments[0]
    folder = Path(arguments[1] if len(arguments) > 1 else ROOT / "build" / "published" / name)
    prepare(name, folder)
    quoin = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
    return subprocess.run([quoin, "-options_file", "scene.yaml"], cwd=folder, check=False).returncode


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    sys.exit(main(sys.argv[1:]))
