"""A dam and its mirror image, whose water stands on the right: the run, the gravity method, lifts and limit analysis have the same numbers."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from quoin_tools.assess import assessment, lifts
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.mesh.blockmesh import BlockMesh, write
from quoin_tools.show.limit import main as limit

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the solver is not built")

LEVELS, COLUMNS = (0.0, 8.0, 16.0, 24.0), 4
SCENE = """
model: model.h5
strain: small
relaxation: {{tolerance: 1e-9, velocity_tolerance: 1e-9}}
materials: {{dam: {{density: 2400, rigid: true}}, rock: {{density: 2600, rigid: true}}}}
joints: {{default: {{k_n: 10e9, k_s: 4e9, friction: 40, cohesion: 0}}, base: {{friction: 38}}, bed_1: {{cohesion: 5e4}}, bed_2: {{friction: 35}}}}
supports: {{floor: {{fix: xy}}}}
loads:
  weight: {{type: self_weight, groups: [dam]}}
  water: {{type: reservoir, faces: upstream, level: 22}}
  tail: {{type: tailwater, faces: downstream, level: 3}}
  silt: {{type: silt, faces: upstream, level: 6, density: 950, friction: 30}}
  ice: {{type: ice, faces: upstream, level: 21.5, force: 100e3}}
  wave: {{type: wave, faces: upstream, level: 22, height: 0.5}}
  crane: {{type: crest_load, faces: crest, at: {0:}2.0, value: [{0:}5e3, -2e4], lever: 1}}
  uplift: {{type: uplift, faces: base, level: 22, tailwater: 3, rule: usace, drain: 3, efficiency: 0.5, gallery: 0.5, cracked: true}}
  lift: {{type: uplift, faces: bed_2, level: 22}}
  quake: {{type: pseudo_static, coefficient: [{0:}0.02, -0.01], faces: upstream, level: 22}}
stages:
  - full: {{loads: [weight, water, tail, silt, uplift, lift, crane]}}
  - winter: {{from: full, loads: [weight, water, tail, uplift, lift, ice, wave]}}
  - shaken: {{from: full, loads: [weight, water, tail, uplift, quake]}}
  - yield: {{from: full, type: load_factor, loads: [weight, water, tail, uplift, quake], raises: [quake], limit: 20, bracket: 0.05}}
  - flood: {{from: full, type: flood, loads: [weight, water, tail, uplift], limit: 30, bracket: 0.1}}
"""
ENDS = {"start": "end", "end": "start"}


def grid(x, y, origin):
    """Vertices of two rows and the blocks between them. x: those of both rows."""
    vertices = [(v, y[row]) for row in (0, 1) for v in x[row]]
    n = len(x[0])
    return vertices, [(origin + i, origin + i + 1, origin + n + i + 1, origin + n + i) for i in range(n - 1)]


def dam():
    """Rigid courses with a battered face upstream, on rock."""
    vertices, blocks, group = [], [], []
    rows = [(np.linspace(0.05 * y, 20 - 0.7 * y, COLUMNS + 1)) for y in LEVELS]
    for k in range(3):
        more, new = grid((rows[k], rows[k + 1]), LEVELS[k : k + 2], len(vertices))
        vertices, blocks, group = vertices + more, blocks + new, group + [0] * COLUMNS
    floor = [-10.0, *rows[0], 34.0]
    more, new = grid((floor, floor), (-8.0, 0.0), len(vertices))
    vertices, blocks, group = vertices + more, blocks + new, group + [1] * len(new)
    n = COLUMNS
    sets = {"base": [(i, 0) for i in range(n)], "bed_1": [(n + i, 0) for i in range(n)], "bed_2": [(2 * n + i, 0) for i in range(n)],
            "upstream": [(k * n, 3) for k in range(3)], "downstream": [(k * n + n - 1, 1) for k in range(3)],
            "crest": [(2 * n + i, 2) for i in range(n)], "floor": [(3 * n + i, 0) for i in range(len(new))]}  # fmt: skip
    return BlockMesh(vertices, blocks, group, ["dam", "rock"], [1, 1], sets, {"heel": 0, "toe": n})


def mirrored(mesh):
    """x turns its sign, and blocks go round the other way."""
    blocks, corners = mesh.blocks.copy(), (mesh.blocks >= 0).sum(axis=1)
    for row, n in enumerate(corners):
        blocks[row, :n] = blocks[row, :n][::-1]
    sets = {name: [(block, (corners[block] - 2 - face) % corners[block]) for block, face in rows] for name, rows in mesh.face_sets.items()}
    return BlockMesh(mesh.vertices * [-1, 1], blocks, mesh.block_group, mesh.group_names, mesh.group_rigid, sets, mesh.points)


def run(folder, mesh, text, ranks=1):
    folder.mkdir(exist_ok=True)
    write(folder / "model.h5", mesh)
    (folder / "scene.yaml").write_text(text, encoding="utf-8")
    command = ["mpirun", "-n", str(ranks)] * (ranks > 1) + [QUOIN, "-options_file", folder / "scene.yaml", "-model", folder / "model.h5", "-output", folder]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mirror")
    for name, mesh, sign in (("left", dam(), ""), ("right", mirrored(dam()), "-")):
        done = run(folder / name, mesh, SCENE.format(sign))
        assert done.returncode == 0, done.stderr
    return folder / "left", folder / "right"


def flat(value, path=()):
    """Numbers and words by their path."""
    if isinstance(value, dict | list):
        rows = value.items() if isinstance(value, dict) else enumerate(value)
        return {key: leaf for name, one in rows for key, leaf in flat(one, (*path, name)).items()}
    return {path: value}


TURNS = ("x", "u_x", "k_h", "T", "M", "tau", "sliding", "k_h_stable", "k_h_failing", "slip")  # members that change their sign
OF_THE_WAY = ("cycles", "force_evaluations", "wall_s", "ratio", "worst_macroblock", "increment", "alpha", "dt", "checksum", "vertex", "evidence", "kinetic", "trials")


def reflected(path):
    """Where the mirror image has the number of this path."""
    turned = {"sigma_linear_start": "sigma_linear_end", "sigma_linear_end": "sigma_linear_start"} | ENDS
    return tuple(turned.get(name, name) if "joints" in path else name for name in path)


def differences(one, other):
    """Paths at which a summary is not the mirror image of another one."""
    one, other, found = flat(one), flat(other), []
    for path, value in one.items():
        if any(word in OF_THE_WAY for word in path):
            continue
        image = other[reflected(path)]
        if path[-1] == "heel":
            found += [path] if image != ENDS[value] else []
        elif isinstance(value, float | int) and image is not None:
            sign = -1 if path[-1] in TURNS or (path[-1] == 0 and "coefficient" in path) else 1
            size = 1e-3 if abs(value) < 1e-3 else abs(value)
            found += [(*path, value, image)] if abs(value - sign * image) > 1e-5 * size else []
        elif path[-1] not in ("at", "name"):
            found += [(*path, value, image)] if value != image else []
    return found


def test_runs_are_mirror_images(pair):
    one, other = (json.loads((folder / "summary.json").read_text(encoding="utf-8")) for folder in pair)
    assert [stage["uplift"]["uplift"]["heel"] for stage in one["stages"][:3]] == ["start"] * 3
    assert one["stages"][0]["uplift"]["uplift"]["diagram"][0][1] == pytest.approx(22 * 9810)
    for stage, image in zip(one["stages"], other["stages"], strict=True):
        assert differences(stage, image) == [], stage["name"]


def cases(pair, *arguments):
    for folder in pair:
        yield assessment.load_case(str(folder), options_from(parser("report", "").parse_args([str(folder), *arguments])))


def numbers(hand, heel):
    """Of the gravity method, as seen from the heel."""
    at_start = heel == "start"
    stress, sign = hand.linear if at_start else hand.linear[::-1], 1 if at_start else -1
    crack_at = None if not hand.crack else "heel" if hand.crack_at == heel else "toe"
    resultant = hand.resultant if at_start else hand.base.length - hand.resultant
    return [hand.N, sign * hand.T, sign * hand.M, hand.uplift, hand.crack, hand.reached, resultant, *stress, hand.compression], crack_at


WAYS = {"scene": (), "usace": ("--uplift", "usace", "--drain", "4", "--efficiency", "0.4"), "usbr": ("--uplift", "usbr", "--guideline", "usbr", "--tailwater", "2"),
        "linear": ("--uplift", "linear", "--uplift-direction", "vertical")}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_gravity_methods_are_mirror_images(pair, way):
    (left, said), (right, echo) = (assessment.assess(case) for case in cases(pair, *WAYS[way]))
    assert len(left) == len(right) >= 10
    images = {(a.stage, a.name): a for a in right}
    for a in left:
        image = images[a.stage, a.name]
        for hand, other in ((a.hand, image.hand), (a.with_uplift, image.with_uplift)):
            assert (hand is None) == (other is None), (a.stage, a.name)
            if hand is None:
                continue
            ours, theirs = numbers(hand, a.heel), numbers(other, image.heel)
            assert ours[1] == theirs[1]
            assert [x is None for x in ours[0]] == [x is None for x in theirs[0]]
            assert [x for x in ours[0] if x is not None] == pytest.approx([x for x in theirs[0] if x is not None], rel=1e-9, abs=1e-6)
        if way != "scene" and a.name == "base":
            assert a.with_uplift is not None and a.with_uplift.uplift > 1e5
        assert (a.heel, image.heel) == ("start", "end")
        assert [limit.verdict for limit in a.limits] == [limit.verdict for limit in image.limits]
        assert [limit.value for limit in a.limits if limit.value is not None] == pytest.approx([limit.value for limit in image.limits if limit.value is not None], rel=1e-5)
        assert a.notes == image.notes
        assert [abs(row[2]) for row in a.yields if row[2]] == pytest.approx([abs(row[2]) for row in image.yields if row[2]], rel=1e-6)
    assert said == echo


def test_the_option_for_earthquakes_leaves_cracks_at_rest(pair):
    """--uplift-in-crack unchanged: stages without an earthquake keep the full head in their cracks."""
    usual = {(a.stage, a.name): a for a in assessment.assess(next(cases(pair, *WAYS["usace"])))[0]}
    for a in assessment.assess(next(cases(pair, *WAYS["usace"], "--uplift-in-crack", "unchanged")))[0]:
        same = usual[a.stage, a.name]
        assert a.with_uplift is None or (a.with_uplift.crack, a.with_uplift.uplift) == (same.with_uplift.crack, same.with_uplift.uplift)
        assert a.with_uplift is None or (a.water.before is None) == (a.stage in ("full", "winter", "flood"))


def test_lifts_are_mirror_images(pair):
    for way in ("scene", "linear"):
        left, right = ([(lift.level, lift.factor, lift.hand.uplift, lift.hand.crack) for lift in lifts.sweep(case, "winter", [])[0]] for case in cases(pair, *WAYS[way]))
        assert len(left) > 1 and left[-1][2] > 0
        assert np.array(left, dtype=float) == pytest.approx(np.array(right, dtype=float), rel=1e-5, nan_ok=True)


def test_limit_analyses_are_mirror_images(pair, capsys):
    said = []
    for folder in pair:
        assert limit([str(folder)]) == 0
        said.append(capsys.readouterr().out)
    assert said[0] == said[1] and "BEYOND" not in said[0]



@pytest.mark.parametrize(("keys", "said"), [
    ("heel: start", "loads.uplift.heel: start is the end at (-20, 0) m, but in stage full the water of loads.water, at the level 22 m, stands at (0, 0) m: expected end"),
    ("heel: end", None)])  # fmt: skip
def test_a_heel_against_the_water_is_refused(tmp_path, keys, said):
    text = SCENE.format("-").replace("cracked: true", f"cracked: true, {keys}")
    done = run(tmp_path, mirrored(dam()), text[: text.index("  - winter")], 2)
    assert done.returncode == (2 if said else 0), done.stderr
    assert said is None or said in done.stderr


DRAINED = """
model: model.h5
materials: {{dam: {{density: 2400, rigid: true}}, rock: {{density: 2600, rigid: true}}}}
joints: {{default: {{k_n: 10e9, k_s: 4e9, friction: 40}}, base: {{aperture: 1e-4, aperture_residual: 1e-4, aperture_max: 1e-4}}}}
supports: {{floor: {{fix: xy}}}}
loads:
  weight: {{type: self_weight, groups: [dam]}}
  water: {{type: reservoir, faces: upstream, level: 22}}
  head: {{type: head, faces: upstream, level: 22}}
  toe: {{type: head, faces: downstream, level: 0}}
  drain: {{type: drain, joint: base, distance: 4}}
stages: [{{full: {{loads: [weight, water, head, toe, drain]}}}}]
"""


def test_a_drain_at_a_distance_is_measured_from_the_water(tmp_path):
    """Between heel and drain the head falls in a straight line, from 22 m to 0; beyond it there is none: 22 x 4 / 2 x 9.81 kN."""
    for name, mesh in (("left", dam()), ("right", mirrored(dam()))):
        done = run(tmp_path / name, mesh, DRAINED.format())
        assert done.returncode == 0, done.stderr
        facts = json.loads((tmp_path / name / "summary.json").read_text(encoding="utf-8"))["stages"][0]
        assert 2400 * 9.81 * AREA + BATTER - facts["joints"]["base"]["N"] == pytest.approx(22 * 4 / 2 * 9810, rel=1e-4)


AREA = sum(8 * (20 - 0.75 * (y + 4)) for y in LEVELS[:3])  # [m2] of the dam
BATTER = 0.05 * 22**2 / 2 * 9810  # [N/m] the water on the upstream face, downwards


CRACKED = """
model: model.h5
strain: small
materials: {{dam: {{density: 2400, rigid: true}}, rock: {{density: 2600, rigid: true}}, apron: {{density: 2600, young: 1e9, poisson: 0}}}}
joints: {{default: {{k_n: 10e9, k_s: 4e9, friction: 40}}, base: {{friction: 70}}, crack: {{friction: 10}}}}
supports: {{floor: {{fix: xy}}}}
loads:
  weight: {{type: self_weight, groups: [dam]}}
  water: {{type: reservoir, faces: upstream, level: 22}}
  pull: {{type: traction, faces: side, value: [{0:}1e6, 0]}}
  inside: {{type: uplift, faces: crack, level: 22, tailwater: 22}}
stages:
  - dry: {{loads: [weight, water, pull]}}
  - wet: {{loads: [weight, water, pull, inside]}}
"""


def apart():
    """The dam, whose rock is cut below the heel; the part upstream is pulled away from the rest."""
    mesh, apron = dam(), 3 * COLUMNS
    vertices = np.vstack([mesh.vertices, mesh.vertices[mesh.blocks[apron, 1:3]]])
    blocks, group = mesh.blocks.copy(), mesh.block_group.copy()
    blocks[apron, 1:3], group[apron] = [len(vertices) - 2, len(vertices) - 1], 2
    sets = mesh.face_sets | {"crack": [(apron + 1, 3)], "side": [(apron, 3)], "upstream": [*mesh.face_sets["upstream"], (apron, 2)]}
    return BlockMesh(vertices, blocks, group, ["dam", "rock", "apron"], [1, 1, 0], sets, mesh.points)


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.alone)])
def test_a_crack_below_the_water_that_stays_dry_is_told(tmp_path, ranks):
    """The one contact of 8 m is open at its upper end: 4 m, 9.81 x 4 x (22 + 26) / 2 kN."""
    for name, mesh, sign in (("left", apart(), "-"), ("right", mirrored(apart()), "")):
        done = run(tmp_path / name, mesh, CRACKED.format(sign), ranks)
        assert done.returncode == 0, done.stderr
        assert done.stderr.count("joint crack is open over 4 m from where it comes out under the water of loads.water") == 1, done.stderr
        dry, wet = json.loads((tmp_path / name / "summary.json").read_text(encoding="utf-8"))["stages"]
        assert dry["dry_joints"] == {"crack": {"length": pytest.approx(4), "force": pytest.approx(4 * 24 * 9810), "water": "water"}}
        assert "dry_joints" not in wet
        said = assessment.assess(next(cases([tmp_path / name])))[1]
        assert sum("crack is open over 4.00 m" in line and "942 kN" in line for line in said["dry"]) == 1
        assert not any("is open over" in line for line in said["wet"])


# ---- bases that are broken lines

BROKEN = """
model: model.h5
strain: small
relaxation: {{tolerance: 1e-9, velocity_tolerance: 1e-9}}
materials: {{dam: {{density: 2400, rigid: true}}, rock: {{density: 2600, rigid: true}}}}
joints: {{default: {{k_n: 20e9, k_s: 8e9, friction: 45}}, foot: {{friction: 40, cohesion: 2e5, cohesion_residual: 2e5}}, rest: {{friction: 45, cohesion: 1e5, cohesion_residual: 1e5}}}}
supports: {{rock: {{fix: xy}}}}
loads:
  weight: {{type: self_weight, groups: [dam]}}
  water: {{type: reservoir, faces: upstream, level: 22}}
  tail: {{type: tailwater, faces: downstream, level: 2}}
  under: {{type: uplift, faces: base, level: 22, tailwater: 2, rule: usace, drain: 4, efficiency: 0.5, cracked: true}}
  quake: {{type: pseudo_static, coefficient: [{0:}0.05, 0], groups: [dam], faces: upstream, level: 22}}
stages:
  - dry: {{loads: [weight, water, tail]}}
  - full: {{from: dry, loads: [weight, water, tail, under]}}
  - shaken: {{from: full, loads: [weight, water, tail, under, quake]}}
"""
BLOCK = ("N", "peak", "residual", "uplift", "compression")
PATHS = {"key at the heel": [[0, 0], [0, -2], [4, -2], [4, 0], [20, 0]], "key in the middle": [[0, 0], [9, 0], [9, -2], [12, -2], [12.8, 0], [20, 0]],
         "step down": [[0, 0], [8, 0], [8, -1.5], [20, -1.5]], "step up": [[0, 0], [8, 0], [8, 1], [20, 1]], "kinked": [[0, 0], [5, -1.25], [11, -1.25], [20, -1.7]]}  # fmt: skip


@pytest.mark.parametrize("shape", PATHS)
def test_broken_bases_are_mirror_images(tmp_path, shape):
    """Rows of a base with a key or steps, of two strengths: both methods, limits, notes, yield coefficients."""
    pytest.importorskip("gmsh")
    from test_section import meshed

    path = PATHS[shape]
    split = 2 if shape == "step up" else len(path) - 2
    text = (f"size: 6\ndam: {{upstream: [[0, 0], [0, 24]], downstream: [[20, {path[-1][1]}], [5, 20], [5, 24]], base: {path[1:-1]}, rigid: true}}\n"
            f"rock: {{upstream: 20, downstream: 20, depth: 15, size: 8, rigid: true}}\njoints: {{foot: {path[:split + 1]}, rest: {path[split:]}}}\n")  # fmt: skip
    mesh = meshed(tmp_path, text)
    for side, of, sign in (("left", mesh, ""), ("right", mirrored(mesh), "-")):
        done = run(tmp_path / side, of, BROKEN.format(sign))
        assert done.returncode == 0, done.stderr
    for arguments in ([], ["--uplift", "usbr", "--drain", "4"]):
        left, right = (assessment.assess(case)[0] for case in cases((tmp_path / "left", tmp_path / "right"), "--guideline", "usbr", "--condition", "full=usual", "--condition", "shaken=extreme", *arguments))
        images = {(a.stage, "+".join(reversed(a.name.split("+")))): a for a in right}
        assert {a.stage for a in left} == {"dry", "full", "shaken"} and len(left) == len(right)
        for a in left:
            b = images[a.stage, a.name]
            assert (a.base.path is None) == (b.base.path is None) and a.base.length == pytest.approx(b.base.length)
            for hand, other in ((a.hand, b.hand), (a.with_uplift, b.with_uplift)):
                ours, theirs = (numbers(one, of.heel) if one else ([], None) for one, of in ((hand, a), (other, b)))
                assert ours[1] == theirs[1] and [x for x in ours[0] if x is not None] == pytest.approx([x for x in theirs[0] if x is not None], rel=1e-6, abs=1e-3), (a.stage, a.name)
                if hand:
                    assert assessment.factors(hand, a.strength)["peak"] == pytest.approx(assessment.factors(other, b.strength)["peak"], rel=1e-6)
            assert [a.block[key] or 0 for key in BLOCK] == pytest.approx([b.block[key] or 0 for key in BLOCK], rel=1e-3)
            assert [limit.verdict for limit in a.limits] == [limit.verdict for limit in b.limits] and len(a.notes) == len(b.notes)
            assert [abs(row[2] or 0) for row in a.yields] == pytest.approx([abs(row[2] or 0) for row in b.yields], rel=1e-6)
