"""CalculiX on the dam of Fig. 6: CPE4 and CPE3, which it expands to a layer of bricks and wedges; SPOOLES, one increment.

--joint springs: linear springs across the joint at the nodes of the base, k_n and k_s times a node's share (elastic only).
--joint node, face: penalty contact, node to face or face to face, of the base with a fixed row of elements below it:
pressure k_n times the overclosure, stick slope k_s, friction 1, no tension; elastic: face to face with behaviour TIED,
which is an elastic joint. Seconds are of the whole process; CalculiX does not tell those of reading and writing apart."""

import os
import subprocess
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN

import numpy as np
from fig6_dam import BASE, FRICTION, K_N, K_S, POISSON, YOUNG, Clock, Dam, arguments, report


def elements(kind, name, first, nodes):
    """Lines of elements numbered from first; nodes from 0."""
    lines = [f"{i}, {', '.join(str(v + 1) for v in row)}" for i, row in enumerate(nodes, first)]
    return [f"*ELEMENT, TYPE={kind}, ELSET={name}", *lines]


def springs(dam, first, top):
    """Four groups: inner and end nodes of the base, along and across the joint."""
    lines, ends = [], np.isin(dam.base, dam.base[[0, -1]])
    for name, mine in (("INNER", ~ends), ("END", ends)):
        for direction, stiffness in ((1, K_S), (2, K_N)):
            pairs = np.column_stack([dam.base, top])[mine]
            lines += elements("SPRING2", f"{name}{direction}", first, pairs)
            lines += [f"*SPRING, ELSET={name}{direction}", f"{direction}, {direction}", f"{stiffness * dam.share[mine][0]:.12e}"]
            first += len(pairs)
    return lines


def contact(dam, first, below, kind, friction):
    """The fixed row below and the contact pair; the first elements of the dam stand on the base."""
    top, bottom = below
    count = dam.n
    behaviour = f"LINEAR\n{K_N:.6e}, 1., 1.e-3" if friction else f"TIED\n{K_N:.6e}"
    return [*elements("CPE4", "GROUND", first, np.column_stack([bottom[:-1], bottom[1:], top[1:], top[:-1]])),
            "*SOLID SECTION, ELSET=GROUND, MATERIAL=MASONRY", "1.",
            "*SURFACE, NAME=DAM_BASE", *(f"{i}, S1" for i in range(1, count + 1)),
            "*SURFACE, NAME=GROUND_TOP", *(f"{i}, S3" for i in range(first, first + count)),
            "*SURFACE INTERACTION, NAME=JOINT", f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE={behaviour}",
            "*FRICTION", f"{FRICTION}, {K_S:.6e}",
            f"*CONTACT PAIR, INTERACTION=JOINT, TYPE={'NODE' if kind == 'node' else 'SURFACE'} TO SURFACE",
            "DAM_BASE, GROUND_TOP"]  # fmt: skip


def deck(dam, kind, friction):
    """The input; numbers of at most 20 characters, as CalculiX reads them."""
    top = len(dam.xy) + np.arange(len(dam.base))
    below = [top] if kind == "springs" else [top, top + len(top)]
    xy = np.vstack([dam.xy, *(dam.xy[dam.base] - [0, k * BASE / dam.n] for k in range(len(below)))])
    first = 1 + len(dam.quads) + len(dam.triangles)
    joint = springs(dam, first, top) if kind == "springs" else contact(dam, first, below, kind, friction)
    return "\n".join([
        "*NODE", *(f"{i}, {x:.12e}, {y:.12e}, 0." for i, (x, y) in enumerate(xy, 1)),
        *elements("CPE4", "DAM", 1, dam.quads), *elements("CPE3", "DAM", 1 + len(dam.quads), dam.triangles),
        "*NSET, NSET=FIXED", *(str(v + 1) for v in np.concatenate(below)),
        "*NSET, NSET=ASKED", *(str(v + 1) for v in (*dam.base, dam.crest)),
        "*MATERIAL, NAME=MASONRY", "*ELASTIC", f"{YOUNG:.6e}, {POISSON}", "*SOLID SECTION, ELSET=DAM, MATERIAL=MASONRY", "1.",
        *joint, "*BOUNDARY", f"FIXED, 1, {3 if kind == 'springs' else 2}", "*STEP", "*STATIC", "1., 1.", "*CLOAD",
        *(f"{i}, {k}, {force:.12e}" for i, row in enumerate(dam.loads, 1) for k, force in enumerate(row, 1) if force),
        "*NODE PRINT, NSET=ASKED", "U", "*END STEP", ""])  # fmt: skip


def main():
    options = arguments(("--joint", {"choices": ("springs", "node", "face"), "default": "face"}), ("--program", {"default": "ccx"}))
    dam = Dam(options.n)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "dam.inp").write_text(deck(dam, options.joint, options.friction), encoding="ascii")
        clock = Clock(RUSAGE_CHILDREN)
        done = subprocess.run([options.program, "dam"], cwd=folder, capture_output=True, text=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
        cost = clock.read()
        if "Job finished" not in done.stdout:
            raise SystemExit(f"ccx: {done.stdout[-500:]}")
        # the last table holds node, u_x, u_y, u_z
        table = [line.split() for line in Path(folder, "dam.dat").read_text(encoding="ascii").splitlines()]
        u = np.array([row[1:] for row in table if len(row) == 4], dtype=float)[-len(dam.base) - 1:]
        iterations = int(Path(folder, "dam.sta").read_text(encoding="ascii").split()[-4])
    report(crest=u[-1, 0], toe=dam.toe_stress(u[:-1, 1]), iterations=iterations, **cost)


if __name__ == "__main__":
    main()
