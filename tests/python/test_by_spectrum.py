"""A design spectrum on the planes of a dam: rigid stones by hand, the coefficient as its rigid limit, the reservoir against closed forms, the first mode, the sheet."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from published import models
from quoin_tools.assess import assessment, by_spectrum, design_spectrum, fenves_chopra, guidelines, lifts, terminal
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.assess.compressible_water import Reservoir
from quoin_tools.assess.gravity import Base
from quoin_tools.base.results import Results
from quoin_tools.front import new
from quoin_tools.mesh import blockmesh
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed
from quoin_tools.show import report

ROOT = Path(__file__).resolve().parents[2]
QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
solver = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
G = 9.80665
EUROCODE = {"rule": "eurocode8", "type": 1, "ground": "A", "a_g": 0.2, "unit": "g"}
FLAT = {"rule": "table", "file": "flat.csv", "table_damping": 0.05, "unit": "g"}


def solved(folder, mesh, scene):
    blockmesh.write(str(folder / "model.h5"), mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump({"model": "model.h5"} | scene, sort_keys=False), encoding="utf-8")
    (folder / "flat.csv").write_text("0, 0.1\n10, 0.1\n")
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml", "-output", "."], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return folder


def designed(folder, keys):
    (folder / "spectrum.yaml").write_text(yaml.safe_dump(keys))
    return design_spectrum.read(str(folder / "spectrum.yaml"))


def studied(folder, keys, *words):
    case = assessment.load_case(str(folder), options_from(parser("report", "").parse_args([str(folder), *words])))
    found, _ = assessment.assess(case)
    stage = by_spectrum.state_at_rest(case)
    return by_spectrum.study(case, designed(folder, keys), found, lifts.sweep(case, stage, lifts.feet(case, [a for a in found if a.stage == stage]))[0] if stage else ())


def rows_of(study, way):
    return {row.plane: row for row in study.rows if row.way == way}


# ---- a column of rigid stones, whose modes and forces in joints are those of springs

N, WIDTH, HEIGHT, K_N, K_S, DENSITY = 4, 2.0, 1.5, 10e9, 3e9, 2400.0


def column():
    base = rectangle(0, -1, WIDTH, 1, 1, 1, group="base", rigid=True)
    return join([base, *(renamed(rectangle(0, i * HEIGHT, WIDTH, HEIGHT, 1, 1, group="dam", rigid=True), {}, {}) for i in range(N))])


@pytest.fixture(scope="module")
def stones(tmp_path_factory):
    scene = {"strain": "small", "materials": {"dam": {"density": DENSITY, "rigid": True}, "base": {"density": DENSITY, "rigid": True}},
             "joints": {"default": {"k_n": K_N, "k_s": K_S, "friction": 40, "cohesion": 1e5}}, "supports": {"base": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}},
             "stages": [{"free": {"type": "modes", "count": 3 * N}}, {"rest": {"loads": ["weight"]}}]}  # fmt: skip
    return solved(tmp_path_factory.mktemp("stones"), column(), scene)


def modes_by_hand():
    """(masses, springs of a joint, opening, sliding and turning of the joints (joint, 3, stones), squares of the frequencies, shapes of unit mass)."""
    m = DENSITY * WIDTH * HEIGHT
    mass, B = np.diag(np.tile([m, m, m * (WIDTH**2 + HEIGHT**2) / 12], N)), np.zeros((N, 3, 3 * N))
    for i in range(N):  # opening, sliding, turning of the joint below stone i
        for stone, sign, arm in ((i, 1, -HEIGHT / 2), (i - 1, -1, HEIGHT / 2)):
            if stone >= 0:
                B[i, :, 3 * stone:3 * stone + 3] += sign * np.array([[0, 1, 0], [1, 0, -arm], [0, 0, 1]])
    spring = np.diag([K_N * WIDTH, K_S * WIDTH, K_N * WIDTH**3 / 12])
    root = np.linalg.inv(np.linalg.cholesky(mass))
    square, vectors = np.linalg.eigh(root @ np.einsum("iak,ab,ibl->kl", B, spring, B) @ root.T)
    return mass, spring, B, square, root.T @ vectors


def by_hand(keys, folder):
    """(joint, 3): largest N, T, M in the joints, by the strain of their springs in every mode; CQC and the part that follows the ground written out."""
    (mass, spring, B, square, shapes), s, total = modes_by_hand(), designed(folder, keys), 0.0
    for axis, curve, ground in ((0, s.horizontal, s.ground), (1, s.vertical, s.ground_vertical)):
        r = np.tile(np.eye(3)[axis], N)
        amount = (shapes.T @ mass @ r) / square
        strain = np.einsum("ab,ibk,kn->nia", spring, B, shapes * amount)  # under 1 m/s2
        beyond = np.sqrt(np.maximum(curve(2 * np.pi / np.sqrt(square)) ** 2 - ground**2, 0))
        periodic = 0.0
        for a, wa in enumerate(np.sqrt(square)):
            for b, wb in enumerate(np.sqrt(square)):
                q = wb / wa
                rho = 8 * s.damping**2 * (1 + q) * q**1.5 / ((1 - q**2) ** 2 + 4 * s.damping**2 * q * (1 + q) ** 2)
                periodic = periodic + rho * beyond[a] * beyond[b] * strain[a] * strain[b]
        total = total + periodic + (ground * strain.sum(axis=0)) ** 2
    return np.sqrt(total)


@solver
@pytest.mark.parametrize("more", [{}, {"vertical": True, "damping": 0.02}])
def test_stones_by_hand(stones, more):
    study = studied(stones, EUROCODE | {"ground": "D"} | more)
    assert study.modes["sum_x"] == pytest.approx(1) and not study.with_water and not study.why
    rows = sorted(rows_of(study, "all modes").values(), key=lambda row: row.level)
    assert [row.level for row in rows] == pytest.approx(HEIGHT * np.arange(N))
    assert np.array([[row.N, row.T, row.M] for row in rows]) == pytest.approx(by_hand(EUROCODE | {"ground": "D"} | more, stones), rel=1e-6, abs=1e-4 * 9.81 * DENSITY)


@solver
def test_without_water_the_first_mode_and_the_rest_are_the_coefficient(stones):
    """f_1 with S_a = A, and f_sc, add up to what follows the ground: the rest has what the first mode has not. The foot has the root of the squares of both masses."""
    study, (mass, _spring, _B, square, shapes) = studied(stones, FLAT), modes_by_hand()
    assert study.first.lengthening == 1 and study.first.period == pytest.approx(2 * np.pi / np.sqrt(square[0]), rel=1e-6) and study.acceleration == pytest.approx(0.1 * G)
    f1, fsc = study.first.forces(study.acceleration, 1.0, 0.0), study.first.static(study.spectrum.ground, 1.0, 0.0, 1.0)
    assert f1 + fsc == pytest.approx(0.1 * G)
    foot = min(study.rows, key=lambda row: row.level).plane
    swings, whole = (shapes[:, 0] @ mass @ np.tile([1.0, 0, 0], N)) ** 2, N * DENSITY * WIDTH * HEIGHT
    assert [rows_of(study, way)[foot].T for way in ("first mode", "coefficient")] == pytest.approx([0.1 * G * np.hypot(swings, whole - swings), 0.1 * G * whole], rel=1e-6)


# ---- a wall that leans, rigid on its joint, with water

TALL, WET = 30.0, 28.0
STIFF = "First mode: dam and water swing at "  # near the reservoir's own frequency or faster


def wall(mirror=False):
    foot = -TALL * np.tan(np.radians(20))
    dam = renamed(quad_patch((foot, 0), (25, 0), (5, TALL), (0, TALL), 4, 6, group="dam", rigid=True), {"bottom": "bottom", "upstream": "left", "downstream": "right"})
    mesh = join([renamed(rectangle(-60, -10, 120, 10, group="rock", rigid=True), {"joint": "top"}), dam])
    if mirror:
        mesh.vertices[:, 0] *= -1
        mesh.blocks = mesh.blocks[:, ::-1].copy()
        mesh.face_sets = {name: np.array([[b, (2 - k) % 4] for b, k in rows]) for name, rows in mesh.face_sets.items()}
    return mesh


def of_wall(rule="westergaard", thickness=1.0):
    water = {"faces": "upstream", "level": WET}
    return {"strain": "small", "relaxation": {"tolerance": 1e-8}, "thickness": thickness, "materials": {name: {"density": 2400, "rigid": True} for name in ("dam", "rock")},
            "supports": {"rock": {"fix": "xy"}}, "joints": {"default": {"k_n": 10e9, "k_s": 10e9, "friction": 45}},
            "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", **water}, "hydro": {"type": "added_mass", "rule": rule, **water},
                      "quake": {"type": "pseudo_static", "coefficient": [0.1, 0], "groups": ["dam"], "rule": rule, **water}},
            "stages": [{"dry": {"type": "modes"}}, {"full": {"loads": ["weight", "water"]}}, {"wet": {"type": "modes", "loads": ["hydro"]}}, {"shaken": {"loads": ["weight", "water", "quake"]}}]}  # fmt: skip


@solver
@pytest.mark.parametrize("rule", ["westergaard", "zangar"])
def test_rigid_limit_is_the_pseudo_static_load(tmp_path, rule):
    """Where S_a is the acceleration of the ground, all modes have the forces of the run's own pseudo-static load, exactly."""
    folder = solved(tmp_path, wall(), of_wall(rule))
    study = studied(folder, FLAT | {"unit": "m/s2"}, "--condition", "full=usual")
    case = assessment.load_case(str(folder), options_from(parser("report", "").parse_args([str(folder)])))
    one, two = (next(a for a in assessment.assess(case)[0] if a.stage == stage) for stage in ("full", "shaken"))
    scale = 0.1 / (0.1 * 9.81)
    assert [line[:len(STIFF)] for line in study.why] == [STIFF]
    for way in ("coefficient", "all modes"):
        row = rows_of(study, way)[one.name]
        assert [row.T, row.M] == pytest.approx([scale * abs(two.hand.T - one.hand.T), scale * abs(two.hand.M - one.hand.M)], rel=1e-6)
    strong = studied(folder, {**FLAT, "unit": "m/s2"}, "--condition", "full=usual").rows[0]
    assert strong.factor < one.hand.sliding_factor(45) and strong.stands


@solver
def test_limits_are_those_of_the_pseudo_static_case(tmp_path):
    """Where S_a is the acceleration of the ground, a base is as far from its limits as in the run's own pseudo-static case, or by its free sign of N a little nearer."""
    scene = of_wall()
    scene["loads"]["back"] = scene["loads"]["quake"] | {"coefficient": [-0.1, 0]}
    scene["stages"].append({"back": {"loads": ["weight", "water", "back"]}})
    words = ("--guideline", "cadam", "--given", "tests=without", "--strength", "10e6", "--condition", "full=usual", "--condition", "shaken=earthquake", "--condition", "back=earthquake", "--strength-on", "lifts=50,3e4")
    folder = solved(tmp_path, wall(), scene)
    study = studied(folder, FLAT, *words)
    case = assessment.load_case(str(folder), options_from(parser("report", "").parse_args([str(folder), *words])))
    own = [{limit.quantity: limit for limit in a.limits} for a in assessment.assess(case)[0] if a.stage in ("shaken", "back")]
    for way in ("coefficient", "all modes"):
        (row,) = (row for row in rows_of(study, way).values() if row.is_base)
        held = {limit.quantity: limit for limit in row.limits}
        assert set(held) == set(own[0]) == {"sliding_peak", "sliding_residual", "middle", "flotation", "strength"} and all(limit.limit == own[0][name].limit for name, limit in held.items())
        assert held["strength"].value == pytest.approx(max(one["strength"].value for one in own), rel=0.02) and held["flotation"].value == np.inf
        least, middle = min(one["sliding_peak"].value for one in own), max(one["middle"].value for one in own)
        assert 0.97 * least < held["sliding_peak"].value == row.factor < 1.001 * least and 0.999 * middle < held["middle"].value < middle + 0.02
    swept = {stage: lifts.sweep(case, stage, lifts.feet(case, [a for a in assessment.assess(case)[0] if a.stage == stage]))[0] for stage in ("shaken", "back")}
    stresses = [{limit.quantity: limit.value for limit in lifts.judged(case, stage, found)} for stage, found in swept.items()]
    for way in ("coefficient", "all modes"):  # of the lifts the worst counts, by each limit
        worst = {limit.quantity: (row, limit) for row, limit in study.judged if row.way == way and not row.is_base}
        assert set(worst) == {"sliding_peak", *stresses[0]} and {"lift_strength", "lift_tension"} == set(stresses[0])
        for quantity in stresses[0]:
            assert worst[quantity][1].value == pytest.approx(max(one[quantity] for one in stresses), rel=0.05, abs=1e-4)
        least = min(lift.factor for found in swept.values() for lift in found)
        assert 0.95 * least < worst["sliding_peak"][1].value == min(row.factor for row in rows_of(study, way).values() if not row.is_base) < 1.001 * least
    for a_g, fails in ((1.0, True), (0.05, False)):  # page 1 names the limit and the way
        page = report.page(case, report.Shaken(case.results), None, designed(folder, EUROCODE | {"a_g": a_g, "reflection": 0.5}))[0]
        assert ("by a spectrum (coefficient) on" in page) == fails and ("<b>FAIL</b>" in page) == fails


OURS = """guidelines:
  ours:
    title: ours
    document: ours
    crack_start: {usual: {value: null, place: p, read: document}, earthquake: {value: %s, place: p, read: memory}}
    conditions:
      usual: {sliding_peak: {value: 1, place: p, read: document}}
      earthquake:
        sliding_partial: {value: 1, place: p, read: document, friction: 1.2, cohesion: 2.4%s}
        local_factor: {value: 1, place: p, read: document}
"""


@solver
def test_no_limit_is_passed_over(tmp_path):
    """Partial factors are held by a spectrum; what it has no number for, a condition without limits and a run without modes leave the sheet without a pass. A crack starts by the criterion
    of the spectrum's condition, not by that of the stage at rest; a base that it keeps closed has no PASS where it was not read in the document."""
    scene = of_wall()
    scene["joints"]["default"] |= {"cohesion": 2e5, "tension": 1e6}
    scene["stages"] = scene["stages"][:3]
    folder, file = solved(tmp_path, wall(), scene), tmp_path / "limits.yaml"
    words = ("--guideline", "ours", "--guidelines", str(file), "--condition", "full=usual")

    def judged(criterion="null", actions="", **keys):
        file.write_text(OURS % (criterion, actions))
        guidelines.read.cache_clear()
        study = studied(folder, EUROCODE | {"a_g": 0.45, "reflection": 0.5} | keys, *words)
        row = min(rows_of(study, "coefficient").values(), key=lambda row: row.level)
        return study, row, {limit.quantity: limit for limit in row.limits}

    _study, cracked, held = judged()
    assert cracked.crack > 0 and held["sliding_partial"].verdict in ("pass", "FAIL") and 1 / 2.4 < held["sliding_partial"].value / cracked.factor < 1 / 1.2
    assert held["local_factor"].verdict == guidelines.OPEN
    _study, closed, held = judged("1.0")
    assert closed.crack == 0 and held["sliding_partial"].verdict != guidelines.PASS
    assert judged(actions=", actions: {earthquake: 1.2}")[2]["sliding_partial"].verdict == guidelines.OPEN
    study, row, held = judged(condition="extreme")
    assert not held and "has no limits for the condition" in " ".join(study.unheld)
    page = report.page(assessment.load_case(str(folder), options_from(parser("report", "").parse_args([str(folder), *words]))), report.Shaken(Results(str(folder))), None, designed(folder, EUROCODE | {"condition": "extreme"}))[0]
    assert "Not all is judged by the spectrum: This guideline has no limits" in page and "<b>INCOMPLETE</b>" in page


@solver
def test_mirrored_and_thick(tmp_path):
    sizes = []
    for name, mesh, thickness in (("one", wall(), 1.0), ("mirrored", wall(True), 1.0), ("thick", wall(), 2.0)):
        (tmp_path / name).mkdir()
        study = studied(solved(tmp_path / name, mesh, of_wall(thickness=thickness)), EUROCODE | {"reflection": 0.5, "vertical": True}, "--condition", "full=usual")
        assert [line[:len(STIFF)] for line in study.why] == [STIFF] and study.first.lengthening > 1.005 and study.first.water_damping > 0
        sizes.append([[row.T / thickness, row.M / thickness, row.N / thickness, row.tension, row.factor or -1, study.first.period, study.first.damping] for row in study.rows])
    assert len(sizes[0]) == 3 * len({row.plane for row in study.rows})
    assert np.array(sizes[1]) == pytest.approx(np.array(sizes[0]), rel=1e-6) and np.array(sizes[2]) == pytest.approx(np.array(sizes[0]), rel=1e-6)


# ---- the reservoir

def test_westergaard_and_compressible_limit():
    """A rigid dam: the force 16/pi^3 sum (2n - 1)^-3 and the pressure 8/pi^2 times Catalan's number at the bottom; a face that moves with the water's own shape in closed form."""
    water = Reservoir(100.0)
    still = water.pressure(np.ones_like, 0.0)
    assert water.over_depth(still).real / 1e7 == pytest.approx(16 / np.pi**3 * 1.0517997902646, rel=2e-5) and still[0].real / 1e5 == pytest.approx(8 / np.pi**2 * 0.915965594177, rel=1e-4)
    for over in (0.3, 0.9, 1.2):  # of the water's own frequency: beyond it waves run off
        omega = over * water.cutoff
        square = (np.pi / 200) ** 2 - (omega / 1440) ** 2
        expected = 5e4 / np.sqrt(square) if square > 0 else 5e4 / (1j * np.sqrt(-square))
        assert water.added(lambda y: np.cos(np.pi * y / 200), omega) == pytest.approx(expected, rel=1e-6)


def by_elements(water, shape, omega, n):
    """Heights, pressures there, and pressures times shape, by linear elements over the depth: K v = kappa^2 M v with the damper of the bottom, all their waves added up."""
    h, y = water.depth / n, np.linspace(0, water.depth, n + 1)[:-1]  # p = 0 at the surface
    K = (np.diag(np.r_[1, 2 * np.ones(n - 1)]) - np.diag(np.ones(n - 1), 1) - np.diag(np.ones(n - 1), -1)) / h + 0j
    M = h / 6 * (np.diag(np.r_[2, 4 * np.ones(n - 1)]) + np.diag(np.ones(n - 1), 1) + np.diag(np.ones(n - 1), -1))
    load = M @ shape(y)
    load[-1] += h / 6 * shape(water.depth)
    A = K - (omega / water.sound) ** 2 * M
    A[0, 0] += 1j * omega / water.sound * (1 - water.reflection) / (1 + water.reflection)
    square, vectors = np.linalg.eig(np.linalg.solve(M, A))
    decay = np.sqrt(square)
    decay = np.where(decay.imag < -1e-9 * abs(decay), -decay, decay)
    amount = vectors.T @ load / np.einsum("in,ij,jn->n", vectors, M, vectors)
    p = water.density * vectors @ (amount / decay)
    return y, p, load @ p


@pytest.mark.parametrize("reflection", [1.0, 0.9, 0.5, 0.0])
def test_reservoir_by_finite_elements(reflection):
    water = Reservoir(80.0, 1020.0, 1450.0, reflection)
    def shape(y):
        return (y / 80) ** 2
    for over in (0.5, 0.95, 1.3):
        omega = over * water.cutoff
        y, p, swings = by_elements(water, shape, omega, 240)
        assert np.interp(y, water.grid, water.pressure(shape, omega).real) == pytest.approx(p.real, abs=2e-3 * abs(p).max())
        added = water.added(shape, omega)
        assert added == pytest.approx(swings, rel=3e-3, abs=1e-3) and added.imag <= 1e-6 * abs(added)


def pushes(mesh, phi, level):
    """int rho phi_x dA and int rho dA of the dam above a level between two rows of blocks, by 2 x 2 places in each block."""
    place, total = (-1 / np.sqrt(3), 1 / np.sqrt(3)), np.zeros(2)
    for block in mesh.blocks[(mesh.centres()[:, 1] > level) & (mesh.block_group == mesh.group_names.index("dam"))]:
        for s in place:
            for t in place:
                N = np.array([(1 - s) * (1 - t), (1 + s) * (1 - t), (1 + s) * (1 + t), (1 - s) * (1 + t)]) / 4
                dN = np.array([[t - 1, s - 1], [1 - t, -1 - s], [1 + t, 1 + s], [-1 - t, 1 - s]]) / 4
                total += 2400 * abs(np.linalg.det(mesh.vertices[block].T @ dN)) * np.array([N @ phi[block, 0], 1.0])
    return total


@solver
@pytest.mark.parametrize("level", [28.0, 12.0])
def test_shear_of_the_first_mode_by_hand(tmp_path, level):
    """Of the run only the shape, its frequency and its generalised mass: L by hand, pressures by finite elements, the root by bisection, S_a by (3.2); a full reservoir and one of less than half."""
    mesh, scene = wall(), of_wall()
    mesh.group_rigid[mesh.group_names.index("dam")] = 0
    scene["materials"]["dam"] = {"density": 2400, "young": 5e9, "poisson": 0.2}
    for name in ("water", "hydro"):
        scene["loads"][name]["level"] = level
    scene["stages"] = scene["stages"][:3]
    folder = solved(tmp_path, mesh, scene)
    study = studied(folder, EUROCODE | {"reflection": 0.6}, "--condition", "full=usual", "--lifts", "2")
    results = assessment.load_case(str(folder), options_from(parser("report", "").parse_args([str(folder)]))).results
    mode, phi = results.stage_summary("dry")["modes"]["list"][0], np.zeros_like(mesh.vertices)
    phi[results.mesh.vertex_file] = results.stage("dry").modes[0]
    face = np.unique(blockmesh.face_ends(mesh, mesh.face_sets["upstream"]))
    face = face[np.argsort(mesh.vertices[face, 1])]
    water, own, M, (L, _mass) = Reservoir(level, reflection=0.6), np.sqrt(mode["omega2"]), mode["modal_mass"], pushes(mesh, phi, 0)

    def shape(y):
        return np.interp(y, mesh.vertices[face, 1], phi[face, 0])

    low, high = 0.5 * own, own
    for _ in range(16):
        omega = (low + high) / 2
        low, high = (omega, high) if omega**2 * (M + by_elements(water, shape, omega, 100)[2].real) < own**2 * M else (low, omega)
    y, p, added = by_elements(water, shape, omega, 100)
    _, rigid, _ = by_elements(water, np.ones_like, 1e-9, 100)
    period, damping, ground = 2 * np.pi / omega, 0.05 * omega / own - added.imag / (2 * M * (own / omega) ** 2), 0.2 * G
    plateau = 2.5 * np.sqrt(10 / (5 + 100 * damping))
    S_a = ground * (1 + period / 0.15 * (plateau - 1) if period < 0.15 else plateau * min(1, 0.4 / period))

    def over(values, bottom, weight=np.ones_like):
        at, step = np.linspace(min(bottom, level), level, 2001, retstep=True)
        at = at[:-1] + step / 2
        return (np.interp(at, [*y, level], [*values.real, 0]) * weight(at)).sum() * step

    rows = rows_of(study, "first mode")
    assert sorted(row.level for row in rows.values()) == pytest.approx([0, 15])
    for row in rows.values():
        moved, mass = pushes(mesh, phi, row.level)
        f1 = (L + over(p, 0)) / (M + added.real) * S_a * (moved + over(p, row.level))
        fsc = ground * (mass + over(rigid, row.level) - (L + over(rigid, 0, shape)) / M * moved)
        assert row.T == pytest.approx(np.hypot(f1, fsc), rel=2e-3)


def test_first_mode_with_the_waters_own_shape():
    """A dam that swings with cos(pi y / 2H) has its added mass in closed form: R_r by bisection by hand, and no damping from a bottom that reflects."""
    water, mass, omega = Reservoir(100.0), 4e5, 20.0

    def added(w):
        return 5e4 / np.sqrt((np.pi / 200) ** 2 - (w / 1440) ** 2)

    low, high = 0.0, min(omega, water.cutoff * (1 - 1e-12))
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (low, middle) if middle**2 * (mass + added(middle)) > omega**2 * mass else (middle, high)
    first = fenves_chopra.first_mode(omega, mass, 6e5, lambda y: np.cos(np.pi * y / 200), water, 0.05, rock_period=1.2, rock_damping=0.06)
    assert first.lengthening == pytest.approx(omega / low, rel=1e-8) and first.water_damping == pytest.approx(0, abs=1e-12)
    assert first.period == pytest.approx(1.2 * 2 * np.pi / low) and first.damping == pytest.approx(0.05 / (omega / low * 1.2**3) + 0.06)
    assert first.mass == pytest.approx(mass + added(low), rel=1e-6)


def test_damping_of_the_bottom_is_that_of_the_peak():
    """xi_r against the width of the dam's own resonance: |1/(-w^2 (M + B) + w_1^2 M)| at half of its power."""
    water, mass, omega = Reservoir(110.0, reflection=0.6), 7.3e5, 20.0

    def shape(y):
        return (y / 120) ** 2

    first = fenves_chopra.first_mode(omega, mass, 1.8e6, shape, water, damping=1e-9)
    w = 2 * np.pi / first.period * np.linspace(0.9, 1.1, 101)
    peak = np.array([abs(1 / (-(f**2) * (mass + water.added(shape, f)) + omega**2 * mass)) for f in w])
    wide = w[peak > peak.max() / np.sqrt(2)]
    assert w[peak.argmax()] * first.period / (2 * np.pi) == pytest.approx(1, abs=0.01) and (wide[-1] - wide[0]) / (2 * w[peak.argmax()]) == pytest.approx(first.water_damping, rel=0.2)


@solver
def test_lifts_that_deform_by_their_springs(tmp_path):
    """Koyna in elastic lifts, with water: T and N of a mode by the springs of a joint, from displacements alone, are the inertia of blocks and water above; M too, but for lumped masses."""
    scene = {"plane": "strain", "strain": "small", "materials": {"dam": {"density": 2643, "young": 31e9, "poisson": 0.2}, "rock": {"density": 0, "rigid": True}},
             "joints": {"default": {"law": "elastic", "k_n": 1e12, "k_s": 4e11}, **{f"j{i}": {} for i in range(6)}}, "supports": {"rock": {"fix": "xy"}},
             "loads": {"hydro": {"type": "added_mass", "faces": "upstream", "level": 91.75}}, "stages": [{"wet": {"type": "modes", "count": 3, "loads": ["hydro"]}}]}  # fmt: skip
    folder = solved(tmp_path, models.koyna_lifts(6), scene)
    case = assessment.load_case(str(folder), options_from(parser("report", "").parse_args([str(folder)])))
    inertia, (mesh, level) = by_spectrum.Inertia(case, "wet"), (case.mesh, 44.0)
    assert not inertia.complaints()
    sides = []
    for blocks in (mesh.blocks[mesh.centres()[:, 1] > level], mesh.blocks[mesh.centres()[:, 1] < level]):
        v = np.unique(blocks[blocks >= 0])
        v = v[abs(mesh.vertices[v, 1] - level) < 1e-9]
        sides.append(v[np.argsort(mesh.vertices[v, 0])])
    x = mesh.vertices[sides[0], 0]
    base = Base((x[0], level), (x[-1], level))
    on = by_spectrum.vector(base, inertia.on(case.part("j2", np.array(base.ends()))))
    for k, mode in enumerate(inertia.modes):
        apart = (inertia.swing.phi[k, sides[0]] - inertia.swing.phi[k, sides[1]]) / mode["omega2"]
        arm, h = x - x.mean(), np.diff(x)
        mean = h @ (apart[:-1] + apart[1:]) / 2
        moment = (h * (2 * apart[:-1, 1] * arm[:-1] + 2 * apart[1:, 1] * arm[1:] + apart[:-1, 1] * arm[1:] + apart[1:, 1] * arm[:-1])).sum() / 6
        assert on[k, :2] == pytest.approx([-1e12 * mean[1], 4e11 * mean[0]], rel=1e-6)
        assert on[k, 2] == pytest.approx(1e12 * moment, rel=0.005 if k == 0 else 0.05)


@solver
def test_pine_flat(tmp_path):
    """Pine Flat with 116.88 m of water: finite elements of dam and water that can be compressed have 2.5267 Hz (Samii and Lotfi 2007) and 2.5966 Hz (Gorai and Maity 2020); first mode and all modes
    agree on T where the dam is thin."""
    scene = {"plane": "strain", "strain": "small", "materials": {"dam": {"density": 2480, "young": 22.75e9, "poisson": 0.2}}, "supports": {"base": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "upstream", "level": 116.88, "density": 981}, "hydro": {"type": "added_mass", "faces": "upstream", "level": 116.88, "density": 981}},
             "stages": [{"sw": {"loads": ["weight"]}}, {"dry": {"type": "modes", "count": 6}}, {"full": {"loads": ["weight", "water"]}}, {"wet": {"type": "modes", "count": 6, "loads": ["hydro"]}}]}  # fmt: skip
    study = studied(solved(tmp_path, models.pine_flat(12), scene), EUROCODE, "--condition", "full=usual")
    assert 2.5267 * 0.99 < 1 / study.first.period < 2.5966 * 1.01 and study.first.lengthening == pytest.approx(1.257, abs=0.01)
    one, every = (max(rows_of(study, way).values(), key=lambda row: row.level) for way in ("first mode", "all modes"))
    assert one.T == pytest.approx(every.T, rel=0.1) and one.tension == pytest.approx(every.tension, rel=0.05)


# ---- what is missing, the sheet

@solver
def test_what_is_missing_is_said(tmp_path):
    scene = of_wall()
    scene["stages"] = scene["stages"][1:2]
    assert "The run has no modes" in studied(solved(tmp_path, wall(), scene), EUROCODE).why[0]


@solver
def test_a_dam_stiffer_than_its_water(tmp_path):
    """Where the dam swings near the reservoir's own frequency, 1440/(4 28) Hz, or faster, the first mode hangs on the bottom: 1 % less of reflection takes two thirds of it or more. The study says so."""
    scene, least = of_wall(), []
    scene["joints"]["default"] |= {"k_n": 1e12, "k_s": 1e12}
    folder = solved(tmp_path, wall(), scene)
    for reflection in (1.0, 0.99):
        study = studied(folder, EUROCODE | {"reflection": reflection}, "--condition", "full=usual")
        least.append(next(row.T for row in study.rows if row.way == "first mode" and row.level == 0))
        (said,) = study.why
        assert f"({1440 / (4 * WET):.2f} Hz; reflection {reflection:.2f})" in said and "hold it against all modes" in said
    assert least[0] > 3 * least[1]


@solver
def test_only_dry_modes(tmp_path, monkeypatch):
    monkeypatch.setattr(by_spectrum.Inertia, "complaints", lambda inertia: ["odd"])
    scene = of_wall()
    scene["stages"] = scene["stages"][:2]
    study = studied(solved(tmp_path, wall(), scene), EUROCODE)
    assert any("No stage of modes has the water" in line for line in study.why) and study.first.lengthening > 1 and len(study.rows) % 3 == 0
    assert study.why.count("odd") == 1  # first mode and all modes are those of one stage


@solver
def test_rock_with_mass(tmp_path):
    """Rock that can move swings as a box: only the coefficient is shown, unless it weighs nothing."""
    scene = of_wall()
    scene["materials"] = {name: {"density": 2400, "young": 20e9, "poisson": 0.2} for name in ("dam", "rock")}
    scene["supports"] = {"base": {"fix": "xy"}}
    mesh = wall()
    mesh.face_sets["base"] = np.array([row for row in blockmesh.all_faces(mesh)[0] if (mesh.vertices[blockmesh.face_ends(mesh, np.array([row]))[0], 1] < -9.99).all()])
    mesh.group_rigid[:] = 0
    for name, density, ways in (("heavy", 2400, {"coefficient"}), ("light", 1, set(by_spectrum.WAYS))):
        (tmp_path / name).mkdir()
        scene["materials"]["rock"]["density"] = density
        study = studied(solved(tmp_path / name, mesh, scene), EUROCODE, "--condition", "full=usual")
        assert {row.way for row in study.rows} == ways and any("is below all bases" in line for line in study.why) == (density > 1)


@solver
def test_sheet_and_terminal(stones, capsys):
    designed(stones, EUROCODE)
    words = ["--spectrum", str(stones / "spectrum.yaml")]
    assert terminal.main([str(stones), *words]) == 0
    said = capsys.readouterr().out
    assert "Eurocode 8, type 1, ground A" in said and "all modes" in said and "It leaves out that the dam amplifies" in said
    case = assessment.load_case(str(stones), options_from(parser("report", "").parse_args([str(stones), *words])))
    text = report.page(case, report.Shaken(case.results), None, design_spectrum.read(case.options.spectrum))[0]
    assert "Earthquake by a spectrum" in text and text.count("<td>all modes</td>") == N
    assert "coefficient: least sliding factor" in text and ("all modes: no equilibrium at the peak" in text or "all modes: least sliding factor" in text)
    (stones / "spectrum.yaml").write_text("rule: eurocode8\n")
    assert terminal.main([str(stones), *words]) == 2 and "spectrum.yaml: unit: missing" in capsys.readouterr().err


@solver
def test_new_with_a_spectrum(tmp_path, capsys):
    """What `quoin new --spectrum` writes runs as it is, and all three ways are found; the static cases are those without it."""
    factors = []
    for name, words in (("plain", []), ("swings", ["--spectrum", "0.05", "--pool", "30"])):
        assert new.main([str(tmp_path / name), "--height", "33", "--columns", "6", "--guideline", "cadam", *(words or ["--pool", "30"])]) == 0
        done = subprocess.run([QUOIN, "-options_file", "scene.yaml", "-output", "out"], cwd=tmp_path / name, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode in (0, 3), done.stderr
        factors.append(Results(str(tmp_path / name / "out")).stage_summary("usual")["joints"]["base"])
    assert [factors[1][key] for key in ("N", "T")] == pytest.approx([factors[0][key] for key in ("N", "T")], rel=1e-6)
    capsys.readouterr()
    assert terminal.main([str(tmp_path / "swings" / "out"), "--guideline", "cadam", "--given", "tests=without", "--spectrum", str(tmp_path / "swings" / "spectrum.yaml")]) == 0
    said = capsys.readouterr().out
    assert "Eurocode 8, type 1, ground A, a_g 0.05 g" in said and all(f"  {way} " in said for way in by_spectrum.WAYS)
