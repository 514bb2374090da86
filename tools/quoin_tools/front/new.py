"""A folder to begin with: scene.yaml and model.h5 of a gravity dam on rock.

    quoin new FOLDER [--height 38] [--crest-width 4] [--downstream-slope 0.8]
                     [--columns 24] ...

Options are those of `quoin dam`, which makes the block mesh; without any it is
section G1 of the Guilhofrei dam. The reservoir of the scene is full. For a mesh
of your own (`quoin import` makes it of a Gmsh file) put its names into the
scene."""

import errno
import os
import shlex
from pathlib import Path

TEMPLATE = Path(__file__).with_name("dam.yaml")


def main(words):
    if not words or words[0] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if words else 2
    from quoin_tools.base.files import write_file
    from quoin_tools.mesh import blockmesh, dam

    folder = Path(words[0])
    scene, model = folder / "scene.yaml", folder / "model.h5"
    for path in (scene, model):
        if os.path.lexists(path):
            raise OSError(errno.EEXIST, "is there already, and stays as it is", str(path))
    code = dam.main(["-o", str(model), *words[1:]])
    if code:
        return code
    mesh = blockmesh.read(str(model))
    level = mesh.vertices[mesh.points["crest_upstream"], 1]
    text = TEMPLATE.read_text(encoding="utf-8").replace("@TITLE@", quoted(folder.resolve().name)).replace("@LEVEL@", f"{level:g}")
    write_file(scene, text)
    print(f"wrote {scene}: self-weight, reservoir up to {level:g} m, uplift, friction of the base reduced until the dam slides\n"
          f"next: cd {shlex.quote(str(folder))}; quoin run -n 2 scene.yaml; quoin show out")  # fmt: skip
    return 0


def quoted(text):
    """A text of YAML."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
