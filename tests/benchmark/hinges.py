"""Limits of rigid blocks over k_n, beside closed forms: docs/img/hinges.png and the table of docs/rigid_blocks.md.

    PYTHONPATH=tools python tests/benchmark/hinges.py --quoin build/quoin

A column of 1 x 10 m, in one piece and of 5 stones, tilted; one of 2 x 10 m under water; a semicircular arch of 30 stones that is
made thinner; and a block that slides. Each limit is found by bisection of runs. Two minutes."""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tests" / "verification" / "hinges"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark")]

import matplotlib  # noqa: E402

matplotlib.use("Agg")
from case import RHO, SCENE, B, G, H, arch, hinge_length  # noqa: E402
from driver import ENVIRONMENT, VERDICTS, changed  # noqa: E402
from matplotlib import pyplot  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import join, rectangle, renamed  # noqa: E402
from record import replace_between  # noqa: E402

STIFFNESSES = (1e9, 1e10, 1e11, 1e12, 1e13)
WEIGHT = RHO * G * B * H


def turned(mesh, slope):
    c, s = np.cos(-slope), np.sin(-slope)
    mesh.vertices = mesh.vertices @ np.array([[c, s], [-s, c]])
    return mesh


def stones(n):
    """A column of n stones on a base."""
    parts = [renamed(rectangle(0.0, i * H / n, B, H / n, group="block", rigid=True), {"upstream": "left"}) for i in range(n)]
    return join([renamed(rectangle(-4.0, -1.0, 9.0, 1.0, group="base", rigid=True)), *parts])


def water(level):
    mesh = join([renamed(rectangle(0.0, 0.0, 2.0, H, group="block", rigid=True), {"upstream": "left"}),
                 renamed(rectangle(-3.0, -1.0, 9.0, 1.0, group="base", rigid=True))])
    return mesh, [("loads.water", {"type": "reservoir", "faces": "upstream", "level": float(level)}), ("stages", [{"rest": {"loads": ["weight", "water"]}}])]


def slides():
    part = renamed(rectangle(0.0, 0.0, 2.0, 1.0, group="block", rigid=True))
    return join([renamed(rectangle(-4.0, -1.0, 10.0, 1.0, group="base", rigid=True)), part])


HIGH = ("joints.default.friction", 70)
SEMICIRCLE = 0.1075  # Milankovitch: least thickness over radius
# name: (mesh and changes of the scene at a load factor 1 of rigid statics, closed form of 1 - limit over k_n or None)
CASES = {
    "column, tilted": (lambda x: (turned(stones(1), np.arctan(x * B / H)), []), lambda k: hinge_length(WEIGHT, H / 2, k) / B),
    "column of 5 stones, tilted": (lambda x: (turned(stones(5), np.arctan(x * B / H)), []), None),
    "column under water, thrust": (lambda x: water(np.cbrt(x * 3 * 2 * WEIGHT * 2.0 / (1000 * G))), lambda k: hinge_length(2 * WEIGHT, H / 2, k) / 2.0),
    "arch, thickness": (lambda x: (arch(SEMICIRCLE / x), [HIGH, ("relaxation", {"tolerance": 1e-5, "max_cycles": 1000000})]), None),
    "block that slides, slope": (lambda x: (turned(slides(), np.arctan(x * np.tan(np.radians(30)))), [("joints.default.friction", 30)]), lambda k: 0.0),
}


def stands(quoin, folder, mesh, scene):
    write(os.path.join(folder, "model.h5"), mesh)
    with open(os.path.join(folder, "scene.yaml"), "w", encoding="utf-8") as file:
        yaml.safe_dump({"model": "model.h5"} | scene, file, sort_keys=False)
    done = subprocess.run([quoin, "-options_file", "scene.yaml"], cwd=folder, env=os.environ | ENVIRONMENT, capture_output=True, text=True, check=False)
    if VERDICTS.get(done.returncode) not in ("converged", "collapsed"):
        raise RuntimeError(f"exit code {done.returncode}: {done.stdout[-500:]}{done.stderr[-500:]}")
    return done.returncode == 0


def limit(quoin, name, k_n):
    """Part of the rigid limit."""
    low, high = 0.6, 1.04
    with tempfile.TemporaryDirectory() as folder:
        while high - low > 1e-3:
            middle = 0.5 * (low + high)
            mesh, more = CASES[name][0](middle)
            scene = changed(SCENE, ("joints.default.k_n", k_n), ("joints.default.k_s", k_n), *more)
            low, high = (middle, high) if stands(quoin, folder, mesh, scene) else (low, middle)
    return 0.5 * (low + high)


def chart(found, path):
    figure, axes = pyplot.subplots(figsize=(7.5, 4.6))
    fine = np.geomspace(STIFFNESSES[0], STIFFNESSES[-1], 60)
    for colour, (name, values) in zip(("#12456b", "#d98200", "#1a8f5a", "#a81919", "#7a7a7a"), found.items()):
        axes.semilogx(STIFFNESSES, values, "o", color=colour, label=name)
        if CASES[name][1]:
            axes.semilogx(fine, [1 - CASES[name][1](k) for k in fine], "-", lw=1.2, color=colour)
    axes.axhline(1.0, color="black", lw=0.8)
    axes.set_xlabel("k_n of the joints, tptm [Pa/m]")
    axes.set_ylabel("limit over that of rigid statics [-]")
    axes.legend(frameon=False, loc="lower right")
    axes.grid(alpha=0.3)
    axes.set_title("Points: Quoin. Lines: 1 - a/b, a = (12 W h / k_n)^(1/3)", fontsize=10)
    save_figure(figure, path, dpi=110, bbox_inches="tight")
    pyplot.close(figure)


def lines(found):
    yield "| limit over that of rigid statics | " + " | ".join(f"k_n {k:.0e}".replace("+", "") for k in STIFFNESSES) + " |"
    yield "|---|" + "---:|" * len(STIFFNESSES)
    for name, values in found.items():
        yield f"| {name} | " + " | ".join(f"{value:.3f}" for value in values) + " |"
        if CASES[name][1]:
            yield "| ... closed form | " + " | ".join(f"{1 - CASES[name][1](k):.3f}" for k in STIFFNESSES) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default="build/quoin")
    quoin = os.path.abspath(parser.parse_args().quoin)
    found = {name: [limit(quoin, name, k) for k in STIFFNESSES] for name in CASES}
    chart(found, ROOT / "docs" / "img" / "hinges.png")
    replace_between("hinges", "\n".join(lines(found)) + "\n")
    print("\n".join(lines(found)))


if __name__ == "__main__":
    main()
