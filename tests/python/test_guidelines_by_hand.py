"""A hand calculation of each guideline and case, written apart: a dam with an upright face, its base cracked by statics, against the sheet's numbers.

Nothing here comes from the program but the runs: weights, thrusts, uplift diagrams, cracks and factors are formulas of textbooks.
"""

import math
import subprocess
from dataclasses import replace

import pytest
from quoin_tools.assess import assessment, guidelines, judgement
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.front import new
from test_combinations import QUOIN

H, CREST, SLOPE = 30.0, 5.0, 0.64  # [m], and horizontal per vertical below 0.85 H
POOL, FLOOD, TAIL = 28.0, 30.0, 3.0  # [m]
DRAIN, EFFICIENCY = 3.0, 0.4  # [m] from the heel
PHI, C, PHI_RESIDUAL = 45.0, 150e3, 40.0  # [degree], [Pa]
STRENGTH, K = 12e6, 0.12  # [Pa], k_h
W, CONCRETE = 9810.0, 2400 * 9.81  # [N/m3]
LOW = 0.85 * H
B = CREST + SLOPE * LOW

SCENE = f"""
loads:
  weight: {{type: self_weight, groups: [dam]}}
  water: {{type: reservoir, faces: upstream, level: {POOL}}}
  flood: {{type: reservoir, faces: upstream, level: {FLOOD}}}
  tail: {{type: tailwater, faces: downstream, level: {TAIL}}}
  drained: {{type: uplift, faces: base, level: {POOL}, rule: RULE, drain: {DRAIN}EFFICIENCY, cracked: true}}
  clogged: {{type: uplift, faces: base, level: {POOL}, rule: RULE, cracked: true}}
  raised: {{type: uplift, faces: base, level: {FLOOD}, tailwater: {TAIL}, rule: RULE, drain: {DRAIN}EFFICIENCY, cracked: true}}
  quake: {{type: pseudo_static, coefficient: [{K}, 0], groups: [dam], faces: upstream, level: {POOL}}}
stages:
  - usual: {{condition: usual, loads: [weight, water, drained]}}
  - clogged: {{from: usual, condition: unusual, loads: [weight, water, clogged]}}
  - flood: {{from: usual, condition: extreme, loads: [weight, flood, raised, tail]}}
  - quake: {{from: usual, condition: earthquake, loads: [weight, water, drained, quake]}}
  - after: {{from: quake, condition: after_earthquake, loads: [weight, water, drained]}}
"""
EFFICIENCIES = {"usace": f", efficiency: {EFFICIENCY}", "ferc": f", efficiency: {EFFICIENCY}", "usbr": ""}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A run for each rule of uplift."""
    folder = tmp_path_factory.mktemp("hand") / "dam"
    assert new.main([str(folder), "--height", str(H), "--crest-width", str(CREST), "--batter", "0", "--slope", str(SLOPE), "--columns", "4"]) == 0
    head = (folder / "scene.yaml").read_text().split("loads:")[0].replace("friction: 45}", f"friction: {PHI}, cohesion: {C}, friction_residual: {PHI_RESIDUAL}}}")
    for rule, efficiency in EFFICIENCIES.items():
        (folder / f"{rule}.yaml").write_text(head + SCENE.replace("RULE", rule).replace("EFFICIENCY", efficiency))
        subprocess.run([QUOIN, "-options_file", f"{rule}.yaml", "-output", rule], cwd=folder, check=False, capture_output=True)
    return folder


# ---- the hand calculation: forces per metre, moments about the heel, x along the base


def diagram(rule, head, toe, drained, crack):
    """[(x, head)]: full in a crack, then straight to what the drain leaves and to the toe; a drain that the crack has passed is lost."""
    if not drained or crack >= DRAIN:
        return [(0, head), (crack, head), (B, toe)]
    if rule == "usbr":
        at = toe + (head - toe) / 3
    else:
        at = toe + (1 - EFFICIENCY) * (head - toe) * (1 if DRAIN <= 0.05 * head else (B - DRAIN) / (B - crack))
    return [(0, head), (crack, head), (DRAIN, at), (B, toe)]


def summed(line):
    """Force and moment about the heel of a diagram, trapezium by trapezium."""
    force = moment = 0.0
    for (a, p), (b, q) in zip(line[:-1], line[1:]):
        force += W * (p + q) / 2 * (b - a)
        moment += W * (b - a) / 6 * (p * (2 * a + b) + q * (a + 2 * b))
    return force, moment


def crack_of(N, M):
    """Length of the crack at the heel, from the resultant at M / N, and whether it leaves the base."""
    x = M / N
    return max(0.0, B - 3 * (B - x)) if x > B / 2 else 0.0


def case_of(rule, stage, opened=0.0, held=None):
    """N, T, crack, uplift and the place of the resultant of a case. opened: crack that the earthquake before has left; held: uplift of the crack of this length, as in an earthquake."""
    level, toe, drained = (FLOOD, TAIL, True) if stage == "flood" else (POOL, 0.0, stage != "clogged")
    parts = [(CONCRETE * CREST * H, CREST / 2), (CONCRETE * SLOPE * LOW**2 / 2, CREST + SLOPE * LOW / 3), (W * SLOPE * toe**2 / 2, B - SLOPE * toe / 3)]
    V, M = sum(f for f, _ in parts), sum(f * x for f, x in parts)
    T = W * (level**2 - toe**2) / 2
    M += W * (level**3 - toe**3) / 6
    if stage == "quake":
        up = (CONCRETE * CREST * H, H / 2), (CONCRETE * SLOPE * LOW**2 / 2, LOW / 3)
        T += K * sum(f for f, _ in up) + 7 / 12 * K * W * level**2
        M += K * sum(f * y for f, y in up) + 7 / 12 * K * W * level**2 * 0.4 * level
    crack = 0.0
    for _ in range(400):
        line = diagram(rule, level, toe, drained, max(crack, opened) if held is None else held)
        if stage == "quake" and rule == "usbr" and crack > held:  # no pressure where the earthquake has opened the base
            line = [(x, h) for x, h in cut(line, held, crack)]
        U, m = summed(line)
        found = crack_of(V - U, M - m)
        if abs(found - crack) < 1e-12:
            break
        crack += 0.5 * (found - crack) if stage == "quake" and rule == "usbr" else found - crack
    return {"N": V - U, "T": T, "U": U, "x": (M - m) / (V - U), "crack": crack, "V": V}


def cut(line, low, high):
    """A diagram without pressure between two places."""
    def at(x):
        for (a, p), (b, q) in zip(line[:-1], line[1:]):
            if a <= x <= b and b > a:
                return p + (q - p) * (x - a) / (b - a)
        return 0.0

    return [*(row for row in line if row[0] <= low), (low, at(low)), (low, 0.0), (high, 0.0), (high, at(high)), *(row for row in line if row[0] > high)]


def numbers(rule, stage):
    """Quantity to number of a case, as a guideline asks for it."""
    still = case_of(rule, "usual")["crack"]
    shaken = case_of(rule, "quake", held=still)
    one = {"quake": shaken, "after": case_of(rule, "usual", opened=shaken["crack"])}.get(stage) or case_of(rule, stage)
    bears = B - max(one["crack"], shaken["crack"] if stage == "after" else 0.0)
    eccentric = one["x"] - B / 2
    friction = one["N"] * math.tan(math.radians(PHI)) / one["T"]
    longest = B - one["crack"]
    return {
        "sliding_peak": friction + C * bears / one["T"], "friction_only": friction,
        "sliding_residual": one["N"] * math.tan(math.radians(PHI_RESIDUAL)) / one["T"],
        "flotation": one["V"] / one["U"], "middle": 2 * abs(eccentric) / B,
        "strength": (2 * one["N"] / longest if one["crack"] > 0 else one["N"] / B * (1 + 6 * abs(eccentric) / B)) / STRENGTH,
        "tension": max(0.0, one["N"] / B * (6 * abs(eccentric) / B - 1)),
        "sliding_partial": lambda entry: friction / entry["friction"] + C * bears / one["T"] / entry["cohesion"],
    }  # fmt: skip


GUIDELINES = {"cadam": ("usace", ["tests=without"]), "usace": ("usace", ["tests=with"]), "usbr": ("usbr", []), "ferc": ("ferc", ["hazard=high"]), "cdsa": ("usace", ["tests=with"]), "is6512": ("usace", [])}


@pytest.mark.parametrize("name", GUIDELINES)
def test_by_hand(runs, name):
    """Every number that the guideline limits, in each of its cases, by the gravity method to 1e-4; what the sheet holds against the limit is the less favourable of it and the block model."""
    rule, given = GUIDELINES[name]
    words = [str(runs / rule), "--guideline", name, "--strength", str(STRENGTH), *(word for choice in given for word in ("--given", choice))]
    case = assessment.load_case(str(runs / rule), options_from(parser("report", "").parse_args(words)))
    found = [a for a in assessment.assess(case)[0] if a.name == "base"]
    held = 0
    for a in found:
        by_hand = numbers(rule, a.stage)
        alone = judgement.least_favourable(replace(a, block=None), STRENGTH, {})
        sheet = {limit.quantity: limit.value for limit in a.limits}
        for limit in guidelines.judge(guidelines.read()[name], a.condition, by_hand, case.options.given):
            own = alone[limit.quantity](limit.entry) if limit.quantity == "sliding_partial" else alone[limit.quantity]
            assert own == pytest.approx(limit.value, rel=1e-4, abs=1.0 if limit.quantity == "tension" else 1e-4), (a.stage, limit.quantity)
            worse = min if guidelines.QUANTITIES[limit.quantity][1] == "least" else max
            assert worse(sheet[limit.quantity], own) == sheet[limit.quantity], (a.stage, limit.quantity)
            held += 1
    assert held >= 4 and {a.stage for a in found} == {"usual", "clogged", "flood", "quake", "after"}
