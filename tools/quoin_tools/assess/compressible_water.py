"""Computes the pressure of a reservoir on a dam that swings: water that can be compressed, of constant depth, without end, on a bottom that takes up waves.

    water = Reservoir(depth, density=1000.0, sound=1440.0, reflection=0.9)
    p = water.pressure(shape, omega)     [Pa] (complex) on water.grid, for accelerations shape(y) [m/s2] of the face at heights y above the bottom, circular frequency omega

p exp(i omega t) solves lap p = -(omega/C)^2 p with p = 0 at the surface, dp/dn = -rho a at the dam's vertical face, dp/dy = i omega q p at the bottom (Fenves and
Chopra), q = (1 - alpha)/(C (1 + alpha)) for the wave reflection alpha; waves run out or die away from the dam. With Y_n = cos(mu_n y) + (i omega q/mu_n) sin(mu_n y),
Y_n(H) = 0, which are orthogonal without conjugation, p = rho sum Y_n (int a Y_n dy / int Y_n^2 dy) / sqrt(mu_n^2 - (omega/C)^2). Westergaard's rigid dam and water that
cannot be compressed is omega = 0: 0.5428 rho a H^2 in all, 0.7425 rho a H at the bottom.
"""

from dataclasses import dataclass

import numpy as np

TERMS = 200  # of a pressure, which falls to 0 steeply at the surface
TERMS_OF_MASS = 40
PLACES = 801  # of integration over the depth
STEPS = 10  # from a rigid bottom to the one asked for, in which Newton's method follows the roots
ROUNDS = 30  # of Newton's method


@dataclass
class Reservoir:
    depth: float  # [m]
    density: float = 1000.0  # [kg/m3]
    sound: float = 1440.0  # [m/s]
    reflection: float = 1.0  # [-] 1: a bottom that gives all waves back; 0: one that gives none

    @property
    def grid(self):
        return np.linspace(0, self.depth, PLACES)

    @property
    def cutoff(self):
        """[1/s] Circular frequency of the water's own slowest vibration, with a bottom that gives all waves back."""
        return np.pi * self.sound / (2 * self.depth)

    @property
    def weight(self):
        """[m] of the places of the grid, by Simpson's rule."""
        weight = np.full(PLACES, self.grid[1] / 3)
        weight[1:-1:2], weight[2:-1:2] = 4 * self.grid[1] / 3, 2 * self.grid[1] / 3
        return weight

    def roots(self, omega, terms=TERMS):
        """[-] (terms,) mu_n H: roots of z cos z + i b sin z = 0, b = omega q H."""
        b = omega * self.depth * (1 - self.reflection) / (self.sound * (1 + self.reflection))
        z = (2 * np.arange(1, terms + 1) - 1) * np.pi / 2 + 0j
        for part in b * np.linspace(0, 1, STEPS + 1)[1:] if b else ():
            for _round in range(ROUNDS):
                cos, sin = np.cos(z), np.sin(z)
                step = (z * cos + 1j * part * sin) / (cos - z * sin + 1j * part * cos)
                z = z - step
                if abs(step).max() < 1e-13 * abs(z).max():
                    break
        return z

    def modes(self, shape, omega, terms=TERMS):
        """Returns (Y_n on the grid (terms, PLACES), int a Y_n dy, int Y_n^2 dy, decay [1/m] away from the dam)."""
        mu = self.roots(omega, terms) / self.depth
        b = 1j * omega * (1 - self.reflection) / (self.sound * (1 + self.reflection))
        waves = np.cos(mu[:, None] * self.grid) + b / mu[:, None] * np.sin(mu[:, None] * self.grid)
        decay = np.sqrt(mu**2 - (omega / self.sound) ** 2 + 0j)  # of its two roots that with the positive real part
        running = abs(decay.real) <= 1e-12 * abs(decay)
        decay = np.where(running & (decay.imag < 0), -decay, decay)  # a wave that runs off
        return waves, (waves * shape(self.grid)) @ self.weight, waves**2 @ self.weight, decay

    def pressure(self, shape, omega):
        """[Pa] (complex) on the grid."""
        waves, pushed, squares, decay = self.modes(shape, omega)
        return self.density * (pushed / squares / decay) @ waves

    def added(self, shape, omega):
        """[kg/m] (complex) Returns int p shape dy."""
        _, pushed, squares, decay = self.modes(shape, omega, TERMS_OF_MASS)
        return self.density * (pushed**2 / squares / decay).sum()

    def over_depth(self, values, shape=None):
        """Returns the integral over the depth of values on the grid, times a shape where one is given."""
        return values @ self.weight if shape is None else (values * shape(self.grid)) @ self.weight
