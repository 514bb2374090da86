"""Readings of a dam's instruments: what is odd in them, and what water, season and time do.

    quoin readings readings.yaml [-o FOLDER] [--model model.yaml] [-j JOBS]

The file says what the columns of a table (CSV, XLSX) are: quantity, place,
sign, unit, accuracy (docs/readings.md). All that is odd is told with its line:
wrong units, outliers, jumps of an instrument, gaps, doubled dates. Each sensor
is fitted by HST or HTT (level, season or air temperature, time), chosen by
cross-validation by years and judged on the last year, which the fit has not
seen. FOLDER (out/readings) receives readings.html, readings.json, and for each
sensor a CSV and pictures.

--model: what the readings say of the parameters of the block model. It
is run over level, season and the priors of model.yaml, JOBS runs at a
time; surfaces through these runs are checked against others. FOLDER
receives posterior.csv and posterior.yaml (for quoin ensemble
--posterior) and pictures, and keeps the runs: begun again it goes on."""

import os
import sys
import time

from quoin_tools.base import solver
from quoin_tools.base.command import Parser
from quoin_tools.base.terminal import table

MOST = 15  # findings on the terminal


def main(words):
    if words[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0
    parser = Parser(prog="quoin readings", add_help=False)
    parser.add_argument("file")
    parser.add_argument("-o", "--output", default=os.path.join("out", "readings"))
    parser.add_argument("--model")
    parser.add_argument("-j", "--jobs", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args(words)
    if given.jobs < 1:
        raise ValueError(f"-j {given.jobs}: expected a number >= 1")
    from quoin_tools.readings import statistics  # here: pandas and statsmodels take longer to load than most commands
    from quoin_tools.readings.table import read
    from quoin_tools.show import readings_part

    readings = read(given.file)
    print_findings(readings)  # before anything that they may be the cause of
    if given.model:
        from quoin_tools.readings import hybrid

        with solver.stopping():
            for text in hybrid.tried(readings, given.model):
                print(text)
    answers = [statistics.analyse(readings, name) for name, sensor in readings.sensors.items() if not sensor.drives]
    written, said = readings_part.write(readings, answers, given.output)
    print_answers(said, readings_part)
    print(f"wrote {os.path.join(given.output, 'readings.html')} and {len(written) - 1} files beside it")
    if given.model:
        with solver.stopping():
            print_posterior(readings, given)
    return 0


def print_posterior(readings, given):
    from quoin_tools.readings import hybrid
    from quoin_tools.show import updated

    began = time.monotonic()

    def report(done, wanted):
        print(f"\r{done} of {wanted} runs, {time.monotonic() - began:.0f} s   ", end="" if done < wanted else "\n", file=sys.stderr, flush=True)

    found = hybrid.updated(readings, given.model, given.output, given.jobs, report=report if sys.stderr.isatty() else None)
    print("\n".join(updated.lines(readings, found)))
    print("\n".join(f"wrote {path}" for path in [*hybrid.write(found, given.output), *updated.pictures(readings, found, given.output)]))


def print_findings(readings):
    found = readings.findings
    print("no findings" if not found else "1 finding" if len(found) == 1 else f"{len(found)} findings")
    for one in found[:MOST]:
        print(f"  {one.words(readings.file)}")
    if len(found) > MOST:
        print(f"  {len(found) - MOST} more are in readings.json")


def print_answers(said, part):
    for name, one in said.items():
        print(f"{name}: {one['fit']}")
        for text in one["notes"]:
            print(f"{name}: {text}")
        if one["left_out"]:
            print(f"{name}: left out: " + ", ".join(f"{count} {reason}" for reason, count in one["left_out"].items()))
    if said:
        print("\n".join(["", *table(part.HEADER, part.rows(said)), ""]))
