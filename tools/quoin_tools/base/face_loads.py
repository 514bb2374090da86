"""Reads the forces of loads on faces at the end of a stage, as the run applied them: the table `loads` of results.h5 (docs/results_format.md).

loads = Results("out").stage("full").loads    # None: no load presses on a face
loads.of("water").force.sum(axis=(0, 1))      # [N] of one load, on the mesh as drawn
"""

from dataclasses import dataclass

import numpy as np

COLUMNS = ("names", "load", "face", "point", "force")


@dataclass
class FaceLoads:
    """A row for each load on each face: a force along the line between two points, linear, with the shares of its ends; a single force has its place on the face as the first point."""

    names: list  # of the loads of the scene when the stage ran: a restart may have added some since
    load: np.ndarray  # (n,) row of names
    face: np.ndarray  # (n, 2) block in model.h5 and face of the block
    point: np.ndarray  # (n, 2, 2) [m] on the mesh as drawn
    force: np.ndarray  # (n, 2, 2) [N]

    def __post_init__(self):
        n = len(self.load)
        self.names = [name.decode() if isinstance(name, bytes) else name for name in self.names]
        self.load, self.face = self.load.astype(int), self.face.astype(int)
        self.point, self.force = self.point.reshape(-1, 2, 2), self.force.reshape(-1, 2, 2)
        if any(len(column) != n for column in (self.face, self.point, self.force)):
            raise ValueError("loads: its columns do not belong together")

    def of(self, name):
        """Returns the rows of one load; none where the scene had no load of this name."""
        mine = self.load == (self.names.index(name) if name in self.names else -1)
        return FaceLoads(self.names, self.load[mine], self.face[mine], self.point[mine], self.force[mine])

    def single(self):
        """Selects rows that are a single force, at their second point."""
        return ~self.force[:, 0].any(axis=1)

    def systems(self):
        """Returns (X, Y, M about the origin) of each row."""
        moment = self.point[..., 0] * self.force[..., 1] - self.point[..., 1] * self.force[..., 0]
        return np.column_stack([self.force.sum(axis=1), moment.sum(axis=1)])

    def between(self, i, low, high):
        """Returns (X, Y, M) of the stretch of row i between two fractions of its line."""
        first, last = self.force[i]
        start, rise = 4 * first - 2 * last, 6 * (last - first)  # force per line, at its start, and what it gains along the line
        whole = start * (high - low) + rise * (high**2 - low**2) / 2
        first_moment = start * (high**2 - low**2) / 2 + rise * (high**3 - low**3) / 3
        (x, y), (along_x, along_y) = self.point[i, 0], self.point[i, 1] - self.point[i, 0]
        return np.array([*whole, x * whole[1] - y * whole[0] + along_x * first_moment[1] - along_y * first_moment[0]])
