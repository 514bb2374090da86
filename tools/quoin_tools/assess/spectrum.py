"""Computes the response spectrum of a record: the largest displacement of oscillators that the ground carries along (Nigam and Jennings 1969). Between rows the record is linear, so the motion of an oscillator is known there in closed form.
record is linear, so the motion of an oscillator is known there in closed form."""

from dataclasses import dataclass

import numpy as np

FINE = 128  # samples in a period: the largest displacement is missed by less than 0.03 %
DAMPING = 0.05
TOGETHER = 40  # oscillators whose motion is in memory at once


@dataclass
class Spectrum:
    period: np.ndarray  # [s]
    damping: float
    displacement: np.ndarray  # [m] largest, relative to the ground

    @property
    def velocity(self):
        """[m/s] Pseudo-velocity."""
        return 2 * np.pi / self.period * self.displacement

    @property
    def acceleration(self):
        """[m/s2] Pseudo-acceleration."""
        return (2 * np.pi / self.period) ** 2 * self.displacement


def periods(shortest=0.02, longest=4.0, n=200):
    return np.geomspace(shortest, longest, n)


def of(record, period=None, damping=DAMPING):
    period = periods() if period is None else np.asarray(period, float)
    parts = [largest(record, 2 * np.pi / part, damping) for part in np.split(period, range(TOGETHER, len(period), TOGETHER))]
    return Spectrum(period, damping, np.concatenate(parts))


def largest(record, w, z):
    """[m] Returns the largest displacement of oscillators with the circular frequencies w (m,) and the damping ratio z, from rest; also after the record has ended."""
    keep = np.diff(record.t) > 0
    h, a = np.diff(record.t)[keep, None], record.a[:-1][keep, None]
    slope = np.diff(record.a)[keep, None] / h
    w = np.asarray(w, float)
    wd, decay = w * np.sqrt(1 - z * z), z * w
    # x'' + 2 z w x' + w^2 x = -(a + slope s) is solved by c0 + c1 s, and exp(-decay s) (A cos wd s + B sin wd s) more
    c1 = -slope / w**2
    c0 = -(a + 2 * z * w * c1) / w**2
    cos, sin = np.exp(-decay * h) * np.cos(wd * h), np.exp(-decay * h) * np.sin(wd * h)
    A, B = np.empty(c0.shape), np.empty(c0.shape)
    x, v = np.zeros(len(w)), np.zeros(len(w))
    for i in range(len(h)):
        A[i] = x - c0[i]
        B[i] = (v - c1[i] + decay * A[i]) / wd
        free = A[i] * cos[i] + B[i] * sin[i]
        v = c1[i] - decay * free + wd * (B[i] * cos[i] - A[i] * sin[i])
        x = c0[i] + c1[i] * h[i] + free
    found = [on_the_way(h, c0[:, j], c1[:, j], A[:, j], B[:, j], wd[j], decay[j]) for j in range(len(w))]
    return np.maximum(found, swung_out(x, v, wd, decay))


def on_the_way(h, c0, c1, A, B, wd, decay):
    """[m] Returns the displacement of one oscillator, over the rows."""
    looks = max(2, int(np.ceil(FINE * h.max() * wd / (2 * np.pi))))
    s = h * np.linspace(0, 1, looks + 1)
    swing = np.exp(-decay * s) * (A[:, None] * np.cos(wd * s) + B[:, None] * np.sin(wd * s))
    return np.abs(c0[:, None] + c1[:, None] * s + swing).max()


def swung_out(x, v, wd, decay):
    """[m] Returns the largest displacement of free oscillators from displacement x and velocity v; over one period, since with damping the first peak is the largest."""
    s = np.linspace(0, 2 * np.pi, FINE + 1)[:, None] / wd
    return np.abs(np.exp(-decay * s) * (x * np.cos(wd * s) + (v + decay * x) / wd * np.sin(wd * s))).max(axis=0)
