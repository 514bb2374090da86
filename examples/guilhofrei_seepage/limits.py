"""How high the water may rise (flood S4) for apertures of the joints and states of the drains: runs, table and picture.

    PYTHONPATH=tools python examples/guilhofrei_seepage/limits.py OUTPUT [--quoin build/quoin] [--draw]

Runs the flood with OUTPUT/model.h5 for every aperture and drain, without and with the curtain, and with uplift by two rules; writes
limits.csv and limits.png into OUTPUT. --draw: the picture alone, of the limits.csv that is there.
About 5 minutes on 1 core (2026-11)."""

import argparse
import csv
import io
import os
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from quoin_tools.base.files import save_figure, write_file  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
CREST, PAPER = 33.0, 5.0  # m; the paper: stable up to 5 m above the crest
APERTURES = (0.1, 0.2, 0.4)  # mm
DRAINS = {"none": "no drains", "1e-6": "1e-6 m2/s: clogged", "1e-5": "1e-5 m2/s", "1e-4": "1e-4 m2/s: clean", "inf": "without resistance"}
CURTAINS = {"no": "no curtain", "yes": "curtain"}
RULES = {"rule": "by rule, uplift as before the flood beyond the drain", "cracked": "by rule, full head in the crack"}
COLUMNS = ("aperture_mm", "drain", "curtain", "uplift_kN", "factor", "stable_m", "first_m", "outcome")
COLOURS = ("#d55e00", "#e69f00", "#009e73", "#0072b2", "#000000")


def cases():
    """aperture [mm], drain, curtain; of a rule only its name."""
    yield from ((None, name, None) for name in RULES)
    yield from ((a, drain, curtain) for curtain in CURTAINS for drain in DRAINS for a in APERTURES)


def options_of(aperture, drain, curtain):
    loads, rises, options = ["ground", "weight", "water", "bed"], ["water", "bed"], {}
    if drain in RULES:
        loads.append(drain)
        rises.append(drain)
    else:
        loads += ["lake", "valley"] + ["curtain"] * (curtain == "yes") + ["drains"] * (drain != "none")
        rises.append("lake")
        options = {f"joints_{joint}_aperture": f"{aperture}e-3" for joint in ("base", "sheet", "steep")}
        options["loads_drains_conductance"] = "inf" if drain == "none" else drain
    return options | {"stages": "rock,sw,present,s4", "stages_present_loads": ",".join(loads), "stages_s4_loads": ",".join(loads),
                      "stages_s4_rises": ",".join(rises)}  # fmt: skip


def solve(quoin, model, case):
    """One run; a row of the table."""
    with tempfile.TemporaryDirectory() as folder:
        command = [quoin, "-options_file", os.path.join(HERE, "scene.yaml"), "-model", model, "-output", folder]
        for key, value in options_of(*case).items():
            command += [f"-{key}", value]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 4):  # 4: a trial without a verdict, and none that fails
            sys.exit(f"limits.py: {' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
        results = Results(folder)
        before, flood = results.stage_summary("present"), results.stage_summary("s4")["flood"]
    beyond = [trial for trial in flood["trials"] if trial["value"] > flood["stable"]]
    first = min(beyond, key=lambda trial: trial["value"], default={"value": None, "outcome": "stands at the limit"})
    water = before.get("flow", {}).get("joints", {}).get("base") or before["uplift"][case[1]]
    rise = [level if level is None else level - CREST for level in (flood["stable"], first["value"])]
    return dict(zip(COLUMNS, (*case, round(uplift_of(water) / 1e3), round(before["joints"]["base"]["sliding_factor_peak"], 3), *rise, first["outcome"])))


def uplift_of(water):
    """[N] as computed, or as prescribed."""
    return water["uplift"] if "uplift" in water else water["to_drain"] + water["beyond_drain"]


# ---- picture


def height(row):
    """[m] Between the last level that stands and the first that does not."""
    return row["stable_m"] if row["first_m"] is None else 0.5 * (row["stable_m"] + row["first_m"])


def draw(rows, path):
    figure, panels = pyplot.subplots(1, 2, figsize=(11, 5), sharey=True, constrained_layout=True)
    for axes, (curtain, title) in zip(panels, CURTAINS.items()):
        for (drain, label), colour in zip(DRAINS.items(), COLOURS):
            mine = [row for row in rows if row["drain"] == drain and row["curtain"] == curtain]
            axes.plot([row["aperture_mm"] for row in mine], [height(row) for row in mine], "o-", color=colour, label=label)
            for row in mine:
                if row["first_m"] is None:
                    axes.plot(row["aperture_mm"], height(row), "^", ms=11, color=colour)
        for row, style in zip((row for row in rows if row["drain"] in RULES), ("--", "-.")):
            axes.axhline(height(row), color="#777777", ls=style, label=RULES[row["drain"]])
        axes.axhline(PAPER, color="#cc79a7", lw=2, label="the paper: stable up to here")
        axes.set_title(title)
        axes.set_xlabel("aperture of the joints without stress [mm]")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("highest level that stands, above the crest [m]")
    panels[0].set_ylim(0, 1.05 * max(height(row) for row in rows) + 0.2)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle("Flood S4 with computed water; drains by conductance, triangles: still stands at the end of the scan")
    save_figure(figure, path, dpi=120)


def read_rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    numbers = ("aperture_mm", "uplift_kN", "factor", "stable_m", "first_m")
    return [row | {name: float(row[name]) if row[name] else None for name in numbers} for row in rows]


def write_rows(path, rows):
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_file(path, text.getvalue())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", help="folder with model.h5")
    parser.add_argument("--quoin", default="build/quoin", help="the program (default: build/quoin)")
    parser.add_argument("--draw", action="store_true", help="draw limits.csv of that folder again")
    options = parser.parse_args()
    table, picture = (os.path.join(options.output, f"limits.{ending}") for ending in ("csv", "png"))
    if not options.draw:
        rows = []
        for case in cases():
            rows.append(solve(options.quoin, os.path.join(options.output, "model.h5"), case))
            print(*("-" if value is None else value for value in rows[-1].values()), sep="  ", flush=True)
        write_rows(table, rows)
    draw(read_rows(table), picture)
    print(f"{table}\n{picture}")


if __name__ == "__main__":
    main()
