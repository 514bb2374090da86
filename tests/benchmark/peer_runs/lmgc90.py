"""LMGC90 (compas_lmgc90: rigid polyhedra, NSCD) on a wall of --n courses of --n rigid blocks: seconds per step and contact.

Blocks 1 x 1 m, 0.5 m thick, in running bond on a fixed base of one piece, 2400 kg/m3, friction 45 degrees, time step 1e-3 s, at rest
under its weight: each step finds the contacts of faces, up to four points each, and solves them by non-linear Gauss-Seidel."""

from compas_lmgc90.solver import Solver
from fig6_dam import DENSITY, FRICTION, Clock, arguments, report

DT = 1e-3  # [s]
FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def box(low, high):
    (a, b, c), (d, e, f) = low, high
    return {"vertices": [[a, b, c], [d, b, c], [d, e, c], [a, e, c], [a, b, f], [d, b, f], [d, e, f], [a, e, f]], "faces": FACES}


def wall(courses, blocks):
    """The base first; every second course is shifted by half a block."""
    yield box([-1, 0, -0.5], [blocks + 1, 0.5, 0])
    for k in range(courses):
        for i in range(blocks):
            x = i + 0.5 * (k % 2)
            yield box([x, 0, k], [x + 1, 0.5, k + 1])


def main():
    options = arguments(("--steps", {"type": int, "default": 20}))
    solver = Solver(dt=DT, density=DENSITY)
    solver.geometry_from_v_f(list(wall(options.n, options.n)))
    solver.set_supports(z_threshold=0.0)
    solver.contact_law("IQS_CLB", FRICTION)
    solver.preprocess()
    solver.lmgc90.compute_one_step()
    clock = Clock()
    for _ in range(options.steps):
        result = solver.lmgc90.compute_one_step()
    cost = clock.read()
    bodies = {tuple(sorted(pair)) for pair in result.interaction_bodies}
    report(blocks=options.n**2, contacts=len(bodies), points=len(result.interaction_bodies), dt=DT, steps=options.steps, **cost)


if __name__ == "__main__":
    main()
