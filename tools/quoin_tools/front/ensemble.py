"""Samples of a scene whose properties scatter: how likely does it fail?

    quoin ensemble ensemble.yaml [-o FOLDER] [-j JOBS]
                   [--part 2/8] [--sample 17] [--keep] [--mpi]
                   [--posterior posterior.yaml]

The file names a scene, distributions for keys of it, and what counts as
failure (docs/ensembles.md). Each sample is a run of the solver on one
rank, JOBS of them at a time; those that differ in numbers of joints,
loads, anchors or stages share a process, with the same results. Rows go
into FOLDER as samples end; begun again it goes on where it was.
--part K/M runs every M-th sample, as a job of an array: any of them,
begun once more without --part, tells what all have found. --sample N
runs one sample alone and keeps its folder.
--mpi: samples over the ranks of one MPI allocation, of which rank 0
hands them out: mpirun -n 9 quoin ensemble ensemble.yaml --mpi.
--posterior: once more with what quoin readings --model has learnt of the
variables, into FOLDER/posterior; both results stand side by side."""

import json
import os
import sys
import time

from quoin_tools.base import solver
from quoin_tools.base.command import Parser
from quoin_tools.base.files import write_file
from quoin_tools.base.terminal import table
from quoin_tools.ensemble import analysis, design, importance, running
from quoin_tools.ensemble.drawn import with_posterior
from quoin_tools.ensemble.journal import Journal
from quoin_tools.ensemble.models import model_of
from quoin_tools.ensemble.variables import EnsembleError
from quoin_tools.show import ensembles

OUTCOMES = {"stands": 0, "fails": 6, "undecided": 4}  # exit codes of one sample, as the solver's


def main(words):
    if words[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0
    parser = Parser(prog="quoin ensemble", add_help=False)
    parser.add_argument("file")
    parser.add_argument("-o", "--output", default=os.path.join("out", "ensemble"))
    parser.add_argument("-j", "--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--part", default="1/1")
    parser.add_argument("--sample", type=int)
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--mpi", action="store_true")
    parser.add_argument("--posterior", action="append", default=[])
    given = parser.parse_args(words)
    if not given.mpi:
        with solver.stopping():
            return ensemble(given)
    with running.allocation() as executor:
        return 0 if executor is None else ensemble(given, executor)


def ensemble(given, executor=None):
    wanted = design.read(given.file)
    if given.jobs < 1:
        raise EnsembleError(f"-j {given.jobs}: expected a number >= 1")
    if len(given.posterior) > 1:
        raise EnsembleError(f"--posterior: {', '.join(given.posterior)}: expected one")
    if not given.posterior:
        return answered(given, wanted, given.output, executor)[0]
    path, folder = given.posterior[0], os.path.join(given.output, "posterior")
    learnt = with_posterior(wanted, path)
    if given.sample is not None:
        return answered(given, learnt, folder, executor)[0]
    Journal(folder, learnt).rows()  # those of another posterior are refused before anything is written
    before = answered(given, wanted, given.output, executor)[1]
    print(f"after the readings ({path}): " + ", ".join(wanted.columns()[k] for k in learnt.drawn.places)
          + (f"; as in the scene stay {', '.join(learnt.drawn.unused)}, which {given.file} does not vary" if learnt.drawn.unused else ""))  # fmt: skip
    for name, text in learnt.drawn.warnings.items():
        print(f"WARNING: {path}: {name}: {text}")
    after = answered(given, learnt, folder, executor)[1]
    if before is not None and after is not None:
        picture = ensembles.write_after(learnt, folder, given.output)
        print("\n".join([*side_by_side(wanted, before, learnt, after), *([f"wrote {picture}"] if picture else [])]))
    return 0


def side_by_side(wanted, before, learnt, after):
    """Returns a table: probability of failure at each level, and danger level, before and after the readings."""
    pairs = zip(analysis.probabilities(wanted, before), analysis.probabilities(learnt, after), strict=True)
    lines = table((", ".join(wanted.level_keys) or "level", "before the readings", "low", "high (95 %)", "after", "low", "high (95 %)"),
                  [("-" if p.level is None else f"{p.level:g}", *(f"{value:.3g}" for one in (p, q) for value in (one.value, one.low, one.high))) for p, q in pairs])  # fmt: skip
    dangers = analysis.danger(wanted, before), analysis.danger(learnt, after)
    return lines + [f"danger level {when} the readings: {danger.words()}" for when, danger in zip(("before", "after"), dangers, strict=True) if danger]


def answered(given, wanted, output, executor):
    """Runs an ensemble, or one sample or a part of it. Returns (exit code, its rows; None: not all of them)."""
    centre, notes = centre_of(wanted, output)
    if given.sample is not None:
        return one(wanted, output, given.sample, centre), None
    part = part_of(given.part)
    rows = running.run(wanted, output, given.jobs, part, given.keep, Progress(wanted) if sys.stderr.isatty() else None, centre, executor)
    if part[1] > 1 and len({i for i, _ in rows}) < wanted.samples:
        print(f"part {given.part}: done; {len(rows)} rows of {wanted.samples * len(wanted.levels)} are there")
        return 0, None
    print_answer(wanted, rows, output, notes)
    return 0, rows


def part_of(text):
    try:
        k, m = (int(word) for word in text.split("/"))
    except ValueError as error:
        raise EnsembleError(f"--part {text}: expected two numbers such as 2/8") from error
    if not 1 <= k <= m:
        raise EnsembleError(f"--part {text}: expected 1/{max(m, 1)} to {max(m, 1)}/{max(m, 1)}")
    return k, m


def centre_of(wanted, folder):
    """Returns (design point or None, a sentence) of importance sampling; the folder keeps it, since all rows depend on it."""
    if wanted.method != "importance":
        return None, []
    path = os.path.join(folder, "design_point.json")
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            found = json.load(file)
        if found["ensemble"] != wanted.mark:
            raise EnsembleError(f"{path}: of another ensemble: use another folder, or remove it")
    else:
        model = model_of(wanted, folder)
        point, distance, asked = importance.design_point(wanted, model)
        others = importance.elsewhere(wanted, model, point)
        model.close()
        found = {"ensemble": wanted.mark, "point": point.tolist(), "distance": distance, "samples": asked, "others": others}
        os.makedirs(folder, exist_ok=True)
        write_file(path, json.dumps(found, indent=1) + "\n")
    values = wanted.variables.values([found["point"]])[0]
    also = ["WARNING: it fails in another way too, at " + ", ".join(f"{name} {value:.5g}" for name, value in zip(wanted.columns(), other)) + ": samples about the design point hardly see it, the probability may be far too low"
            for other in found.get("others", ())]  # fmt: skip
    return found["point"], [f"design point after {found['samples']} samples: " + ", ".join(f"{name} {value:.5g}" for name, value in zip(wanted.columns(), values))
                            + f"; {found['distance']:.4f} deviations from the mean"] + also  # fmt: skip


def one(wanted, folder, index, centre):
    if not 0 <= index < wanted.samples:
        raise EnsembleError(f"--sample {index}: expected 0 to {wanted.samples - 1}")
    values, _ = running.Samples(wanted, centre).of(index)
    worst = 0
    for level in wanted.levels:
        model = model_of(wanted, folder, keep=True)
        outcome, response, why = model.judge(values, index, level)
        at = "" if level is None else f" at {level:g}"
        print(f"sample {index}{at}: {outcome}{f' ({why})' if why else ''}{'' if response is None else f', {wanted.response} {response:.6g}'}; "
              + ", ".join(f"{name} {value if isinstance(value, str) else format(value, '.6g')}" for name, value in zip(wanted.columns(), values)))  # fmt: skip
        worst = max(worst, OUTCOMES[outcome])
    return worst


class Progress:
    """Writes a line of progress over the last one: samples done, time left, the interval so far."""

    def __init__(self, wanted):
        self.wanted, self.last = wanted, 0.0

    def __call__(self, rows, done, left, began):
        now = time.monotonic()
        if left and now - self.last < 0.5:
            return
        self.last = now
        found = analysis.probabilities(self.wanted, rows)
        so_far = f"; {found[-1].low:.3g} to {found[-1].high:.3g}" if found else ""
        print(f"\r{done} done, {left} left, {left * (now - began) / done:.0f} s{so_far}   ", end="" if left else "\n", file=sys.stderr, flush=True)


def print_answer(wanted, rows, folder, notes):
    found = analysis.probabilities(wanted, rows)
    lines = wanted.words() + notes
    if not found and wanted.method != "sobol_indices":
        lines.append("no whole sample yet")
    lines += [("probability of failure" if p.level is None else f"{', '.join(wanted.level_keys)} = {p.level:g}") + f": {analysis.words(p)}" for p in found]
    curve = analysis.fragility(found) if wanted.level_keys else None
    if curve:
        lines.append(f"curve: half of the samples fail at {curve.median:.5g}, 5 % at {curve.level(0.05):.5g}, 95 % at {curve.level(0.95):.5g} (lognormal)")
    danger = analysis.danger(wanted, rows)
    if danger:
        lines.append(f"danger level: {danger.words()}")
    influence = [] if wanted.method == "sobol_indices" else analysis.influence(wanted, rows)
    if influence:
        lines += table(("variable", "rank correlation", "samples"), [(name, f"{value:+.3f}", n) for name, value, n in influence])
    choices = analysis.by_choice(wanted, rows)
    if choices:
        lines += table(("variable", "value", *([", ".join(wanted.level_keys)] if wanted.level_keys else []), "samples", "fail", "undecided", "low", "high (95 %)"),
                       [(c["variable"], c["choice"], *([f"{c['level']:g}"] if wanted.level_keys else []), c["n"], c["fails"], c["undecided"], f"{c['low']:.3g}", f"{c['high']:.3g}") for c in choices])  # fmt: skip
    if wanted.method == "sobol_indices":
        indices, dropped = analysis.sobol_indices(wanted, rows)
        lines += table(("variable", "first order", "total"), [(name, f"{first:.4f}", f"{total:.4f}") for name, first, total in indices])
        lines += [f"{dropped} groups are left out, because a sample of them gave no number"] if dropped else []
    reasons = [row.why for row in rows.values() if row.outcome == "undecided"]
    lines += [f"undecided {reasons.count(why)} times: {why}" for why in sorted(set(reasons))]
    print("\n".join(lines))
    print("\n".join(f"wrote {path}" for path in ensembles.write(wanted, rows, found, curve, choices, folder)))
