"""The tool for records of ground motion: readers, measures, response spectra and Newmark's block against closed forms; points of a run."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.assess import newmark, spectrum  # noqa: E402
from quoin_tools.base import record  # noqa: E402
from quoin_tools.base.record import Record, RecordError  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
HEAD = "PEER STRONG MOTION DATABASE RECORD\nHere 1/1/26\nACCELERATION TIME HISTORY IN UNITS OF {}.\n"


def read(tmp_path, name, text, **options):
    (tmp_path / name).write_text(text)
    return record.read(str(tmp_path / name), **options)


def tool(*words, cwd):
    command = [sys.executable, "-m", "quoin_tools", "motion", *map(str, words)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=120, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")})


# ---- readers


def test_formats_agree(tmp_path):
    two = read(tmp_path, "two.txt", "# made by hand\nt a\n0 0\n.5\t1.5 # here\n\n1, -2.25\n")
    three = read(tmp_path, "three.csv", "0, 7, 0\n.5, 7, 1.5\n1, 7, -2.25\n", direction="y")
    peer = read(tmp_path, "new.AT2", HEAD.format("CM/S/S") + "NPTS=   3, DT=  .5000 SEC,\n 0.E+00 .15E+03\n-225\n")
    older = read(tmp_path, "older.at2", HEAD.format("M/S2") + "   3   .5000   NPTS, DT\n0 1.5 -2.25\n")
    for other in (three, peer, older):
        assert np.array_equal(other.t, two.t) and np.allclose(other.a, two.a, rtol=1e-15)
    assert read(tmp_path, "g.AT2", HEAD.format("G") + "NPTS= 2, DT= 1\n0 1").a[1] == 9.80665
    assert read(tmp_path, "ms.AT2", HEAD.format("G") + "NPTS= 3, DT= 10 MSEC\n0 1 0").t[2] == pytest.approx(0.02)
    assert read(tmp_path, "two.txt", "0 0\n1 2", scale=-0.5).a[1] == -1


@pytest.mark.parametrize("name, text, said", [
    ("a.csv", "0, 0\n1, x\n", "line 2: could not convert string to float: 'x'"), ("a.csv", "0, 0\n1, nan\n", "line 2: expected finite numbers"),
    ("a.csv", "0, 0\n1\n", "line 2: 1 numbers"), ("a.csv", "0, 0\n2, 0\n1, 0\n", "line 3: t = 1 after 2"), ("a.csv", "0, 0\n", "1 rows"),
    ("a.AT2", HEAD.format("G") + "NPTS= 3, DT= .1\n0 1\n", "2 values of step 0.1 s: NPTS says 3"), ("a.AT2", HEAD.format("IN") + "NPTS= 2, DT= .1\n0 1\n", "units of 'IN'"),
    ("a.AT2", HEAD.format("G") + "NPTS= 2, DT= 0\n0 1\n", "the step is to be > 0"), ("a.AT2", HEAD.format("G") + "NPTS= 2, DT= 1 MIN\n0 1\n", "DT in 'MIN': expected SEC or MSEC"), ("a.AT2", "0 1 2\n", "expected 'UNITS OF ...'"),
    ("a.VT2", HEAD.format("CM/S") + "NPTS= 2, DT= 1\n0 1\n", "it gives velocities"),
])  # fmt: skip
def test_bad_files(tmp_path, name, text, said):
    with pytest.raises(RecordError, match=said.replace("(", r"\(")):
        read(tmp_path, name, text)


# ---- measures


def test_measures_of_a_triangle():
    """Up to 2 m/s2 in 1 s, down to -2 in two, back in one."""
    r = Record("", np.array([0.0, 1, 3, 4]), np.array([0.0, 2, -2, 0]))
    assert (r.pga, r.pgv) == (2, 2)  # between rows, where the acceleration passes 0
    assert r.v == pytest.approx([0, 1, 1, 0]) and r.u[-1] == pytest.approx(1 / 3 + (2 + 4 / 3) + 1 / 3)
    assert r.arias(g=np.pi / 2)[-1] == pytest.approx(2 + 8 + 2)
    assert r.significant(2 / 12, 11 / 12) == pytest.approx((1, 3.5))
    with pytest.raises(RecordError, match="all accelerations are 0"):
        Record("", np.array([0.0, 1]), np.zeros(2)).significant()


# ---- spectra


@pytest.mark.parametrize("z", [0.0, 0.05, 0.2])
def test_spectrum_of_a_step(z):
    """An acceleration that sets in and stays: the oscillator swings beyond its new place by exp(-pi z/sqrt(1 - z^2))."""
    step = Record("", np.array([0.0, 30.0]), np.array([3.0, 3.0]))
    for w in (1.0, 8.0, 300.0):
        beyond = 1 + np.exp(-np.pi * z / np.sqrt(1 - z * z))
        assert spectrum.largest(step, [w], z)[0] == pytest.approx(3 / w**2 * beyond, rel=4e-4)


@pytest.mark.parametrize("ratio", [0.3, 0.8, 1.7])
def test_spectrum_of_a_harmonic(ratio):
    """Without damping: x = -a/(w^2 - p^2) (sin pt - p/w sin wt), then it swings on."""
    w, end = 2 * np.pi / 0.5, 6.1
    p = ratio * w
    t = np.linspace(0, end, 20001)
    x = -(np.sin(p * t) - ratio * np.sin(w * t)) / (w * w - p * p)
    v = -p * (np.cos(p * end) - np.cos(w * end)) / (w * w - p * p)
    exact = max(np.abs(x).max(), np.hypot(x[-1], v / w))
    assert spectrum.largest(Record("", t, np.sin(p * t)), [w], 0.0)[0] == pytest.approx(exact, rel=4e-4)


def test_spectrum_at_resonance():
    w, z = 2 * np.pi / 0.4, 0.05
    t = np.linspace(0, 24, 24001)
    assert spectrum.largest(Record("", t, np.sin(w * t)), [w], z)[0] == pytest.approx(1 / (2 * z * w * w), rel=4e-4)


def test_ends_of_a_spectrum():
    """Stiff oscillators move with the ground, soft ones stay where they are."""
    t = np.linspace(0, 4, 401)
    r = Record("", t, np.sin(2 * np.pi * t) * np.sin(np.pi * t / 4) ** 2)
    s = spectrum.of(r, [0.01, 400.0])
    assert s.acceleration[0] == pytest.approx(r.pga, rel=2e-3) and s.displacement[1] == pytest.approx(r.pgd, rel=2e-2)
    assert s.velocity == pytest.approx(2 * np.pi / s.period * s.displacement)


# ---- Newmark's block


def test_block_on_a_square_pulse():
    """Acceleration A for t0: slip (A - a_c) A t0^2 / 2 a_c, against it; stops at A t0 / a_c."""
    A, t0, k = 4.0, 0.5, 0.15
    pulse = Record("", np.array([0, t0, t0, 5]), np.array([A, A, 0, 0]))
    slip, reach = newmark.slide(pulse, newmark.yielding(k))
    a_c = k * newmark.G
    assert slip.final == pytest.approx(-(A - a_c) * A * t0**2 / (2 * a_c), rel=1e-12) and reach == (slip.final, 0)
    assert slip.ends() == pytest.approx((0, A * t0 / a_c), rel=1e-12)


def test_block_against_small_steps():
    """Both ways, with other resistances; steps of 1e-5 s."""
    rng = np.random.default_rng(7)
    r = Record("", np.arange(40) * 0.05, np.append(rng.normal(0, 3, 39), 0))
    block = newmark.incline(20, 6)
    slip, _ = newmark.slide(r, block)
    h, v, x = 1e-5, 0.0, 0.0
    for a in np.interp(np.arange(0, slip.t[-1], h) + h / 2, r.t, r.a, right=r.a[-1]):
        on, back = -block.p * a - block.r, -block.q * a + block.s
        new = v + h * (on if v > 0 or (v == 0 and on > 0) else back if v < 0 or back < 0 else 0)
        v = 0.0 if new * v < 0 else new
        x += h * v
    assert slip.final == pytest.approx(x, abs=2e-5) and len(slip.phases) > 3


def test_block_that_never_slides_or_never_stops():
    r = Record("r", np.array([0.0, 1, 2]), np.array([0.0, 1, 0]))
    slip, reach = newmark.slide(r, newmark.yielding(0.2))
    assert slip.final == 0 and slip.ends() is None and reach == (0, 0)
    with pytest.raises(RecordError, match="does not stop"):
        newmark.slide(r.scaled(-1), newmark.yielding(0, 0.2))
    with pytest.raises(RecordError, match="slides at rest"):
        newmark.incline(10, 11)


# ---- the command


def test_command(tmp_path):
    t = np.arange(0, 4.005, 0.01)
    (tmp_path / "quake.csv").write_text("".join(f"{x}, {y}\n" for x, y in zip(t, 3 * np.sin(2 * np.pi * t) * np.sin(np.pi * t / 4) ** 2)))
    done = tool("quake.csv", "--ky", 0.1, 0.3, "--pga", 2, "--to", "pictures", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "PGA                               2.0000 m/s2" in done.stdout and "block: final slip" in done.stdout
    assert sorted(path.name for path in (tmp_path / "pictures").iterdir()) == ["quake_motion.png", "quake_slip.csv", "quake_spectrum.csv"]
    with open(tmp_path / "pictures" / "quake_spectrum.csv", newline="") as file:
        header, *rows = csv.reader(file)
    assert header[0] == "period [s]" and float(rows[0][3]) == pytest.approx(2, rel=0.01)


@pytest.mark.parametrize("words, said", [
    (["no.csv"], "no.csv: No such file"), (["a.csv", "--pga", "2", "--scale", "2"], "--pga 2: expected"), (["a.csv", "--ky", "-0.1"], "yield coefficients"),
    (["a.csv", "--ky", "0.1", "--friction", "20"], "expected --ky with one or two numbers"), (["a.csv", "--damping", "1"], "--damping 1: expected"),
    (["a.csv", "--periods", "2", "1"], "--periods 2 1: expected"), (["a.csv", "--points", "crest"], "a record has no points"), (["."], "no results.h5"),
    ([".", "a.csv"], "expected no other source"),
])  # fmt: skip
def test_command_refuses(tmp_path, words, said):
    (tmp_path / "a.csv").write_text("0, 0\n1, 1\n2, 0\n")
    done = tool(*words, cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and said in done.stderr, done.stderr


@pytest.mark.skipif(not os.path.exists(QUOIN), reason="the program is not built")
def test_points_of_a_run(tmp_path):
    """A block that is stuck to a moving table by a spring of 4 Hz: the spectrum of the table is that of its file, and the block moves as an oscillator."""
    t = np.arange(0, 6.005, 0.01)
    a = 2 * np.sin(2 * np.pi * 3 * t) * np.sin(np.pi * t / 6) ** 2
    (tmp_path / "quake.csv").write_text("".join(f"{x:.10g}, {y:.17g}\n" for x, y in zip(t, a)))
    table = renamed(rectangle(-1, -1, 6, 1, group="table", rigid=True), {}, {"ground": "bottom_left"})
    block = renamed(rectangle(0, 0, 4, 0.1, group="block", rigid=True), {}, {"block": "bottom_left"})
    write(str(tmp_path / "model.h5"), join([table, block]))
    w = 2 * np.pi * 4
    scene = {"model": "model.h5", "strain": "small", "relaxation": {"history_every": 25}, "materials": {"table": {"density": 2000}, "block": {"density": 2000}},
             "joints": {"default": {"law": "elastic", "k_n": 2e8, "k_s": 200 * w * w}}, "motions": {"quake": {"file": "quake.csv", "direction": "x"}},
             "supports": {"table": {"fix": "xy", "motion": "quake"}}, "stages": {"shake": {"type": "dynamic", "loads": [], "duration": 8}}}  # fmt: skip
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False))
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "motions.quake along x: quake.csv: to 6 s, largest 1.9" in done.stdout
    said = tool("out", "--points", "ground", "block", cwd=tmp_path)
    assert said.returncode == 0, said.stderr
    with open(tmp_path / "out" / "out_spectrum.csv", newline="") as file:
        header, *rows = csv.reader(file)
    table = np.array(rows, float)
    assert [word.split()[0] for word in header[1:7:3]] == ["ground", "block"] and header[7:] == ["block over ground"]
    assert table[:, 7] == pytest.approx(table[:, 6] / table[:, 3])
    exact = spectrum.of(Record("", t, a), table[:, 0])
    assert table[:, 3] == pytest.approx(exact.acceleration, rel=5e-3)
    history = Results(tmp_path / "out").history
    apart = np.abs(history["block_ux_m"] - history["ground_ux_m"]).max()
    assert apart == pytest.approx(spectrum.largest(Record("", t, a), [w], 0.0)[0], rel=5e-3)
    assert "expected --points of the mesh: block, ground" in tool("out", "--points", "crest", cwd=tmp_path).stderr
