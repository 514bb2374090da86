"""Draws the force of a pushover over its displacement.

pushover_<stage>.png   force of each increment, in the order of the path, the largest one named
"""

import numpy as np
from matplotlib import pyplot

from quoin_tools.base.language import _
from quoin_tools.show.style import GREY, LINES, plain, save


def curve_of(s):
    """Returns displacements [m], forces [N] and whether each is an equilibrium, of a stage's object in summary.json; None: it is no pushover."""
    found = s.get("pushover")
    return tuple(np.array(found[name], dtype=float) for name in ("displacement", "force", "equilibrium")) if found else None


def legs(u):
    """Returns (first, last) rows of the legs of a path: stretches in which the displacement goes one way."""
    way = np.sign(np.diff(u))
    cuts = np.flatnonzero(way[1:] * way[:-1] < 0) + 1
    return list(zip([0, *cuts], [*cuts, len(u) - 1], strict=True))


def plot_pushover(results, stage, path):
    """False for a stage that is no pushover."""
    s = results.stage_summary(stage)
    curve = curve_of(s)
    if curve is None or len(curve[0]) < 2:
        return False
    u, force, rests = 1e3 * curve[0], 1e-3 * curve[1], curve[2] > 0
    figure, axes = pyplot.subplots(figsize=(8.0, 5.0))
    for number, (first, last) in enumerate(legs(u)):
        back = u[last] < u[first]
        axes.plot(u[first : last + 1], force[first : last + 1], marker=".", ms=4, lw=1.4, color=LINES[number % len(LINES)], ls="--" if back else "-")
        axes.annotate("", (u[last], force[last]), (u[last - 1], force[last - 1]), arrowprops={"arrowstyle": "->", "color": LINES[number % len(LINES)]})
    if not rests.all():
        axes.plot(u[~rests], force[~rests], "o", ms=6, mfc="none", color=GREY, label=_("no equilibrium"))
        axes.legend(frameon=False)
    peak = np.abs(np.where(rests, force, 0)).argmax()
    words = _("{0} kN at {1} mm", plain(force[peak]), plain(u[peak]))
    if "peak_factor" in s["pushover"]:
        words = _("{0}, factor {1:.4f}", words, s["pushover"]["peak_factor"])
        load = 1e-3 * s["pushover"]["load"]
        axes.secondary_yaxis("right", functions=(lambda f: f / load, lambda f: f * load)).set_ylabel(_("factor of the loads [-]"))
    right = u[peak] > 0.5 * (u.min() + u.max())
    axes.annotate(words, (u[peak], force[peak]), (-8 if right else 8, 8), textcoords="offset points", ha="right" if right else "left")
    axes.axhline(0, color=GREY, lw=0.8)
    axes.margins(y=0.12)
    axes.grid(alpha=0.3)
    axes.set_xlabel(_("displacement [mm]"))
    axes.set_ylabel(_("force [kN]"))
    axes.set_title(_("Stage {0} ({1}): force over displacement", stage, _(s["verdict"])))
    save(figure, path)
    return True
