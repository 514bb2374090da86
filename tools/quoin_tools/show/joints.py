"""Draws the forces in joints that are lines, for plots.py: stresses beside those of the gravity method, and the opening of the joint.

joint_<joint>_<stage>.png
"""

from textwrap import fill

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection

from quoin_tools.assess.gravity import Base, Hand, crack_of
from quoin_tools.base import sheet_units
from quoin_tools.base.language import _
from quoin_tools.base.results import sliding
from quoin_tools.show.style import GREY, LINES, placed, plain, save

NOTHING = 1.0  # [Pa] stress along a joint that is rounding only
SIZE = (9.2, 3.6)  # [inch] of a picture as wide as the sheet, on which its letters are as large as those of a table
LABEL, TITLE = 25, 105  # letters of a line: panels keep one width, and nothing goes beyond the picture
LEFT, BOTTOM, RIGHT = 1.05, 0.58, 0.1  # [inch] beside a panel, for its numbers and label; below; at the edge
TOP, LINE = 0.25, 0.19  # [inch] above the panels: for gaps, and for each line
OPEN = "#f6dcdc"  # behind the open stretches


def joint_facts(facts):
    words = [f"{name} = {sheet_units.said(plain(facts[name] / 1e3), 'kN')}" for name in "NT"]
    if facts["sliding_factor_peak"] is not None:
        words.append(_("sliding factor {0} (c on {1:.2f} m closed)", sliding(facts["sliding_factor_peak"], 2), facts["length"] - facts["open_length"]))
    words += [_("open {0:.2f} m", facts["open_length"])] if facts["open_length"] > 0 else []
    words += [_("slipping {0:.2f} m", facts["slipping_length"])] if facts["slipping_length"] > 0 else []
    return ", ".join(words)


def no_tension(facts, thickness):
    """Distances [m] and stresses [Pa] of the gravity method under N and M of the joint, as in its tables without tension; None and why there are none."""
    base = Base(*((facts[end]["x"], facts[end]["y"]) for end in ("start", "end")), thickness)
    crack, where, refused = crack_of(base, facts["N"], facts["M"])
    if refused:
        return None, refused
    hand = Hand(base, facts["N"], facts["T"], facts["M"], crack=crack, crack_at=where)
    if crack == 0:
        return (np.array([0, base.length]), np.array(hand.linear)), _("gravity method, −N/L ± 6M/L²")
    at, stress = np.array([0, crack, base.length]), np.array([0, 0, -hand.compression])
    at, stress = (at, stress) if where == "start" else (base.length - at[::-1], stress[::-1])
    return (at, stress), _("gravity method, no tension: crack {0:.2f} m", crack)


def open_stretches(distance, opening):
    """Returns start and end [m] of the open stretches; opening is linear between the ends of a contact."""
    found = []
    for (a, b), (u, v) in zip(distance, opening):
        if u <= 0 and v <= 0:
            continue
        zero = a + (b - a) * u / (u - v) if u * v < 0 else None
        found.append((a if u > 0 else zero if zero is not None else a, b if v > 0 else zero if zero is not None else b))
    return found


def draw_course(axes, distance, values, colour, label):
    axes.add_collection(LineCollection(np.stack([distance, values], axis=2), colors=colour, linewidths=1.8))
    axes.plot(distance.ravel(), values.ravel(), ".", ms=4, color=colour, label=label)


def panels_of(carries, is_open):
    """Keys of the panels: stresses where there are any, the opening where there is one."""
    return (["sigma", "tau"] if carries else []) + (["opening"] if is_open or not carries else [])


def plot_joint(results, stage, joint, path):
    """False when the joint is no line of several contacts."""
    if results.without_profile(stage, joint):
        return False
    profile = results.joint_profile(stage, joint, "opening")
    if len(profile[0]) < 2:
        return False
    facts = results.stage_summary(stage)["joints"][joint]
    distance, sigma, tau, opening = profile
    carries, is_open = max(np.abs(sigma).max(), np.abs(tau).max()) >= NOTHING, facts["open_length"] > 0
    keys = panels_of(carries, is_open)
    figure, panels = pyplot.subplots(1, len(keys), figsize=SIZE, sharex=True, squeeze=False, layout="none")
    for key, axes in zip(keys, panels[0]):
        if key == "sigma":
            draw_sigma(axes, distance, sigma, facts, results.thickness)
        elif key == "tau":
            draw_course(axes, distance, tau / 1e3, LINES[2], _("Quoin, ends of contacts"))
            mean = facts["T"] / (facts["chord"] * results.thickness) / 1e3
            axes.plot([0, facts["chord"]], [mean, mean], "--", lw=1.5, color=LINES[1], label=_("mean, T/L"))
            axes.set_ylabel(_("shear stress τ [kPa]\n(+ towards the end)"))
        else:
            draw_course(axes, distance, 1e3 * np.maximum(opening, 0.0), LINES[3], fill(_("Quoin, {0} mm at most", plain(1e3 * opening.max())), LABEL))
            axes.set_ylabel(_("opening [mm]"))
            axes.set_ylim(bottom=0)
        for stretch in open_stretches(distance, opening) if is_open else ():
            axes.axvspan(*stretch, color=OPEN, lw=0, zorder=0)
        axes.axhline(0.0, color=GREY, lw=0.7)
        axes.grid(alpha=0.3)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=1, frameon=False, borderaxespad=0.1, handlelength=1.3, handletextpad=0.5)
    along = _("distance along the joint from ({0:.2f}, {1:.2f}) m to ({2:.2f}, {3:.2f}) m [m]", *(facts[end][x] for end in ("start", "end") for x in "xy"))
    figure.supxlabel(_("{0}; behind colour: open", along) if is_open else along, fontsize=10)
    words = (joint_facts(facts) if carries else _("it carries nothing, open over {0:.2f} of {1:.2f} m", facts["open_length"], facts["length"]) if is_open else
             _("it carries nothing, and is closed"))  # fmt: skip
    figure.suptitle(fill(_("Joint {0}, stage {1}: {2}", joint, stage, words), TITLE), fontsize=10)
    place_words(figure, panels[0])
    save(figure, path)
    return True


def lines_of(texts):
    return sum(text.get_text().count("\n") + 1 for text in texts)


def place_words(figure, panels):
    """Gives panels, their legends and the words about all of them their places [inch], alike in every picture."""
    height = figure.get_size_inches()[1]
    legends = max(lines_of(axes.get_legend().get_texts()) for axes in panels)
    placed(figure, LEFT, BOTTOM, RIGHT, TOP + LINE * (lines_of([figure._suptitle]) + legends), apart=LEFT)
    figure._suptitle.set_y(1 - RIGHT / height)
    figure._supxlabel.set_y(RIGHT / height)


def draw_sigma(axes, distance, sigma, facts, thickness):
    draw_course(axes, distance, sigma / 1e3, LINES[0], _("Quoin, ends of contacts"))
    line, words = no_tension(facts, thickness)
    if line:
        axes.plot(line[0], line[1] / 1e3, "--", lw=1.5, color=LINES[1], label=fill(words, LABEL))
    else:
        axes.plot([], [], " ", label=fill(_("gravity method: {0}", words), LABEL))
    axes.set_ylabel(_("normal stress σ [kPa]\n(tension positive)"))
