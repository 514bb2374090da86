"""Newmark's sliding block (1965): a rigid block on a rigid plane that is shaken, with friction alone. Between its rows the record is linear, so every
start and stop is the root of a polynomial of the first or second degree: exact."""

from dataclasses import dataclass

import numpy as np

from quoin_tools.base.record import RecordError

G = 9.81


@dataclass
class Resistance:
    """A block that slides on is accelerated by -p a - r [m/s2] relative to the ground, one that slides back by -q a + s."""

    p: float
    r: float
    q: float
    s: float


def yielding(on, back=None, g=G):
    """Converts yield coefficients [-] to the ground's acceleration over g against the slip at which slip begins, for each direction."""
    back = on if back is None else back
    if on < 0 or back < 0:
        raise RecordError(f"yield coefficients {on:g} and {back:g}: expected none below 0, where the block slides at rest")
    return Resistance(1.0, on * g, 1.0, back * g)


def incline(friction, slope=0.0, g=G):
    """A plane that falls to +x by slope, shaken along x; angles [degree]. On is downwards. With the normal force as it changes."""
    phi, theta = np.radians([friction, slope])
    if not 0 <= slope <= friction < 90:
        raise RecordError(f"plane of {slope:g} degrees, friction {friction:g}: expected 0 <= slope <= friction < 90, or the block slides at rest")
    c, s, mu = np.cos(theta), np.sin(theta), np.tan(phi)
    return Resistance(c + mu * s, g * (c * mu - s), c - mu * s, g * (c * mu + s))


@dataclass
class Slip:
    """Slip [m] and its velocity in the rows of the record, and after it until the block stops; phases: (from, to) [s] of sliding."""

    t: np.ndarray
    slip: np.ndarray
    velocity: np.ndarray
    phases: list

    @property
    def final(self):
        return self.slip[-1]

    def ends(self):
        """[s] When it begins to slide for the first time, and when it stops for good; None where it never slides."""
        return (self.phases[0][0], self.phases[-1][1]) if self.phases else None


def root(c0, c1, c2, most):
    """Returns the least s in (0, most] with c0 + c1 s + c2 s^2 = 0; None: there is none."""
    if c2 == 0:
        found = [-c0 / c1] if c1 else []
    else:
        under = c1 * c1 - 4 * c2 * c0
        q = -0.5 * (c1 + np.copysign(np.sqrt(under), c1)) if under >= 0 else 0.0
        found = [q / c2, c0 / q] if q else []
    found = [s for s in found if 1e-14 * max(most, 1) < s <= most]
    return min(found) if found else None


class Block:
    """Follows the block between two rows, where the ground's acceleration is a0 + a1 s, from event to event."""

    def __init__(self, resistance):
        self.of, self.x, self.v, self.way, self.since = resistance, 0.0, 0.0, 0, None
        self.phases, self.least, self.most = [], 0.0, 0.0

    def drive(self, way, a):
        """Acceleration relative to the ground when it slides that way."""
        return -self.of.p * a - self.of.r if way > 0 else -self.of.q * a + self.of.s

    def start(self, t, a, slope):
        """Decides whether a block at rest begins to slide; where it is just at the limit, the slope decides."""
        for way in (1, -1):
            pull = way * self.drive(way, a)
            grows = way * (-self.of.p if way > 0 else -self.of.q) * slope > 0
            if pull > 1e-13 * G or (abs(pull) <= 1e-13 * G and grows):
                self.way, self.since = way, t
                return

    def go(self, t, h, a, slope):
        """Over h seconds from time t."""
        s = 0.0
        while h - s > 1e-14 * max(t, 1):
            now = a + slope * s
            if not self.way:
                self.start(t + s, now, slope)
            s += self.slide(t + s, h - s, now, slope) if self.way else self.rest(h - s, now, slope)

    def rest(self, h, a, slope):
        """Returns how long the block stays at rest, at most h."""
        starts = [root(self.drive(way, a), -(self.of.p if way > 0 else self.of.q) * slope, 0.0, h) for way in (1, -1)]
        return min([s for s in starts if s is not None], default=h)

    def slide(self, t, h, a, slope):
        """Returns how long the block slides in this direction, at most h."""
        b0, b1 = self.drive(self.way, a), -(self.of.p if self.way > 0 else self.of.q) * slope
        stops = root(self.v, b0, b1 / 2, h)
        s = h if stops is None else stops
        self.x += s * (self.v + s * (b0 / 2 + s * b1 / 6))
        self.v = self.v + s * (b0 + s * b1 / 2) if stops is None else 0.0
        self.least, self.most = min(self.least, self.x), max(self.most, self.x)
        if stops is not None:
            self.phases.append((self.since, t + s))
            self.way = 0
        return s


def slide(record, resistance):
    """Slip of the block on a record; behind its end the ground goes on as it moves then."""
    block, rows = Block(resistance), [(record.t[0], 0.0, 0.0)]
    for t, h, a, b in zip(record.t, np.diff(record.t), record.a, record.a[1:]):
        if h > 0:
            block.go(t, h, a, (b - a) / h)
        rows.append((t + h, block.x, block.v))
    if block.way:
        brake = resistance.r if block.way > 0 else resistance.s
        if brake <= 0:
            raise RecordError(f"{record.name}: the block does not stop: its friction is what the slope takes")
        block.go(record.t[-1], 1.001 * abs(block.v) / brake, 0.0, 0.0)
        rows.append((block.phases[-1][1], block.x, 0.0))
    return Slip(*np.array(rows).T, block.phases), (block.least, block.most)
