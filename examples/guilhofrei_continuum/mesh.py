"""Section G1 of the Guilhofrei dam in random polygons, as stones with joints or as one body of the same blocks.

    PYTHONPATH=tools python examples/guilhofrei_continuum/mesh.py OUTPUT.h5 [SEED] [OPTIONS]

Mean side 2 m; SEED of the random numbers, 1 by default; OPTIONS as `quoin import voronoi` knows them: --continuous --refine 1 for one body."""

import sys

from quoin_tools.mesh.voronoi import main

if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    seed, *options = sys.argv[2:] or ["1"]
    sys.exit(main(["-o", sys.argv[1], "--seed", seed, "--square", *options]))
