"""Runs blocks that fall, slide off an edge and rock, and a rocking block by all six stress models; draws them.

    PYTHONPATH=tools python examples/motion/chart.py [--quoin build/quoin] [--output docs/img] [--seconds 20]

Writes motion_frames.png, motion_energy.png and motion_energy.csv. About 8 s on 1 core (2026-11)."""

import argparse
import csv
import importlib.util
import io
import os
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import numpy as np  # noqa: E402
from matplotlib import pyplot  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from quoin_tools.base.files import save_figure, write_file  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
MODELS = {"pt": "#d55e00", "r2pt": "#e69f00", "r3pt": "#009e73", "t2pt": "#cc79a7", "t3pt": "#56b4e9", "tptm": "#0072b2"}
LEVEL = ("kinetic_J", "strain_J", "joints_J")
# of each picture: title, mesh, options beyond those of scene.yaml, frames shown [s]
MOVES = [
    ("a column of ten falls", "column", {"materials_block_velocity": "0,0", "joints_default_friction": "35", "stages_move_duration": "1"}, (0, 0.15, 0.3, 0.6, 1)),
    ("a block slides off an edge", "edge", {}, (0, 0.35, 0.55, 0.75, 1.6)),
    ("a leaning block rocks", "leaning", {"materials_block_velocity": "0,0", "joints_default_friction": "60"}, (0, 0.5, 0.8, 1.1, 1.6)),
]


def load_meshes():
    spec = importlib.util.spec_from_file_location("mesh", os.path.join(HERE, "mesh.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def solve(quoin, mesh, folder, options):
    os.makedirs(folder)
    model = os.path.join(folder, "model.h5")
    write(model, mesh)
    command = [quoin, "-options_file", os.path.join(HERE, "scene.yaml"), "-model", model, "-output", folder]
    for key, value in options.items():
        command += [f"-{key}", value]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):  # 3: r2pt, r3pt, t2pt and t3pt make energy, which ends a stage as diverged
        sys.exit(f"chart.py: {' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    return Results(folder)


# ---- pictures of motion


def draw_blocks(axes, result, stage):
    mesh, moved = result.mesh, result.mesh.vertices + stage.displacement
    rigid = mesh.block_group == mesh.group_names.index("base")
    for mask, colour in ((rigid, "#b8b8b8"), (~rigid, "#e3b980")):
        axes.add_collection(PolyCollection(moved[mesh.blocks[mask]], facecolor=colour, edgecolor="#333333", linewidth=0.7))


def frames(quoin, folder, path):
    meshes = load_meshes().MESHES
    figure, panels = pyplot.subplots(3, 5, figsize=(12, 8.5), height_ratios=(3, 1, 1.8), constrained_layout=True)
    for row, (title, name, options, times) in zip(panels, MOVES):
        mesh = meshes[name]()
        result = solve(quoin, mesh, os.path.join(folder, name), options)
        stages = [result.stage(frame) for frame in [*result.frames("move"), "move"]]
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        for axes, time in zip(row, times):
            stage = min(stages, key=lambda s, t=time: abs(s.time - t))
            draw_blocks(axes, result, stage)
            axes.set_xlim(low[0] - 0.2, high[0] + 0.2)
            axes.set_ylim(low[1] - 0.1, high[1] + 0.2)
            axes.set_aspect("equal")
            axes.set_title(f"t = {stage.time:.2f} s")
            axes.tick_params(labelsize=8)
        row[0].set_ylabel(f"{title}\ny [m]")
    for axes in panels[-1]:
        axes.set_xlabel("x [m]")
    save_figure(figure, path, dpi=110)


# ---- energy of a rocking block by stress model


def rocking(quoin, folder, model, seconds):
    """t [s] and the change of its energy over that of the spin it starts with."""
    meshes = load_meshes()
    mesh = join([meshes.rigid(-2, -0.5, 4, 0.5, "base"), meshes.rigid(0, 0, 0.5, 2, "block")])
    options = {"materials_block_spin": "-0.5", "materials_block_velocity": "0,0.125", "joints_default_damping": "0",
               "joints_default_k_n": "1e8", "joints_default_k_s": "0", "joints_default_friction": "60",
               "joints_default_stress_model": model, "stages_move_duration": str(seconds), "stages_move_frames": "0",
               "stages_move_dt_factor": "0.02", "relaxation_history_every": "500"}
    history = solve(quoin, mesh, os.path.join(folder, model), options).history
    mine = np.isfinite(history["balance_J"])
    total = sum(history[name][mine] for name in LEVEL) - history["outside_J"][mine]
    return history["time_s"][mine], (total - total[0]) / history["kinetic_J"][mine][0]


def energy(quoin, folder, path, seconds):
    curves = {model: rocking(quoin, folder, model, seconds) for model in MODELS}
    figure, axes = pyplot.subplots(figsize=(9, 4.8), constrained_layout=True)
    for model, colour in MODELS.items():
        t, drift = curves[model]
        axes.plot(t, drift, color=colour, label=model, linewidth=2.2 if model in ("pt", "tptm") else 1.2,
                  linestyle="--" if model == "pt" else "-", zorder=4 if model == "pt" else 3)
    axes.set_yscale("symlog", linthresh=0.5)
    ticks = (-10, -1, -0.5, 0, 0.5, 1, 10, 100)
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xlabel("time [s]")
    axes.set_ylabel("change of the energy\nover that given at the start [-]")
    axes.set_title("A rocking block without friction, damping or shear stiffness: its energy should not change")
    axes.grid(alpha=0.3)
    axes.legend(title="stress model", ncols=2)
    save_figure(figure, path + ".png", dpi=120)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["model", "change at the end", "largest change", "over [s]"])
    for model, (t, drift) in curves.items():
        writer.writerow([model, f"{drift[-1]:.3g}", f"{drift[np.argmax(np.abs(drift))]:.3g}", f"{t[-1]:.3g}"])
    write_file(path + ".csv", text.getvalue())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default="build/quoin", help="the program (default: build/quoin)")
    parser.add_argument("--output", default="docs/img", help="folder for pictures and table (default: docs/img)")
    parser.add_argument("--seconds", type=float, default=20, help="of the rocking block (default: 20)")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        frames(options.quoin, folder, os.path.join(options.output, "motion_frames.png"))
        energy(options.quoin, folder, os.path.join(options.output, "motion_energy"), options.seconds)
    for name in ("motion_frames.png", "motion_energy.png", "motion_energy.csv"):
        print(os.path.join(options.output, name))


if __name__ == "__main__":
    main()
