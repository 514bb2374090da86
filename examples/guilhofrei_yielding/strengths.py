"""How far the strengths of the masonry may go down until its first block yields, and until the dam fails.

    PYTHONPATH=tools python examples/guilhofrei_yielding/strengths.py MODEL.h5 OUTPUT

All strengths of a scenario, tan(friction) among them, are divided by one factor; each factor is a run of its own, from the unloaded
dam. The empty dam and the full one are loaded in one step each. Prints a row for each scenario and reservoir, and writes OUTPUT/strengths.csv."""

import csv
import math
import os
import subprocess
import sys
from pathlib import Path

from quoin_tools.base.results import Results

HERE = Path(__file__).parent
QUOIN = os.environ.get("QUOIN", "build/quoin")
SCENARIOS = {1: (1.0e6, 1.58e6), 2: (0.5e6, 1.12e6), 3: (0.25e6, 0.79e6)}  # tension, cohesion [Pa]
FRICTION = 55.0  # degree
CLOSE = 0.1  # width of a bracket
HEADER = ("scenario", "stage", "local_factor", "yields_x_m", "yields_y_m", "first_yield", "stable", "failing", "verdict", "area_m2", "plastic_strain")


def solved(model, output, scenario, stage, factor):
    """Summary of the stage with the strengths of a scenario over a factor."""
    tension, cohesion = SCENARIOS[scenario]
    friction = math.degrees(math.atan(math.tan(math.radians(FRICTION)) / factor))
    done = subprocess.run([QUOIN, "-options_file", HERE / "scene.yaml", "-model", model, "-output", output, "-stages", stage,
                           "-materials_dam_tension", repr(tension / factor), "-materials_dam_cohesion", repr(cohesion / factor),
                           "-materials_dam_friction", repr(friction)], check=False, capture_output=True, text=True)  # fmt: skip
    if done.returncode not in (0, 3, 4, 6):  # it collapsed, or found no equilibrium: a result
        sys.exit(f"strengths: {done.stderr.strip()}")
    return Results(output).stage_summary(stage)


def bracket(low, high, holds):
    """The last factor that holds and the first that does not, CLOSE apart; `low` holds."""
    while holds(high):
        low, high = high, high + 2.0
    while high - low > CLOSE * 1.001:
        middle = CLOSE * round((low + high) / 2 / CLOSE)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low, high


def row_of(model, output, scenario, stage):
    """One line of the table."""
    known = {}

    def at(factor):
        factor = round(factor, 9)
        if factor not in known:
            known[factor] = solved(model, f"{output}/{scenario}_{stage}_{factor:.1f}", scenario, stage, factor)
        return known[factor]

    _, yields = bracket(1.0, 3.0, lambda factor: at(factor)["laws"]["dam"]["blocks"] == 0)
    stable, failing = bracket(yields - CLOSE, yields + 2.0, lambda factor: at(factor)["verdict"] == "converged")
    law, first = at(stable)["laws"]["dam"], at(yields)["laws"]["dam"]
    return (scenario, stage, at(1.0)["safety"]["dam"]["value"], first["x"], first["y"], yields, stable, failing, at(failing)["verdict"], law["area"],
            law["plastic_strain"])  # fmt: skip


def rows_of(model, output, scenarios=tuple(SCENARIOS)):
    return [dict(zip(HEADER, row_of(model, output, scenario, stage))) for scenario in scenarios for stage in ("sw", "swhp")]


def line_of(row, area):
    where = "toe" if row["yields_x_m"] > 11 else "heel"
    return (f"| {row['scenario']} | {'empty' if row['stage'] == 'sw' else 'full'} | {row['local_factor']:.2f} | {where} | {row['first_yield']:.1f} "
            f"| {row['stable']:.1f} to {row['failing']:.1f} | {100 * row['area_m2'] / area:.0f} |")  # fmt: skip


def main(model, output):
    rows = rows_of(model, output)
    with open(f"{output}/strengths.csv", "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, HEADER)
        writer.writeheader()
        writer.writerows(rows)
    mesh = Results(f"{output}/3_swhp_1.0").mesh
    area = mesh.areas()[mesh.block_group == mesh.group_names.index("dam")].sum()
    for row in rows:
        print(line_of(row, area))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
