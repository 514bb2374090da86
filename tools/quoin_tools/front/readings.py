"""Readings of a dam's instruments: what is odd in them, and what water, season and time do.

    quoin readings readings.yaml [-o FOLDER]

The file says what the columns of a table (CSV, XLSX) are: quantity, place,
sign, unit, accuracy (docs/readings.md). All that is odd is told with its line:
wrong units, outliers, jumps of an instrument, gaps, doubled dates. Each sensor
is fitted by HST or HTT (level, season or air temperature, time), chosen by
cross-validation by years and judged on the last year, which the fit has not
seen. FOLDER (out/readings) receives readings.html, readings.json, and for each
sensor a CSV and pictures."""

import os

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
    given = parser.parse_args(words)
    from quoin_tools.readings import statistics  # here: pandas and statsmodels take longer to load than most commands
    from quoin_tools.readings.table import read
    from quoin_tools.show import readings_part

    readings = read(given.file)
    answers = [statistics.analyse(readings, name) for name, sensor in readings.sensors.items() if not sensor.drives]
    print_findings(readings)
    written, said = readings_part.write(readings, answers, given.output)
    print_answers(said, readings_part)
    print(f"wrote {os.path.join(given.output, 'readings.html')} and {len(written) - 1} files beside it")
    return 0


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
