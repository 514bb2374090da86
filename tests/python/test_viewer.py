"""The page of a run (quoin show FOLDER --html): its numbers against those of the results, and itself in headless Chromium under mouse, fingers and keys.
Colours and numbers that the page computes are compared, not dots of pictures. Without Chromium the second half is skipped, and says so; CI installs it."""

import base64
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import chromium_driver
import h5py
import numpy as np
import pytest
from quoin_tools.base.integrity import ResultsError, check_made
from quoin_tools.base.results import OPEN, SLIPPING, Results
from quoin_tools.mesh.blockmesh import write
from quoin_tools.mesh.meshing import join, rectangle, renamed
from quoin_tools.show import browser, style, viewer, viewer_data

ROOT = Path(__file__).resolve().parents[2]
QUOIN = Path(os.environ.get("QUOIN", ROOT / "build/quoin"))
RED, ORANGE, BLUE, WATER = (193, 18, 31), (213, 94, 0), (0, 114, 178), (11, 95, 165)  # open joint, tension, compression, edge of water
FORCE = (179, 38, 30)
WIDTH, HEIGHT = 1200, 1000  # [px] of the window

pytestmark = pytest.mark.skipif(not QUOIN.exists(), reason="the program is not built")
chromium = pytest.mark.skipif(browser.find() is None, reason=f"NOT TESTED: the page in a browser; {browser.HOW}")


def solve(folder, example, *options, words=(), move=None):
    """A run of an example, on its mesh or on one moved by [m]; then its page."""
    folder.mkdir(parents=True)
    environment = os.environ | {"PYTHONPATH": str(ROOT / "tools")}
    subprocess.run([sys.executable, ROOT / "examples" / example / "mesh.py", folder / "model.h5", *words], check=True, env=environment, capture_output=True)
    if move is not None:
        with h5py.File(folder / "model.h5", "a") as file:
            file["vertices"][...] = file["vertices"][...] + move
    command = [QUOIN, "-options_file", ROOT / "examples" / example / "scene.yaml", "-model", folder / "model.h5", "-output", folder, *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == 0, done.stderr
    assert viewer.main([str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def dam(tmp_path_factory):
    """Tendons, a lift, a flood up to failure; as few rows of history as charts show in full."""
    return solve(tmp_path_factory.mktemp("page") / "dam", "anchored_dam", "-relaxation_history_every", "1000")


@pytest.fixture(scope="module")
def motion(tmp_path_factory):
    """A block that slides off an edge and falls: frames in time, contacts found again."""
    return solve(tmp_path_factory.mktemp("page") / "motion", "motion", "-stages_move_dt_factor", "0.5", words=["edge"])


@pytest.fixture(scope="module")
def seepage(tmp_path_factory):
    """Water that flows in the joints of the rock, and uplift by a rule."""
    return solve(tmp_path_factory.mktemp("page") / "seepage", "guilhofrei_seepage", "-stages", "rock,sw,rule,present")


class Read:
    """What a page holds, read without its script."""

    def __init__(self, text):
        found = [re.search(rf'<script type="[a-z/]+" id="{name}">(.*?)</script>', text, flags=re.S)[1] for name in ("described", "base64")]
        self.scene, self.data = json.loads(found[0]), base64.b64decode(found[1])

    def at(self, place):
        kind, start, count = place
        return np.frombuffer(self.data, "<f4" if kind == "f" else "<i4", count, 4 * start)

    def pairs(self, place):
        return self.at(place).reshape(-1, 2)


def read(folder):
    return Read((folder / "view.html").read_text(encoding="utf-8"))


LOADED = """model: model.h5
materials: {dam: {density: 2400, rigid: true}, rock: {density: 2600, rigid: true}}
joints: {base: {k_n: 20e9, k_s: 8e9, friction: 50}}
supports: {rock: {fix: xy}}
loads:
  weight: {type: self_weight}
  water: {type: reservoir, faces: upstream, level: 16}
  silt: {type: silt, faces: upstream, level: 8, friction: 30, density: 900}
  ice: {type: ice, faces: upstream, level: 16, force: 150e3}
  wave: {type: wave, faces: upstream, level: 16, height: 1}
  road: {type: crest_load, faces: crest, value: [0, -1e5], at: 5}
  gas: {type: pressure, faces: upstream, pressure: 5 kPa}
stages:
  - empty: {loads: [weight]}
  - full: {loads: [weight, water, silt, ice, wave, road, gas]}
"""


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    """Silt, ice, a wave and a load on the crest."""
    folder = tmp_path_factory.mktemp("page") / "loaded"
    folder.mkdir()
    dam = renamed(rectangle(0, 0, 10, 20, 5, 20, group="dam", rigid=True), {"upstream": "left", "base": "bottom", "crest": "top"})
    write(str(folder / "model.h5"), join([renamed(rectangle(-10, -4, 30, 4, group="rock", rigid=True), {}), dam]))
    (folder / "scene.yaml").write_text(LOADED, encoding="utf-8")
    done = subprocess.run([QUOIN, "-options_file", folder / "scene.yaml", "-output", folder], capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 0, done.stderr
    assert viewer.main([str(folder)]) == 0
    return folder


# ---- what it holds


@pytest.mark.parametrize("name", ["dam", "motion", "seepage"])
def test_numbers_are_those_of_the_results(name, request):
    folder = request.getfixturevalue(name)
    results, page = Results(folder), read(folder)
    wanted = [step for stage in results.stages for step in [*results.frames(stage), stage]]
    assert len(page.scene["steps"]) == len(wanted) and not page.scene["notes"]
    origin = np.array(page.scene["origin"])
    assert np.abs(page.pairs(page.scene["mesh"]["vertices"]) + origin - results.mesh.vertices).max() < 1e-5
    for step, stage in zip(page.scene["steps"], map(results.stage, wanted)):
        assert step["verdict"] == stage.verdict and (step["time"] is None or step["time"] == stage.time)
        for place, values in ((step["displacement"], stage.displacement), (step["blocks"]["s1"], stage.s1), (step["blocks"]["angle"], stage.angle),
                              (step["contacts"]["sigma"], stage.contacts.sigma), (step["contacts"]["opening"], stage.contacts.opening),
                              (step["contacts"]["state"], stage.contacts.state), (step["contacts"]["point"], stage.contacts.point - origin)):  # fmt: skip
            assert np.allclose(page.at(place), values.ravel(), rtol=1e-6, atol=1e-7, equal_nan=True)
        if stage.flow is not None:
            assert np.allclose(page.at(step["flow"]["pressure"]), stage.flow.pressure.ravel(), rtol=1e-6)
        if stage.anchors is not None:
            assert np.allclose(page.at(step["anchors"]["force"]), stage.anchors.force, rtol=1e-6)


def test_water_and_uplift_are_those_of_the_scene(seepage):
    """Uplift by the rule in stage `rule`: 33 m of water at the heel, a third of it at the drain, none at the toe; its force is the run's."""
    results, page = Results(seepage), read(seepage)
    steps = {step["stage"]: step for step in page.scene["steps"]}
    assert not steps["sw"]["faces"] and not steps["sw"]["uplift"] and steps["sw"]["flow"] is None and steps["present"]["flow"]
    (rule,) = steps["rule"]["uplift"]
    place, pressure = page.pairs(rule["point"]) + page.scene["origin"], page.at(rule["pressure"])
    assert np.allclose(pressure, 9810 * np.array([33, 11, 0]), rtol=1e-6)
    assert np.allclose(np.hypot(*(place[1:] - place[:-1]).T).sum(), results.stage_summary("rule")["joints"]["base"]["chord"], rtol=1e-6)
    facts = results.stage_summary("rule")["uplift"]["rule"]
    force = (0.5 * (pressure[1:] + pressure[:-1]) * np.hypot(*(place[1:] - place[:-1]).T)).sum()
    assert np.isclose(force, facts["to_drain"] + facts["beyond_drain"], rtol=1e-5)
    levels = {face["name"]: face["level"] + page.scene["origin"][1] for face in steps["rule"]["faces"]}
    assert levels and set(levels.values()) == {33.0}


def test_forces_are_those_of_the_loads(loaded):
    """Silt: K gamma' h^2 / 2 a third up; ice at its level; the crest load at its place; a pressure in the middle of its faces."""
    page = read(loaded)
    steps = {step["stage"]: step for step in page.scene["steps"]}
    forces = {force["name"]: (np.array(force["at"]) + page.scene["origin"], force["force"]) for force in steps["full"]["forces"]}
    assert steps["empty"]["forces"] == [] and set(forces) == {"silt", "ice", "wave", "road", "gas"}
    assert np.allclose(forces["gas"][1], [5e3 * 20, 0]) and np.allclose(forces["gas"][0], [0, 10], atol=0.4)
    assert np.allclose(forces["silt"][1], [900 * 9.81 * 8**2 / 2 / 3, 0]) and np.allclose(forces["silt"][0], [0, 8 / 3], atol=0.02)
    assert np.allclose(forces["ice"][1], [150e3, 0]) and forces["ice"][0][1] == pytest.approx(16, abs=0.6)
    assert np.allclose(forces["road"][1], [0, -1e5]) and np.allclose(forces["road"][0], [5, 20], atol=0.1)
    assert forces["wave"][1][0] > 0 and 16 - 3 < forces["wave"][0][1] < 17.5


def test_histories_are_those_of_the_run(dam, motion):
    results, page = Results(dam), read(dam)
    chart = page.scene["charts"][0]
    series, x = {name: page.at(place) for name, place in chart["series"]}, page.at(chart["x"])
    assert set(series) == {"crest u_x", "crest u_y", "toe u_x", "toe u_y"} and [span[0] for span in chart["spans"]] == results.stages
    for name, values in series.items():
        all_of_it = 1e3 * results.history[f"{name.replace(' ', '_').replace('u_', 'u')}_m"]
        assert np.isclose(values.max(), all_of_it.max(), rtol=1e-6) and np.isclose(values.min(), all_of_it.min(), rtol=1e-6)
        assert np.allclose(values, np.interp(x, results.history["cycle"], all_of_it), rtol=1e-5, atol=1e-6)
    titles = [chart["title"] for chart in read(motion).scene["charts"]]
    assert "Slip of joints, stage move" in titles and "Displacement of points, stage move" in titles and "Unbalanced ratio" not in titles


def test_a_large_run_is_thinned_and_says_so(motion, dam, tmp_path):
    """A limit below what the frames have; one below what the contacts have; one that nothing fits into leaves the last stage."""
    for name, folder in (("motion", motion), ("dam", dam)):
        shutil.copytree(folder, tmp_path / name)
    all_of_it = read(tmp_path / "motion").scene["steps"]
    assert viewer.main([str(tmp_path / "motion"), "--numbers", "3000"]) == 0
    some = read(tmp_path / "motion").scene
    assert 10 < len(some["steps"]) < len(all_of_it) / 2 and some["steps"][-1]["frame"] == 0
    assert some["notes"] == [f"{len(some['steps']) - 1} of {len(all_of_it) - 1} frames of stages in time are shown: the model has 4 blocks."]
    viewer.main([str(tmp_path / "dam"), "--numbers", "8000"])
    page, contacts = read(tmp_path / "dam"), Results(dam).stage("flood").contacts
    states = page.pairs(page.scene["steps"][-1]["contacts"]["state"])
    assert (states != 0).any(axis=1).sum() == (contacts.state != 0).any(axis=1).sum() and len(states) < len(contacts)
    assert page.scene["notes"][0].startswith("Of the contacts that are closed and hold every ")
    viewer.main([str(tmp_path / "dam"), "--numbers", "1"])
    last = read(tmp_path / "dam").scene
    assert [step["stage"] for step in last["steps"]] == ["flood"] and "5 of 6 stages are left out, the first ones: the model has 202 blocks." in last["notes"]


def test_the_page_is_signed_and_what_it_lacks_is_told(dam, tmp_path, monkeypatch):
    copy = tmp_path / "out"
    shutil.copytree(dam, copy)
    assert str(copy / "view.html") in check_made(copy)
    monkeypatch.setattr(viewer_data, "mesh_of", lambda results, scene: (copy / "no.h5").read_bytes())
    viewer.main([str(copy)])
    scene = read(copy).scene
    assert len(scene["notes"]) == 1 and scene["notes"][0].startswith("Water on faces, uplift by rules and named points are left out: ") and scene["points"] == []
    data = bytearray((copy / "view.html").read_bytes())
    data[len(data) // 2] ^= 1
    (copy / "view.html").write_bytes(data)
    with pytest.raises(ResultsError, match=r"view\.html: it is damaged"):
        check_made(copy)


def test_titles_and_names_cannot_break_the_page(dam, tmp_path):
    """A title is text: it ends no script, and is no mark of the page."""
    results = Results(dam)
    results.title = "</script><script>alert(1)</script> <!--NUMBERS--> & \u2028"
    results.mesh.group_names[0] = "</script>"
    text = viewer.page(results)
    assert text.count("<script") == text.count("</script>") == 3 and "alert(1)</script> <" not in text
    assert Read(text).scene["title"] == results.title and Read(text).scene["groups"][0] == "</script>"
    text = re.sub(r"/\*! https://github.com/leeoniya/uPlot .*?\*/", "", text)  # the library names its home in a comment
    assert not re.search(r"""(?:src|href)\s*=|https?:|@import|url\(""", text)


def test_bad_words(dam, tmp_path, capsys):
    for words in ([str(dam), "--numbers", "0"], [str(dam), "--numbers", "x"]):
        with pytest.raises(SystemExit) as ended:
            viewer.main(words)
        assert ended.value.code == 2 and capsys.readouterr().err.count("\n") == 1
    with pytest.raises(ResultsError, match=r"no results\.h5"):
        viewer.main([str(tmp_path)])


# ---- in a browser


@pytest.fixture(scope="module")
def page(dam):
    with chromium_driver.opened(dam / "view.html", WIDTH, HEIGHT) as opened:
        yield opened
        assert not opened.errors, opened.errors
        assert opened.asked == [(dam / "view.html").as_uri()], "the page wants something from elsewhere"


def on_canvas(page, results, point):
    """Where a place of the undeformed mesh is on the canvas when the box of the dam fills it: parts of its width and height."""
    low_x, high_x, low_y, high_y = style.view(results.mesh)[0]
    width, height = page.value("[document.querySelector('#section').clientWidth, document.querySelector('#section').clientHeight]")
    zoom = min(width / (high_x - low_x), height / (high_y - low_y))
    return 0.5 + (point[0] - 0.5 * (low_x + high_x)) * zoom / width, 0.5 - (point[1] - 0.5 * (low_y + high_y)) * zoom / height


@chromium
def test_every_stage_has_the_numbers_of_the_results(dam, page):
    """By the arrow key on the slider, from the last stage to the first; the whole model is in the picture."""
    results = Results(dam)
    page.click("#all")
    page.value("document.querySelector('#step').focus()")
    for stage in map(results.stage, results.stages[::-1]):
        contacts = stage.contacts
        assert page.text("#state").startswith(f"Stage {stage.name}: {stage.verdict} (") and page.value("document.querySelector('#stage').value") == stage.name
        assert page.number("drawn") == len(results.mesh.blocks) and page.number("contacts") == len(contacts)
        for key, wanted in (("u_max", np.hypot(*stage.displacement.T).max()), ("s1_max", np.nanmax(stage.s1)), ("s2_min", np.nanmin(stage.s2)),
                            ("opening", max(0, contacts.opening.max())), ("sigma_min", contacts.sigma.min()), ("anchor", stage.anchors.force.max()),
                            ("open", ((contacts.state & OPEN) != 0).any(axis=1).sum()), ("slipping", ((contacts.state & SLIPPING) != 0).any(axis=1).sum())):  # fmt: skip
            assert np.isclose(page.number(key), wanted, rtol=1e-5, atol=1e-12), (stage.name, key)
        page.key("ArrowLeft", 37)
    assert page.number("level water") is None and page.number("pressure") is None  # the first stage has no water


@chromium
def test_sliders_lists_and_colours(dam, page):
    results = Results(dam)
    page.click("#dam")
    page.click("#step", right=0.998)
    assert page.text("#state").startswith("Stage flood") and page.number("level water") == 53.25
    assert page.number("pressure") == pytest.approx(9810 * 53.25, rel=1e-6)
    joined = page.colours()
    assert joined[RED] > 100 and joined[WATER] > 100, "no open joint, no edge of water"
    page.click("#water")
    assert WATER not in page.colours() and page.number("pressure") is None
    page.click("#water")
    page.choose("#joints", "none")
    assert page.colours().get(RED, 0) < joined[RED] / 2  # its key is gone too
    page.choose("#joints", "opening")
    assert RED not in page.colours()
    page.choose("#joints", "state")
    assert page.colours().get(ORANGE, 0) == 0
    page.click("#crosses")
    with_crosses = page.colours()
    assert with_crosses[BLUE] > 50 and 100 < page.number("crosses") <= np.isfinite(results.stage("flood").s1).sum()
    page.click("#crosses")
    few = len(page.colours())
    page.choose("#fill", "s2")
    assert len(page.colours()) > few + 10
    page.choose("#fill", "groups")
    page.click("#step", right=0.002)
    assert page.text("#state").startswith("Stage own") and page.number("open") == 0
    assert page.colours()[RED] < joined[RED], "a joint that is closed is drawn as open"


@chromium
def test_forces_are_drawn(loaded):
    with chromium_driver.opened(loaded / "view.html", WIDTH, HEIGHT) as page:
        assert [page.number(f"force {name}") for name in ("ice", "road")] == [150e3, 1e5]
        assert page.number("force silt") == pytest.approx(900 * 9.81 * 8**2 / 6, rel=1e-6)
        assert page.colours()[FORCE] > 100
        page.click("#water")
        assert page.number("force ice") is None and FORCE not in page.colours()
        assert not page.errors


@chromium
def test_each_stage_has_the_scale_that_fits_it(page):
    """Until one is chosen by hand, which stays."""
    fitting = "SCALES[fittingScale(stepOf(choice.step))]"
    scales = []
    for k in range(page.value("scene.steps.length")):
        page.value(f"goTo({k})")
        scales.append(page.value("choice.scale"))
        if k == 0 or page.value(f"stepOf({k}).stage !== stepOf({k - 1}).stage"):
            assert scales[-1] == page.value(fitting)
    assert len(set(scales)) > 1
    page.value("rescale(0)")
    page.value("goTo(0)")
    assert page.value("choice.scale") == 0


@chromium
def test_scale_of_displacements(page):
    """Undeformed: nothing is drawn dashed, and the picture is that of any stage but for its words; the slider and the keys move the same scale."""
    page.click("#step", right=0.998)
    page.click("#scale", right=0.002)
    assert page.text("#scaled") == "not drawn (× 0)"
    page.value("document.activeElement.blur()")  # a slider takes the arrows itself
    for wanted in ("× 1", "× 2", "× 5", "× 10"):
        page.key("ArrowUp", 38)
        assert page.text("#scaled") == wanted
    page.key("ArrowDown", 40)
    assert page.text("#scaled") == "× 5"
    still = page.value("document.querySelector('#section').toDataURL()")
    page.click("#scale", right=0.5)
    assert page.value("document.querySelector('#section').toDataURL()") != still
    page.key("u", 85)
    assert page.text("#scaled") == "not drawn (× 0)"
    page.choose("#shape", "motion of the failure")
    assert page.text("#scaled").startswith("not to scale") and page.text("#said").startswith("The motion of the failure")
    page.choose("#shape", "")


@chromium
def test_a_click_on_a_block_has_its_numbers(dam, page):
    results = Results(dam)
    stage = results.stage("full")
    page.choose("#stage", "full")
    page.click("#dam")
    page.click("#scale", right=0.002)
    deformable = np.flatnonzero(np.isfinite(stage.s1))
    for block in deformable[[0, len(deformable) // 3, len(deformable) // 2, -1]]:
        page.click("#section", *on_canvas(page, results, results.mesh.centres()[block]))
        assert page.number("block", "picked") == results.mesh.block_file[block]
        assert np.isclose(page.number("s1", "picked"), stage.s1[block], rtol=1e-5) and np.isclose(page.number("s2", "picked"), stage.s2[block], rtol=1e-5)
    base = np.flatnonzero(stage.contacts.joint == results.mesh.joint_names.index("base"))[5]
    page.click("#section", *on_canvas(page, results, 0.97 * stage.contacts.point[base, 0] + 0.03 * stage.contacts.point[base, 1] + [0, 0.05]))
    assert page.value("document.querySelector('#picked tr[data-key=\"joint\"] td').textContent") == "base"
    ends = np.concatenate([stage.contacts.sigma[base - 1 : base + 2].ravel(), [stage.contacts.sigma[base, 0]]])
    assert np.isclose(ends, page.number("sigma", "picked"), rtol=1e-5).any()
    page.click("#section", 0.985, 0.3)  # air
    assert page.number("block", "picked") is None


@chromium
def test_blocks_are_drawn_where_they_have_moved(dam, page):
    """Displacements × 200, up to 4 m in the picture: a block is found where it is drawn, and no longer where it was."""
    results = Results(dam)
    stage, mesh = results.stage("flood"), results.mesh
    page.choose("#stage", "flood")
    page.click("#dam")
    page.click("#scale", right=0.002)
    page.value("document.activeElement.blur()")
    for _ in range(8):
        page.key("ArrowUp", 38)
    assert page.text("#scaled") == "× 200"
    moved = mesh.rings(mesh.vertices + 200 * stage.displacement).mean(axis=1)
    crest = np.flatnonzero(np.isfinite(stage.s1))[np.argsort(mesh.centres()[np.isfinite(stage.s1), 1])[-40]]
    page.click("#section", *on_canvas(page, results, moved[crest]))
    assert page.number("block", "picked") == mesh.block_file[crest]
    page.click("#section", *on_canvas(page, results, mesh.centres()[crest]))
    assert page.number("block", "picked") != mesh.block_file[crest]


@chromium
def test_crosses_point_the_right_way(dam, page):
    """Compression runs down along the downstream face: dots along its direction are blue, those along the mirrored one are not."""
    results = Results(dam)
    stage, mesh = results.stage("full"), results.mesh
    page.choose("#stage", "full")
    page.click("#dam")
    page.click("#scale", right=0.002)
    for box in ("#water", "#anchors", "#points", "#crosses"):
        page.click(box)
    page.choose("#joints", "none")
    inside = np.isfinite(stage.s2) & (np.abs(stage.s1) < 0.1 * np.abs(stage.s2)) & (np.abs(np.sin(2 * stage.angle)) > 0.6)
    block = np.flatnonzero(inside)[np.argmin(stage.s2[inside])]
    right, lower = on_canvas(page, results, mesh.centres()[block])
    for mirrored in (1, -1):
        along = 6 * np.array([np.cos(stage.angle[block] + np.pi / 2), -mirrored * np.sin(stage.angle[block] + np.pi / 2)])
        blue = page.value(f"""(() => {{ const c = document.querySelector("#section"), x = {right} * c.clientWidth + {along[0]}, y = {lower} * c.clientHeight + {along[1]};
            const d = c.getContext("2d").getImageData(x - 1.5, y - 1.5, 3, 3).data; let n = 0;
            for (let i = 0; i < d.length; i += 4) n += d[i] < 60 && d[i + 2] > 140; return n; }})()""")
        assert (blue > 0) == (mirrored == 1)
    for box in ("#water", "#anchors", "#points", "#crosses"):
        page.click(box)
    page.choose("#joints", "state")


@chromium
def test_charts_and_the_joint(dam, page):
    results = Results(dam)
    page.click("#dam")
    for stage in ("full", "flood"):
        page.choose("#stage", stage)
        page.choose("#joint", "base")
        facts, shown = results.joint_profile(stage, "base"), page.value("({...document.querySelector('#profile').dataset})")
        opening = results.stage(stage).contacts.opening[results.stage(stage).contacts.joint == results.mesh.joint_names.index("base")]
        assert int(shown["contacts"]) == len(facts[0]) and np.isclose(float(shown["least"]), 1e-3 * facts[1].min(), rtol=1e-5)
        assert np.isclose(float(shown["widest"]), max(0, 1e3 * opening.max()), rtol=1e-5)
        history = results.history
        here = page.value("document.querySelector('#charts canvas').dataset.here")
        assert float(here) == history["cycle"][history["stage"] == stage][-1]
    assert page.value("document.querySelectorAll('#charts canvas').length") == 2
    assert page.value("axisOf('', 'x').values(null, [0, 2.5, 12.5, 20, 1500], 0, 0, 2.5)") == ["0", "2.5", "12.5", "20", "1\u202f500"]
    page.click("#charts canvas", right=0.17, lower=0.5)  # the first stage, which has room on the axis though it is short
    assert page.text("#state").startswith("Stage own")


@chromium
def test_zoom_drag_and_keys(dam, page):
    page.click("#all")
    page.value("choice.picked = null; redraw()")
    everything = page.number("drawn")
    page.value("document.activeElement.blur()")
    for _ in range(8):
        page.key("+", 187)
    few = page.number("drawn")
    assert 0 < few < everything
    page.key("a", 65)
    assert page.number("drawn") == everything
    page.drag("#section", (0.5, 0.5), (0.5, 1.4))
    assert page.number("drawn") < everything
    assert page.number("block", "picked") is None  # a drag is no click
    page.key("d", 68)


@chromium
def test_fingers(dam):
    """On a telephone: two fingers zoom, one moves, a tap chooses a block."""
    with chromium_driver.opened(dam / "view.html", 400, 800, touch=True) as page:
        x, y = page.place("#section", 0.5, 0.4)
        assert page.value("document.documentElement.scrollWidth") <= 400, "wider than the telephone"
        drawn = page.number("drawn")
        page.touch("touchStart", (x - 20, y), (x + 20, y))
        for far in (60, 110, 160):
            page.touch("touchMove", (x - far, y), (x + far, y))
        page.touch("touchEnd")
        assert 0 < page.number("drawn") < drawn / 2 and page.number("block", "picked") is None
        page.click("#dam")
        page.touch("touchStart", page.place("#section", 0.45, 0.6))
        page.touch("touchEnd")
        assert page.number("block", "picked") is not None
        assert not page.errors


@chromium
def test_stage_in_time(motion):
    """Frames follow each other; the time in the words, the chart and the displacement are those of the frame."""
    results = Results(motion)
    frames = results.frames("move")
    with chromium_driver.opened(motion / "view.html", WIDTH, HEIGHT) as page:
        page.key("a", 65)
        for k in (len(frames) // 2, len(frames) - 1):
            page.value(f"(() => {{ const e = document.querySelector('#step'); e.value = {k}; e.dispatchEvent(new Event('input')); }})()")
            page.settle()
            stage = results.stage(frames[k])
            assert f"t = {stage.time:.3f} s" in page.text("#state")
            assert np.isclose(page.number("u_max"), np.hypot(*stage.displacement.T).max(), rtol=1e-5)
            assert page.number("contacts") == len(stage.contacts)
            charts = page.value("[...document.querySelectorAll('#charts canvas')].map((c) => c.dataset.here)")
            assert np.isclose(float(charts[1]), stage.time, rtol=1e-5)
        page.click("#step", right=0.002)
        page.click("#play")
        page.value("new Promise((done) => setTimeout(() => done(1), 700))")
        page.click("#play")
        assert page.value("Number(document.querySelector('#step').value)") > 1
        assert not page.errors


@chromium
def test_a_dam_far_from_the_origin(tmp_path_factory):
    """500 km, as in coordinates of a map: blocks are found, and numbers are as good as elsewhere."""
    far = solve(tmp_path_factory.mktemp("page") / "far", "guilhofrei", "-stages", "sw", move=np.array([500_000.0, 0.0]))
    results = Results(far)
    with chromium_driver.opened(far / "view.html", WIDTH, HEIGHT) as page:
        page.click("#dam")
        page.click("#scale", right=0.002)
        block = np.flatnonzero(np.isfinite(results.stage("sw").s1))[40]
        page.click("#section", *on_canvas(page, results, results.mesh.centres()[block]))
        assert page.number("block", "picked") == results.mesh.block_file[block]
        assert np.isclose(page.number("s2_min"), np.nanmin(results.stage("sw").s2), rtol=1e-5)
        assert not page.errors
