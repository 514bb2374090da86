"""Computes the gravity method: the classical hand calculation of a dam on a plane.

The part above a base is rigid; N, T, M follow from statics, stress is a straight line over the length in contact. Where that line
would pull, the base opens: no tension, a crack, and a triangle of stress on the ligament of length 3 x_r (x_r: distance of the
resultant from the compressed end). Uplift follows a rule of uplift.py; where it follows the crack, crack and uplift are
iterated until they agree.

Signs are those of summary.json: N positive in compression; T positive when the part above pushes towards the end (toe) of the
base; M about the middle of the base, positive when it pulls at the end; stress positive in tension.

    base = Base((0, 0), (22.8, 2.28))
    answer = hand_method(base, total(stage_forces(mesh, scene, "swhp", cut(mesh, base.ends()))[0]))
"""

from dataclasses import dataclass, field

import numpy as np

from quoin_tools.assess import uplift as uplift_rules
from quoin_tools.assess.crack_start import CrackStart
from quoin_tools.assess.section_cut import GravityError, force_at
from quoin_tools.base.language import _

ROUNDS = 500  # of crack and uplift
SETTLED = 1e-10  # change of the crack over the length of the base


@dataclass
class Base:
    """A straight base from start (the heel of a dam with its water on the left) to end; the part above lies to the left of that direction.

    path: corners of the broken line that it stands for (broken.py); bears: (n, 2) stretches of it that have cohesion, None: all of it; opens: the criterion of
    a guideline by which a crack starts (crack_start.py), None: with any tension."""

    start: tuple
    end: tuple
    thickness: float = 1.0
    path: np.ndarray | None = None
    bears: np.ndarray | None = None
    opens: CrackStart | None = None

    def __post_init__(self):
        self.start, self.end = np.array(self.start, dtype=float), np.array(self.end, dtype=float)
        self.length = float(np.hypot(*(self.end - self.start)))
        if not self.length > 0:
            raise GravityError("the base has no length")
        self.along = (self.end - self.start) / self.length
        self.normal = np.array([-self.along[1], self.along[0]])
        self.middle = 0.5 * (self.start + self.end)

    def ends(self):
        return np.array([self.start, self.end])

    def meets(self):
        """Returns where the base meets the face: at its own ends, or at the ends of the broken line that it replaces."""
        return self.ends() if self.path is None else self.path[[0, -1]]

    def at(self, distance):
        return self.start + distance * self.along

    def resultants(self, forces):
        """N, T, M of the forces (X, Y, M about the origin) on the part above."""
        about_middle = forces[2] - (self.middle[0] * forces[1] - self.middle[1] * forces[0])
        return -forces[:2] @ self.normal, forces[:2] @ self.along, about_middle


@dataclass(frozen=True)
class Uplift:
    """Water under the base. direction: normal to the base, or its vertical part only (the paper, section 4.4); heel: the end of the base at which the water
    stands, from which the distances of the rule are measured; before: [m] during an earthquake, the crack without it; shaken: what becomes of the pressure in the
    crack that it opens, None: as the rule says."""

    rule: str
    heads: uplift_rules.Heads
    direction: str = "normal"
    in_crack: str | None = None
    unit_weight: float = uplift_rules.WATER
    heel: str = "start"
    before: float | None = None
    shaken: str | None = None
    opened: float = 0.0  # [m] crack that an earthquake before has left, from the heel: the full head stays in it
    drains: str = "past"  # one of uplift.DRAINS

    def line(self, crack):
        """Corners of the diagram of heads for a crack [m] from the heel: distances from there [m], heads [m]."""
        return uplift_rules.head_line(self.rule, self.heads, crack, self.in_crack, self.before, self.shaken, self.drains)

    def place(self, base, x):
        """The place (2,) of the base at a distance x [m] from the heel."""
        return base.at(x if self.heel == "start" else base.length - x)

    def forces(self, base, crack):
        """Returns (X, Y, M) on the part above."""
        force, x = uplift_rules.resultant(self.rule, self.heads, crack, self.in_crack, self.unit_weight, self.before, self.shaken, self.drains)
        direction = base.normal if self.direction == "normal" else np.array([0.0, base.along[0]])
        return force_at(force * base.thickness * direction, self.place(base, x))

    def has_drain(self):
        return self.heads.drain is not None and self.rule not in ("none", "linear")

    def is_emptied(self):
        """Tells whether the crack that an earthquake opens has no pressure."""
        return self.before is not None and self.rule != "none" and (self.shaken or uplift_rules.rule_named(self.rule).shaken) == "zero"

    def follows_crack(self):
        if self.before is not None:
            return (self.shaken or uplift_rules.rule_named(self.rule).shaken) != "unchanged" and self.rule != "none"
        return (self.in_crack or uplift_rules.rule_named(self.rule).crack) == "full" and self.rule != "none"


@dataclass
class Hand:
    """Answer of the hand method. crack is None, and refused says why, where the part above finds no equilibrium."""

    base: Base
    N: float
    T: float
    M: float
    uplift: float = 0.0  # [N], resultant of the pressure
    crack: float | None = 0.0  # [m], from the start, or from the end when crack_at says so
    crack_at: str = "start"
    rounds: int = 0
    refused: str = ""
    reached: float = 0.0  # [m] crack of the forces where there is no equilibrium
    start: tuple | None = None  # [Pa] (compression at the end where a crack would start, the least by the criterion of a guideline); None: nothing pulls there, or there is no criterion
    closed_by: float = 0.0  # [m] crack without tension, which does not start by that criterion
    notes: list = field(default_factory=list)

    @property
    def eccentricity(self):
        """Distance [m] of the resultant from the middle, positive towards the end; nan without a normal force."""
        return -self.M / self.N if self.N > 0 else float("nan")

    @property
    def resultant(self):
        """Distance of the resultant from the start [m]."""
        return 0.5 * self.base.length + self.eccentricity

    @property
    def ligament(self):
        return None if self.crack is None else self.base.length - self.crack

    @property
    def linear(self):
        """Stress at start and end by the straight line over the whole length, tension included [Pa]."""
        mean, bend = -self.N / self.base.length, 6 * self.M / self.base.length**2
        return (mean - bend) / self.base.thickness, (mean + bend) / self.base.thickness

    @property
    def compression(self):
        """Largest compression of the no-tension base [Pa]: at the toe of the ligament. None without equilibrium."""
        if self.crack is None:
            return None
        if self.crack > 0:
            return 2 * self.N / (self.ligament * self.base.thickness)
        return -min(self.linear)

    def carried(self, low, high):
        """Part of the normal force on the stretch from low to high [m from the start], by the straight line without tension."""
        L = self.base.length
        if self.N <= 0 or self.crack is None:
            return 0.0
        if self.crack > 0:  # a triangle that begins where the crack ends
            a, b = (low, high) if self.crack_at == "start" else (L - high, L - low)
            a, b = (min(max((x - self.crack) / (L - self.crack), 0.0), 1.0) for x in (a, b))
            return b * b - a * a
        a, b = (min(max(x / L, 0.0), 1.0) for x in (low, high))
        bend = 6 * self.M / (self.N * L)  # of the straight line, over its mean: 1 + bend (1 - 2 x / L)
        return (b - a) * (1 + bend * (1 - a - b))

    @property
    def friction_needed(self):
        """[degree]"""
        return float(np.degrees(np.arctan2(abs(self.T), self.N)))

    def sliding_factor(self, friction, cohesion=0.0, length=None):
        """Returns (N tan(friction) + cohesion * length) / |T|; length: closed, where cohesion acts; by default the uncracked part."""
        length = (self.ligament or 0.0) if length is None else length
        strength = max(self.N, 0.0) * np.tan(np.radians(friction)) + cohesion * length * self.base.thickness
        return float(strength / abs(self.T)) if abs(self.T) > 1e-12 * max(abs(self.N), 1.0) else float("inf")

    def motion(self, k_n):
        """Rigid part on a joint of normal stiffness k_n [Pa/m]: rotation [rad], closure at the toe, gap at the heel [m]."""
        closure = self.compression / k_n
        if self.crack > 0:
            rotation = closure / self.ligament
            return rotation, closure, rotation * self.crack
        rotation = abs(self.linear[1] - self.linear[0]) / (k_n * self.base.length)
        return rotation, closure, 0.0


def crack_of(base, N, M):
    """Crack [m] and the end where it starts, for a base without tension; None and the reason without equilibrium."""
    if N <= 0:
        return None, "start", _("nothing presses on the base: the part above is lifted")
    off = -M / N
    edge = 0.5 * base.length - abs(off)  # distance of the resultant from the compressed end
    where = "start" if off >= 0 else "end"
    if edge <= 0:
        return None, where, _("the resultant leaves the base: overturning")
    return max(0.0, base.length - 3 * edge), where, ""


def hand_method(base, forces, uplift=None, beside=None):
    """Hand of the forces (X, Y, M) on the part above and of the uplift; beside: of uplift elsewhere on the part."""
    beside = np.zeros(3) if beside is None else beside
    if uplift and uplift.is_emptied():
        return emptied(base, forces, uplift, beside)
    crack, where, answer, start = 0.0, "start", None, None
    for rounds in range(1, ROUNDS + 1):
        under = uplift.forces(base, max(crack if where == uplift.heel else 0.0, uplift.opened)) if uplift else np.zeros(3)
        N, T, M = base.resultants(forces + under + beside)
        answer = Hand(base, N, T, M, float(np.hypot(*(under + beside)[:2])), rounds=rounds)
        found, where, refused = crack_of(base, N, M)
        if refused:
            return run_away(answer, crack, refused)
        start = started(answer, found, where, forces + beside, uplift) if rounds == 1 else start
        answer.start, answer.crack_at = start, where
        if stays_closed(answer, found):
            return answer
        settled = abs(found - crack) <= SETTLED * base.length
        crack = found
        if settled or not (uplift and uplift.follows_crack()):
            break
    else:
        return run_away(answer, crack, _("crack and uplift do not settle in {0} rounds", ROUNDS))
    answer.crack, answer.crack_at = crack, where
    if uplift and where == uplift.heel:
        answer.notes += about_drain(uplift, crack)
    return answer


def started(hand, found, where, dry, uplift):
    """[Pa] (compression at the end where a crack would start, the least by the criterion of the base); None where no tension opens it (found: [m] crack), there is no
    criterion, or it asks for water that nobody knows. dry: (X, Y, M) without the uplift under the base."""
    base, opens = hand.base, hand.base.opens
    if opens is None or found <= 0 or (uplift and (uplift.opened > 0 or (uplift.before or 0.0) > 0)) or (opens.without_uplift and uplift is None):
        return None
    if opens.without_uplift:
        hand = Hand(base, *base.resultants(dry))
    head = 0.0 if uplift is None else uplift.heads.heel if where == uplift.heel else uplift.heads.toe
    return -hand.linear[where == "end"], opens.asks(head, uplift is not None and uplift.has_drain(), uplift_rules.WATER if uplift is None else uplift.unit_weight)


def stays_closed(hand, found):
    """Tells whether a base stays closed by its criterion though it is in tension, and notes the crack that there would be without."""
    held = hand.start is not None and hand.start[0] >= hand.start[1]
    hand.closed_by = found if held else 0.0
    return held


def about_drain(uplift, crack):
    """Says in a line what becomes of the drain in a cracked base; none where it works as without."""
    drain = uplift.heads.drain if uplift.has_drain() else None
    if drain is None or crack <= 0 or (crack < drain and not (uplift.follows_crack() and uplift.drains == "lost")):
        return []
    if crack < drain:
        return [_("the base is cracked ({0:.2f} m), and the drain ({1:.2f} m) is lost", crack, drain)]
    if uplift.follows_crack() and uplift.drains != "work":
        return [_("the crack ({0:.2f} m) has passed the drain ({1:.2f} m), which is lost", crack, drain)]
    return [_("the crack ({0:.2f} m) has passed the drain ({1:.2f} m), which is assumed to work on", crack, drain)]


def emptied(base, forces, uplift, beside):
    """Hand of an earthquake that takes the pressure out of the crack that it opens: less pressure, a shorter crack, so one length agrees."""
    def at(crack):
        under = uplift.forces(base, crack)
        N, T, M = base.resultants(forces + under + beside)
        answer = Hand(base, N, T, M, float(np.hypot(*(under + beside)[:2])))
        found, answer.crack_at, refused = crack_of(base, N, M)
        return answer, found, refused

    low, high = uplift.before, base.length
    answer, found, refused = at(low)
    start = answer.start = None if refused else started(answer, found, answer.crack_at, forces + beside, uplift)
    if stays_closed(answer, found):
        return answer
    if not refused and (found <= low or answer.crack_at != uplift.heel):  # it opens nothing
        answer.crack = found
        return answer
    rounds = 0
    while high - low > SETTLED * base.length:
        rounds, middle = rounds + 1, 0.5 * (low + high)
        answer, found, refused = at(middle)
        low, high = (middle, high) if refused or found > middle else (low, middle)
    if high >= base.length:
        return run_away(answer, base.length, refused or _("the base is open all through"))
    answer, answer.crack, refused = at(high)
    answer.start = start
    answer.rounds = rounds
    return answer


def run_away(answer, crack, why):
    """Returns an answer without equilibrium; its forces are those of the last round."""
    answer.crack, answer.reached = None, crack
    answer.refused = _("{0}, once the crack has reached {1:.2f} m", why, crack) if crack > 0 else why
    return answer


def triangle_crack(width, height, ratio):
    """Crack over width of a triangular dam with vertical upstream face, full reservoir, no uplift; ratio of densities."""
    return max(0.0, (height / width) ** 2 / ratio - 1.0)
