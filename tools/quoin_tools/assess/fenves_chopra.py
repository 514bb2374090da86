"""The simplified analysis of Fenves and Chopra (1986): the first mode of a dam with its reservoir and rock by a design spectrum, all higher modes as they follow the ground.

    first = first_mode(omega, mass, excitation, shape, water, ...)
    first.period, first.damping, first.factor          of the dam with water and rock
    first.forces(S_a, of_mode, of_pressure)            of the first mode
    first.static(a_g, of_ground, of_rigid_water, of_mode)    of the higher ones

M, L: generalised mass and excitation of the mode phi of the empty dam on rigid rock. B(w) = int p(y, w) phi dy, p of a face that swings with phi (compressible_water.py).
Without their tables, what these have is computed:
  R_r = w_1/w_r, w_r the root of w^2 (M + Re B(w)) = w_1^2 M; xi_r = -Im B(w_r)/(2 M R_r^2)
  T = R_r R_f T_1, xi = xi_1/(R_r R_f^3) + xi_r + xi_f; R_f, xi_f of the rock are given (1 and 0: rigid rock)
  f_1 = (L + int Re p dy)/(M + Re B) S_a(T, xi) (m phi + Re p)
  f_sc = a_g (m + p_0 - (L + B_0)/M m phi), p_0 of a rigid dam and water that cannot be compressed, B_0 = int p_0 phi dy
Both are added as the root of the sum of squares. Sources: the structure of the method is that of UCB/EERC-85/10; the formulas for R_r and xi_r follow from the equation
of the first mode, -w^2 (M + B) + 2 i w w_1 xi_1 M + w_1^2 M = 0, at w_r. No table was copied.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from quoin_tools.base.language import _

SEARCHED = 20  # frequencies up to that of the empty dam


class NoRootError(ValueError):
    """The dam with its water has no period; the message is one line."""


@dataclass
class FirstMode:
    period: float  # [s] with water and rock
    damping: float  # [-] with water and rock
    lengthening: float  # [-] R_r
    water_damping: float  # [-] xi_r
    mass: float  # M + Re B
    excitation: float  # L + int Re p dy
    dry: float  # L/M of the empty dam
    correction: float  # (L + B_0)/M
    pressure: object  # Re p [Pa] at heights above the bottom
    rigid: object  # p_0 [Pa]

    @property
    def factor(self):
        return self.excitation / self.mass

    def forces(self, acceleration, of_mode, of_pressure):
        return self.factor * acceleration * (np.asarray(of_mode) + np.asarray(of_pressure))

    def static(self, ground, of_ground, of_rigid_water, of_mode):
        return ground * (np.asarray(of_ground) + np.asarray(of_rigid_water) - self.correction * np.asarray(of_mode))


def first_mode(omega, mass, excitation, shape, water, damping=0.05, rock_period=1.0, rock_damping=0.0, thickness=1.0):
    """omega, mass, excitation: [1/s], [kg], [kg] of the empty dam; shape(y): phi of the wet face at heights above the bottom; water: Reservoir, None: there is none."""
    if water is None:
        def none(y):
            return np.zeros_like(np.asarray(y, float))

        return FirstMode(2 * np.pi / omega * rock_period, damping / rock_period**3 + rock_damping, 1.0, 0.0, mass, excitation, excitation / mass, excitation / mass, none, none)

    def added(w):
        return thickness * water.added(shape, w)

    wet = root(lambda w: w**2 * (mass + added(w).real) - omega**2 * mass, omega, water.cutoff)
    ratio = omega / wet
    with_water = added(wet)
    p = water.pressure(shape, wet).real
    still = water.pressure(np.ones_like, 0.0).real
    xi = -with_water.imag / (2 * mass * ratio**2)
    return FirstMode(
        2 * np.pi / wet * rock_period, damping / (ratio * rock_period**3) + xi + rock_damping, ratio, xi, mass + with_water.real, excitation + thickness * water.over_depth(p), excitation / mass,
        (excitation + thickness * water.over_depth(still, shape)) / mass, lambda y: at(water, y, p), lambda y: at(water, y, still))  # fmt: skip


def at(water, y, values):
    """[Pa] Returns the pressure at heights y; none above the surface and below the bottom."""
    return np.interp(y, water.grid, values, left=0.0, right=0.0)


def root(difference, highest, cutoff):
    """[1/s] Returns the slowest frequency at which the difference turns positive. cutoff: where the added mass has a peak, or no end."""
    tried = np.append(highest * np.arange(1, SEARCHED + 1) / SEARCHED, cutoff * (1 - 1e-9))
    low = 0.0
    for high in np.sort(tried[tried <= highest]):
        if difference(high) >= 0:
            break
        low = high
    else:
        raise NoRootError(_("the dam with its water has no frequency below that of the empty dam"))
    return float(scipy.optimize.brentq(difference, low, high, xtol=1e-10 * highest))
