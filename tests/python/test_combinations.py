"""Load combinations of guidelines: to which one a case belongs, what it lacks, which have no case."""

import os
import subprocess
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from quoin_tools.assess import assessment, combinations, danger_level, guidelines
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.base import scene as scenes
from quoin_tools.front import cases, new
from quoin_tools.mesh import blockmesh
from quoin_tools.show import annex, front_page, report

QUOIN = os.environ.get("QUOIN", str(Path(__file__).resolve().parents[2] / "build/quoin"))

LOADS = """
loads:
  weight: {type: self_weight}
  water: {type: reservoir, faces: upstream, level: 33}
  over: {type: overflow, faces: upstream, level: 35}
  tail: {type: tailwater, faces: downstream, level: 4}
  uplift: {type: uplift, faces: base, level: 33}
  drained: {type: uplift, faces: base, level: 33, drain: 4, tailwater: 3}
  ice: {type: ice, faces: upstream, level: 32, force: 1e5}
  quake: {type: pseudo_static, coefficient: [0.1, 0]}
  back: {type: pseudo_static, coefficient: [-0.1, 0]}
stages:
"""


def case_of(guideline, uplift=None, drain=None, **cases):
    """cases: name to (condition, loads)."""
    text = LOADS + "".join(f"  {name}: {{loads: [{', '.join(loads)}]}}\n" for name, (_, loads) in cases.items())
    return SimpleNamespace(scene=scenes.parse(text, "scene.yaml"), options=SimpleNamespace(guidelines=None, guideline=guideline, uplift=uplift, drain=drain, no_case={}), conditions={name: condition for name, (condition, _) in cases.items()})


@pytest.fixture(autouse=True)
def no_mesh(monkeypatch):
    """The way in which an earthquake pushes goes by the forces on a mesh."""
    monkeypatch.setattr(combinations, "is_reversed", lambda case, stage: "back" in case.scene.stage_loads(stage))


BARE, FULL, FLOOD = ["weight"], ["weight", "water", "uplift"], ["weight", "over", "tail", "uplift"]


@pytest.mark.parametrize("guideline, condition, loads, wanted, lacks", [
    ("usace", "unusual", BARE, ["1 construction"], []), ("usace", "usual", FULL, ["2 normal operating"], []), ("usace", "usual", [*FULL, "ice"], ["2 normal operating"], []),
    ("usace", "usual", ["weight", "water"], ["2 normal operating"], ["uplift"]), ("usace", "usual", BARE, [], []),
    ("usace", "unusual", FLOOD, ["3 flood discharge"], []), ("usace", "unusual", FULL, ["3 flood discharge"], ["tailwater"]), ("usace", "unusual", ["weight", "water", "drained"], ["3 flood discharge"], []),
    ("usace", "unusual", [*FULL, "ice"], [], []), ("usace", "earthquake", ["weight", "quake"], ["4 construction with OBE"], []),
    ("usace", "unusual", [*FULL, "quake"], ["5 normal operating with OBE"], []), ("usace", "earthquake", [*FULL, "quake"], ["6 normal operating with MCE"], []),
    ("usace", "extreme", FLOOD, ["7 probable maximum flood"], []), ("ferc", "unusual", [*FULL, "ice"], ["IIA ice"], []), ("ferc", "unusual", FLOOD, ["II flood discharge"], []),
    ("usbr", "extreme", FULL, ["drains out of work"], []), ("usbr", "extreme", ["weight", "water", "drained"], [], []), ("cadam", "after_earthquake", FULL, ["post-seismic"], []),
    ("ferc", "extreme", FLOOD, [], []), ("ferc", "extreme", [*FULL, "quake"], ["III earthquake"], []), ("ferc", "after_earthquake", FULL, ["III earthquake"], []),
    ("usace", "earthquake", [*FULL, "back"], [], []), ("usace", "unusual", [*FULL, "back"], [], []), ("usbr", "earthquake", [*FULL, "back"], ["extreme"], []),
])  # fmt: skip
def test_a_case_belongs(guideline, condition, loads, wanted, lacks):
    (row,), missing = combinations.of_cases(case_of(guideline, one=(condition, loads)))
    assert row[:2] == ("one", condition) and [one["name"] for one in row[2]] == wanted and row[3] == lacks
    everything = [one["name"] for one in guidelines.read()[guideline]["combinations"]]
    assert [one["name"] for one in missing] == [name for name in everything if name not in wanted or "back" in loads]  # a push against the water is not the case that is asked for


def test_the_state_after_an_earthquake_is_shaken():
    """A stage that comes of a shaken one belongs to FERC's case III, though no earthquake acts in it; a flood that does not has no combination."""
    case = case_of("ferc", full=("usual", FULL), shaken=("earthquake", [*FULL, "quake"]), after=("extreme", FULL))
    rows, _ = combinations.of_cases(case)
    assert [[one["name"] for one in mine] for _, _, mine, _ in rows] == [["I usual"], ["III earthquake"], ["III earthquake"]]
    assert combinations.none_belongs(case_of("ferc", flood=("extreme", FLOOD)), "flood", "extreme") and not combinations.none_belongs(case, "after", "extreme")


def test_uplift_of_the_options_counts():
    for uplift, drain, condition, wanted in (("usbr", 4.0, "usual", "usual"), ("usbr", None, "extreme", "drains out of work")):
        (row,), _ = combinations.of_cases(case_of("usbr", uplift, drain, one=(condition, ["weight", "water"])))
        assert [one["name"] for one in row[2]] == [wanted] and row[3] == []


def test_every_combination_can_be_met():
    """Each by a case with what it is to have and what it asks for; so none is in the shadow of another."""
    for name, guideline in guidelines.read().items():
        for one in guideline.get("combinations") or ():
            words = set(one["with"]) | set(one["asks"])
            for condition in one["conditions"]:
                assert one in combinations.closest(guideline["combinations"], condition, words), (name, one["name"], condition)


def test_what_the_sheet_says():
    case = case_of("usace", full=("usual", FULL), flood=("unusual", FULL), odd=("usual", BARE))
    part = annex.combinations_part(case)
    assert "<td>full</td><td>usual</td><td>2 normal operating</td><td>-</td>" in part
    assert "<td>flood</td><td>unusual</td><td>3 flood discharge</td><td>tailwater</td>" in part and "section 4-1; not held against the document, from memory" in part
    assert ">none<" in part and part.index("Without a case") < part.index("7 probable maximum flood")
    assert combinations.judged_as(case) == {"full": "usual: 2 normal operating", "flood": "unusual: 3 flood discharge", "odd": "usual"}


def test_none_is_told():
    case = case_of("npb", full=("usual", FULL))
    assert combinations.of_cases(case) == (None, None) and "not filled in" in annex.combinations_part(case)
    assert annex.combinations_part(case_of(None, full=("usual", FULL))) == ""


@pytest.mark.parametrize("change, said", [
    (("with: [water], without", "with: [wind], without"), "'wind' is not one of ['water'"), (("conditions: [usual]", "conditions: [normal]"), "'normal' is not one of"),
    (('name: "2 normal operating", ', 'name: "", '), "name: ''"),
])  # fmt: skip
def test_a_file_that_is_wrong(tmp_path, change, said):
    with open(guidelines.PATH, encoding="utf-8") as file:
        text = file.read()
    assert change[0] in text
    (tmp_path / "g.yaml").write_text(text.replace(*change), encoding="utf-8")
    with pytest.raises(guidelines.GuidelineError, match="combinations") as error:
        guidelines.read(str(tmp_path / "g.yaml"))
    assert said in str(error.value)


ALL = {"pool": 39, "flood": 41.5, "tailwater": 4, "silt": 9, "ice": 150e3, "drain": 4, "efficiency": 0.5, "obe": 0.05, "quake": 0.1}
LAST = {"after_earthquake": "III earthquake", "construction": "construction", "unusual": "unusual", "post_seismic": "post-seismic", "flood_drains_out_of_work": "F flood, drains out of work"}  # some stages by hand


def of_new(guideline, **numbers):
    """The cases that quoin new writes, as a case of the sheet."""
    loads, stages, usual = cases.of_guideline(guideline, cases.Numbers(42, **numbers))
    text = "\n".join(["loads:", *loads, "stages:", "  - empty: {loads: [weight]}", *stages])
    scene = scenes.parse(text, "scene.yaml")
    judged = {name: scene.condition(name) for name in scene.stages if scene.condition(name) not in (None, "none")}
    options = SimpleNamespace(guidelines=None, guideline=guideline, uplift=None, drain=None, no_case={})
    return SimpleNamespace(scene=scene, options=options, conditions=judged), usual, text


@pytest.mark.parametrize("guideline", [name for name, one in guidelines.read().items() if one["combinations"]])
def test_quoin_new_writes_the_cases_of_a_guideline(guideline):
    """With all numbers every combination has its case, which the sheet finds again by its loads and misses nothing in; the usual one is the first."""
    fixed = guidelines.read()[guideline].get("uplift") == "usbr"  # the efficiency of drains
    case, usual, text = of_new(guideline, **ALL | ({"efficiency": None} if fixed else {}))
    rows, missing = combinations.of_cases(case)
    assert missing == [] and "missing" not in text and rows[0][:2] == (usual.name, "usual")
    for stage, _condition, mine, lacks in rows:
        assert mine and lacks == [], (stage, mine, lacks)
        if stage in LAST:
            assert any(one["name"].endswith(LAST[stage]) for one in mine)


def test_what_is_missing_stands_as_a_comment():
    case, _, text = of_new("usace")
    assert list(case.scene.stages) == ["empty", "normal_operating", "construction"]
    assert "# - flood_discharge: as unusual; missing: --flood, --tailwater" in text and "# - normal_operating_with_mce: as earthquake; missing: --quake" in text
    with pytest.raises(guidelines.GuidelineError, match="--efficiency of the drains is missing"):
        of_new("usace", drain=4)
    with pytest.raises(guidelines.GuidelineError, match="--ice: it needs a face behind it"):
        of_new("usace", ice=1e5)
    with pytest.raises(guidelines.GuidelineError, match="to be filled in; those there are: usbr, usace"):
        of_new("npb")


@pytest.mark.parametrize(("numbers", "said"), [({"quake": -0.1}, "--quake: -0.1: expected above 0"), ({"obe": 15}, "--obe: 15: "), ({"pool": 43}, "--pool: 43: "), ({"pool": 30, "flood": 29}, "--flood: 29: expected not below the pool, 30"),
                                               ({"pool": 30, "tailwater": 31}, "--tailwater: 31: "), ({"silt": 43}, "--silt: 43: "), ({"pool": 30, "ice": -1e5}, "--ice: -100000: ")])  # fmt: skip
def test_numbers_that_make_another_case_are_refused(numbers, said):
    """An earthquake that pushes against the water, or a flood below the pool, would pass under a name that promises more."""
    with pytest.raises(guidelines.GuidelineError, match=said):
        of_new("usace", **numbers)


@pytest.mark.parametrize("guideline", [name for name, one in guidelines.read().items() if one["combinations"]])
def test_an_earthquake_starts_from_its_own_water(guideline):
    """The crack at rest is that of the stage before: it has the uplift of the case, drains out of work too."""
    fixed = guidelines.read()[guideline].get("uplift") == "usbr"
    case, _usual, _text = of_new(guideline, **ALL | ({"efficiency": None} if fixed else {}))
    shaken = [name for name, stage in case.scene.stages.items() if {"obe", "quake"} & set(stage["loads"]) and not case.scene.is_design(name)]
    for name in shaken:
        start = case.scene.stages_before(name)[-1]
        under = [[load for load in case.scene.stages[stage]["loads"] if load.startswith("uplift")] for stage in (name, start)]
        assert under[0] == under[1] and not {"obe", "quake"} & set(case.scene.stages[start]["loads"]), name
    assert shaken


def test_rising_water_is_judged_by_the_flood_with_the_drains_of_the_stage():
    """IS 6512 allows 1.0 on friction where the drains are out of work, 1.5 where they work: 1.0 is no limit of a dam with drains."""
    case, usual, _ = of_new("is6512", **ALL)
    assert danger_level.condition_of(case, usual.name) == "unusual" and danger_level.condition_of(case, "flood_drains_out_of_work") == "extreme"
    case, usual, _ = of_new("usace", **ALL)
    assert danger_level.condition_of(case, usual.name) == "extreme"  # the ice of the usual case decides nothing


def test_water_in_joints_does_not_push():
    """A head is the water of joints alone: without a reservoir no case has its water."""
    text = "loads:\n  {}head: {{type: head, faces: upstream, level: 9}}\nstages:\n  - full: {{loads: [{}head]}}"
    for reservoir, name in (("pool: {type: reservoir, faces: upstream, level: 9}\n  ", "pool, "), ("", "")):
        case = SimpleNamespace(scene=scenes.parse(text.format(reservoir, name), "scene.yaml"), options=SimpleNamespace(guidelines=None, guideline="cadam", uplift=None, drain=None))
        assert combinations.none_belongs(case, "full", "usual") == (not reservoir)


def polygon_area(mesh, group):
    corners = mesh.vertices[mesh.blocks[mesh.block_group == mesh.group_names.index(group)]]
    x, y = corners[:, :, 0], corners[:, :, 1]
    return 0.5 * float(np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y))


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
def test_danger_level(tmp_path):
    """A dam with an upright face and friction alone, by hand: (W - rho g h B / 2) tan 45 = factor * rho g (h^2 - (h - 30)^2) / 2, the last term above the crest;
    the limit of a flood is 1.3, and at 1 it slides."""
    folder = tmp_path / "dam"
    assert new.main([str(folder), "--height", "30", "--batter", "0", "--columns", "4"]) == 0
    mesh = blockmesh.read(folder / "model.h5")
    subprocess.run([QUOIN, "-options_file", "scene.yaml", "-stages", "empty,full"], cwd=folder, check=True, capture_output=True)
    case = assessment.load_case(str(folder / "out"), options_from(parser("report", "").parse_args([str(folder / "out"), "--guideline", "cadam", "--given", "tests=without"])))
    found = danger_level.danger_level(case, assessment.assess(case)[0])
    base = next(a.base for a in assessment.assess(case)[0] if a.stage == "full")
    weight, rho_g = 2400 * 9.81 * polygon_area(mesh, "dam"), 9810.0

    def level(factor):
        h = np.linspace(20, 40, 200001)
        return float(h[(weight - rho_g * h * base.length / 2 < factor * rho_g * (h**2 - np.maximum(h - 30, 0) ** 2) / 2).argmax()])

    assert (found.stage, found.base, found.start, found.condition, found.missing.quantity) == ("full", "base", 30, "extreme", "sliding_peak")
    assert found.broken == pytest.approx(level(1.3), abs=2 * danger_level.FINE) and found.fails == pytest.approx(level(1.0), abs=2 * danger_level.FINE)
    words = front_page.danger_words(case, assessment.assess(case)[0])
    assert "by the gravity method" in words and "limits are broken below that level" not in words  # the level is below the water of the usual case
    lower = assessment.load_case(str(folder / "out"), options_from(parser("report", "").parse_args([str(folder / "out"), "--guideline", "usbr"])))
    words = front_page.danger_words(lower, assessment.assess(lower)[0])  # 3.00 of the usual case is broken at 30 m, 1.00 of the extreme one later
    assert f"from {level(1.0):.2f} m on" in words and "limits are broken below that level in full, by the condition and loads of the case or in the block model" in words
    case.options.conditions = {"empty": "usual"}  # no water, which every usual combination has
    empty = next(a for a in assessment.assess(case)[0] if a.stage == "empty")
    assert not empty.complete and any(note.startswith("No load combination of this guideline that is usual has the loads") for note in empty.notes)


def test_loads_that_exclude_each_other():
    """IS 6512 has no ice in an earthquake, and USACE none in a flood; a case without the water that a combination asks for excludes nothing."""
    full = ("weight", "water", "drained", "tail")
    case = case_of("is6512", a=("earthquake", (*full, "ice", "quake")), b=("earthquake", (*full, "quake")), c=("usual", (*full, "ice")), d=("usual", ("weight",)))
    case.forces = lambda stage: ({"water": np.array([1.0, 0, 0]), "quake": np.array([1.0, 0, 0])}, [])
    assert [combinations.excluded(case, stage, condition) for stage, condition in case.conditions.items()] == [["ice"], [], [], []]
    case = case_of("usace", a=("extreme", (*full, "ice")), b=("usual", (*full, "ice")))
    assert [combinations.excluded(case, stage, condition) for stage, condition in case.conditions.items()] == [["ice"], []]


def test_a_combination_without_a_case_is_wanting_until_it_is_said_why():
    case = case_of("ferc", one=("usual", FULL), two=("unusual", FLOOD))
    assert [one["name"] for one in combinations.wanting(case)] == ["IIA ice", "III earthquake"]
    case.options.no_case = {"IIA ice": "no ice at this site"}
    combinations.check(case)
    assert [one["name"] for one in combinations.wanting(case)] == ["III earthquake"]
    case.options.no_case["I usual"] = "forgotten"
    with pytest.raises(guidelines.GuidelineError, match="'I usual' has a case"):
        combinations.check(case)
    assert combinations.wanting(case_of("npb", one=("usual", FULL))) == []  # its combinations are not known


def test_the_sheet_of_one_case(tmp_path, capsys):
    """A flat dam that keeps all limits of cadam in its one case passes once it is said why there are no others; page 1 repeats it."""
    folder = tmp_path / "dam"
    assert new.main([str(folder), "--height", "20", "--slope", "1.2", "--columns", "4"]) == 0
    subprocess.run([QUOIN, "-options_file", "scene.yaml", "-stages", "empty,full", "-joints_base_friction", "60"], cwd=folder, check=True, capture_output=True)
    words = [str(folder / "out"), "--guideline", "cadam", "--given", "tests=without", "--strength", "20e6", "--condition", "full=usual"]
    excused = [word for name in ("unusual", "flood", "seismic", "post-seismic") for word in ("--no-case", f"{name}=none <here>")]
    pages = []
    for more in ([], excused):
        assert report.main([*words, *more]) == 0
        pages.append((folder / "out" / "report.html").read_text(encoding="utf-8"))
    assert "<b>INCOMPLETE</b>" in pages[0] and "4 load combinations of the guideline have no case" in pages[0] and "without a case: unusual, flood, seismic, post-seismic. --no-case" in pages[0]
    assert "<b>PASS</b>" in pages[1] and "Said not to concern this dam: unusual (none &lt;here&gt;); flood" in pages[1] and "has no case" not in pages[1]
    for name, said in (("usual", "has a case in this run"), ("ice", "no load combination 'ice', there are: usual")):
        assert report.main([*words, "--no-case", f"{name}=x"]) == 2 and said in capsys.readouterr().err
