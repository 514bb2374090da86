"""Draws the figures of docs/theory.md: docs/img/theory_*.png, in half a minute.

    PYTHONPATH=tools python examples/theory_figures.py

The first three are drawn from the equations, the fourth from a chain of masses that relaxes by (11)-(38) as the paper has them, the last
from two runs of `quoin` (the dam of `quoin new`).
"""

import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib import pyplot
from matplotlib.patches import Polygon
from quoin_tools.base.files import save_figure
from quoin_tools.show.style import STYLE

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs/img"
STONE, ROCK, BLUE, RED, GREEN = "#e8dfd0", "#c9c9c9", "#0072B2", "#D55E00", "#009E73"


def arrow(axes, start, end, colour="black", style="-|>"):
    axes.annotate("", end, start, arrowprops={"arrowstyle": style, "color": colour, "shrinkA": 0, "shrinkB": 0, "lw": 1.3})


def model():
    """Macroblocks of blocks, and a face contact with its two sub-contacts."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9.5, 4), width_ratios=[1.15, 1])
    dam = np.array([[(x * (6 - 4.4 * y), 0.25 + 5 * y) for x in np.linspace(0, 1, 5)] for y in np.linspace(0, 1, 6)])
    for lower, upper, colour in ((0, 3, STONE), (3, 5, "#f3ead9")):
        for row in range(lower, upper):
            for column in range(4):
                corners = [dam[row, column], dam[row, column + 1], dam[row + 1, column + 1], dam[row + 1, column]]
                left.add_patch(Polygon(np.array(corners) + [0, 0.25 * (lower > 0)], facecolor=colour, edgecolor="grey", lw=0.7))
    for column in range(6):
        left.add_patch(Polygon([(-3 + 2 * column, -2), (-1 + 2 * column, -2), (-1 + 2 * column, 0), (-3 + 2 * column, 0)], facecolor=ROCK, edgecolor="grey", lw=0.7))
    left.annotate("block: 3 or 4 vertices", (4.0, 1.0), (5.6, 2.3), arrowprops={"arrowstyle": "-"})
    left.annotate("macroblock: blocks\nthat share vertices", (2.6, 2.4), (4.6, 3.7), arrowprops={"arrowstyle": "-"})
    left.annotate("joint: all contacts\nbetween two macroblocks", (1.8, 3.4), (3.6, 5.1), arrowprops={"arrowstyle": "-"})
    left.text(3, -1.1, "rock, one macroblock more", ha="center")
    left.set(xlim=(-3.2, 9.3), ylim=(-2.2, 6.2), aspect="equal", title="Blocks and macroblocks (parted for the picture)")

    right.add_patch(Polygon([(0.2, -1.6), (8, -1.6), (8, 0), (0.2, 0)], facecolor=ROCK, edgecolor="grey"))
    right.add_patch(Polygon([(1.5, 0.9), (7, 0.5), (7, 2.4), (1.5, 2.8)], facecolor=STONE, edgecolor="grey"))
    for x, y, name in ((1.5, 0.9, "1"), (7.0, 0.5, "2")):
        right.plot(x, y, "o", color=BLUE)
        right.text(x, y + 0.2, f" P{name}", color=BLUE)
        right.plot(x, 0, "s", color=RED, ms=5)
        arrow(right, (x, 0), (x, y), BLUE, "<->")
        right.text(x + 0.15, y / 2 - 0.12, f"$u_{{n,{name}}}$", color=BLUE)
    for start, end, name in ((1.5, 4.25, "$L_{i,1} = L/2$"), (4.25, 7, "$L_{i,2} = L/2$")):
        arrow(right, (start, -0.45), (end, -0.45), "black", "<->")
        right.text((start + end) / 2, -0.85, name, ha="center")
    arrow(right, (1.5, -1.2), (3.3, -1.2), GREEN)
    right.text(1.5, -1.55, "$s$, along $u_s$", color=GREEN)
    arrow(right, (0.7, 0), (0.7, 1.1), GREEN)
    right.text(0.45, 1.2, "$n$", color=GREEN)
    right.text(4.3, 0.95, "source edge", ha="center", rotation=-4)
    right.text(5.7, -1.35, "destination edge", ha="center")
    right.set(xlim=(0, 8.2), ylim=(-1.8, 3), aspect="equal", title="A face contact: two sub-contacts, P1 and P2")
    for axes in (left, right):
        axes.axis("off")
    return figure


def joint():
    """The law of a place: tension and crushing, shear, envelope."""
    figure, axes = pyplot.subplots(1, 3, figsize=(10, 3.2))
    k, tension, crush = 1.0, 0.5, 2.2
    u = np.linspace(-3, tension, 200)
    axes[0].plot(u, np.maximum(k * u, -crush), color=BLUE)
    axes[0].plot([tension, tension, 2], [tension, 0, 0], color=BLUE)
    axes[0].plot([-3, -3 + crush], [-crush, 0], "--", color="grey")
    axes[0].text(-2.95, -2.55, "crushing strength", fontsize=8)
    axes[0].text(0.6, 0.15, "tensile strength,\nlost when passed", fontsize=8)
    axes[0].text(-0.85, -1.4, "$k_n$", color=BLUE)
    axes[0].set(ylim=(-2.8, 1.1), xlabel="opening $u_n$", ylabel="normal stress $\\sigma$", title="(5): $\\sigma = k_n\\,u_n$")
    axes[1].plot([-1, 1.2, 1.2, 3], [-1, 1.2, 0.9, 0.9], color=BLUE)
    axes[1].plot([2.2, 1.3], [0.9, 0], "--", color="grey")
    axes[1].text(1.3, 1.15, "peak, then residual", fontsize=8)
    axes[1].text(1.5, 0.05, "slip", fontsize=8)
    axes[1].text(0.25, 0.6, "$k_s$", color=BLUE)
    axes[1].set(xlabel="sliding $u_s$", ylabel="shear stress $\\tau$", title="(6): $\\tau = k_s\\,(u_s - slip)$")
    sigma = np.linspace(-3, 0.5, 50)
    axes[2].plot(sigma, 0.6 - 0.8 * sigma, color=BLUE, label="peak: $c - \\sigma\\,\\tan\\varphi$")
    axes[2].plot([0.5, 0.5], [0, 0.2], color=BLUE)
    axes[2].plot(sigma[sigma <= 0], -0.7 * sigma[sigma <= 0], color=RED, label="residual")
    axes[2].legend(fontsize=8)
    axes[2].set(xlabel="normal stress $\\sigma$ (tension +)", ylabel="shear strength", title="Mohr and Coulomb, with cut-offs", ylim=(0, 3.4))
    for one in axes:
        one.axhline(0, color="black", lw=0.6)
        one.axvline(0, color="black", lw=0.6)
        one.set(xticks=[], yticks=[])
    return figure


def stress_models():
    """What six ways of integration make of one contact that is open over a part of its length. Forces over k_n times length times closure of the pressed end."""
    closed = 0.6  # end 0 is pressed, end 1 open; sigma is zero from here on
    at = lambda x: np.minimum(0.0, -(1 - np.asarray(x) / closed))  # noqa: E731
    s = at([0, 0.5, 1])
    rows = {"pt": (1 / 2, 0, 0), "r2pt": (3 / 8, 0, 1 / 8), "r3pt": (7 / 32, 8 / 32, 1 / 32), "t2pt": (2 / 6, 0, 1 / 6), "t3pt": (5 / 24, 6 / 24, 1 / 24)}
    x = np.linspace(0, 1, 401)
    diagrams = {"pt": np.where(x < 0.5, s[0], s[2]), "r2pt": np.where(x < 0.5, s[0], s[2]), "r3pt": np.select([x < 0.25, x < 0.75], [s[0], s[1]], s[2]),
                "t2pt": np.interp(x, [0, 1], s[[0, 2]]), "t3pt": np.interp(x, [0, 0.5, 1], s), "tptm": at(x)}  # fmt: skip
    figure, axes = pyplot.subplots(2, 3, figsize=(9.5, 4.6), sharex=True, sharey=True)
    for one, (name, diagram) in zip(axes.flat, diagrams.items(), strict=True):
        row = rows.get(name)
        forces = (row @ s, row[::-1] @ s) if row else (np.trapezoid(diagram * (1 - x), x), np.trapezoid(diagram * x, x))
        one.plot(x, at(x), "--", color="grey", label="the law, at every place")
        one.fill_between(x, diagram, color=BLUE, alpha=0.25, label="what the model integrates")
        for place, force in zip((0, 1), forces, strict=True):
            if force < -1e-3:
                arrow(one, (place, 0.75 * -force / 0.5), (place, 0), RED)
        one.set_title(f"{name}:  end forces {abs(forces[0]):.3f}, {abs(forces[1]):.3f}", fontsize=9)
        one.axhline(0, color="black", lw=0.8)
        one.set(xlim=(-0.06, 1.06), ylim=(-1.1, 0.85), xticks=[0, 1], yticks=[])
        one.set_xticklabels(["pressed end", "open end"])
    axes[0, 0].legend(fontsize=7, loc="lower right")
    return figure


def chain(damping, n=20, cycles=600):
    """A chain of n masses under its weight: displacement of its end over that at rest, unbalanced ratio; alpha by (35)-(38), 0, or a number."""
    stiffness = np.diag(np.full(n, 2.0)) - np.eye(n, k=1) - np.eye(n, k=-1)
    stiffness[-1, -1] = 1
    load = np.ones(n)
    mass = np.abs(stiffness).sum(axis=1) / (4 * 0.9**2)  # (33), dt = 1, safety 0.9
    u, v, before, alpha, ends, ratios = np.zeros(n), np.zeros(n), np.zeros(n), 0.0, [], []
    for _ in range(cycles):
        force = stiffness @ u
        if damping is None and v @ v > 0:
            alpha = 2 * np.sqrt(max(0.0, (force - before) @ v / (v @ (mass * v))))  # (35)-(38)
        alpha = min(damping if damping is not None else alpha, 1.9)
        before = force
        v = (v * (1 - alpha / 2) + (load - force) / mass) / (1 + alpha / 2)  # (11)-(13)
        u = u + v  # (17)-(18)
        ends.append(u[-1])
        ratios.append(np.abs(load - stiffness @ u).sum() / load.sum())
    return np.array(ends) / np.linalg.solve(stiffness, load)[-1], ratios


def relaxation():
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9.5, 3.4))
    for damping, colour, name in ((0.0, "grey", "no damping"), (1.5, RED, "alpha = 1.5, too much"), (None, BLUE, "alpha by (35)-(38)")):
        end, ratio = chain(damping)
        left.plot(end, color=colour, label=name)
        right.semilogy(ratio, color=colour)
    left.set(xlabel="cycle", ylabel="end of the chain, over its rest", title="A chain of 20 masses under its weight")
    right.set(xlabel="cycle", ylabel="unbalanced force / load", title="How far from equilibrium", ylim=(1e-8, 3))
    left.legend(fontsize=8, loc="upper right", framealpha=1)
    return figure


def verdicts():
    """The stage `full` of the dam of `quoin new --height 38` with 45 degrees, which stands, and with 37."""
    figure, axes = pyplot.subplots(1, 2, figsize=(9.5, 3.4))
    quoin = [sys.executable, str(ROOT / "tools/quoin.py")]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([*quoin, "new", ".", "--height", "38"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        for friction, colour in ((45, BLUE), (37, RED)):
            subprocess.run([*quoin, "run", "scene.yaml", "-stages", "empty,full", "-joints_base_friction", str(friction), "-relaxation_method", "explicit", "-output", str(friction)],
                           cwd=folder, check=friction == 45, stdout=subprocess.DEVNULL)  # fmt: skip
            with Path(folder, str(friction), "history.csv").open(encoding="utf-8") as file:
                rows = [row for row in csv.DictReader(file) if row["stage"] == "full"]
            cycle = [int(row["cycle"]) for row in rows]
            axes[0].semilogy(cycle, [float(row["ratio"]) for row in rows], color=colour, label=f"friction {friction} degrees")
            axes[1].plot(cycle, [1e3 * float(row["crest_upstream_ux_m"]) for row in rows], color=colour)
    axes[0].axhline(1e-6, ls="--", color="grey")
    axes[0].text(6500, 1.4e-6, "tolerance", fontsize=8)
    axes[0].legend(fontsize=8)
    axes[0].set(xlabel="cycle", ylabel="unbalanced ratio", title="It falls, or it stays")
    axes[1].set(xlabel="cycle", ylabel="crest [mm]", title="It comes to rest, or it moves on", ylim=(-5, 60))
    return figure


if __name__ == "__main__":
    os.environ.setdefault("QUOIN_SOLVER", str(ROOT / "build/quoin"))
    with pyplot.rc_context(STYLE):
        for draw in (model, joint, stress_models, relaxation, verdicts):
            figure = draw()
            save_figure(figure, IMAGES / f"theory_{draw.__name__}.png")
            pyplot.close(figure)
            print(f"wrote docs/img/theory_{draw.__name__}.png")
