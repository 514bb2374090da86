#!/usr/bin/env python3
"""The tables of a cycle in docs/generated/benchmarks.md: what run.py measures, kept in docs/data/cycle.json.

    PYTHONPATH=tools python tests/benchmark/cycle.py                     # some minutes, on a quiet machine
    PYTHONPATH=tools python tests/benchmark/cycle.py --scenes tptm --sides 32    # these again, the others stay

Nanoseconds on one rank, instructions at side 32, what two ranks tell each other, and the cycle with plain sums
(bench_plain_sums), whose bits depend on their order."""

import argparse
import os

import run
from record import keep, replace_between, table

IDENTITY = ("unit", "program", "scene", "side", "ranks", "exchange_by")
SIDES = {scene: [32] for scene in run.SCENES} | {"block": [32, 100, 316, 1000], "t2pt": [32, 100, 316], "tptm": [32, 100, 316]}
KERNELS = [  # what, of each, scene and part
    ("4 vertices, full", "block", "block", "elements"),
    ("4 vertices, full, small strain", "block", "block small", "elements"),
    ("4 vertices, `bending`", "block", "bending", "elements"),
    ("4 vertices, `reduced`", "block", "reduced", "elements"),
    ("3 vertices", "block", "triangles", "elements"),
    ("3 vertices, small strain", "block", "triangles small", "elements"),
    ("rigid, of 4 vertices", "body", "rigid", "rigid"),
    ("condensed", "entry of S", "condensed", "condensed"),
    ("motion, sums included", "vertex", "block small", "motion"),
    ("elastic, any stress model, faces match", "contact", "tptm", "contacts"),
    ("elastic, any stress model, faces do not match", "contact", "tptm uneven", "contacts"),
    *((f"slides or is open, {model}", "contact", f"{model} slides", "contacts") for model in ("pt", "r2pt", "r3pt", "t2pt", "t3pt", "tptm")),
    ("half open, tptm, cohesion breaks", "contact", "tptm open", "contacts"),
    ("slides or is open, tptm, dynamic stage", "contact", "tptm in time", "contacts"),
]
UNITS = {"ns": "{:.1f}", "instructions": "{:.0f}"}
EXCHANGE = {"auto": "through shared memory", "messages": "by messages (PetscSF, MPI_Allreduce)"}


def at_full_clock(options, path, scene, side):
    """Of several runs, seconds apart, the one in which the processor's clock was the fastest."""
    rows = [run.measure(path, scene, side, 1, options.seconds) for _ in range(options.tries)]
    return min(rows, key=lambda row: sum(run.least(row, part) for part in run.PARTS))


def measured(options):
    """Rows of one scene after another, each with what identifies it."""
    for program, scenes in (("bench_cycle", options.scenes), ("bench_plain_sums", [s for s in options.scenes if s == "block"])):
        path = os.path.join(options.folder, program)
        own = {"program": program, "exchange_by": "auto"}
        for scene in scenes if "ns" in options.units else ():
            for side in options.sides or SIDES[scene]:
                yield run.show(at_full_clock(options, path, scene, side)) | own | {"unit": "ns"}
        for row in run.instructions(path, scenes) if scenes and "instructions" in options.units else ():
            yield run.show(row) | own | {"unit": "instructions"}
    both = "block" in options.scenes and "ns" in options.units
    for row in run.exchange(os.path.join(options.folder, "bench_cycle"), [32, 316], [2], options.seconds) if both else ():
        yield row | {"unit": "ns", "program": "bench_cycle", "exchange_by": row.pop("how")}


def lines_of(rows, scene, count, cells):
    """A line a size, then one of instructions; cells: of a row and of the function that finds another like it."""
    lines = []
    for unit, form in UNITS.items():
        own = [row for row in rows if (row["unit"], row["scene"], row["program"], row["ranks"]) == (unit, scene, "bench_cycle", 1)]
        for row in sorted(own, key=lambda row: row["side"]):
            first = row[count] if unit == "ns" else f"instructions (x86-64-v3), {row[count]}"
            lines.append([first, *cells(row, form)])
    return lines


def like(rows, row, **other):
    """Parts, per element or contact, of the row that differs from this one in some columns; None when there is none."""
    return next((run.per_item(r) for r in rows if all(r[c] == (row | other)[c] for c in IDENTITY)), None)


def document(rows):
    def cycle(row, form):
        per, unordered = run.per_item(row), like(rows, row, program="bench_plain_sums")
        pairs = ((per["elements"], per["textbook"]), (per["cycle"], per["textbook"] + per["update"]))
        return [cell for own, other in pairs for cell in (form.format(own), form.format(other), f"{other / own:.1f}")] + [
            form.format(unordered["cycle"]) if unordered else ""]  # fmt: skip

    def contacts(row, form):
        cells = []
        for scene in ("t2pt", "tptm", "tptm open"):
            per = like(rows, row, scene=scene)
            cells += [form.format(per["contacts"]), form.format(per["plain"]), f"{per['contacts'] / per['plain']:.1f}"] if per else ["", "", ""]
        return cells

    def kernel(what, each, scene, part):
        row, cells = {"program": "bench_cycle", "scene": scene, "side": 32, "ranks": 1, "exchange_by": "auto"}, []
        for unit, form in UNITS.items():
            per, full = like(rows, row, unit=unit), like(rows, row, unit=unit, scene="block")
            own = per[part] if per else 0.0
            cells += [form.format(own) if own >= 10.0 else f"{own:.2g}", f"{own / full['elements']:.2g}"] if own else ["", ""]
        return [what, each, *cells]

    told = [[row["n_elements"], EXCHANGE[row["exchange_by"]], *(f"{run.least(row, part) / 1e3:.3g}" for part in ("exchange", "sums", "cycle"))]
            for row in sorted(rows, key=lambda row: row["side"]) if row["ranks"] == 2]  # fmt: skip
    head = ["ratio", "cycle", "textbook", "ratio", "cycle, plain sums"]
    replace_between("cycle", table(["blocks (times in ns a block)", "forces", "textbook", *head], lines_of(rows, "block", "n_elements", cycle)))
    head = ["contacts (times in ns each)", *(word for model in ("t2pt", "tptm", "tptm, half open") for word in (model, "plain", "ratio"))]
    replace_between("contacts", table(head, lines_of(rows, "t2pt", "n_contacts", contacts)))
    head = ["", "of each", "time [ns]", "over full", "instructions (x86-64-v3)", "over full"]
    replace_between("kernels", table(head, [kernel(*line) for line in KERNELS]))
    replace_between("exchange", table(["blocks", "how", "exchange [us]", "sums [us]", "cycle [us]"], told))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", default=str(run.ROOT / "build" / "tests"), help="of bench_cycle and bench_plain_sums (%(default)s)")
    parser.add_argument("--scenes", nargs="*", default=list(SIDES), choices=list(SIDES), help="none: the tables alone")
    parser.add_argument("--sides", type=int, nargs="+", help="of each scene, instead of its own")
    parser.add_argument("--units", nargs="+", default=list(UNITS), choices=list(UNITS))
    parser.add_argument("--seconds", type=float, default=0.3, help="for each measurement")
    parser.add_argument("--tries", type=int, default=3, help="runs of each, of which the fastest counts")
    options = parser.parse_args()
    options.folder, rows = os.path.abspath(options.folder), keep("cycle", [], IDENTITY)
    run.header("ns, then instr.,")
    for row in measured(options):
        rows = keep("cycle", [row], IDENTITY)
    document(rows)


if __name__ == "__main__":
    main()
