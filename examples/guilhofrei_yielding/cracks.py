"""How far the dam cracks at its heel as the reservoir rises above the crest, for the three tensile strengths.

    PYTHONPATH=tools python examples/guilhofrei_yielding/cracks.py MODEL.h5 OUTPUT

runs scene_heel.yaml into OUTPUT/heel_<scenario> and prints a row for each level: open cracks [m] and widest one [mm] of each scenario, then the
flood that the dam no longer stands."""

import os
import subprocess
import sys
from pathlib import Path

from quoin_tools.base.laws import open_cracks
from quoin_tools.base.results import Results

HERE = Path(__file__).parent
QUOIN = os.environ.get("QUOIN", "build/quoin")
TENSION = {1: 1.0e6, 2: 0.5e6, 3: 0.25e6}  # [Pa]
LEVELS = {"swhp": 33, "at36": 36, "at39": 39, "at42": 42, "at45": 45}


def solved(model, output, scenario):
    folder = f"{output}/heel_{scenario}"
    subprocess.run([QUOIN, "-options_file", HERE / "scene_heel.yaml", "-model", model, "-output", folder, "-materials_dam_tension", repr(TENSION[scenario])],
                   check=True, stdout=subprocess.DEVNULL)  # fmt: skip
    return Results(folder)


def crack(results, stage):
    """Open cracks [m], the widest [mm]."""
    return open_cracks(results.mesh, results.stage(stage)).sum(), 1e3 * results.stage_summary(stage)["laws"]["dam"]["crack_width"]


def rows_of(runs):
    """(what, a cell for each scenario)"""
    rows = [(f"level {level} m: open cracks [m], widest [mm]", [crack(run, stage) for run in runs.values()]) for stage, level in LEVELS.items()]
    rows = [(what, ["none" if length == 0 else f"{length:.1f}, {width:.2f}" for length, width in cells]) for what, cells in rows]
    floods = {name: run.stage_summary("flood")["flood"] for name, run in runs.items()}
    last = [crack(run, "flood") for run in runs.values()]
    rows.append(("flood: last level that it stands, first that it does not [m]", [f"{f['stable']:g}, {f['failing']:g}" for f in floods.values()]))
    return [*rows, ("... at the last level: open cracks [m], widest [mm]", [f"{length:.1f}, {width:.1f}" for length, width in last])]


def main(model, output):
    runs = {scenario: solved(model, output, scenario) for scenario in TENSION}
    for what, cells in rows_of(runs):
        print("| " + " | ".join([what, *cells]) + " |")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
