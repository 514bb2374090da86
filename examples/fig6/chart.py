"""Runs the dam of Fig. 6 with all six stress models on meshes of both families and draws the stress at the toe.

    PYTHONPATH=tools python examples/fig6/chart.py [--quoin build/quoin] [--output docs/img]

Writes fig6_stress_models.png and fig6_stress_models.csv. About 30 s on 2 cores (2026-11)."""

import argparse
import csv
import io
import os
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from quoin_tools.base.files import save_figure, write_file  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from triangle_dam import triangle_dam  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
MODELS = ("pt", "r2pt", "r3pt", "t2pt", "t3pt", "tptm")
SIZES = (2, 4, 8, 16, 32)
FAMILIES = {"M": "mapped mesh, n by n blocks", "G": "grid of rectangles, triangles on the slope"}
COLUMNS = ("family", "n", "model", "toe_MPa", "heel_MPa", "crest_ux_mm", "cycles")
# colour-blind safe; the last three lie on one line, so their marks differ
STYLES = {
    "pt": {"color": "#d55e00", "marker": "o"},
    "r2pt": {"color": "#e69f00", "marker": "s"},
    "r3pt": {"color": "#009e73", "marker": "D"},
    "t2pt": {"color": "#0072b2", "marker": "+", "markersize": 13, "markeredgewidth": 1.6, "linestyle": "none"},
    "t3pt": {"color": "#cc79a7", "marker": "x", "markersize": 9, "markeredgewidth": 1.6, "linestyle": "none"},
    "tptm": {"color": "#0072b2", "marker": ".", "markersize": 7},
}


def solve(quoin, family, n, model, folder):
    """One run; a row of the table."""
    mesh = os.path.join(folder, "model.h5")
    write(mesh, triangle_dam(n, family))
    command = [quoin, "-options_file", os.path.join(HERE, "scene.yaml"), "-model", mesh, "-output", folder,
               "-joints_base_stress_model", model]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"chart.py: {' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    stage = Results(folder).stage_summary("full")
    base = stage["joints"]["base"]
    return (family, n, model, base["end"]["sigma"] * 1e-6, base["start"]["sigma"] * 1e-6,
            stage["probes"]["crest"]["u_x"] * 1e3, stage["cycles"])


def draw(rows, path):
    figure, panels = pyplot.subplots(1, 2, figsize=(10, 4.6), sharey=True, constrained_layout=True)
    for axes, (family, title) in zip(panels, FAMILIES.items()):
        for model in MODELS:
            points = [(row[1], row[3]) for row in rows if row[0] == family and row[2] == model]
            axes.plot(*zip(*points), label=model, **STYLES[model])
        axes.set_xscale("log", base=2)
        axes.set_xticks(SIZES, SIZES)
        axes.minorticks_off()
        axes.grid(alpha=0.3)
        axes.set_title(title)
        axes.set_xlabel("blocks along the base")
    panels[0].set_ylabel("normal stress at the toe [MPa]\n(tension positive)")
    panels[0].legend(title="stress model", ncols=2)
    figure.suptitle("Toe stress of the dam of Fig. 6: elastic joint, self-weight and full reservoir")
    save_figure(figure, path, dpi=130)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default="build/quoin", help="the program (default: build/quoin)")
    parser.add_argument("--output", default="docs/img", help="folder for picture and table (default: docs/img)")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        rows = [solve(options.quoin, family, n, model, folder)
                for family in FAMILIES for n in SIZES for model in MODELS]
    path = os.path.join(options.output, "fig6_stress_models")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([f"{x:.5f}" if isinstance(x, float) else x for x in row] for row in rows)
    write_file(path + ".csv", text.getvalue())
    draw(rows, path + ".png")
    print(f"{path}.csv\n{path}.png")


if __name__ == "__main__":
    main()
