"""Levels and strengths of limit analysis: the place where bodies begin to stand is closed in by few trials, whatever what is missing looks like before it. Solvers of its programmes: both
agree, a solution that does not hold is none, and a signal stops them."""

import math
import re
import signal
import threading
import time
from types import SimpleNamespace

import assemblies
import numpy as np
import pytest
import scipy
from quoin_tools.base import solver
from quoin_tools.limit import LimitError, bounds, path, program, solvers
from quoin_tools.limit.beside import Beside
from quoin_tools.limit.both import Ends, Way
from quoin_tools.limit.bounds import STANDS, Trials, closed_in
from quoin_tools.limit.standing import Standing
from quoin_tools.mesh import blockmesh, voronoi
from quoin_tools.show import limit_both

SHAPES = {  # what is missing, and where it falls to STANDS
    "straight": (lambda x: max(0.0, 1 - x), 1 - STANDS, 10),
    "two mechanisms": (lambda x: max(0.0, 1 - x) + max(0.0, 0.3 - x) * 100, 1 - STANDS, 11),
    "touches": (lambda x: max(0.0, 1 - x) ** 3, 1 - STANDS ** (1 / 3), 35),
    "steep at its end": (lambda x: max(0.0, 1 - x) ** 0.3, 1.0, 35),
    "a step": (lambda x: 5.0 if x < 1 else 0.0, 1.0, 35),
    "flat": (lambda x: math.exp(-40 * x), -math.log(STANDS) / 40, 35),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("fails, stands, up", [(0.0, 45.0, 1), (0.0, 1.01, 1), (2.0, -45.0, -1)])
def test_closed_in(shape, fails, stands, up):
    """From below and from above, as a strength and a level; no more trials than a third more than halving takes, and far fewer where it is straight."""
    missing, place, most = SHAPES[shape]
    asked = {}

    def trial(value):
        x = value if up > 0 else 2 - value
        asked[value] = SimpleNamespace(short=missing(x), slope=up * (missing(x + 1e-8) - missing(x - 1e-8)) / 2e-8)
        return asked[value]

    low, high = closed_in(trial, fails, stands, 4.5e-6)
    place = place if up > 0 else 2 - place
    assert min(low, high) - 1e-9 <= place <= max(low, high) + 1e-9 and abs(high - low) <= 4.5e-6
    assert missing(low if up > 0 else 2 - low) > STANDS >= missing(high if up > 0 else 2 - high)
    assert len(asked) <= most


@pytest.mark.parametrize("friction", [0.2, 0.6])
def test_clarabel_and_highs_agree(monkeypatch, friction):
    """Factor and strength of an arch of 24 stones, each by one of the two alone; 0.2: it slides."""
    mesh, keys = assemblies.arch(24, friction)
    scene, found = assemblies.scene_of(keys), {}
    for name, hidden in (("Clarabel", {"WAYS": (), "SMALL": 0}), ("HiGHS", {"clarabel": None})):
        with monkeypatch.context() as only:
            for key, value in hidden.items():
                only.setattr(solvers, key, value)
            factor = bounds.bound(mesh, scene, "push")
            parts, loads = factor.parts, sum(factor.loads.values())
            short = program.missing(parts, loads, ("friction", 3.0, None), (loads, ("friction", 3.0 + 1e-6, None)))
            found[name] = [factor.value, short.short, short.slope / 1e-6]
    assert found["Clarabel"][:2] == pytest.approx(found["HiGHS"][:2], rel=1e-6)
    lower, higher = (program.missing(parts, loads, ("friction", 3.0 + step, None)).short for step in (-1e-3, 1e-3))
    assert [slope for _, _, slope in found.values()] == pytest.approx(2 * [(higher - lower) / 2e-3], rel=1e-4)


@pytest.mark.parametrize("hidden, above", [({}, 1e-8), ({"clarabel": None}, 2e-3)])
def test_cones_and_tangents(monkeypatch, hidden, above):
    """A toe that is crushed, and a bar with its dowel, by hand: Clarabel, which takes cones, is exact; HiGHS cuts with tangents from outside."""
    for key, value in hidden.items():
        monkeypatch.setattr(solvers, key, value)
    mesh, keys = assemblies.dam(math.tan(math.radians(80)), lifts=1)
    keys["joints"]["default"]["compression"] = 2e6
    weight, thrust = 0.5 * 30 * 40 * 2300 * 9.81, 0.5 * 9810 * 40**2
    crushed = weight * (20 - weight / 2e6 / 2) / (thrust * 40 / 3)
    found = bounds.bound(mesh, assemblies.scene_of(keys), "push")
    assert -1e-8 <= found.value / crushed - 1 <= above
    for steel, strength in ((200.0, 150.0), (500.0, 60.0)):
        mesh, keys = assemblies.barred((1, 0), **{"yield": steel * 1e6, "dowel_stiffness": 1e8, "dowel_strength": strength * 1e3})
        pushed = 0.5 * 96 + math.hypot(0.5 * steel, strength)
        assert -1e-8 <= bounds.bound(mesh, assemblies.scene_of(keys), "push").value / pushed - 1 <= above
    parts, loads = found.parts, sum(times * found.loads[name] for name, times in (("weight", 1.0), ("push", found.value)))
    here, *beside = (program.missing(parts, loads, ("strength", left, None), (loads, ("strength", left + 1e-6, None))) for left in (0.2, 0.199, 0.201))
    assert here.short > 1e-3 and here.slope / 1e-6 == pytest.approx((beside[1].short - beside[0].short) / 2e-3, rel=1e-3)


def test_solutions_that_do_not_hold():
    """Least x of x >= 1: errors of x, of the dual, and of a dual that is right but for an unknown of 1e7."""
    asked = solvers.Standard(np.array([1.0, 0.0]), scipy.sparse.csc_matrix([[-1.0, 0.0]]), np.array([-1.0]), 0)
    for x, dual, why in (((1.0, 0.0), 1.0, ""), ((0.99, 0.0), 1.0, "strengths are missed by 1.0e-02"), ((1.0, 0.0), 0.99, "mechanism is missed by 1.0e-02"), ((2.0, 0.0), 1.0, "value is uncertain by 5.0e-01"),
                         ((1e7, 0.0), 1.0 - 1e-7, "value is uncertain by 1.0e+00")):  # fmt: skip
        done = solvers.checked(asked, solvers.Solution(solvers.SOLVED, "it", np.array(x), np.array([dual])))
        assert (done.status == solvers.SOLVED) == (not why) and why in done.why
    for level, status in ((4.5, solvers.SOLVED), (3.5, solvers.OPEN)):  # a value of 2, uncertain by 1: is it above the level?
        assert solvers.checked(asked, solvers.Solution(solvers.SOLVED, "it", np.array([2.0, 0.0]), np.array([1.0])), level).status == status


def test_a_search_stops_with_its_bracket(monkeypatch):
    monkeypatch.setattr(bounds, "LONG", 0.0)

    def solve(value):
        if value == 3:
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            solvers.in_thread(lambda: solvers.STOP.wait(20))
        return program.Missing(max(0.0, 1 - value), 0.0, None)

    before, told = signal.signal(signal.SIGALRM, signal.default_int_handler), []
    trials, began = Trials(solve, 1.0, lambda value: f"{value} m", told.append), time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt, match="stopped after 3 programmes: stands at 2 m, fails at 0.5 m"):
            for value in (0, 2, 0.5, 3):
                trials(value)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert time.monotonic() - began < 4 and told[0] == "1 programme: fails at 0 m" and not solvers.STOP.is_set()


def test_highs_stops(monkeypatch):
    """HiGHS, which answers no signal, computes in a process of its own, and that ends; what it says is what linprog says."""
    asked = solvers.Standard(np.array([1.0]), scipy.sparse.csc_matrix([[-1.0]]), np.array([-1.0]), 0)
    monkeypatch.setattr(solvers, "SMALL", 0)
    assert solvers.checked(asked, solvers.by_highs(asked, solvers.SHARP)).value == 1.0
    monkeypatch.setattr(solvers, "BLINK", 1e-3)
    many = solvers.Standard(np.ones(20000), -scipy.sparse.eye(20000).tocsc(), -np.ones(20000), 0)  # more than a pipe holds
    assert solvers.checked(many, solvers.by_highs(many, solvers.SHARP)).value == 20000.0
    monkeypatch.setattr(solvers, "APART", "import time; time.sleep(60)")
    before, began, threads = signal.signal(signal.SIGALRM, signal.default_int_handler), time.monotonic(), threading.active_count()
    signal.setitimer(signal.ITIMER_REAL, 0.5)
    try:
        with pytest.raises(KeyboardInterrupt):
            solvers.in_thread(lambda: solvers.by_highs(asked, solvers.SHARP))
    finally:
        signal.signal(signal.SIGALRM, before)
    assert time.monotonic() - began < 4 and threading.active_count() <= threads + 1 and not solvers.STOP.is_set()
    monkeypatch.setattr(solvers, "APART", "import sys; sys.exit(3)")
    assert solvers.by_highs(asked, solvers.SHARP).status == solvers.OPEN


def test_a_long_search_says_so_first(monkeypatch):
    monkeypatch.setattr(bounds, "LONG", 0.0)
    mesh, keys = assemblies.dam(0.75)
    told = []
    keys["stages"] = [{"push": {"type": "strength_reduction", "loads": ["weight", "push"]}}]
    bounds.bound(mesh, assemblies.scene_of(keys), "push", watch=told.append)
    assert told[0].startswith("push: 5 joints, about ") and told[-1].endswith("degree")


@pytest.mark.parametrize("half, wedged", [(20, 2), (30, 0)])
def test_a_wedge_in_a_notch(monkeypatch, half, wedged):
    """Walls that lean by less than the angle of friction (26.6 degrees) hold the stone with forces of any size. By hand: what it takes to lift the stone and what rests on it, out of walls pressed by no more than PRESSED."""
    mesh, keys = assemblies.notch(half)
    keys["stages"] = [{"push": {"type": "load_factor", "loads": ["weight", "lift"], "raises": ["lift"]}}]
    depth, rests, tan = 1.0, 40e3, 0.5
    weight = 20e3 * depth * (0.4 + depth * math.tan(math.radians(half)))
    lean = math.radians(half)
    most = 2 * bounds.PRESSED * depth / math.cos(lean) * (tan * math.cos(lean) - math.sin(lean))
    for hidden in ({}, {"WAYS": (), "SMALL": 0}):
        with monkeypatch.context() as only:
            for key, value in hidden.items():
                only.setattr(solvers, key, value)
            found = bounds.bound(mesh, assemblies.scene_of(keys), "push")
        assert found.value == pytest.approx(math.inf if wedged else (weight + rests) / weight, rel=1e-8)
        assert [note.split(": ")[-1] for note in found.notes] == ([f"{(weight + rests + most) / weight:.6g}."] if wedged else [])
    parts, loads = found.parts, sum(found.loads.values())
    p = program.programme(parts, loads)
    asked = program.standard(p, -p.rows(loads), program.strengths_of(parts))
    done = solvers.by_wedges(asked, None)
    assert (program.wedged_contacts(p, asked, done) if done else 0) == wedged


def test_a_wedged_dam(monkeypatch, tmp_path):
    """A Voronoi dam at a friction of 60 degrees: the limit of the programme without its wedged rows, the same of a flood, that of a mean pressure of PRESSED, which is also what is told where the wedged rows are not found."""
    voronoi.main(["-o", str(tmp_path / "dam.h5"), "--seed", "3", "--square", "--side", "1.2", "--course", "1"])
    mesh = blockmesh.read(str(tmp_path / "dam.h5"))
    keys = assemblies.basic(2400, math.sqrt(3), {"push": {"type": "reservoir", "faces": "upstream", "level": 33}})
    keys |= {"materials": {group: {"density": 2400, "rigid": True} for group in mesh.group_names}, "supports": {"base": {"fix": "xy"}}}
    keys["loads"]["weight"] = {"type": "self_weight"}
    scene, began = assemblies.scene_of(keys), time.process_time()
    found = bounds.bound(mesh, scene, "push")
    assert found.limit.wedged > 100 and found.limit.residual < 1e-9 and found.limit.gap < 1e-6
    note = found.notes[-1]
    keys["stages"] = [{"push": {"type": "flood", "loads": ["weight", "push"]}}]
    kept, told = bounds.Kept(), []
    monkeypatch.setattr(bounds, "LONG", 0.5)
    flood = bounds.bound(mesh, assemblies.scene_of(keys), "push", kept=kept, watch=told.append)  # without bounded forces there is no other way to this level: the water there times 1 is the limit
    loads = kept.forces(scene, "push", found.parts, None, flood.value - 33)
    assert flood.limit.wedged == found.limit.wedged and program.largest(found.parts, loads["weight"], loads["push"]).factor == pytest.approx(1, abs=2e-6)
    assert any("joints may be wedged" in sentence for sentence in told)
    monkeypatch.setattr(solvers, "wedged", lambda asked: np.zeros(len(asked.right), dtype=bool))
    monkeypatch.setattr(solvers, "WEDGES", solvers.Wedges())
    monkeypatch.setattr(solvers, "MANY", 0)
    pressed = bounds.bound(mesh, scene, "push")
    assert pressed.value < found.value and note.endswith(f"is: {pressed.value:.6g}.")
    assert pressed.notes[0].endswith("The bound is for a mean pressure of at most 100 MPa on each joint.")
    area = pressed.parts.contacts.length * pressed.parts.thickness
    assert (pressed.limit.normal.sum(axis=1) / area)[area > 0].max() == pytest.approx(bounds.PRESSED, rel=1e-6)
    assert time.process_time() - began < 20  # 280 s and no end before


def cracked_dam_stands(level, friction, times=1.0, height=26.0, base=20.0, crest=4.0):
    """Statics of assemblies.cracked_dam, its base cracked and uplift iterated; times: of the water on its face."""
    parts = (2300 * 9.81 * crest * height, base - crest / 2), (2300 * 9.81 * (base - crest) * height / 2, (base - crest) * 2 / 3)
    over, p, crack = max(level - height, 0.0), 9810 * level, 0.0
    thrust, turning = times * 9810 * (level**2 - over**2) / 2, times * 9810 * (level**3 / 6 - over**3 / 6 - over**2 / 2 * height)
    for _ in range(10000):
        normal = sum(weight for weight, _ in parts) - p * (base + crack) / 2
        arm = (sum(weight * arm for weight, arm in parts) - turning - p * crack * (base - crack / 2) - p * (base - crack) ** 2 / 3) / normal
        if normal <= 0 or arm <= 0:
            return False
        crack, before = max(0.0, base - 3 * arm), crack
        if abs(crack - before) < 1e-12:
            break
    return thrust <= friction * normal


@pytest.mark.parametrize("lifts", [1, 3])
@pytest.mark.parametrize("stage, first, fails, stands", [
    ({"type": "flood"}, 20.0, 40.0, lambda level: cracked_dam_stands(level, 2.0)),
    ({"type": "load_factor", "raises": ["push"]}, 0.0, 9.0, lambda times: cracked_dam_stands(20.0, 2.0, times)),
    ({"type": "strength_reduction", "what": "friction"}, 63.0, 1.0, lambda left: cracked_dam_stands(20.0, math.tan(math.radians(left)))),
])  # fmt: skip
def test_the_limit_with_water_in_the_crack(lifts, stage, first, fails, stands):
    """The bound has the joint closed; a sentence says what stands with the full head in the crack: by hand, which runs confirm (27.906 stands, 27.938 m fails at a friction of 60 degrees)."""
    for _ in range(60):
        middle = 0.5 * (first + fails)
        first, fails = (middle, fails) if stands(middle) else (first, middle)
    mesh, keys = assemblies.cracked_dam(2.0, stage, lifts)
    found = bounds.bound(mesh, assemblies.scene_of(keys), "push")
    note = next(note for note in found.notes if "full head in the crack" in note)
    assert float(re.search(r"limit is: ([0-9]+\.[0-9]+)", note)[1]) == pytest.approx(first, rel=5e-4)
    assert abs(found.value - first) > 1e-3 * first or stage["type"] == "strength_reduction"


def test_a_crack_that_runs_away():
    """Water to the crest on a base of 14.5 m: no level stands once the crack has water. How far a joint that bears tension opens is not followed."""
    mesh, keys = assemblies.cracked_dam(2.0, {"type": "flood"}, level=26.0, base=14.5)
    assert not cracked_dam_stands(26.0, 2.0, base=14.5)
    assert [note for note in bounds.bound(mesh, assemblies.scene_of(keys), "push").notes if note.endswith("nothing stands.")]
    keys["joints"]["default"] |= {"tension": 1e5, "cohesion": 1e6}
    assert [note for note in bounds.bound(mesh, assemblies.scene_of(keys), "push").notes if note.endswith("closed: with the crack less would be borne.")]


def test_a_second_search_that_is_stopped_tells_the_bound(monkeypatch):
    monkeypatch.setattr(bounds, "LONG", 0.0)
    monkeypatch.setattr(bounds, "limit_with_cracks", lambda *_: signal.raise_signal(signal.SIGINT))
    mesh, keys = assemblies.cracked_dam(2.0, {"type": "load_factor", "raises": ["push"]})
    told = []
    with pytest.raises(KeyboardInterrupt, match=r"stopped after the bound, [0-9.]+, with water in cracks"):
        bounds.bound(mesh, assemblies.scene_of(keys), "push", watch=told.append)
    assert told[-1].endswith("; once more, with water in cracks")


def test_bodies_that_need_no_strength():
    mesh, keys = assemblies.dam(0.75, cohesion=1e9, lifts=1)
    keys["stages"] = [{"push": {"type": "strength_reduction", "what": "friction", "loads": ["weight", "push"]}}]
    keys["joints"]["default"]["tension"] = 1e8
    assert bounds.bound(mesh, assemblies.scene_of(keys), "push").value == 0.0


HINGES = "The joints of the scene bear 0.34, the path of rigid blocks that are pressed over the length of their faces {0}: hinges take the difference, {1} %."
BOTH = "{0} stands at {1}, {2} fails at {3}: both are true, and no solver can close this part of the gap, {4} %."
CORNER, OWN = "A run with forces in the corners of the faces", "a run with the joints of the scene"


@pytest.mark.parametrize("runs, at_once, pressed, cohesion, said", [
    ({"corners": (0.395, 0.396), 1.0: (0.34, 0.342)}, None, (0.345, 0.346), 0.0, [HINGES.format(0.345, 1.2), BOTH.format(CORNER, 0.395, OWN, 0.342, 13), "Rigid blocks that are pressed over the length of their faces fail at 0.346: the way takes 12 % of it."]),
    ({"corners": (0.36, 0.361), 1.0: (0.34, 0.3405)}, None, (0.361, 0.362), 0.0, [HINGES.format(0.361, 5.2), BOTH.format(CORNER, 0.36, OWN, 0.3405, 4.9)]),  # hinges alone
    ({"corners": (0.36, 0.361), 1.0: (0.34, None)}, 0.39, None, 0.0, [BOTH.format("A run with forces in the corners whose loads come at once", 0.39, CORNER.replace("A", "a", 1), 0.361, 7.3), "Not decided beyond where they stand: a run with the joints of the scene."]),
    ({"corners": (0.36, 0.361), 1.0: (0.359, 0.3595), "as is": (0.34, 0.3405)}, None, (0.36, None), 1e4, [HINGES.format(0.36, 0.25).replace("0.34,", "0.359,"), BOTH.format(CORNER, 0.36, "the run as the scene is, with its own method,", 0.3405, 4.9),
     "Runs may lose cohesion and tension, as the scene says; paths and bound keep them."]),
    ({"corners": (0.34, 0.3405), 1.0: (0.34, 0.3405)}, None, (0.34, None), 0.0, [HINGES.format(0.34, 0), "No run has been found that stands where another one fails."]),
])  # fmt: skip
def test_why_both_ends_are_far_apart(runs, at_once, pressed, cohesion, said):
    """Ends of 0.34 and 0.4: the sentences have the runs that stand and fail, what hinges take, and the way."""
    raised = SimpleNamespace(gap=lambda one, other: (other - one) / 0.4, value=lambda measure: measure, bound=0.5)
    strengths = {"default": SimpleNamespace(cohesion=cohesion, tension=0.0)}
    answer = SimpleNamespace(kind="load_factor", unit="-", parts=SimpleNamespace(strengths=lambda: strengths))
    runs = {what: Standing(*ends, 1e-7) for what, ends in runs.items()}
    ways = [Way(1.0, 17, 0.0, *pressed, None)] if pressed else []
    ends = Ends(answer, raised, ways, runs, at_once and Standing(at_once, None, 1e-7), 0.34, 0.36, 0.4)
    sentences = limit_both.wide(ends)
    assert sentences[0] == "THE GAP IS LARGER THAN 3 %: 15 %, 10 % of it between the least and the most that blocks bear whose hinges stand at edges."
    assert sentences[1:] == said


@pytest.mark.parametrize("limit, longest, near, most", [(0.6172, 1.0, math.inf, 4), (0.6172, 1.0, 0.618, 2), (0.6172, 0.01, math.inf, 8), (2.0, 1.0, 0.9, 0)])
def test_a_path_finds_its_end_with_few_trials_that_fail(limit, longest, near, most):
    """Blocks that stand up to a limit, in steps that are not too long: where a long step fails, short ones go on to the limit and past that failure."""
    failed = []

    def trial(share, state):
        stands = share <= limit and share - state <= longest
        failed.extend([] if stands else [share])
        return stands, share if stands else state, share

    end = path.follow(SimpleNamespace(trial=trial, start=0.0), lambda share: share, near=near)
    assert len(failed) <= most
    if limit > 1:  # nothing stands beyond 1
        assert end.fails is None and end.stands == pytest.approx(1, abs=path.FINE)
    else:
        assert end.stands <= limit < end.fails <= end.stands + 1.01 * path.FINE
        assert len(end.motions) == sum(share > limit for share in failed)


def test_runs_beside_the_main_thread():
    with Beside(1) as side:
        with side.turn():  # the only processor
            begun = [side.begin(lambda running, i=i: solver.run(["true"], running=running).returncode + i) for i in range(3)]
            time.sleep(0.2)
            assert not any(one.done() for one in begun)
        assert [one.result() for one in begun] == [0, 1, 2]


@pytest.mark.parametrize("error", [LimitError, KeyboardInterrupt])
def test_what_leaves_runs_ends_them(error):
    began, ended = time.monotonic(), []

    def sleeps(running):
        ended.append(solver.run(["sleep", "60"], running=running).returncode)

    with pytest.raises(error), Beside(2) as side:
        begun = [side.begin(sleeps) for _ in range(3)]
        while len(side.running) < 2:
            time.sleep(0.01)
        raise error
    assert time.monotonic() - began < 8
    assert all(code < 0 for code in ended) and len(ended) == 2  # the third did not begin
    assert all(one.done() for one in begun) and not solver.RUNNING
