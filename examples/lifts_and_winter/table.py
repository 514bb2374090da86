"""The dam in lifts beside the same one in one piece:  PYTHONPATH=tools python examples/lifts_and_winter/table.py OUTPUT"""

import sys

import numpy as np
from quoin_tools.base.results import Results


def rows(folder):
    """(what, in lifts, in one piece)"""
    runs = [Results(f"{folder}/{name}") for name in ("lifts", "whole")]
    def probe(run, stage, x):
        return 1e3 * run.stage_summary(stage)["probes"]["crest"][("u_x", "u_y")[x]]
    def base(run, stage, key, scale=1.0):
        return scale * run.stage_summary(stage)["joints"]["base"][key]
    table = [("built: crest, along x, y [mm]", *(f"{probe(run, 'lift_5', 0):.2f}, {probe(run, 'lift_5', 1):.2f}" for run in runs))]
    for stage in ("full", "winter"):
        table.append((f"{stage}: crest since the dam stood, along x, y [mm]", *(", ".join(f"{probe(run, stage, x) - probe(run, 'lift_5', x):.2f}" for x in (0, 1)) for run in runs)))
        table.append(("... pressure of the base at the heel, the toe, straight line [kPa]", *(f"{-base(run, stage, 'sigma_linear_start', 1e-3):.0f}, {-base(run, stage, 'sigma_linear_end', 1e-3):.0f}" for run in runs)))
        table.append(("... open length of joints [m]", *(f"{sum(joint['open_length'] for joint in run.stage_summary(stage)['joints'].values()):.2f}" for run in runs)))
    def dam(run):
        return run.mesh.block_group != run.mesh.group_names.index("rock")
    table.append(("winter: largest s1 in the dam, across the plane [MPa]", *(f"{run.stage('winter').s1[dam(run)].max() / 1e6:.2f}, {np.nanmax(run.stage('winter').stress_z[dam(run)]) / 1e6:.2f}" for run in runs)))
    return table


if __name__ == "__main__":
    for what, lifts, whole in rows(sys.argv[1]):
        print(f"| {what} | {lifts} | {whole} |")
