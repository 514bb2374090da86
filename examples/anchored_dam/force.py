"""The force of the tendons that gives a sliding factor in the flood to 46 m, by trials of the prestress.

    PYTHONPATH=tools python examples/anchored_dam/force.py MODEL.h5 OUTPUT FACTOR

prints each trial, and the force by statics beside the last."""

import os
import subprocess
import sys
from pathlib import Path

from closed_form import needed
from quoin_tools.base.results import Results

HERE = Path(__file__).parent
QUOIN = os.environ.get("QUOIN", "build/quoin")
SPACING, LEVEL = 3.0, 46.0
CLOSE = 1e-3  # of the factor


def factor_with(model, output, prestress):
    """Sliding factor of the base, and force of one tendon then [N]."""
    area = max(3.22e-3, prestress / 1400e6)  # more strands where they are needed
    subprocess.run([QUOIN, "-options_file", HERE / "scene.yaml", "-model", model, "-output", output, "-stages", "own,stressing,at46",
                    "-anchors_tendon_prestress", f"{prestress:.17g}", "-anchors_tendon_area", f"{area:.17g}"], check=True, stdout=subprocess.DEVNULL)  # fmt: skip
    stage = Results(output).stage_summary("at46")
    return stage["joints"]["base"]["sliding_factor_peak"], stage["anchors"]["tendon"]["force"]


def search(model, output, wanted):
    """Trials (prestress, factor, force) until the factor is the wanted one: the factor is nearly linear in the force."""
    trials = [(T, *factor_with(model, output, T)) for T in (1e6, 4e6)]
    while abs(trials[-1][1] - wanted) > CLOSE * wanted and len(trials) < 12:
        (T0, factor0, _), (T1, factor1, _) = trials[-2:]
        T = T1 + (wanted - factor1) * (T1 - T0) / (factor1 - factor0)
        if T <= 0:
            sys.exit(f"force: the factor is more than {wanted} without tendons")
        trials.append((T, *factor_with(model, output, T)))
    return trials


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    found = search(sys.argv[1], sys.argv[2], float(sys.argv[3]))
    for prestress, factor, force in found:
        print(f"locked at {prestress / 1e3:8.1f} kN: factor {factor:.4f}, {force / 1e3:.1f} kN in the flood")
    print(f"by statics {SPACING * needed(LEVEL, float(sys.argv[3])) / 1e3:.1f} kN every {SPACING:g} m in the flood")
