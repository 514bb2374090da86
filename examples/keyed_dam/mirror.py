"""The mirror image of a block mesh, about x = 0: the water of a dam stands on its right then.

    PYTHONPATH=tools python examples/keyed_dam/mirror.py model.h5 mirrored.h5
"""

import sys

from quoin_tools.mesh.blockmesh import BlockMesh, read, write


def mirrored(mesh):
    """x turns its sign, and corners of blocks go round the other way, so that they are counter-clockwise again."""
    blocks, sets = mesh.blocks.copy(), {}
    corners = (blocks >= 0).sum(axis=1)
    for row, n in enumerate(corners):
        blocks[row, :n] = blocks[row, :n][::-1]
    for name, faces in mesh.face_sets.items():
        sets[name] = [(block, (corners[block] - 2 - face) % corners[block]) for block, face in faces]
    return BlockMesh(mesh.vertices * [-1, 1], blocks, mesh.block_group, mesh.group_names, mesh.group_rigid, sets, mesh.points)


def main(arguments):
    if len(arguments) != 2 or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    write(arguments[1], mirrored(read(arguments[0])))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
