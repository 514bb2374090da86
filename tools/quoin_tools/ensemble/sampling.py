"""Which samples: independent normal numbers and a weight for each index, the same whoever asks and in whatever order.

For Sobol's indices samples come in groups: two independent ones, A and B, and for each variable A with that of B. A Latin hypercube and a Sobol sequence come in blocks, each with its own shuffle, so that their spread says how sure the mean is and more blocks can follow.
"""

import hashlib
import math
from functools import lru_cache

import numpy as np
import scipy

from quoin_tools.ensemble.variables import EnsembleError, stream

METHODS = ("monte_carlo", "latin_hypercube", "sobol", "importance", "sobol_indices")
BLOCK = {"latin_hypercube": 50, "sobol": 64}


class Sampler:
    """normal(index): (k,) independent normal numbers; weight(index): 1, or the ratio of densities of importance sampling. centre: of that, the design point (k,)."""

    def __init__(self, method, variables, seed, block=None, centre=None):
        if method not in METHODS:
            raise EnsembleError(f"method: {method}: expected one of {', '.join(METHODS)}")
        self.method, self.names, self.seed = method, variables.names(), seed
        self.block = len(self.names) + 2 if method == "sobol_indices" else block or BLOCK.get(method, 1)
        if method == "sobol" and self.block & (self.block - 1):
            raise EnsembleError(f"block: {self.block}: a block of a Sobol sequence has a power of two samples")
        self.centre = np.zeros(len(self.names)) if centre is None else np.asarray(centre, dtype=float)

    def uniform(self, index):
        if self.method == "latin_hypercube":
            block, place = divmod(index, self.block)
            return np.array([(shuffle(self.seed, name, block, self.block)[place] + stream(self.seed, name, index)) / self.block for name in self.names])
        if self.method == "sobol":
            block, place = divmod(index, self.block)
            return sobol(self.seed, block, self.block, len(self.names))[place]
        if self.method == "sobol_indices":
            group, place = divmod(index, self.block)
            return np.array([stream(self.seed, name if place == 0 or (place > 1 and place - 2 != k) else f"{name}, the other", group) for k, name in enumerate(self.names)])
        return np.array([stream(self.seed, name, index) for name in self.names])

    def normal(self, index):
        return scipy.special.ndtri(self.uniform(index)) + self.centre

    def weight(self, index):
        if self.method != "importance":
            return 1.0
        shifted = self.normal(index)
        return math.exp(0.5 * float(((shifted - self.centre) ** 2).sum() - (shifted**2).sum()))


@lru_cache(maxsize=256)
def shuffle(seed, name, block, size):
    """Returns a permutation of 0 ... size - 1 of this variable in this block."""
    return np.argsort([stream(seed, f"{name}, order of block {block}", place) for place in range(size)])


@lru_cache(maxsize=64)
def sobol(seed, block, size, dimensions):
    """Returns a scrambled Sobol sequence of its own for each block; inside (0, 1)."""
    key = int.from_bytes(hashlib.sha256(f"{seed}, Sobol block {block}".encode()).digest()[:8], "little")
    points = scipy.stats.qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(key)).random(size)
    return np.clip(points, 2.0**-54, 1 - 2.0**-54)
