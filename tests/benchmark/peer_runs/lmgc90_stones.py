"""LMGC90 (compas_lmgc90: rigid polyhedra, NSCD) on a dam of rigid stones under its weight, until its forces balance.

The stones are prisms of 1 m thickness, unilateral contact with friction (IQS_CLB), those on the base held. A step of --dt finds the contacts and solves
them by non-linear Gauss-Seidel; package 0.1.11 fixes its tolerance (1.67e-4) and iterations (25 000 a step at most). A next step goes on from the last.
Stands: the largest unbalanced force of a stone, over the forces on it, is below --residual. Falls: after 0.01 s some stone moves at a tenth of free fall.
No end: --limit seconds of processor time are over. Best: the least residual on the way.
Reads a file of voronoi_stones.py's rings: {"rings": [[[x, y], ...], ...] [m], "held": [...]}."""

import json
from pathlib import Path

import numpy as np
from compas_lmgc90.solver import Solver
from fig6_dam import DENSITY, GRAVITY, Clock, arguments, report

FALLS, EARLIEST = 0.1, 0.01  # part of free fall; [s]


def prism(ring):
    """x, y of the dam are x, z here; faces look outwards."""
    n = len(ring)
    sides = [[i + n, (i + 1) % n + n, (i + 1) % n, i] for i in range(n)]
    return {"vertices": [[x, depth, y] for depth in (0.0, 1.0) for x, y in ring], "faces": [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides]}


def area(ring):
    x, y = np.transpose(ring)
    return 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def made(rings, held, friction, dt):
    solver = Solver(dt=dt, density=DENSITY)
    solver.geometry_from_v_f([prism(ring) for ring in rings])
    for i in np.flatnonzero(held):
        solver.v_drvdof[int(i)] = {component: np.zeros(6) for component in range(1, 7)}
    solver.contact_law("IQS_CLB", float(np.tan(np.radians(friction))))
    solver.preprocess()
    return solver


def balance(step, weight, held):
    """Largest unbalanced force of a stone over the forces on it; sum of normal forces [N]."""
    pairs, force = np.array(step.interaction_bodies) - 1, np.array(step.interaction_force_global)
    total, scale = np.column_stack([0 * weight, 0 * weight, -weight]), weight.copy()
    for side, sign in ((0, 1), (1, -1)):
        np.add.at(total, pairs[:, side], sign * force)
        np.add.at(scale, pairs[:, side], np.linalg.norm(force, axis=1))
    return (np.linalg.norm(total, axis=1) / scale)[~held].max(), float(sum(local[1] for local in step.interaction_rloc))


def main():
    options = arguments(("--stones", {"required": True, "help": "file of rings"}), ("--angle", {"type": float, "default": 60.0, "help": "of friction [degree]"}),
                        ("--dt", {"type": float, "default": 1e-3, "help": "[s]"}), ("--residual", {"type": float, "default": 1e-2}),
                        ("--limit", {"type": float, "default": 300.0, "help": "[s] of processor time"}))  # fmt: skip
    dam = json.loads(Path(options.stones).read_text(encoding="utf-8"))
    held, weight = np.array(dam["held"]), np.array([DENSITY * GRAVITY * area(ring) for ring in dam["rings"]])
    solver = made(dam["rings"], held, options.angle, options.dt)
    clock, verdict, best, spent = Clock(), "no end", np.inf, []
    start = here = np.array(solver.init_coor)
    while verdict == "no end" and clock.read()["cpu_s"] < options.limit:
        step = solver.lmgc90.compute_one_step()
        spent.append(clock.read()["cpu_s"])
        residual, normal = balance(step, weight, held)
        best = min(best, residual)
        before, here, time = here, np.array(step.bodies), len(spent) * options.dt
        speed = np.linalg.norm(here - before, axis=1).max() / options.dt
        if residual <= options.residual:
            verdict = "stands"
        elif time > EARLIEST and speed > FALLS * GRAVITY * time:
            verdict = "falls"
    report(verdict=verdict, steps=len(spent), residual=residual, best=best, normal=normal, penetration=float(max(0.0, -min(step.interaction_gap))),
           moved=float(np.linalg.norm(here - start, axis=1).max()), points=len(step.interaction_bodies), first_s=spent[0], dt=options.dt, **clock.read())  # fmt: skip


if __name__ == "__main__":
    main()
