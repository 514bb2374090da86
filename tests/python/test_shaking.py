"""Stages that are shaken: courses in time, Newmark's block beside the model, spectra over the record, pictures, what the sheet says and what it says is missing."""

import contextlib
import csv
import io
import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from quoin_tools.assess import newmark, not_modelled, spectrum  # noqa: E402
from quoin_tools.assess.assessment import load_case  # noqa: E402
from quoin_tools.assess.assessment_options import options_from, parser  # noqa: E402
from quoin_tools.base.record import Record  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.base.time_series import TimeSeries, dynamic_stages, reach  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402
from quoin_tools.show import plots, report, shaken_part, stress, style  # noqa: E402
from quoin_tools.show.shaking import Shaken, ratio_of, spectra_of  # noqa: E402

QUOIN = os.environ.get("QUOIN", str(ROOT / "build" / "quoin"))
solver = pytest.mark.skipif(not os.path.exists(QUOIN), reason="the solver is not built")
FRICTION = 15.0
T = np.arange(0, 3.005, 0.01)
A = -5 * np.sin(2 * np.pi * 4 / 3 * T) * np.sin(np.pi * T / 3) ** 2


def scene(**stages):
    """A rigid block of 3 x 1 m on a table that is shaken along x; its joint swings with 60 Hz."""
    k_s = 3 * 2000 * (2 * np.pi * 60) ** 2 / 3
    return {"model": "model.h5", "output": "out", "relaxation": {"history_every": 20}, "title": "Block <on> a table",
            "materials": {name: {"density": 2000, "rigid": True} for name in ("table", "block")},
            "joints": {"default": {"stress_model": "tptm", "k_n": 10 * k_s, "k_s": k_s, "friction": FRICTION, "damping": 1e-6}, "base": {}},
            "motions": {"quake": {"file": "quake.csv", "direction": "x"}}, "supports": {"table": {"fix": "xy", "motion": "quake"}},
            "loads": {"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["block"]},
                      "pull": {"type": "pseudo_static", "coefficient": [-1, 0], "groups": ["block"]},
                      "water": {"type": "reservoir", "faces": "left", "level": 0.3}},
            "stages": stages}  # fmt: skip


def trials(load):
    return {"type": "load_factor", "loads": ["weight", load], "raises": [load], "start": 0, "step": 0.1, "bracket": 0.001, "limit": 1}


SHAKE = {"type": "dynamic", "loads": ["weight"], "duration": 3.2, "dt_factor": 0.2, "frames": 3}


def solve(folder, text):
    """A material `block` with a modulus deforms."""
    folder.mkdir(exist_ok=True)
    (folder / "quake.csv").write_text("".join(f"{t:.10g}, {a:.17g}\n" for t, a in zip(T, A)))
    table = renamed(rectangle(-4, -1, 12, 1, group="table", rigid=True), {}, {"ground": "bottom_left"})
    deforms = "young" in text["materials"]["block"]
    block = renamed(rectangle(0, 0, 3, 1, *((6, 2) if deforms else (1, 1)), group="block", rigid=not deforms), {"base": "bottom", "left": "left"}, {"block": "top_left"})
    write(str(folder / "model.h5"), join([table, block]))
    (folder / "scene.yaml").write_text(yaml.safe_dump(text, sort_keys=False))
    done = subprocess.run([QUOIN, "-options_file", "scene.yaml"], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return folder / "out"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """k_y by trials, back to rest, the record, and after it less friction."""
    after = {"loads": ["weight"], "joints": {"base": {"friction": 10}}}
    return solve(tmp_path_factory.mktemp("runs") / "push", scene(rest={"loads": ["weight"]}, limit=trials("push"), back={"loads": ["weight"]}, shake=SHAKE, after=after))


@pytest.fixture(scope="module")
def pulled(tmp_path_factory):
    """Along -x, with water that does not move."""
    wet = {"loads": ["weight", "water"]}
    return solve(tmp_path_factory.mktemp("runs") / "pull", scene(rest=wet, limit=trials("pull"), back=wet, shake=SHAKE | wet))


@pytest.fixture(scope="module")
def elastic(tmp_path_factory):
    """A block that deforms, has strengths, and keeps its envelope."""
    text = scene(rest={"loads": ["weight"]}, shake=SHAKE | {"envelope_every": 50, "duration": 1.2})
    text["materials"]["block"] = {"density": 2000, "young": 1e8, "poisson": 0.2, "tension": 1e5, "compression": 1e6, "cohesion": 1e5, "friction": 40}
    return solve(tmp_path_factory.mktemp("runs") / "elastic", text)


@pytest.fixture(autouse=True)
def pictures(request, monkeypatch):
    """As in test_report.py: pictures are put together and left undrawn, but by tests marked `drawn`."""
    if not request.node.get_closest_marker("drawn"):
        monkeypatch.setattr(style, "save_figure", lambda figure, path, **options: Path(path).write_bytes(b"none"))


def tool(name, *words, cwd):
    """A command as `python -m quoin_tools` starts it, in this process: to start Python and matplotlib for each takes longer than all of them."""
    before, said, told = os.getcwd(), io.StringIO(), io.StringIO()
    os.chdir(cwd)
    try:
        with patch.object(sys, "argv", ["quoin", name, *map(str, words)]), contextlib.redirect_stdout(said), contextlib.redirect_stderr(told), pytest.raises(SystemExit) as left:
            runpy.run_module("quoin_tools", run_name="__main__")
    finally:
        os.chdir(before)
    return SimpleNamespace(returncode=left.value.code or 0, stdout=said.getvalue(), stderr=told.getvalue())


# ---- courses


@solver
def test_courses_are_those_of_the_stage(run):
    results = Results(run)
    assert dynamic_stages(results) == ["shake"]
    c, facts = TimeSeries(results, "shake"), results.stage_summary("shake")
    base = c.joints["base"]
    assert base["time"][0] == 0 and base["time"][-1] == pytest.approx(facts["time"], rel=1e-9) and c.sliding() == ["base"]
    assert base["N"][-1] == pytest.approx(facts["joints"]["base"]["N"], rel=1e-6) and base["T"][-1] == pytest.approx(facts["joints"]["base"]["T"], abs=50)
    assert reach(base) == np.abs(base["slip"] - base["slip"][0]).max() > 0.02
    assert c.probe("block", "x")[-1] == pytest.approx(facts["probes"]["block"]["u_x"], abs=1e-9)
    apart = c.probe("block", "x") - c.probe("ground", "x")
    assert c.probe("block", "x", relative=True) == pytest.approx(apart, abs=1e-8) and np.ptp(apart) > 0.02
    assert c.supports == ["table"]
    weight = 3 * 2000 * 9.81
    assert np.median(c.shear("y")) == pytest.approx(weight, rel=1e-3)
    assert np.abs(c.shear("x")).max() == pytest.approx(np.tan(np.radians(FRICTION)) * weight, rel=0.2)


# ---- Newmark's block


@solver
@pytest.mark.parametrize("which, way", [("run", 1), ("pulled", -1)])
def test_block_of_the_run(which, way, request):
    """k_y is tan(friction) to the bracket. With its way alone the rigid block slides as the formula has it."""
    shaken = Shaken(Results(request.getfixturevalue(which)))
    assert shaken.missing is None and (shaken.block.way, shaken.block.joints, shaken.block.from_stage) == (way, ["base"], "limit")
    k_y = np.tan(np.radians(FRICTION))
    assert abs(shaken.block.stable) <= k_y <= abs(shaken.block.failing) + 1e-9 and abs(shaken.block.stable) == pytest.approx(k_y, abs=1.1e-3)
    assert np.sign(shaken.block.slip.final) == way
    both = newmark.slide(Record("", T, A), newmark.yielding(*([abs(shaken.block.stable), 1e3][::way])))[0]
    assert shaken.block.slip.final == pytest.approx(both.final, rel=1e-9)


@solver
def test_model_slides_as_the_block_both_ways(run):
    """The model slides back too: with both ways open the rigid block is where the model is, to 4 % of the way that it went to and fro."""
    c, k = TimeSeries(Results(run), "shake").joints["base"], np.tan(np.radians(FRICTION))
    slip = newmark.slide(Record("", T, A), newmark.yielding(k, k))[0]
    assert np.interp(c["time"], slip.t, slip.slip) == pytest.approx(c["slip"] - c["slip"][0], abs=0.04 * np.abs(np.diff(slip.slip)).sum())


@solver
def test_coefficient_that_is_given(run):
    shaken = Shaken(Results(run), ky=-0.2)
    assert (shaken.block.way, shaken.block.stable, shaken.block.from_stage) == (-1, -0.2, None) and shaken.block_beside("shake", "base") is shaken.block
    assert shaken.block_beside("rest", "base") is None and Shaken(Results(run)).block_beside("shake", "other") is None
    for word in ("x", "0", "nan"):
        done = tool("report", run, f"--ky={word}", cwd=run)
        assert done.returncode == 2 and "--ky" in done.stderr


# ---- spectra


@solver
def test_spectrum_of_the_highest_point_over_the_record(run):
    shaking, top, (below, above) = spectra_of(Shaken(Results(run)), "shake")
    assert (shaking.words, top) == ("table along x", "block")
    exact = spectrum.of(Record("", T, A), below.period)
    assert below.acceleration == pytest.approx(exact.acceleration)
    assert ratio_of(above, below) == pytest.approx(above.acceleration / below.acceleration)
    soft = above.period > 1.0
    assert above.acceleration[~soft][0] < below.acceleration[~soft].max()  # the block takes no more than its friction gives


@solver
def test_motion_tool_on_a_run(run, tmp_path):
    done = tool("motion", run, "--record", "--points", "ground", "block", "--to", tmp_path, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "record quake" in done.stdout and "joint base of the run" in done.stdout and "stage limit, along +x" in done.stdout
    with open(tmp_path / "out_spectrum.csv", newline="") as file:
        header, *rows = csv.reader(file)
    table = np.array(rows, float)
    assert header[-2:] == ["ground over record quake", "block over record quake"]
    assert table[:, -2] == pytest.approx(1, abs=0.01) and table[0, 0] < 0.05  # the table is the record; rows of points, not of the record, bound the periods
    assert table[:, -1] == pytest.approx(table[:, header.index("block S_a [m/s2]")] / table[:, header.index("record quake S_a [m/s2]")])
    assert (tmp_path / "out_slip.csv").exists()
    plain = tool("motion", run, "--points", "ground", "--to", tmp_path, cwd=tmp_path)
    assert plain.returncode == 0 and "k_y" not in plain.stdout
    other = tool("motion", run, "--record", "--ky", run, "--to", tmp_path, cwd=tmp_path)
    assert other.returncode == 0 and "stage limit of out, along +x" in other.stdout
    for words, said in ((["--ky", run], "and --record"), (["--record", "--direction", "y"], "no record shakes it along y"), (["--record", "--stage", "rest"], "expected --stage"), ([], "expected --points")):
        done = tool("motion", run, *words, cwd=tmp_path)
        assert done.returncode == 2 and done.stderr.count("\n") == 1 and said in done.stderr, done.stderr
    assert "a record has no points" in tool("motion", run.parent / "quake.csv", "--record", cwd=tmp_path).stderr


# ---- pictures


@pytest.mark.drawn
@solver
def test_pictures(run, capsys):
    assert plots.main([str(run)]) == 0
    written = {os.path.basename(path) for path in capsys.readouterr().out.split()}
    wanted = {"time_base_shake.png", "shaking_shake.png", "spectrum_shake.png", "energy_shake.png"}
    assert wanted <= written and not [name for name in written if name.startswith(("time", "shaking", "spectrum")) and "shake.png" not in name]
    from matplotlib.image import imread
    for name in wanted:
        assert np.unique(imread(run / name)[:, :, :3].reshape(-1, 3).round(2), axis=0).shape[0] > 20, name
    with open(run / "spectrum_shake.csv", newline="") as file:
        assert next(csv.reader(file))[-1] == "ratio"


@solver
def test_envelope(run, elastic, tmp_path, monkeypatch):
    """It is drawn of a stage that has kept one, with the extremes of all looks."""
    titles = []
    monkeypatch.setattr(stress, "save", lambda figure, path: titles.extend([figure.get_suptitle(), *(axes.get_title() for axes in figure.axes)]))
    results = Results(elastic)
    assert not stress.plot_envelope(Results(run), "shake", "") and not stress.plot_envelope(results, "rest", "")
    assert stress.plot_envelope(results, "shake", "")
    kept, end = results.stage("shake").envelope, results.stage("shake")
    block = np.isfinite(end.s1)
    assert (kept.s1_max[block] >= end.s1[block]).all() and (kept.s2_min[block] <= end.s2[block]).all()
    assert f"{kept.samples} looks, one every 50 steps" in titles[0]
    assert f"largest {np.nanmax(kept.s1_max) / 1e6:+.3f} MPa" in titles[1] and f"least {np.nanmin(kept.s2_min) / 1e6:+.3f}".replace("-", "−") in titles[2]
    assert f"least {np.nanmin(kept.safety_factor_min):.2f} (ring)" in titles[3]


@solver
def test_without_its_record(run, tmp_path, capsys):
    """Pictures and sheet go on, and say what they do not know."""
    folder = Path(shutil.copytree(run.parent, tmp_path / "copy")) / "out"
    (folder.parent / "quake.csv").unlink()
    assert plots.main([str(folder)]) == 0
    told = capsys.readouterr()
    assert told.err.count("\n") == 1 and "pictures have no record" in told.err and "time_base_shake.png" in told.out and "spectrum" not in told.out
    assert report.main([str(folder)]) == 0
    assert "The record is not known" in (folder / "report.html").read_text(encoding="utf-8")


# ---- the sheet


def part_of(folder, *words):
    options = options_from(parser("report", "").parse_args([str(folder), *words]))
    case = load_case(str(folder), options)
    html = shaken_part.shaken_part(case, Shaken(case.results, options.ky))
    return re.sub("<[^>]*>", " | ", html)


@solver
def test_sheet_says_what_shook_it_and_what_it_did(run):
    text = part_of(run)
    c = TimeSeries(Results(run), "shake").joints["base"]
    r = Record("", T, A)
    first, last = r.significant()
    for words in (f"{r.pga:.3f} ({r.pga / 9.81:.3f} g)", f"{last - first:.2f} ({first:.2f} to {last:.2f})", "table: fixed, holds xy, moves by quake", "stage limit: 0.267",
                  "damping of default 1e-06 s", f"{1e3 * (c['slip'][-1] - c['slip'][0]):.2f}", "Newmark&#x27;s rigid block with k_y 0.267", "lost in joints", "not accounted for",
                  "The ground (table) is rigid", "Vertical motion of the ground is absent", "Force of the supports on the model"):  # fmt: skip
        assert words in text, words
    rows = dict(re.findall(r"\|  \| base \|  \| (.*?) \|  \| (.*?) \|", text))
    end, largest = (1e3 * value for value in (c["slip"][-1] - c["slip"][0], max(c["slip"] - c["slip"][0], key=abs)))
    assert float(rows["mean slip at the end [mm]"]) == pytest.approx(end, abs=0.01) and float(rows["largest mean slip [mm]"]) == pytest.approx(largest, abs=0.01)
    assert float(rows["least sliding factor of one moment, peak strength [-]"]) == pytest.approx(c["factor_peak"].min(), abs=0.01)
    assert float(rows["largest T [kN]"]) == pytest.approx(1e-3 * max(c["T"], key=abs), abs=1)
    factor = np.tan(np.radians(10)) * 3 * 2000 * 9.81
    T_after = abs(Results(run).stage_summary("after")["joints"]["base"]["T"])
    assert "After it" in text and (f"{factor / T_after:.3f}" in text or "&gt; 1000" in text)
    assert "does not move with the faces" not in text and "<on>" not in report_text(run)


def report_text(folder):
    assert report.main([str(folder)]) == 0
    return (folder / "report.html").read_text(encoding="utf-8")


@solver
def test_sheet_of_a_run_without_shaking_has_no_such_part(run, tmp_path):
    still = solve(tmp_path / "still", scene(rest={"loads": ["weight"]}))
    assert part_of(still) == "" and "Earthquake in time" not in report_text(still) and "Earthquake in time" in report_text(run)


@solver
def test_water_that_stands_still_is_told(pulled):
    assert "The water of water does not move with the faces" in part_of(pulled)


# ---- what is not modelled


class Case:
    """A dam on its rock, of which the scene tells what is held."""

    def __init__(self, supports, loads=None, rigid=0, contact=None):
        from quoin_tools.base.scene import parse
        ground = renamed(rectangle(-10, -10, 30, 10, group="rock"), {"rock_sides": "left", "rock_bottom": "bottom"})
        dam = renamed(rectangle(0, 0, 10, 20, group="dam"), {"upstream": "left"})
        self.mesh = join([ground, dam])
        text = {"supports": supports, "loads": loads or {}, "stages": {"shake": {"type": "dynamic", "loads": list(loads or {})}}}
        self.scene = parse(yaml.safe_dump(text), "scene.yaml")
        self.results = type("R", (), {"mesh": type("M", (), {"group_names": self.mesh.group_names, "group_rigid": np.full(2, rigid), "joint_names": []})})
        self.results.stage_summary = lambda name: {"joints": {}}
        self.results.stage = lambda name: type("S", (), {"contacts": None})


def test_edges():
    box = not_modelled.edges(Case({"rock_bottom": {"fix": "xy", "motion": "q"}, "rock_sides": {"fix": "xy", "motion": "q"}}))
    assert box == ["The ground is a box that is held and shaken (rock_bottom and rock_sides): waves that the structure sends out come back from its edge."]
    quiet = not_modelled.edges(Case({"rock_bottom": {"fix": "xy", "motion": "q", "boundary": "quiet"}, "rock_sides": {"fix": "y"}}))
    assert quiet == ["rock_sides holds the ground: waves that come there are sent back."]
    assert not_modelled.edges(Case({"rock_bottom": {"fix": "xy", "motion": "q", "boundary": "quiet"}})) == []
    assert "is rigid" in not_modelled.edges(Case({"rock": {"fix": "xy", "motion": "q"}}, rigid=1))[0]


def test_moving_and_still_water():
    """Water that has pulled, a reservoir whose faces have none that moves, uplift."""
    load = {"type": "added_mass", "faces": "upstream", "level": 16.0}
    case = Case({}, {"hydro": load, "lake": {"type": "reservoir", "faces": "rock_sides", "level": 3.0}, "full": {"type": "reservoir", "faces": "upstream", "level": 16},
                     "up": {"type": "uplift", "faces": "upstream", "level": 3}})  # fmt: skip
    pulled = {"pressure": -21.4e3, "x": 0.5, "y": 14.25, "time": 3.456, "length": 4.0}
    case.results.stage_summary = lambda name: {"joints": {}, "added_mass": {"hydro": {"suction": pulled}}}
    said = not_modelled.waters(case, "shake")
    assert len(said) == 3 and said[0].startswith("The water of lake does not move") and said[2].startswith("Uplift (up) stays")
    assert "over 4.0 m of its faces, to -21 kPa at (0.50, 14.25) at 3.46 s" in said[1]
    case.results.stage_summary = lambda name: {"joints": {}, "added_mass": {"hydro": {"suction": pulled | {"pressure": 0}}}}
    assert "pulled" not in not_modelled.waters(case, "shake")[1]
