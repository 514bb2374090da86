"""Combines responses of modes to a design spectrum: SRSS, CQC (Der Kiureghian 1981), and the part that moves with the ground.

    total = combine(parts, whole, acceleration, ground, omega, damping)

A response of mode n under the acceleration 1 m/s2 is parts[n]; that of the whole structure which the ground takes along with 1 m/s2 is `whole`, the sum over all
modes. A stiff mode follows the ground, in phase with all other stiff modes, so the largest acceleration A of the ground acts on everything at once with its signs,
also on the mass that no mode found has; what a spectrum has beyond it, sqrt(S_a^2 - A^2), swings at each mode's own time and is combined by CQC (Lindley and Yow
1980, in the form with the static response to A). A structure whose modes are all stiff so gets the answer of the coefficient A/g, exactly; sums of squares alone
would give less. Where S_a is less than A the mode counts with A, on the safe side.
"""

import numpy as np


def correlation(omega, damping):
    """(n, n) Returns the coefficients of CQC. omega: circular frequencies; damping: ratio, one or (n,)."""
    omega = np.asarray(omega, float)
    xi = np.broadcast_to(np.asarray(damping, float), omega.shape)
    r, a, b = omega[None] / omega[:, None], xi[:, None], xi[None]
    return 8 * np.sqrt(a * b) * (a + r * b) * r**1.5 / ((1 - r**2) ** 2 + 4 * a * b * r * (1 + r**2) + 4 * (a**2 + b**2) * r**2)


def quadratic(responses, omega, damping, rule="cqc"):
    """Returns the largest responses (...) of those of the modes (n, ...), without their signs."""
    responses = np.asarray(responses, float)
    between = correlation(omega, damping) if rule == "cqc" else np.eye(len(responses))
    return np.sqrt(np.maximum(np.einsum("i...,ij,j...->...", responses, between, responses), 0.0))


def combine(parts, whole, acceleration, ground, omega, damping, rule="cqc"):
    """Returns the largest responses (...) without their signs. parts: (n, ...) of modes and whole: (...) of everything, under 1 m/s2; acceleration: (n,) S_a and ground: A [m/s2]."""
    beyond = np.sqrt(np.maximum(np.asarray(acceleration, float) ** 2 - ground**2, 0.0))
    parts = np.asarray(parts, float)
    swings = quadratic(parts * beyond.reshape(-1, *[1] * (parts.ndim - 1)), omega, damping, rule)
    return np.hypot(swings, ground * np.asarray(whole, float))
