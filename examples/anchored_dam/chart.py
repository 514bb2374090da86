"""Open length and stress at the toe against the level, with and without tendons, beside statics of a rigid dam; prints the table of the README.

    PYTHONPATH=tools python examples/anchored_dam/chart.py OUTPUT

OUTPUT has the folders `with` and `without` of run.sh; writes OUTPUT/levels.png."""

import os
import sys

import closed_form
import numpy as np
from matplotlib import pyplot
from quoin_tools.base.results import Results
from quoin_tools.show import style

FORCE, SPACING, STIFFNESS = 4500e3, 3.0, 195e9 * 3.22e-3 / 40
KINDS = (("without", 0.0, 0.0, style.LINES[1]), ("with", STIFFNESS / SPACING, FORCE / SPACING, style.LINES[0]))


def base_of(s):
    """Open length [m] and pressure at the toe [Pa] of a stage or trial."""
    joint = s["joints"]["base"]
    return joint["open_length"], -joint["end"]["sigma"]


def trials_of(results):
    return sorted((t for t in results.stage_summary("flood")["flood"]["trials"] if t["outcome"] == "stable"), key=lambda t: t["value"])


def draw(runs, path):
    figure, panels = pyplot.subplots(1, 2, figsize=(10, 4.2))
    for name, k, T, colour in KINDS:
        trials = trials_of(runs[name])
        levels = np.linspace(36, closed_form.overturns(T) - 0.05, 120)
        hand = np.array([closed_form.anchored(level, k, T)[:2] for level in levels])
        for panel, row, unit in zip(panels, range(2), (1.0, 1e6)):
            panel.plot(levels, hand[:, row] / unit, color=colour, lw=1.2, label=f"{name} tendons, rigid dam by statics")
            panel.plot([t["value"] for t in trials], [base_of(t)[row] / unit for t in trials], "o", ms=4, color=colour, label=f"{name} tendons, blocks")
            panel.axvline(closed_form.slides(T), color=colour, lw=0.8, ls=":")
    panels[0].set_ylabel("open length of the base [m]")
    panels[1].set_ylabel("pressure at the toe [MPa]")
    panels[1].set_ylim(0, 8)
    panels[0].legend(frameon=False, fontsize=8)
    for panel in panels:
        panel.set_xlabel("level of the flood [m] (dotted: slides)")
        panel.set_xlim(36, 56)
        panel.grid(alpha=0.3)
    style.save(figure, path)


def table(runs):
    """Rows of words: quantity, without, with."""
    rows = []
    for stage in ("full", "at46"):
        level = 36 if stage == "full" else 46
        found = [base_of(runs[name].stage_summary(stage)) for name, *_ in KINDS]
        hand = [closed_form.anchored(level, k, T) for _, k, T, _ in KINDS]
        rows.append((f"level {level} m: open length of the base [m] (statics)", *(f"{f[0]:.2f} ({h[0]:.2f})" for f, h in zip(found, hand))))
        rows.append(("... pressure at the toe [kPa]", *(f"{f[1] / 1e3:.0f} ({h[1] / 1e3:.0f})" for f, h in zip(found, hand))))
        factors = [runs[name].stage_summary(stage)["joints"]["base"]["sliding_factor_peak"] for name, *_ in KINDS]
        rows.append(("... sliding factor", *(f"{f:.3f} ({(closed_form.WEIGHT + h[2]) / closed_form.thrust(level)[0]:.3f})" for f, h in zip(factors, hand))))
    forces = [runs["with"].stage_summary(stage)["anchors"]["tendon"]["force"] / 1e3 for stage in ("stressing", "full", "at46", "back")]
    rows.append(("tendon as it is locked, at 36, 46, again 36 m [kN]", "", ", ".join(f"{force:.1f}" for force in forces)))
    floods = [runs[name].stage_summary("flood")["flood"] for name, *_ in KINDS]
    ends = [f"{f['stable']:.2f} to {f['failing']:.2f} ({closed_form.slides(T):.2f})" for f, (_, _, T, _) in zip(floods, KINDS)]
    rows.append(("flood that it no longer stands [m] (it slides by statics)", *ends))
    return rows


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    both = {name: Results(os.path.join(sys.argv[1], name)) for name, *_ in KINDS}
    with pyplot.rc_context(style.STYLE):
        draw(both, os.path.join(sys.argv[1], "levels.png"))
    for words in table(both):
        print("| " + " | ".join(words) + " |")
