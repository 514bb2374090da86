"""A synthetic record of 12 s: five sines in an envelope, its baseline closed. PGA 4.31 m/s2, Arias intensity 1.83 m/s.

PYTHONPATH=tools python examples/guilhofrei_earthquake/record.py FILE"""

import sys

import numpy as np
from quoin_tools.base.files import write_file
from quoin_tools.base.record import Record

G = 9.81
SINES = ((0.8, 0.10, 0.0), (1.7, 0.14, 1.1), (2.9, 0.12, 2.3), (4.3, 0.08, 0.7), (6.1, 0.05, 4.0))  # Hz, g, phase


def ends(t, a):
    """[m/s], [m] at the end of accelerations that are linear between rows."""
    record = Record("", t, a)
    return record.v[-1], record.u[-1]


def accelerations(t):
    envelope = np.sin(np.pi * t / t[-1]) ** 2
    a = envelope * G * sum(size * np.sin(2 * np.pi * f * t + phase) for f, size, phase in SINES)
    off = np.array([ends(t, x) for x in (envelope, envelope * t, a)])
    c = np.linalg.solve(off[:2].T, off[2])
    return a - envelope * (c[0] + c[1] * t)


if __name__ == "__main__":
    t = np.round(np.arange(0, 12.005, 0.01), 2)
    write_file(sys.argv[1], "".join(f"{x:.2f}, {a:.12g}\n" for x, a in zip(t, accelerations(t))))
    print(f"wrote {sys.argv[1]}")
