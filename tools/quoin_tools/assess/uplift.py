"""Computes uplift pressure under a base or in a joint by the rule of a guideline. Pure functions, no files.

Distances run along the base from the heel [m]; heads are metres of water above the base where they act.

    H1, H2  heads at heel and toe          L  length of the base        X  drain line       T  length of the crack
    H3      head at the drain line         H4 head in the gallery       K = 1 - E, E efficiency of the drain
    Hi      H4 where a gallery stands higher than the tailwater (H4 > H2), else H2

    rule     head H3 at the drain line                              crack       earthquake  status
    none     no uplift at all                                       -           -           -
    linear   no drain: straight from H1 to H2                       full        unchanged   standard
    npb      H2 + (H1 - H2) / 3                                     unchanged   unchanged   paper, sections 4.4 and S4
    usbr     H2 + (H1 - H2) / 3, written for X <= 0.05 H1           full        zero        to be checked by the user
    usace    K (H1 - Hi) + Hi                    if X <= 0.05 H1    full        unchanged   to be checked by the user
             K (H1 - Hi) (L - X) / (L - T) + Hi  otherwise
    ferc     as usace                                               full        unchanged   to be checked by the user

    Without a drain every rule is `linear`. Heads run straight from H1 (at 0) to H3 (at X) to H2 (at L).
    At rest, also after an earthquake:
    crack = unchanged   the crack changes nothing (the paper's flood S4)
    crack = full        H1 along the whole crack, then straight to H3 and H2 while T < X; once the crack has passed the
                        drain, the drain is lost: H1 to T, then straight to H2. In a base that falls towards the toe the
                        water stands higher above T than above the heel: from H1 to H1 and this fall
    During an earthquake, where T0 is the crack of the same loads without it:
    unchanged           the diagram of T0, however far the earthquake opens the base
    zero                the same, and no pressure from T0 to T, which the earthquake has opened
    full                as crack = full, with the crack of the moment
    A measured head at the drain (drain_head) takes the place of H3 in every rule.
    Drains where the full head follows the crack, as a guideline may want them in place of the above:
    past                lost once the crack has passed them (if nothing is said)
    lost                lost as soon as the base is cracked
    work                never lost: H1 up to the drain at most, H3 there

"to be checked by the user": written from memory of EM 1110-2-2200, FERC chapter 3, and the Bureau of Reclamation's manuals;
no copy was at hand. What they want during an earthquake is quoted by others: Leger, Leclerc et al. on CADAM (USACE 1995 and FERC: unchanged;
USBR 1987: zero) and the help of CADAM3D. ICOLD (1986), by the first, calls full pressure adequate and safe. The solver has the same table
(src/water/uplift.c).
"""

from dataclasses import dataclass

import numpy as np

from quoin_tools.base.language import N_, _

WATER = 9810.0  # [N/m3] 1000 kg/m3 times 9.81 m/s2
NEAR = 0.05  # a drain is near the heel when X <= NEAR * H1
CHECK = N_("to be checked by the user")
WITHOUT_PROOF, VERIFIED = 0.5, 0.67  # largest efficiencies of drains, by USACE as others quote it
CRACKS = (N_("unchanged"), N_("full"))  # at rest
SHAKEN = ("unchanged", N_("zero"), "full")  # during an earthquake
SHAKEN_RANK = {"zero": 0, "unchanged": 1, "full": 2}  # by how much they press
DRAINS = ("past", "lost", "work")  # in a cracked base
STEP = 1e-9  # of the length of the base: over which the pressure falls to zero at the ends of a crack without any


class UpliftError(ValueError):
    """The heads or the rule are wrong; the message is one line."""


@dataclass(frozen=True)
class Heads:
    """Water at a base: lengths along it from the heel and heads above it [m]."""

    length: float
    heel: float
    toe: float = 0.0
    drain: float | None = None
    efficiency: float | None = None
    gallery: float | None = None
    drain_head: float | None = None
    fall: float = 0.0  # of the base, from the heel to the toe; 0 where it rises
    tail_at_drain: float = 0.0  # head of the tailwater at the drain, which counts where it is more than that at the toe: the base rises

    @property
    def tail(self):
        """The head from which that at the drain line counts."""
        return max(self.toe, self.tail_at_drain)

    def in_crack(self, x):
        """Returns the full head at a distance x from the heel."""
        return self.heel + self.fall * x / self.length if self.heel > 0 else 0.0

    def __post_init__(self):
        if not self.length > 0:
            raise UpliftError(f"length of the base {self.length:g} m: expected more than 0")
        if not (self.heel + self.fall >= self.toe - 1e-9 * self.length and min(self.heel, self.toe) >= 0):
            raise UpliftError(f"heads {self.heel:g} m at the heel, {self.toe:g} m at the toe" + (f" {self.fall:g} m lower" if self.fall else "") + ": expected heel >= toe >= 0")
        if self.drain is not None and not 0 < self.drain < self.length:
            raise UpliftError(f"drain at {self.drain:g} m: expected between 0 and {self.length:g} m, ends excluded")
        if self.drain_head is not None and not 0 <= self.drain_head <= self.heel + self.fall:
            raise UpliftError(f"head of {self.drain_head:g} m at the drain: expected 0 to {self.heel:g} m")
        if self.drain_head is not None and self.drain is None:
            raise UpliftError("a head at the drain needs the place of the drain")


@dataclass(frozen=True)
class Rule:
    """A row of the table above; at_drain(heads, crack) gives H3."""

    name: str
    at_drain: object
    crack: str
    shaken: str
    source: str
    status: str


def third(heads, crack):
    """A third of the difference of heads is left at the drain line."""
    return heads.tail + max(0.0, heads.heel - heads.tail) / 3


def by_efficiency(heads, crack):
    if heads.efficiency is None or not 0 <= heads.efficiency <= 1:
        raise UpliftError(f"this rule needs the efficiency of the drain, 0 to 1, not {heads.efficiency}")
    inside = heads.tail if heads.gallery is None else max(heads.gallery, heads.tail)
    if heads.gallery is not None and heads.gallery > heads.heel + heads.fall:
        raise UpliftError(f"gallery: its head {heads.gallery:g} m is above that at the heel, {heads.heel:g} m")
    reach = 1.0 if heads.drain <= NEAR * heads.heel else (heads.length - heads.drain) / (heads.length - crack)
    return (1 - heads.efficiency) * max(0.0, heads.heel - inside) * reach + inside


RULES = {
    rule.name: rule
    for rule in (
        Rule("none", None, "unchanged", "unchanged", N_("no uplift"), N_("as the user says")),
        Rule("linear", None, "full", "unchanged", N_("no drain: straight line from heel to toe"), N_("standard")),
        Rule("npb", third, "unchanged", "unchanged", N_("Portuguese practice, Portaria 846/93, as the paper uses it"), N_("as in the paper")),
        Rule("usbr", third, "full", "zero", N_("US Bureau of Reclamation, Design of Small Dams (1987)"), CHECK),
        Rule("usace", by_efficiency, "full", "unchanged", N_("US Army Corps of Engineers, EM 1110-2-2200 (1995)"), CHECK),
        Rule("ferc", by_efficiency, "full", "unchanged", N_("FERC engineering guidelines, chapter 3"), CHECK),
    )
}


def rule_named(name):
    if name not in RULES:
        raise UpliftError(f"no uplift rule '{name}', there are: {', '.join(RULES)}")
    return RULES[name]


def head_line(name, heads, crack=0.0, in_crack=None, before=None, shaken=None, drains="past"):
    """Corners of the diagram of heads: distances x and heads, both rising in x; straight between them.

    in_crack (unchanged or full) overrides what the rule says about the crack at rest. before: [m] the crack of the same loads without the earthquake, None:
    there is none; shaken (unchanged, zero or full) overrides what the rule says during one; drains: one of DRAINS.
    """
    rule = rule_named(name)
    in_crack, shaken = in_crack or rule.crack, shaken or rule.shaken
    if in_crack not in CRACKS:
        raise UpliftError(f"in the crack '{in_crack}': expected {' or '.join(CRACKS)}")
    if shaken not in SHAKEN:
        raise UpliftError(f"in the crack during an earthquake '{shaken}': expected {', '.join(SHAKEN)}")
    if before is None:
        return line_at_rest(rule, heads, crack, in_crack, drains)
    if shaken == "full":
        return line_at_rest(rule, heads, crack, "full", drains)
    line = line_at_rest(rule, heads, before, in_crack, drains)
    return line if shaken == "unchanged" else emptied(*line, max(before, 0.0), min(crack, heads.length))


def line_at_rest(rule, heads, crack, in_crack, drains="past"):
    """The corners of a diagram without an earthquake."""
    if rule.name == "none":
        return np.array([0.0, heads.length]), np.zeros(2)
    if in_crack == "unchanged":
        crack = 0.0
    crack = min(max(crack, 0.0), heads.length)
    drained = heads.drain is not None and rule.name != "linear" and (drains == "work" or (crack < heads.drain if drains == "past" else crack == 0))
    if drained:
        crack = min(crack, heads.drain)
    full = crack if not drained or crack < heads.drain else crack - STEP * heads.length
    corners = [(0.0, heads.heel)] + ([(full, heads.in_crack(full))] if full > 0 else [])
    if drained:
        at_drain = rule.at_drain(heads, crack) if heads.drain_head is None else heads.drain_head
        corners.append((heads.drain, at_drain))
    if crack < heads.length:
        corners.append((heads.length, heads.toe))
    return tuple(np.array(corners).T)


def emptied(x, head, low, high):
    """A diagram without the pressure between two places."""
    length = x[-1]
    if high <= low:
        return x, head
    step = min(STEP * length, 0.5 * (high - low))
    corners = [(a, b) for a, b in zip(x, head) if a < low]
    corners += [(low, np.interp(low, x, head)), (low + step, 0.0)] if low > 0 else [(0.0, 0.0)]
    corners += [(high, 0.0)]
    corners += [(high + step, np.interp(high, x, head))] if high < length else []
    return tuple(np.array(corners + [(a, b) for a, b in zip(x, head) if a > high + step], dtype=float).T)


def pressure(name, heads, x, crack=0.0, in_crack=None, unit_weight=WATER, before=None, shaken=None, drains="past"):
    """[Pa] at distances x [m]; 0 outside the base."""
    corners = head_line(name, heads, crack, in_crack, before, shaken, drains)
    return unit_weight * np.interp(x, *corners, left=0.0, right=0.0)


def resultant(name, heads, crack=0.0, in_crack=None, unit_weight=WATER, before=None, shaken=None, drains="past"):
    """Force per metre of thickness [N/m] and its distance from the heel [m]; exact for the straight pieces."""
    x, head = head_line(name, heads, crack, in_crack, before, shaken, drains)
    step = np.diff(x)
    area = 0.5 * step * (head[:-1] + head[1:])
    moment = step * (x[:-1] * (2 * head[:-1] + head[1:]) + x[1:] * (head[:-1] + 2 * head[1:])) / 6
    total = area.sum()
    return unit_weight * total, (moment.sum() / total if total > 0 else 0.0)


def remarks(name, heads):
    """Lines an engineer must read beside the numbers of this rule."""
    rule, lines = rule_named(name), []
    if rule.status == CHECK:
        lines.append(_("Uplift rule {0} ({1}) is written from memory: to be checked by the user.", name, _(rule.source)))
    if name == "usbr" and heads.drain is not None and heads.drain > NEAR * heads.heel:
        lines.append(_("The drain is {0:.2f} m from the heel, beyond 5 % of the head there ({1:.2f} m): the rule is written for drains nearer than that.", heads.drain, heads.heel))
    if rule.at_drain is by_efficiency and heads.drain is not None and heads.drain_head is None and heads.efficiency > WITHOUT_PROOF:
        what = _("25 to 50 %, and 67 % where measurements verify it") if heads.efficiency <= VERIFIED else _("at most 67 %, where measurements verify it")
        lines.append(_("The drains have an efficiency of {0:.0f} %: USACE (EM 1110-2-2200, 3-3), as others quote it, takes {1}: to be checked by the user.", 100 * heads.efficiency, what))
    if name not in ("none", "linear") and heads.drain is None:
        lines.append(_("No drain was given: rule {0} is the straight line from heel to toe.", name))
    return lines
