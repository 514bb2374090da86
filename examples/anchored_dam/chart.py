"""Open length and stress at the toe against the level, without anchors, with tendons, with grouted bars, beside statics of a rigid dam; prints the table of the README.

    PYTHONPATH=tools python examples/anchored_dam/chart.py OUTPUT

OUTPUT has the folders `with`, `without` and `grouted` of run.sh; writes OUTPUT/levels.png."""

import os
import sys

import closed_form
import numpy as np
from matplotlib import pyplot
from quoin_tools.base.results import Results
from quoin_tools.show import style
from scipy.optimize import brentq

FORCE, SPACING, AXIAL = 4500e3, 3.0, 195e9 * 3.22e-3
GROUT = {"axial": AXIAL, "bond": 2e9, "strength": 600e3}
STEEL = {"without": "without steel", "with": "with tendons", "grouted": "with grouted bars"}
COLOURS = dict(zip(STEEL, (style.LINES[1], style.LINES[0], style.LINES[2])))


def by_statics(name, level):
    """Open length [m], pressure at the toe [Pa] and force [N] of a metre of steel."""
    if name == "grouted":
        return closed_form.grouted(level, SPACING, **GROUT)
    return closed_form.anchored(level, *((AXIAL / 40 / SPACING, FORCE / SPACING) if name == "with" else (0.0, 0.0)))


def slides(name):
    """Level [m] at which the rigid dam slides."""
    if name == "grouted":
        return brentq(lambda level: closed_form.WEIGHT + by_statics(name, level)[2] - closed_form.thrust(level)[0], 45, 51)
    return closed_form.slides(FORCE / SPACING if name == "with" else 0.0)


def base_of(s):
    """Open length [m] and pressure at the toe [Pa] of a stage or trial."""
    joint = s["joints"]["base"]
    return joint["open_length"], -joint["end"]["sigma"]


def force_of(results, stage):
    """[kN] of one tendon or bar; of a bar the largest, which it has at the base."""
    return next(iter(results.stage_summary(stage)["anchors"].values()))["force"] / 1e3


def trials_of(results):
    return sorted((t for t in results.stage_summary("flood")["flood"]["trials"] if t["outcome"] == "stable"), key=lambda t: t["value"])


def draw(runs, path):
    figure, panels = pyplot.subplots(1, 2, figsize=(10, 4.2))
    for name, words in STEEL.items():
        trials, colour = trials_of(runs[name]), COLOURS[name]
        levels = np.linspace(36, slides(name) + (2 if name != "grouted" else 0), 120)
        hand = np.array([by_statics(name, level)[:2] for level in levels])
        for panel, row, unit in zip(panels, range(2), (1.0, 1e6)):
            panel.plot(levels, hand[:, row] / unit, color=colour, lw=1.2, label=f"{words}, rigid dam by statics")
            panel.plot([t["value"] for t in trials], [base_of(t)[row] / unit for t in trials], "o", ms=4, color=colour, label=f"{words}, blocks")
            panel.axvline(slides(name), color=colour, lw=0.8, ls=":")
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
    """Rows of words: quantity, without, with tendons, grouted."""
    rows = []
    for stage, level in (("full", 36), ("at46", 46)):
        found = [base_of(runs[name].stage_summary(stage)) for name in STEEL]
        hand = [by_statics(name, level) for name in STEEL]
        rows.append((f"level {level} m: open length of the base [m] (statics)", *(f"{f[0]:.2f} ({h[0]:.2f})" for f, h in zip(found, hand))))
        rows.append(("... pressure at the toe [kPa]", *(f"{f[1] / 1e3:.0f} ({h[1] / 1e3:.0f})" for f, h in zip(found, hand))))
        factors = [runs[name].stage_summary(stage)["joints"]["base"]["sliding_factor_peak"] for name in STEEL]
        rows.append(("... sliding factor", *(f"{f:.3f} ({(closed_form.WEIGHT + h[2]) / closed_form.thrust(level)[0]:.3f})" for f, h in zip(factors, hand))))
        rows.append(("... force of one at the base [kN]", "", *(f"{force_of(runs[name], stage):.0f} ({SPACING * h[2] / 1e3:.0f})" for name, h in list(zip(STEEL, hand))[1:])))
    rows.append(("force in stage stressing, at 36, 46, again 36 m [kN]", "",
                 *(", ".join(f"{force_of(runs[name], stage):.1f}" for stage in ("stressing", "full", "at46", "back")) for name in ("with", "grouted"))))  # fmt: skip
    floods = [runs[name].stage_summary("flood")["flood"] for name in STEEL]
    rows.append(("flood that it no longer stands [m] (it slides by statics)", *(f"{f['stable']:.2f} to {f['failing']:.2f} ({slides(name):.2f})" for f, name in zip(floods, STEEL))))
    return rows


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    runs = {name: Results(os.path.join(sys.argv[1], name)) for name in STEEL}
    with pyplot.rc_context(style.STYLE):
        draw(runs, os.path.join(sys.argv[1], "levels.png"))
    for words in table(runs):
        print("| " + " | ".join(words) + " |")
