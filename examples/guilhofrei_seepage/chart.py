"""The states of guilhofrei_seepage: their numbers against those of reference.csv, and the uplift of the base.

    PYTHONPATH=tools python examples/guilhofrei_seepage/chart.py OUTPUT

OUTPUT is the folder of the run; writes states.csv and states.png into it."""

import csv
import io
import os
import sys

import h5py
import matplotlib

matplotlib.use("Agg")
import numpy as np  # noqa: E402
from matplotlib import pyplot  # noqa: E402
from quoin_tools.base.files import save_figure, write_file  # noqa: E402
from quoin_tools.base.results import Results, ResultsError, table  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
STATES = {"present": "#d55e00", "grouted": "#e69f00", "clogged": "#009e73", "drained": "#0072b2"}
LITRES = 6e4  # per minute and metre, of a m2/s
COLUMNS = {"state": "", "valley": "l/(min m)", "drains": "l/(min m)", "uplift": "kN/m", "centre": "m", "factor": "-", "crack": "m"}


def state_row(results, name):
    """What the valley and the drains take, uplift of the base and its x, sliding factor and crack at the end of a stage."""
    stage = results.stage_summary(name)
    base, flow = stage["joints"]["base"], stage.get("flow")
    row = {"state": name, "valley": None, "drains": None, "factor": base["sliding_factor_peak"], "crack": base["open_length"]}
    if flow is None:
        distance, pressure = np.array(stage["uplift"][name]["diagram"]).T
        force, at = resultant(distance, pressure)
        return row | {"uplift": force / 1e3, "centre": at * base["end"]["x"] / base["chord"]}
    taken = {condition: LITRES * found["discharge"] for condition, found in flow["conditions"].items()}
    water = flow["joints"]["base"]
    return row | {"valley": taken["valley"], "drains": taken.get("drains", taken.get("clogged", 0.0)),
                  "uplift": water["uplift"] / 1e3, "centre": water["centre_x"]}  # fmt: skip


def resultant(distance, pressure):
    """Force of straight pieces and its place."""
    length, mean = np.diff(distance), 0.5 * (pressure[1:] + pressure[:-1])
    moment = length * (distance[:-1] * (2 * pressure[:-1] + pressure[1:]) + distance[1:] * (pressure[:-1] + 2 * pressure[1:])) / 6
    return (length * mean).sum(), moment.sum() / (length * mean).sum()


def state_rows(results):
    return [state_row(results, name) for name in ("rule", *STATES)]


def references():
    with open(os.path.join(HERE, "reference.csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {row["state"]: {name: float(row[name]) if row[name] else None for name in COLUMNS if name != "state"} for row in rows}


# ---- picture


def along_base(results, stage):
    """Distance from the heel [m] and water pressure [Pa] at the ends of the pieces of the base, in order."""
    with h5py.File(results.path) as file:
        flow = file[f"stages/{stage}/flow"]
        mine = flow["joint"][()].ravel() == results.mesh.joint_names.index("base")
        points, pressure = flow["point"][()].reshape(-1, 2)[np.repeat(mine, 2)], flow["pressure"][()].ravel()[np.repeat(mine, 2)]
    order = np.argsort(points[:, 0], kind="stable")
    return np.hypot(*(points[order] - points[order[0]]).T), pressure[order]


def draw(results, path):
    figure, axes = pyplot.subplots(figsize=(8.5, 4.8), constrained_layout=True)
    for name, colour in STATES.items():
        distance, pressure = along_base(results, name)
        axes.plot(distance, pressure / 1e3, color=colour, label=f"{name}: {resultant(distance, pressure)[0] / 1e3:.0f} kN/m")
    rule = np.array(results.stage_summary("rule")["uplift"]["rule"]["diagram"]).T
    axes.plot(rule[0], rule[1] / 1e3, "--", color="#777777", label=f"by rule, a third at the drain: {resultant(*rule)[0] / 1e3:.0f} kN/m")
    axes.plot(rule[0][[0, -1]], rule[1][[0, -1]] / 1e3, ":", color="#777777", label="straight line from heel to toe")
    axes.set_xlabel("distance from the heel along the base [m]")
    axes.set_ylabel("water pressure [kPa]")
    axes.set_ylim(0, None)
    axes.grid(alpha=0.3)
    axes.legend()
    axes.set_title("Uplift of the Guilhofrei dam (section G1) by flow through jointed rock, reservoir full")
    save_figure(figure, path, dpi=120)


def cell(value):
    return value if isinstance(value, str) else "-" if value is None else f"{value:.0f}" if value >= 100 else f"{value:.3f}"


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    try:
        results = Results(sys.argv[1])
        rows, expected = state_rows(results), references()
    except ResultsError as error:
        sys.exit(f"chart.py: {error}")
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(row | {name: round(value, 4) for name, value in row.items() if isinstance(value, float)} for row in rows)
    write_file(os.path.join(sys.argv[1], "states.csv"), text.getvalue())
    header = [f"{name} {unit}".strip() for name, unit in COLUMNS.items()]
    lines = [[cell(row[name]) for name in COLUMNS] for row in rows]
    lines += [[f"{state}, expected", *(cell(value) for value in numbers.values())] for state, numbers in expected.items()]
    print("\n".join(table(header, sorted(lines, key=lambda line: [*expected].index(line[0].split(",")[0])))))
    draw(results, os.path.join(sys.argv[1], "states.png"))


if __name__ == "__main__":
    main()
