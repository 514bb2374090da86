"""Hunt for silent differences: random scenes, each solved in several ways that must agree.

    python tests/verification/hunt/hunt.py --seeds 1-12                           # minutes
    python tests/verification/hunt/hunt.py --minutes 60 --table docs/generated/hunt.md
    python tests/verification/hunt/hunt.py --seeds 17 --keep /tmp/17              # one scene, its folders stay for a look
    python tests/verification/hunt/hunt.py --kind water --seeds 1-5               # the first five scenes of one kind

The reference is the explicit method on one rank with fixed connectivity. Displacements, forces of joints and limits of trials of the other ways must be its own
within 0.5 %, verdicts the same, other numbers of ranks the same bits; some kinds have a value by hand. A larger difference must have a warning of one of
the two runs; one that ends undecided says so itself. Exit code 0: nothing silent; 1: something was; 2: a run could not be made.
Kinds: methods.py (dams, slopes, walls, columns), more.py (cracked, anchored, toppling, arches), twins.py (mirrored, renumbered, rounded, layers, stages), rests.py (slopes that come to rest, joints of several
strengths), water.py (transient), drawings.py (areas)."""

import argparse
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import drawings  # noqa: E402
import methods  # noqa: E402
import more  # noqa: E402
import rests  # noqa: E402
import twins  # noqa: E402
import water  # noqa: E402
from driver import ROOT  # noqa: E402
from runs import Count, hunt  # noqa: E402

KINDS = methods.KINDS + more.KINDS + twins.KINDS + rests.KINDS + water.KINDS + drawings.KINDS


def table(counts):
    lines = ["| scene | way | runs | largest difference of those that agree | told by a warning | silent |", "|---|---|---|---|---|---|"]
    for (kind, way), count in sorted(counts.items()):
        lines.append(f"| {kind} | {way} | {count.runs} | {100 * count.worst:.2g} % | {count.told} | {len(count.silent)} |")
    return lines


def seeds_of(text):
    """1-12, or 3,5,9."""
    if "," in text:
        return [int(word) for word in text.split(",")]
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def one(seed, kind, quoin, folder, counts, most):
    """Lines about what was silent in one scene."""
    made = kind(np.random.default_rng(seed))
    if callable(made):  # no scene to solve
        return made(seed, folder, counts)
    return hunt(seed, made, quoin, folder, counts, most)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--seeds", type=seeds_of, help="such as 1-12 or 3,5,9")
    parser.add_argument("--kind", action="append", choices=[kind.__name__ for kind in KINDS], help="only these kinds, one after the other")
    parser.add_argument("--ways", type=int, help="at most so many of each scene, beside its reference")
    parser.add_argument("--minutes", type=float, help="as many seeds as fit in, from 1 (or the first of --seeds) on")
    parser.add_argument("--keep", type=Path, help="folder for the runs, which stay there")
    parser.add_argument("--table", type=Path, help="document to write (Markdown)")
    given = parser.parse_args()
    kinds = [kind for kind in KINDS if not given.kind or kind.__name__ in given.kind]
    start, counts, silent, broken = time.monotonic(), defaultdict(Count), [], []
    first = given.seeds[0] if given.seeds else 1
    seeds = range(first, 10**9) if given.minutes else given.seeds or range(1, 1 + len(kinds))
    with tempfile.TemporaryDirectory(prefix="quoin_hunt_") as temporary:
        n = 0
        for seed in seeds:
            if given.minutes and time.monotonic() - start > 60 * given.minutes:
                break
            n += 1
            began = time.monotonic()
            kind = kinds[seed % len(kinds)]
            try:
                said = one(seed, kind, str(Path(given.quoin).resolve()), (given.keep or Path(temporary)) / f"{kind.__name__}_{seed}", counts, given.ways)
            except (RuntimeError, subprocess.TimeoutExpired, ValueError) as error:
                broken.append(f"seed {seed}, {kind.__name__}: {error}")
                said = broken[-1:]
            silent += said
            print("\n".join(said) if said else f"seed {seed}, {kind.__name__}: agree, or told ({time.monotonic() - began:.1f} s)", flush=True)
    minutes = (time.monotonic() - start) / 60
    lines = [f"{n} scenes, {sum(count.runs for count in counts.values())} comparisons, {minutes:.0f} min.", "", *table(counts)]
    print("\n".join(lines))
    if given.table:
        head = ["# The hunt", "", "Written by `tests/verification/hunt/hunt.py`; [verification](../verification.md#the-hunt) says what it is.", ""]
        given.table.write_text("\n".join([*head, *lines, ""]), encoding="utf-8")
    return 2 if broken else int(bool(silent))


if __name__ == "__main__":
    sys.exit(main())
