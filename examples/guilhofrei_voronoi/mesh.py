"""Section G1 of the Guilhofrei dam in random Voronoi polygons between facing courses square to the faces.

    PYTHONPATH=tools python examples/guilhofrei_voronoi/mesh.py OUTPUT.h5 [SEED] [OPTIONS]

Mean side 2 m; SEED of the random numbers, 1 by default; OPTIONS as `quoin import voronoi` knows them."""

import sys

from quoin_tools.mesh.voronoi import main

if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    seed, *options = sys.argv[2:] or ["1"]
    sys.exit(main(["-o", sys.argv[1], "--seed", seed, "--square", *options]))
