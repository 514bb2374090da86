"""Error against time where rock yields: docs/img/yielding_accuracy.png and docs/data/yielding_accuracy.csv.

    PYTHONPATH=tools python tests/benchmark/yielding.py --quoin build/quoin

The thick ring of the case `yielding` (M03: a hole of 1.5 m in rock to 15 m under 5 MPa): error of the displacement of its wall by explicit
cycles, by Newton's method in one step and in 8 increments, by kinds of blocks, on four meshes, with a flow as wide as the friction and without. The rough footing on soil with a friction of
30 degrees: error of its bearing capacity, pressed in time. Seconds of processor time of the whole process. Three minutes; --draw only draws."""

import argparse
import csv
import os
import resource
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tests" / "verification" / "yielding"), str(ROOT / "tools")]

import matplotlib  # noqa: E402

matplotlib.use("Agg")
from case import FOOTINGS, pressed_footing, quarter_ring  # noqa: E402
from driver import Case  # noqa: E402
from matplotlib import pyplot  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.mesh.meshing import split_triangles  # noqa: E402

DATA, PICTURE = ROOT / "docs" / "data" / "yielding_accuracy.csv", ROOT / "docs" / "img" / "yielding_accuracy.png"
WALL = {35: 2.9129, 0: 1.8710}  # dilation [degree]: [mm] of a radial equation
RINGS, SOILS = (10, 20, 40, 80), (4, 8, 16)
METHODS = {"explicit": {"method": "explicit", "max_cycles": 30000}, "newton": {"method": "preconditioned"}, "newton, 8 increments": {"method": "preconditioned", "increments": 8}}
FIELDS = ("scene", "kind", "how", "blocks", "seconds", "error", "verdict")


def ring(case, n, element, how, dilation):
    """Displacement of the wall [mm], number of blocks, verdict."""
    mesh, loads = quarter_ring(n, 6 * n // 10)
    inner = [v for v, (x, y) in enumerate(mesh.vertices) if x * x + y * y < 1.5**2 + 1e-6]
    rock = {"density": 0, "young": 10e9, "poisson": 0.25, "law": "mohr_coulomb", "cohesion": 0.8e6, "friction": 35, "dilation": dilation}
    result = case.run(split_triangles(mesh) if element == "triangles" else mesh,
                      {"strain": "small", "materials": {"rock": rock if element == "triangles" else rock | {"element": element}}, "supports": {"x0": {"fix": "x"}, "y0": {"fix": "y"}},
                       "loads": loads, "relaxation": METHODS[how], "stages": [{"press": {"loads": list(loads)}}]})  # fmt: skip
    u, x = result.stage("press").displacement[inner], result.mesh.vertices[inner]
    return float(-1e3 * ((u * x).sum(axis=1) / 1.5).mean()), len(result.mesh.blocks), result.verdict


def seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measure(quoin):
    with tempfile.TemporaryDirectory() as folder:
        case = Case("yielding", quoin, folder)
        for dilation, elements in ((35, ("bending", "full", "triangles")), (0, ("bending",))):
            for how in METHODS:
                for element in elements:
                    for n in RINGS:
                        start = seconds()
                        wall, blocks, verdict = ring(case, n, element, how, dilation)
                        yield f"ring, dilation {dilation}", element, how, blocks, seconds() - start, wall / WALL[dilation] - 1, verdict
        capacity, *how = FOOTINGS[30]
        for n in SOILS:
            start = seconds()
            found, _ = pressed_footing(case, n, 30, *how)
            spent = seconds() - start
            for name, width in (("as it is", 1.0), ("half a block wider", 1 + 0.5 / n)):
                yield "footing", name, "in time", n, spent, found / width / capacity - 1, "completed"


COLOURS = {"bending": "#12456b", "full": "#d98200", "triangles": "#a81919", "as it is": "#12456b", "half a block wider": "#1a8f5a"}
MARKS = {"explicit": "o-", "newton": "s--", "newton, 8 increments": "^:", "in time": "o-"}
TICKS = (0.08, 0.1, 0.15, 0.2, 0.3, 0.5, 1, 2, 3)
TITLES = {"ring, dilation 35": "Thick ring, friction and dilation 35 degrees: wall", "ring, dilation 0": "the same without dilation", "footing": "Rough footing, friction and dilation 30 degrees: capacity"}


def draw(rows, path):
    figure, panels = pyplot.subplots(1, 3, figsize=(15, 4.6), constrained_layout=True)
    for axes, scene in zip(panels, TITLES, strict=True):
        for how in MARKS:
            for kind, colour in COLOURS.items():
                some = [row for row in rows if (row["scene"], row["kind"], row["how"]) == (scene, kind, how) and row["verdict"] != "undecided"]
                if some:
                    axes.loglog([float(row["seconds"]) for row in some], [100 * abs(float(row["error"])) for row in some], MARKS[how], color=colour, ms=5, lw=1.2, label=f"{kind}, {how}")
        axes.set_title(TITLES[scene], fontsize=10)
        axes.set_xlabel("processor time [s]")
        axes.set_xticks([t for t in TICKS if axes.get_xlim()[0] < t < axes.get_xlim()[1]])
        axes.xaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.minorticks_off()
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, fontsize=7, loc="upper right" if scene.startswith("ring") else "center right")
    panels[0].set_ylabel("error [%]")
    save_figure(figure, path, dpi=110)
    pyplot.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default="build/quoin")
    parser.add_argument("--draw", action="store_true", help="from the data that is there")
    options = parser.parse_args()
    if not options.draw:
        with open(DATA, "w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(FIELDS)
            for row in measure(os.path.abspath(options.quoin)):
                writer.writerow([f"{cell:.4g}" if isinstance(cell, float) else cell for cell in row])
                file.flush()
                print(*row, flush=True)
    with open(DATA, encoding="utf-8") as file:
        draw(list(csv.DictReader(file)), PICTURE)


if __name__ == "__main__":
    main()
