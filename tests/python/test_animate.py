"""Films: what they show against the frames of a run, that they are whole files, and what is refused."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.base import ground, integrity, scene  # noqa: E402
from quoin_tools.base.record import RecordError  # noqa: E402
from quoin_tools.base.results import OPEN, SLIPPING, Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402
from quoin_tools.show import animate, film  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
solver = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
T = np.arange(0, 2.005, 0.01)
A = 4 * np.sin(2 * np.pi * 2 * T) * np.sin(np.pi * T / 2) ** 2


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A block on a table that is shaken, with water on its left: it slides."""
    folder = tmp_path_factory.mktemp("film")
    (folder / "quake.csv").write_text("".join(f"{t:.10g}, {a:.17g}\n" for t, a in zip(T, A)))
    table = renamed(rectangle(-2, -1, 8, 1, group="table", rigid=True), {}, {"ground": "bottom_left"})
    block = renamed(rectangle(0, 0, 3, 1, nx=3, group="block"), {"left": "left"}, {"block": "bottom_left"})
    write(str(folder / "model.h5"), join([table, block]))
    text = {"model": "model.h5", "relaxation": {"history_every": 25}, "contact": {"connectivity": "variable"},
            "materials": {"table": {"density": 2000, "rigid": True}, "block": {"density": 2000, "young": 1e8, "poisson": 0.2}},
            "joints": {"default": {"stress_model": "tptm", "k_n": 1e9, "k_s": 1e9, "friction": 15}}, "motions": {"quake": {"file": "quake.csv", "direction": "x", "scale": 1.5}},
            "supports": {"table": {"fix": "xy", "motion": "quake"}}, "loads": {"weight": {"type": "self_weight", "groups": ["block"]},
            "water": {"type": "reservoir", "faces": "left", "level": 0.6}},
            "stages": {"rest": {"loads": ["weight", "water"]}, "shake": {"type": "dynamic", "loads": ["weight", "water"], "duration": 2.5, "frames": 19, "dt_factor": 0.2}}}  # fmt: skip
    (folder / "scene.yaml").write_text(yaml.safe_dump(text, sort_keys=False))
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return folder / "out"


def film_of(run, *words):
    return animate.film_of(Results(run), animate.parser().parse_args([str(run), *words]))


def tool(*words, cwd):
    command = [sys.executable, "-m", "quoin_tools", "show", "--film", *map(str, words)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=120, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")})


# ---- what it shows


@solver
def test_section_is_that_of_the_frames(run):
    results, shown = Results(run), film_of(run)
    names = [*results.frames("shake"), "shake"]
    assert shown.n == len(names) == 20 and shown.time == pytest.approx([results.stage(name).time for name in names])
    table = results.mesh.group_names.index("table")
    fixed = np.unique(results.mesh.blocks[results.mesh.block_group == table])
    assert np.abs(shown.displacement[:, fixed]).max() < 1e-7  # the ground that is shaken stands still
    last, u = results.stage("shake"), results.history
    block = int(np.flatnonzero((results.mesh.vertices == 0).all(axis=1))[-1])
    apart = u["block_ux_m"] - u["ground_ux_m"]
    assert shown.displacement[-1, block, 0] == pytest.approx(apart[-1], abs=1e-6) and abs(apart[-1]) > 0.01
    contacts = last.contacts
    assert shown.factor == film_of(run, "--frames", "2").factor  # the largest displacement is at the end
    assert film_of(run, "--scale", "3").factor == 3
    slips = [(results.stage(name).contacts.state & SLIPPING > 0).sum() for name in names]
    assert [len(slipping) for _, slipping in shown.joints] == slips and max(slips) > 0 and contacts.slip.any()


@solver
def test_courses_are_record_and_joints(run):
    shown = film_of(run)
    record, joints = shown.charts
    assert record.lines[0][1] == pytest.approx(1.5 * A) and record.lines[0][2] == "table along x"
    slip = joints.lines[0]
    assert slip[2] == "largest slip" and slip[1][-1] == pytest.approx(1e3 * np.abs(Results(run).stage("shake").contacts.slip).max())
    assert record.lines[0][0] == pytest.approx(T, abs=1e-9)


def test_open_joints():
    """Of two contacts one is open at its first end and slips at the other, one is open by less than is shown."""
    class Contacts:
        point = np.array([[[0.0, 0], [2, 0]], [[2, 0], [4, 0]]])
        state = np.array([[OPEN, SLIPPING], [OPEN, 0]])
        opening = np.array([[2e-3, -1e-5], [1e-6, -1e-5]])

    is_open, slips = film.joints_of(Contacts, np.array([0.0, 0.1]), 10.0, 1e-5)
    assert is_open.tolist() == [[[0, 1], [1, 1]]] and slips.tolist() == [[[1, 1], [2, 1]]]


def test_slip_since_the_stage_began():
    """Less that of before, as long as the contacts are the same."""
    class Contacts:
        def __init__(self, slip, face=(0, 0, 1, 2)):
            self.face, self.slip = np.array([face]), np.array([slip])

        def __len__(self):
            return 1

    before = Contacts([0.01, -0.02])
    assert film.slid(Contacts([0.04, -0.03]), before) == pytest.approx(0.03) and film.slid(Contacts([0.04, -0.03]), None) == 0.04
    assert film.slid(Contacts([0.04, -0.03], (0, 1, 1, 2)), before) == 0.04


def test_one_scale_for_all_pictures():
    """That of the largest displacement; where it is drawn as it is, the view holds all places."""
    mesh = type("Mesh", (), {"vertices": np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])})
    box = (-1, 11, -1, 11)
    small, large = np.zeros((4, 2)), np.zeros((4, 2))
    small[2], large[2] = (0.01, 0), (0.1, 0)
    assert film.common_scale(mesh, [small], box, None)[0] > film.common_scale(mesh, [small, large], box, None)[0] == film.common_scale(mesh, [large], box, None)[0] == 5
    assert film.common_scale(mesh, [small, large], box, 20.0) == (20.0, box)
    large[2] = (5, 0)
    factor, wider = film.common_scale(mesh, [small, large, -large], box, None)
    assert factor == 1 and wider[1] > 15 and wider[0] == -1


def test_water_reaches_the_moved_face():
    """A face that leans, wet up to half of its height, and has moved by 1 m; the water is on its left."""
    places = np.array([[[0.0, 10], [0, 0]]])
    moved = np.array([[1.0, 0], [1, 0]])
    quads, surfaces = film.pools([(5.0, np.array([[0, 1]]), places)], places[0], moved, (-4, 4, -1, 11))
    assert np.array(quads[0]).tolist() == [[1, 0], [1, 5], [-4, 5], [-4, 0]] and np.array(surfaces[0]).tolist() == [[-4, 5], [1, 5]]
    above = film.pools([(-1.0, np.array([[0, 1]]), places)], places[0], moved, (-4, 4, -1, 11))
    assert above == ([], [])
    assert film.edge(places, np.array([[-3.0, 0], [4, 0]]), (-4, 4, -1, 11), False) == -3  # the model ends there


# ---- the file


@solver
def test_gif(run, tmp_path):
    done = tool(run, "--frames", 8, "--speed", 0.5, cwd=tmp_path)
    path = run / "animation_shake.gif"
    assert done.returncode == 0 and done.stdout.split() == [str(path)], done.stderr
    with Image.open(path) as shown:
        assert shown.n_frames == 8 and shown.size[0] > 400
        pictures = []
        for k in range(8):
            shown.seek(k)
            pictures.append(np.asarray(shown.convert("L"), dtype=int))
        assert shown.info["duration"] > 1500  # the last one stays
    assert all((a != b).sum() > 50 for a, b in zip(pictures, pictures[1:]))
    assert str(path) in "".join(integrity.check_folder(run))
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    assert integrity.film_is_whole(path.read_bytes()) and not integrity.film_is_whole(bytes(data)) and not integrity.film_is_whole(bytes(data[:-1]))
    path.unlink()


def test_mp4_is_signed_by_a_box_that_players_skip():
    """Boxes go from one to the next by their sizes, to the end."""
    made = integrity.signed_mp4(b"\0\0\0\x10ftypisom\0\0\2\0" + b"\0\0\0\x0amdat\7\7")
    at, kinds = 0, []
    while at < len(made):
        kinds.append(made[at + 4 : at + 8])
        at += int.from_bytes(made[at : at + 4], "big")
    assert at == len(made) and kinds == [b"ftyp", b"mdat", b"free"] and integrity.film_is_whole(made) and not integrity.film_is_whole(made[:-1] + b"g")


@solver
def test_mechanism_of_a_stage_that_fails(run, tmp_path):
    """The block on a table that is tilted: the whole of it slides."""
    text = yaml.safe_load((run.parent / "scene.yaml").read_text())
    text |= {"loads": text["loads"] | {"tilt": {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["block"]}}, "output": str(tmp_path / "out"),
             "motions": {}, "supports": {"table": {"fix": "xy"}}, "model": str(run.parent / "model.h5"),
             "stages": {"rest": {"loads": ["weight"]}, "tilt": {"type": "load_factor", "loads": ["weight", "tilt"], "raises": ["tilt"], "start": 0, "step": 0.5, "limit": 1}}}  # fmt: skip
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(text, sort_keys=False))
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    shown = film_of(tmp_path / "out", "--frames", "10")
    assert shown.stage == "tilt" and shown.n == 10 and "how it fails" in shown.title
    size = max(shown.box[1] - shown.box[0], shown.box[3] - shown.box[2])
    assert np.hypot(*shown.displacement[4].T).max() == pytest.approx(film.SWING * size, rel=1e-6) and not shown.displacement[[0, -1]].any()


# ---- the ground


def of_scene(tmp_path, support, motions, summary=None):
    class Run:
        folder = str(tmp_path)

    Run.summary = {"stages": summary or []}
    return ground.of_run(Run, scene.parse(yaml.safe_dump({"supports": {"base": support}, "motions": motions}), "scene.yaml"))


def test_records_of_supports(tmp_path):
    """Acceleration, the wave that comes in, a velocity, a support with a file of its own, one that holds the other way, one at rest."""
    (tmp_path / "a.csv").write_text("0, 0\n1, 2\n2, 0\n")
    (tmp_path / "v.csv").write_text("0, 0, 0\n1, 3, 0\n2, 0, 1\n")
    a = {"q": {"file": "a.csv", "direction": "x"}}
    plain = of_scene(tmp_path, {"fix": "xy", "motion": "q"}, a)
    assert [s.words for s in plain] == ["base along x"] and plain[0].record.pga == 2
    wave = of_scene(tmp_path, {"fix": "xy", "motion": "q", "boundary": "quiet", "input": "incident"}, a)
    assert wave[0].record.pga == 4 and wave[0].boundary == "quiet"
    own = of_scene(tmp_path, {"fix": "xy", "motion": "v.csv"}, {})
    assert [(s.direction, s.record.pga) for s in own] == [("x", 3), ("y", 1)] and own[0].record.v[-1] == 0 and own[0].record.u[-1] == pytest.approx(3)
    assert of_scene(tmp_path, {"fix": "y", "motion": "q"}, a) == [] == of_scene(tmp_path, {"fix": "y"}, a)
    with pytest.raises(RecordError, match="is not there"):
        of_scene(tmp_path, {"fix": "xy", "motion": "q"}, {"q": {"file": "b.csv", "direction": "x"}})
    with pytest.raises(RecordError, match="in the run it was 5"):
        of_scene(tmp_path, {"fix": "xy", "motion": "q"}, a, [{"motion": {"base_x": {"largest_acceleration": 5.0}}}])
    (tmp_path / "v.csv").write_text("0, 1, 0\n1, 3, 0\n")
    with pytest.raises(RecordError, match="a blow"):
        of_scene(tmp_path, {"fix": "xy", "motion": "v.csv"}, {})


# ---- what is refused


@solver
@pytest.mark.parametrize("words, said", [
    (["--stage", "none"], "no stage 'none', there are: rest, shake"), (["--stage", "rest"], "has no frames in time"), (["--frames", "1"], "--frames 1: expected"),
    (["--scale", "0"], "--scale 0: expected"), (["--speed", "nan"], "--speed nan: expected"), (["--speed", "1e4"], "pictures a second"), (["--mp4"], "ffmpeg is not installed"),
])  # fmt: skip
def test_refused(run, words, said, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    done = tool(run, *words, cwd=run)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and said in done.stderr, done.stderr


@solver
def test_what_is_missing_is_told(run, capsys):
    """Without its record and its mesh a film has neither ground nor water, and says so."""
    (run / "motion_quake.csv").rename(run / "gone.csv")
    (run.parent / "model.h5").rename(run.parent / "gone.h5")
    try:
        shown = film_of(run, "--frames", "3")
    finally:
        (run / "gone.csv").rename(run / "motion_quake.csv")
        (run.parent / "gone.h5").rename(run.parent / "model.h5")
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 2 and "the water is left out" in said[0] and "the motion of the ground is left out" in said[1]
    assert not shown.water and [chart.label[:6] for chart in shown.charts] == ["joints"]
