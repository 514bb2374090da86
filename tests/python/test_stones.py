"""What a scene of thousands of stones needs of the solver: rows of joints known before the first cycle, effort that ends, and is reported."""

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from matplotlib import image
from quoin_tools.base.results import Results
from quoin_tools.mesh import blockmesh
from quoin_tools.mesh.meshing import face_set_on, join, rectangle, renamed
from quoin_tools.mesh.walls import wall
from quoin_tools.show import plot_mesh

QUOIN = os.environ.get("QUOIN", "build/quoin")
pytestmark = pytest.mark.skipif(not Path(QUOIN).exists(), reason="the solver is not built")


def quoin(folder, mesh, scene, *options, ranks=1):
    """The finished process; its results are in folder / "out"."""
    folder.mkdir(parents=True, exist_ok=True)
    blockmesh.write(folder / "model.h5", mesh)
    (folder / "scene.yaml").write_text(yaml.safe_dump({"model": "model.h5", "output": "out"} | scene, sort_keys=False), encoding="utf-8")
    start = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"] if ranks > 1 else []
    return subprocess.run([*start, str(Path(QUOIN).resolve()), "-options_file", "scene.yaml", *options], cwd=folder, capture_output=True,
                          text=True, timeout=120, env=os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})  # fmt: skip


# ---- pictures

def test_outlines_do_not_cover(tmp_path):
    """Thousands of stones: outlines and joints get thinner, and the fill is still what one sees; few keep their lines."""
    for blocks, courses, many in ((4, 4, False), (40, 40, True)):
        mesh = wall(blocks, courses)
        ends = mesh.vertices[blockmesh.face_ends(mesh, mesh.face_sets["joint_bed"])]
        width = plot_mesh.outline_width(ends, 2.4, plot_mesh.limits(mesh, None), 5.0)
        length = np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum()
        assert (width == 2.4) != many
        area = np.prod(np.ptp(ends.reshape(-1, 2), axis=0))
        height = np.diff(plot_mesh.limits(mesh, None)[2:])[0]
        assert not many or width * length <= 0.21 * area * 72 * 5.0 / height
        plot_mesh.plot(mesh, str(tmp_path / "mesh.png"))
        picture = image.imread(tmp_path / "mesh.png")[:, :, :3]
        red = (picture[:, :, 0] - picture[:, :, 1] > 0.5).mean()
        assert not many or red < 0.15
    outer = plot_mesh.silhouette(ends)
    assert outer.sum() < 0.05 * len(ends)


# ---- rows of joints for contacts that come later

SLIDING = {
    "contact": {"connectivity": "variable", "tolerance": 0.01},
    "materials": {"base": {"density": 0}, "stone": {"density": 2400}},
    "joints": {"bed": {"k_n": 1e8, "k_s": 1e8, "friction": 20}, "head": {"k_n": 1e8, "k_s": 1e8, "friction": 30}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["stone"]},
              "push": {"type": "traction", "faces": "left", "value": [100e3, 0]}},
    "stages": [{"weight": {"loads": ["weight"]}}, {"push": {"type": "dynamic", "loads": ["weight", "push"], "duration": 0.3}}],
}  # fmt: skip


def row(second):
    """A stone, at x = `second` another, and a third 0.1 m beyond that; the first is pushed to the right until it touches all."""
    places = (0.0, second, second + 1.1)
    mesh = join([renamed(rectangle(-1, -1, 7, 1, group="base", rigid=True))]
                + [renamed(rectangle(x, 0, 1, 1, group="stone", rigid=True)) for x in places])  # fmt: skip
    mesh.face_sets = {"bed": face_set_on(mesh, (-1, 0), (6, 0)), "left": face_set_on(mesh, (0, 0), (0, 1)),
                      "head": face_set_on(mesh, (1, 0), (1, 1))}  # fmt: skip
    return mesh


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.alone)])
def test_later_contacts_have_the_row_of_their_groups(tmp_path, ranks):
    """No `default`: a contact that comes between groups that touch at the start has their row (the third stone: `head`)."""
    done = quoin(tmp_path, row(1.0), SLIDING, ranks=ranks)
    assert done.returncode == 0, done.stderr
    results = Results(str(tmp_path / "out"))
    assert results.stage_summary("push")["contacts_made"] > 0
    assert results.stage("push").displacement[-4:, 0].min() > 0.01  # the third stone was hit


def test_missing_row_is_refused_at_set_up(tmp_path):
    """Stones that do not touch at the start, and no row for them: reported before the first stage, not after two."""
    done = quoin(tmp_path, row(1.1), SLIDING)
    assert done.returncode == 2 and "stage" not in done.stdout
    assert "groups stone and stone may come into contact" in done.stderr and "stone+stone or default" in done.stderr
    given = quoin(tmp_path, row(1.1), SLIDING | {"joints": SLIDING["joints"] | {"stone+stone": SLIDING["joints"]["head"]}})
    assert given.returncode == 0, given.stderr
    fixed = SLIDING | {"contact": {"connectivity": "fixed"}, "joints": {name: joint for name, joint in SLIDING["joints"].items() if name != "head"}, "stages": SLIDING["stages"][:1]}
    assert quoin(tmp_path, row(1.1), fixed).returncode == 0  # there they never meet, so "head" would be a row without a contact


# ---- effort and its report

WALL = {
    "materials": {"block": {"density": 2400, "young": 10e9, "poisson": 0.2}, "base": {"density": 0}},
    "joints": {"default": {"law": "elastic", "k_n": 10e9, "k_s": 4e9}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
    "stages": [{"weight": {"loads": ["weight"]}}],
}


def test_effort_of_newton_is_bounded(tmp_path):
    """Preconditioned relaxation that has spent `relaxation.effort` says so, and explicit cycles come to the same end."""
    mesh = wall(4, 3, rigid=False)
    done = quoin(tmp_path, mesh, WALL, "-relaxation_method", "preconditioned", "-relaxation_effort", "1")
    assert done.returncode == 0 and "found no equilibrium in" in done.stderr and "goes on by explicit cycles" in done.stderr
    stage = Results(str(tmp_path / "out")).stage_summary("weight")
    assert stage["method"] == "preconditioned, then explicit" and stage["verdict"] == "converged"
    given = quoin(tmp_path, mesh, WALL, "-relaxation_method", "preconditioned")
    assert given.returncode == 0 and "found no equilibrium" not in given.stderr
    assert Results(str(tmp_path / "out")).stage_summary("weight")["method"] == "preconditioned"


def test_large_factor_is_told(tmp_path):
    """A line, in a file too, names the factorisation before it is made: 1800 stones, 21 600 degrees of freedom."""
    done = quoin(tmp_path, wall(45, 40, rigid=False), WALL, "-relaxation_method", "preconditioned")
    assert done.returncode == 0
    line = re.search(r"^ +weight: Newton's method: factor 1 by (cholmod|mumps), (\d+) degrees of freedom$", done.stdout, re.MULTILINE)
    assert line and int(line[2]) > 20000


def test_advise_says_what_it_does_not_know(tmp_path):
    """No equilibrium of the first stage: cycles of that stage have no upper end, the next is unknown, none is zero."""
    joints = {"default": {"k_n": 10e9, "k_s": 4e9, "friction": 5}}
    push = {"push": {"type": "traction", "faces": "left", "value": [200e3, 0]}}
    stages = [{"one": {"loads": ["weight", "push"]}}, {"two": {"loads": ["weight"]}}]
    scene = WALL | {"joints": joints, "loads": WALL["loads"] | push, "stages": stages}
    done = quoin(tmp_path, wall(2, 2, rigid=False), scene, "-advise", "0.01")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("stage "))
    one, two = (line.split() for line in lines[head + 1:head + 3])
    assert one[2] == "-" and float(one[3]) > 0 and one[4:] == ["-", "-", "-"] and two[2:] == ["-"] * 5
    assert "-: not known" in done.stdout


def test_advise_marks_what_is_only_a_lower_bound(tmp_path):
    """More than a thousand stones, a fifth of their joints open: cycles may be any number from the lower end of the range on, which stands
    marked where the likely number would; the run takes no fewer."""
    joints = {"default": {"k_n": 10e9, "k_s": 4e9, "friction": 35}}
    mesh, scene = wall(36, 28), WALL | {"materials": {"block": {"density": 2400}, "base": {"density": 0}}, "joints": joints}
    scene |= {"relaxation": {"method": "explicit"}}  # the estimate is of explicit cycles
    done = quoin(tmp_path, mesh, scene)
    assert done.returncode == 0, done.stderr
    stage = Results(str(tmp_path / "out")).stage_summary("weight")
    command = [str(Path(QUOIN).resolve()), "-options_file", "scene.yaml", "-advise", "0.01"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        said = []
        for line in process.stdout:
            said.append(line)
            if line.startswith("-: not known"):
                break
        process.terminate()  # before it tries what could be left out
    name, trials, cycles, least, most, seconds, _ = next(line for line in said if line.startswith("weight ")).split()
    assert (name, trials, cycles, most) == ("weight", "1", f">{least}", "-") and seconds.startswith(">")
    assert stage["method"] == "explicit" and 0 < int(least) <= stage["cycles"]
    assert ">: the least" in said[-1]
