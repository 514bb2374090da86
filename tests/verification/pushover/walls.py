"""Walls 1 to 3 of Ferris and Tin-Loi past their peak: the factor of the weight over the displacement of the crest, in large strain.

    PYTHONPATH=tools:tests/verification:examples/published python tests/verification/pushover/walls.py --quoin build/quoin [--picture docs/img/pushover_walls.png]

Prints the peaks beside the limits of problems.yaml, and the processor time. Half a minute."""

import argparse
import tempfile

import models
import numpy as np
import yaml
from driver import PUBLISHED, Case, changed, processor_seconds
from matplotlib import pyplot
from quoin_tools.show.style import GREY, LINES, STYLE

REACH = 0.4  # [m] of the crest
WAYS = {1: (0.054, 0.002), 2: (0.09, 0.003), 3: (0.11, 0.004)}  # of the mass centre, and the longest increment [m]
LIMITS = {1: (0.64286, 0.6294), 2: (0.58, 0.5506), 3: (0.40369, 0.3494)}  # with dilation; explicit runs without, small displacement


def pushed(case, number):
    """Displacements of the crest [m] and factors, and the stage's object in summary.json."""
    scene = yaml.safe_load((PUBLISHED / f"wall_{number}.yaml").read_text(encoding="utf-8"))
    way, step = WAYS[number]
    scene = changed(scene, ("strain", "large"), ("contact", {"connectivity": "variable"}), ("relaxation", {"ramp": 1000, "max_cycles": 50000}),
                    ("joints.default.k_n", 1e10), ("joints.default.k_s", 1e10),
                    ("stages", [scene["stages"][0], {"push": {"type": "pushover", "loads": ["weight"], "pushes": ["push"], "path": [way], "step": step}}]))
    result = case.run(models.wall_with_crest(number), scene)
    found = result.stage_summary("push")
    rows = np.isfinite(result.history["push_N"])
    return result.history["crest_ux_m"][rows], result.history["push_N"][rows] / found["pushover"]["load"], found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", default="build/quoin")
    parser.add_argument("--picture")
    options = parser.parse_args()
    pyplot.rcParams.update(STYLE)
    figure, axes = pyplot.subplots(figsize=(8.0, 5.0))
    with tempfile.TemporaryDirectory() as folder:
        case = Case("walls", options.quoin, folder)
        for number, colour in zip(WAYS, LINES):
            before = processor_seconds()
            crest, factor, found = pushed(case, number)
            peak = factor.argmax()
            print(f"wall {number}: {found['verdict']}, peak {factor[peak]:.4f} at {1e3 * crest[peak]:.0f} mm of the crest, {factor[-1]:.4f} at {1e3 * crest[-1]:.0f} mm; "
                  f"limits {LIMITS[number][0]} with dilation, {LIMITS[number][1]} without; {processor_seconds() - before:.1f} s")
            axes.plot(crest, factor, color=colour, marker=".", ms=4, lw=1.4, label=f"wall {number}: peak {factor[peak]:.3f}")
            axes.plot([0, 0.02], [LIMITS[number][1]] * 2, color=colour, ls="--", lw=1.2)
            axes.plot([0, 0.02], [LIMITS[number][0]] * 2, color=colour, ls=":", lw=1.2)
    axes.plot([], [], color=GREY, ls="--", label="stands and fails, small displacement")
    axes.plot([], [], color=GREY, ls=":", label="limit with dilation")
    axes.axhline(0, color=GREY, lw=0.8)
    axes.set(xlabel="displacement of the crest [m]", ylabel="factor of the weight, horizontal [-]", xlim=(0, 1.05 * REACH))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    if options.picture:
        figure.savefig(options.picture)


if __name__ == "__main__":
    main()
