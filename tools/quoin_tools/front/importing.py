"""Makes a block mesh.

    quoin import section.yaml -o model.h5 [--scene scene.yaml]
        of a section, or of a drawing (DXF) that the section file names
    quoin import model.msh -o model.h5
        of a mesh of Gmsh
    quoin import dam -o model.h5
        of a gravity dam on rock
    quoin import voronoi -o model.h5
        of a dam of random polygons
    quoin import walls wall -o model.h5
        of a wall; arch and slope in place of wall

`quoin import section.yaml -h`, `quoin import model.msh -h`,
`quoin import dam -h` and so on say which options these take;
`quoin help generators` has more."""

import importlib

GENERATORS = ("dam", "voronoi", "walls")  # modules of mesh/


def main(words):
    if words[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0
    if words and words[0] in GENERATORS:
        return importlib.import_module(f"quoin_tools.mesh.{words[0]}").main(words[1:])
    if any(word.lower().endswith(".msh") for word in words):
        from quoin_tools.mesh.gmsh_import import main as chosen
    else:
        from quoin_tools.mesh.section import main as chosen
    return chosen(words)
