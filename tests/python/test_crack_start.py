"""Where a crack starts by the criterion of a guideline, and the water in it, by hand: a wall of 20 m by 24 m; then sheet and check of a run."""

import subprocess
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from quoin_tools.assess import assessment, crack_notes, crack_start, guidelines
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.assess.gravity import Base, Uplift, about_drain, hand_method
from quoin_tools.assess.uplift import Heads, head_line
from quoin_tools.front import new, running
from quoin_tools.front.main import main
from test_combinations import QUOIN

B, W, H, DRAIN, E = 20.0, 9810.0, 30.0, 2.0, 0.5  # [m], [N/m3]
WEIGHT, ARM, THRUST = 7.5e6, 6.1, W * H**2 / 2  # [N/m], and where it presses, from the heel [m]
HEAD = (1 - E) * H * (B - DRAIN) / B  # at the drain, which is farther than 5 % of the head


def forces():
    """(X, Y, M) on the part above, about the heel at the origin."""
    return np.array([THRUST, -WEIGHT, -WEIGHT * ARM - THRUST * H / 3])


def stress_at_heel(N, arm):
    """[Pa] compression at the heel of a straight line: N at a distance arm from it."""
    return N / B * (1 + 6 * (B / 2 - arm) / B)


def without_uplift():
    return stress_at_heel(WEIGHT, ARM + THRUST * H / 3 / WEIGHT)


def with_uplift():
    near, far = (H + HEAD) / 2 * DRAIN, HEAD / 2 * (B - DRAIN)
    x = DRAIN / 3 * (H + 2 * HEAD) / (H + HEAD), DRAIN + (B - DRAIN) / 3
    N = WEIGHT - W * (near + far)
    return stress_at_heel(N, (WEIGHT * ARM + THRUST * H / 3 - W * (near * x[0] + far * x[1])) / N)


def base_with(guideline, condition, tension):
    base = Base((0, 0), (B, 0))
    base.opens = crack_start.of(guidelines.read()[guideline], condition, {"tension": tension})
    return base


def water(**keys):
    return Uplift("usace", Heads(B, H, 0.0, DRAIN, E), **keys)


def test_the_numbers_are_between():
    """Compression without uplift at the heel, tension with it: a criterion decides."""
    assert 0.4 * W * H < without_uplift() < W * H and with_uplift() < 0
    assert (without_uplift(), with_uplift()) == pytest.approx((151.6e3, -23.5e3), rel=0.01)


@pytest.mark.parametrize("guideline, condition, tension, drain, closed, least", [
    ("usbr", "usual", 0.0, DRAIN, True, 0.4 * W * H), ("usbr", "usual", 0.0, None, False, W * H), ("usbr", "usual", 3 * (W * H - 140e3), None, True, W * H - (W * H - 140e3)),
    ("usbr", "unusual", 3 * (W * H - 140e3), None, True, W * H - 1.5 * (W * H - 140e3)), ("usbr", "unusual", 0.0, None, False, W * H), ("usbr", "extreme", 1e5, None, False, W * H - 1e5), ("usace", "usual", 1e9, DRAIN, False, 0.0),
])  # fmt: skip
def test_a_crack_starts(guideline, condition, tension, drain, closed, least):
    """Of USBR with f_t / 3, f_t / 2 and f_t, p 0.4 with drains and 1 without; of USACE with any tension."""
    base, own = base_with(guideline, condition, tension), Uplift("usace", Heads(B, H, 0.0, drain, E if drain else None))
    hand, cracked = hand_method(base, forces(), own), hand_method(replace(base, opens=None), forces(), own)
    assert hand.start[1] == pytest.approx(least, rel=1e-4, abs=1)
    assert hand.start[0] == pytest.approx(without_uplift() if guideline == "usbr" else with_uplift(), rel=1e-9)
    assert cracked.crack is None or cracked.crack > 0
    if closed:
        assert hand.crack == 0 and hand.closed_by > 0
        assert drain is None or hand.linear[0] == pytest.approx(-with_uplift())
    else:
        assert (hand.crack, hand.N, hand.refused, hand.closed_by) == (cracked.crack, cracked.N, cracked.refused, 0)


def test_a_base_in_compression_and_one_that_overturns():
    base = base_with("usbr", "extreme", 1e9)
    assert hand_method(base, np.array([1e5, -7e6, -7e7 - 1e5])).start is None
    assert hand_method(base, np.array([1e5, -7e6, -7e6 * 21])).refused
    assert hand_method(base, forces(), replace(water(), opened=1.0)).crack > 0  # what an earthquake has opened is open


def test_in_an_earthquake():
    """The earthquake opens a base whose heel has less compression than its criterion asks for; the crack at rest stays closed by its own."""
    quake = np.array([0.1 * WEIGHT, 0.0, -0.1 * WEIGHT * 8])
    for shaken in ("unchanged", "zero", "full"):
        own = water(shaken=shaken, before=0.0)
        hand, cracked = (hand_method(replace(base_with("usbr", "earthquake", tension), opens=opens), forces() + quake, own) for tension, opens in ((2e5, base_with("usbr", "earthquake", 2e5).opens), (0.0, None)))
        assert hand.start[0] == pytest.approx(stress_at_heel(WEIGHT, ARM + (THRUST * H / 3 + 0.1 * WEIGHT * 8) / WEIGHT)) and hand.start[1] == pytest.approx(0.4 * W * H - 2e5)
        assert hand.crack == 0 and cracked.crack != 0


@pytest.mark.parametrize("drains, crack, corners", [
    ("past", 1.0, [(0, H), (1, H), (DRAIN, (1 - E) * H * 18 / 19), (B, 0)]), ("past", 5.0, [(0, H), (5, H), (B, 0)]),
    ("lost", 0.0, [(0, H), (DRAIN, HEAD), (B, 0)]), ("lost", 1.0, [(0, H), (1, H), (B, 0)]),
    ("work", 1.0, [(0, H), (1, H), (DRAIN, (1 - E) * H * 18 / 19), (B, 0)]), ("work", 5.0, [(0, H), (DRAIN, H), (DRAIN, (1 - E) * H), (B, 0)]),
])  # fmt: skip
def test_drains_in_a_crack(drains, crack, corners):
    x, head = head_line("usace", Heads(B, H, 0.0, DRAIN, E), crack, drains=drains)
    assert np.column_stack([x, head]) == pytest.approx(np.array(corners), rel=1e-9, abs=1e-6)
    told = {("past", 5.0): "which is lost", ("lost", 1.0): "and the drain (2.00 m) is lost", ("work", 5.0): "which is assumed to work on"}.get((drains, crack))
    notes = about_drain(water(drains=drains), crack)
    assert len(notes) == bool(told) and (not told or told in notes[0])


# ---- a run

ROOT = Path(__file__).resolve().parents[2]
DAM = ["--height", "30", "--crest-width", "5", "--batter", "0", "--slope", "0.6", "--columns", "4"]
LOADS = """loads:
  weight: {type: self_weight, groups: [dam]}
  water: {type: reservoir, faces: upstream, level: 30}
  uplift: {type: uplift, faces: base, level: 30, rule: usbr, drain: 3, cracked: false}
  quake: {type: pseudo_static, coefficient: [0.12, 0], groups: [dam], faces: upstream, level: 30}
stages:
  - usual: {condition: usual, loads: [weight, water, uplift]}
  - quake: {from: usual, condition: earthquake, loads: [weight, water, uplift, quake]}
"""


@pytest.fixture(scope="module")
def dam(tmp_path_factory):
    folder = tmp_path_factory.mktemp("crack") / "dam"
    assert new.main([str(folder), *DAM]) == 0
    head = (folder / "scene.yaml").read_text().split("loads:")[0]
    (folder / "scene.yaml").write_text(head + LOADS)
    subprocess.run([QUOIN, "-options_file", "scene.yaml", "-output", "out"], cwd=folder, check=False, capture_output=True)
    return folder


def assessed(dam, *words):
    case = assessment.load_case(str(dam / "out"), options_from(parser("report", "").parse_args([str(dam / "out"), *words])))
    return {a.stage: a for a in assessment.assess(case)[0] if a.name == "base"}


def by_hand():
    """Compression at the heel without uplift in the usual stage, and length of the base."""
    crest, low = 5.0, 0.85 * 30
    length, rho = crest + 0.6 * low, 2400 * 9.81
    parts = (rho * crest * 30, crest / 2), (rho * 0.6 * low**2 / 2, crest + 0.6 * low / 3)
    N = sum(f for f, _ in parts)
    arm = (sum(f * x for f, x in parts) + W * 30**3 / 6) / N
    return N / length * (1 + 6 * (length / 2 - arm) / length), length


def test_the_sheet_says_what_decides(dam):
    stress, _length = by_hand()
    usual = assessed(dam, "--guideline", "usbr")["usual"]
    assert usual.hand.start == (pytest.approx(stress, rel=1e-6), pytest.approx(0.4 * W * 30))
    told = [note for note in usual.notes if "By the criterion of this guideline" in note]
    assert len(told) == 1 and f"compression without uplift {stress / 1e3:.1f} kPa, asked for at least 117.7 kPa" in told[0] and "quoted by Novak" in told[0]
    assert ("no crack starts" in told[0]) == (stress > 0.4 * W * 30) == (usual.hand.crack == 0)
    any_tension = assessed(dam, "--guideline", "cdsa", "--given", "tests=with")["usual"]
    assert any_tension.hand.crack > 0 and "Where a crack starts is to be filled in" in " ".join(any_tension.notes)


def test_the_sheet_says_where_the_water_of_the_run_is_another(dam):
    weak = assessed(dam, "--guideline", "usace", "--given", "tests=with")["usual"]
    assert not weak.complete and any(note.startswith("Uplift of the run in the crack: unchanged; this guideline asks for: full (") for note in weak.notes)
    quake = assessed(dam, "--guideline", "usbr")["quake"]
    assert any("Uplift of the run in the crack: unchanged; this guideline asks for: zero" in note for note in quake.notes)  # on the safe side
    quake = assessed(dam, "--guideline", "cdsa", "--given", "tests=with")["quake"]
    assert not quake.complete and any("depends on seismicity" in note for note in quake.notes)
    rule = assessed(dam, "--guideline", "cdsa", "--given", "tests=with", "--given", "seismicity=high", "--uplift", "usbr", "--drain", "3")["quake"]
    assert rule.water.shaken == "zero" and not any("depends on" in note for note in rule.notes)


def test_a_file_of_the_user(dam, tmp_path):
    entry = {"place": "note 3", "read": "document"}
    own = {"guidelines": {"ours": {"like": "cadam", "crack_start": {"usual": {"value": 1, **entry}}, "in_crack": {"at_rest": {"value": "full", "drains": "lost", **entry}, "earthquake": {"value": "full", **entry}}}}}
    (tmp_path / "g.yaml").write_text(yaml.safe_dump(own))
    words = ["--guideline", "ours", "--guidelines", str(tmp_path / "g.yaml"), "--given", "tests=with"]
    usual = assessed(dam, *words)["usual"]
    assert usual.hand.start[1] == 0 and usual.hand.crack > 0  # the joint has no tensile strength
    rule = assessed(dam, *words, "--uplift", "usbr", "--drain", "3")
    assert (rule["usual"].water.drains, rule["usual"].water.in_crack, rule["quake"].water.shaken) == ("lost", "full", "full")
    assert any("and the drain (3.00 m) is lost" in note or "no equilibrium" in note or "which is lost" in note for note in rule["usual"].notes)


@pytest.mark.parametrize("change, said", [
    ({"crack_start": {"usual": {"value": 2, "place": "x", "read": "memory"}}}, "crack_start.usual.value: 2 is greater than the maximum of 1"),
    ({"crack_start": {"usual": {"value": 1, "pressure": {"drained": 0.4}, "place": "x", "read": "memory"}}}, "'undrained' is a required property"),
    ({"crack_start": {"flood": {"value": 1, "place": "x", "read": "memory"}}}, "'flood' is not one of"), ({"crack_start": {"usual": {"value": 1, "read": "memory"}}}, "'place' is a required property"),
    ({"crack_start": {"usual": {"value": 1, "place": "x", "read": "quoted"}}}, "'quoted' is a required property"), ({"crack_start": {"usual": {"value": 1, "drains": "lost", "place": "x", "read": "memory"}}}, "'drains' is not one of"),
    ({"in_crack": {"at_rest": {"value": "zero", "place": "x", "read": "memory"}}}, "'zero' is not one of"), ({"in_crack": {"flood": {"value": "full"}}}, "'flood' was unexpected"),
    ({"in_crack": {"at_rest": {"value": "full", "drains": "half", "place": "x", "read": "memory"}}}, "'half' is not one of"),
    ({"in_crack": {"earthquake": {"value": {"low": "full"}, "by": "site", "place": "x", "read": "memory"}}}, "in_crack.earthquake.value: expected a word, or a word for choices of an input"),
    ({"after_earthquake": "closed"}, "'after_earthquake' was unexpected"),
])  # fmt: skip
def test_a_file_that_is_wrong(tmp_path, change, said):
    (tmp_path / "g.yaml").write_text(yaml.safe_dump({"guidelines": {"ours": {"like": "cadam", **change}}}))
    with pytest.raises(guidelines.GuidelineError) as error:
        guidelines.read(str(tmp_path / "g.yaml"))
    assert said in str(error.value) and "\n" not in str(error.value)


def test_check_says_where_the_scene_differs(dam, capsys, monkeypatch):
    monkeypatch.chdir(dam)
    assert running.check(["scene.yaml", "--guideline", "usace"]) == 0
    told = [line for line in capsys.readouterr().err.splitlines() if "loads.uplift" in line]
    assert [line.split("; guideline")[0].removeprefix("quoin: warning: scene.yaml: loads.uplift.") for line in told] == ["rule: usbr", "cracked: unchanged"]
    assert running.check(["scene.yaml", "--guideline", "npb"]) == 0
    assert "rule: usbr; guideline npb asks for npb" in capsys.readouterr().err
    for words, said in ((["--guideline", "x"], "no guideline 'x'"), (["--guideline"], "a value behind it is missing"), (["--guidelines", "f"], "--guideline names none")):
        assert main(["check", "scene.yaml", *words]) == 2
        told = capsys.readouterr()
        assert told.out == "" and len(told.err.splitlines()) == 1 and said in told.err


@pytest.mark.parametrize("name", ["usbr", "usace", "ferc", "is6512", "cadam"])
def test_new_writes_what_check_asks_for(name, tmp_path, capsys, monkeypatch):
    drained = ["--drain", "3"] + (["--efficiency", "0.4"] if guidelines.read()[name].get("uplift", "usace") in ("usace", "ferc") else [])
    assert new.main([str(tmp_path / "d"), "--height", "30", "--guideline", name, "--flood", "31", "--tailwater", "2", "--quake", "0.1", *drained]) == 0
    monkeypatch.chdir(tmp_path / "d")
    assert main(["import", "section.yaml", "-o", "model.h5"]) == 0
    capsys.readouterr()
    assert running.check(["scene.yaml", "--guideline", name]) == 0
    assert "guideline" not in capsys.readouterr().err
    text = (tmp_path / "d/scene.yaml").read_text()
    assert ("in_earthquake: zero" in text) == (name == "usbr") and ("in_earthquake: unchanged" in text) == (name in ("usace", "ferc"))


def test_states_of_service(tmp_path):
    """A file of the user with crack limits for each state of service (ELS): each case is held against those of its state, those of strength against the others."""
    text = yaml.safe_load((ROOT / "examples/guidelines/cfbr2012.yaml").read_text())
    limits = text["guidelines"]["cfbr"]["conditions"]
    for condition, crack in (("quasi_permanent", 0.01), ("frequent", 0.02), ("rare", 0.9)):
        limits[condition] = {"crack": {"value": crack, "place": "note 1", "read": "document"}}
    for condition in ("usual", "unusual", "extreme", "earthquake"):
        limits[condition] = {"sliding_partial": {"value": 1.0, "place": "note 1", "read": "document", "friction": 1.2, "cohesion": 3.0}}
    (tmp_path / "g.yaml").write_text(yaml.safe_dump(text))
    folder = tmp_path / "dam"
    assert new.main([str(folder), *DAM, "--guideline", "cfbr", "--guidelines", str(tmp_path / "g.yaml"), "--flood", "30", "--pool", "28", "--tailwater", "2", "--quake", "0.1"]) == 0
    scene = (folder / "scene.yaml").read_text()
    for stage, condition in (("els_quasi_permanent", "quasi_permanent"), ("els_frequent", "frequent"), ("els_rare", "rare"), ("rare", "unusual")):
        assert f"  - {stage}: {{from: operation, condition: {condition}, loads:" in scene
    assert "els_rare_design" not in scene and "rare_design" in scene
    subprocess.run([QUOIN, "-options_file", "scene.yaml", "-output", "out"], cwd=folder, check=False, capture_output=True)
    bases = assessed(folder, "--guideline", "cfbr", "--guidelines", str(tmp_path / "g.yaml"))
    crack = {stage: bases[stage].hand.crack / by_hand()[1] for stage in ("els_quasi_permanent", "els_frequent", "els_rare")}
    held = {stage: [(row.quantity, row.limit, row.verdict) for row in bases[stage].limits] for stage in bases if bases[stage].condition}
    for stage, limit in (("els_quasi_permanent", 0.01), ("els_frequent", 0.02), ("els_rare", 0.9)):
        worse = max(crack[stage], bases[stage].block["crack"] / by_hand()[1])
        assert held[stage] == [("crack", limit, "pass" if worse <= limit else "FAIL")], stage
    assert [verdict for rows in held.values() for *_, verdict in rows if verdict == "FAIL"] and held["els_rare"][0][2] == "pass"
    assert [quantity for quantity, *_ in held["rare"]] == ["sliding_partial"] and [quantity for quantity, *_ in held["operation"]] == ["sliding_partial"]


def test_a_crack_of_the_run_that_has_closed_again_counts(monkeypatch):
    """The run keeps a crack of the earthquake without water though its joint is closed at the end: a guideline that asks for the full head is not met."""
    asked = {"in_crack": {"earthquake": {"value": "full", "place": "p", "read": "document"}}}
    monkeypatch.setattr(crack_notes.guidelines, "of", lambda options: asked)
    water = SimpleNamespace(name="uplift", rule="usbr", before=0.0, shaken="zero", in_crack=None, heel="start")
    hand = SimpleNamespace(crack=0.0, crack_at="start", reached=0.0)
    for opened, weaker in ((0.25, True), (0.0, False)):
        facts = {"uplift": {"uplift": {"opened_by_earthquake": opened}}}
        case = SimpleNamespace(options=SimpleNamespace(given={}), results=SimpleNamespace(stage_summary=lambda stage, facts=facts: facts))
        found = SimpleNamespace(stage="shaken", scene_water=water, hand=hand, block={"crack": 0.0})
        assert crack_notes.of_water(case, found)[1] == weaker
