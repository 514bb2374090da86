"""Draws limit analysis: the line of thrust with hinges and joints that slide, and the mechanism of the bound."""

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection

from quoin_tools.base.language import N_, _
from quoin_tools.limit.program import velocities
from quoin_tools.mesh import blockmesh
from quoin_tools.show.style import COMPRESSION, GREY, STYLE, TENSION, figure_size, legend_below, save, set_view

MOVED = 0.06  # of the section: how far the fastest vertex of a mechanism is drawn
TURNS = 0.02  # of the pressed face: the resultant is nearer to its end, a hinge


def draw(answer, path, what, value):
    """Blocks moved along the mechanism, hinges and faces that slide, and the line of thrust; its path. what, value: the limit in words."""
    parts, limit = answer.parts, answer.limit
    corners = blockmesh.closed_rings(parts.mesh)
    rings = parts.mesh.vertices[corners]
    moving = rings if limit.motion is None else rings + MOVED * span(parts) * velocities(parts, limit.motion)[corners]
    box = view_of(parts)
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(1, 2, figsize=figure_size(box, 2, extra=0.8), sharey=True)
        for one, places in zip(axes, (rings, moving)):
            held = parts.ground[parts.body]
            one.add_collection(PolyCollection(places[~held], facecolors="#e8dfcc", edgecolors="#6b6b6b", linewidths=0.4))
            one.add_collection(PolyCollection(places[held], facecolors="#c9c9c9", edgecolors="#8a8a8a", linewidths=0.4))
            set_view(one, box)
        lines, points = thrust(answer)
        axes[0].add_collection(LineCollection(lines, colors=COMPRESSION, linewidths=1.6))
        axes[0].plot(*points.T, ".", color=COMPRESSION, markersize=4)
        axes[0].set_title(_("Thrust: where forces pass\nfrom block to block"))
        if parts.ties.lines:
            tied = axes[0].add_collection(LineCollection(list(parts.ties.lines.values()), colors="black", linewidths=1.2, linestyles="dashed", zorder=3))
            tied.set_label(_("anchor ({0})", len(parts.ties.lines)))
        state = states(answer)
        for name, colour, mark in ((N_("hinge"), TENSION, "o"), (N_("slides"), "#009e73", "s")):
            at = np.array([place for place, what in state if what == name]).reshape(-1, 2)
            if len(at):
                axes[0].plot(*at.T, mark, markerfacecolor="none", markeredgecolor=colour, markersize=6, label=f"{_(name)} ({len(at)})", linestyle="none")
        handles = axes[0].get_legend_handles_labels()[0]
        if handles:  # below the section, on which it could hide a crest
            legend_below(figure, handles, len(handles))
        axes[1].set_title(_("Mechanism of the bound\n(not to scale)"))
        axes[0].set_ylabel("y [m]")
        figure.suptitle(_("Stage {0}: limit analysis, {1} {2}", answer.stage, what, value), color=GREY)
        save(figure, path)
    return path


def span(parts):
    low, high = free_corners(parts)
    return float((high - low).max())


def free_corners(parts):
    points = parts.mesh.vertices[blockmesh.closed_rings(parts.mesh)[~parts.ground[parts.body]]].reshape(-1, 2)
    return points.min(axis=0), points.max(axis=0)


def view_of(parts):
    """The free bodies and a margin."""
    low, high = free_corners(parts)
    margin = 0.12 * (high - low).max()
    return low[0] - margin, high[0] + margin, low[1] - margin, high[1] + margin


def resultants(answer):
    """Returns for each contact the normal force [N], the place of the resultant, at an end of the face where tension puts it outside, and its part of the face from p."""
    contacts, (n1, n2) = answer.parts.contacts, answer.limit.normal.T
    force = n1 + n2
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(np.abs(force) > 0, n2 / force, 0.5)
    return force, contacts.p + np.clip(share, 0.0, 1.0)[:, None] * (contacts.q - contacts.p), share


def thrust(answer):
    """Returns (segments, points) of the line of thrust: from contact to contact through each body, where forces of note pass."""
    force, place, _ = resultants(answer)
    contacts = answer.parts.contacts
    pressed = force > 1e-3 * force.max(initial=0.0)
    segments = []
    for body in np.flatnonzero(~answer.parts.ground):
        mine = np.flatnonzero(pressed & ((contacts.a == body) | (contacts.b == body)))
        if len(mine) == 2:
            segments.append(place[mine])
        elif len(mine) > 2:  # forces meet within the block: each goes towards the middle of all, by their sizes
            middle = np.average(place[mine], axis=0, weights=force[mine])
            segments += [np.array([place[i], middle]) for i in mine]
    return segments, place[pressed]


def states(answer):
    """Returns (place, hinge or slides) of the contacts whose strength is used up in the mechanism."""
    force, place, share = resultants(answer)
    parts, limit = answer.parts, answer.limit
    contacts, found = parts.contacts, []
    if limit.motion is None:
        return found
    largest = force.max(initial=0.0)
    for i in range(len(contacts)):
        if force[i] <= 1e-6 * largest:
            continue
        ends = np.array([relative(parts, limit.motion, i, place) for place in (contacts.p[i], contacts.q[i])])
        opening, sliding = ends @ contacts.normal[i], ends @ contacts.along[i]
        if abs(opening[0] - opening[1]) > 1e-4 and min(share[i], 1 - share[i]) < TURNS:
            found.append((place[i], "hinge"))
        elif np.abs(sliding).max() > 1e-4:
            found.append((place[i], "slides"))
    return found


def relative(parts, motion, i, place):
    """Velocity of body b over body a at a place of a contact."""
    one, two = parts.contacts.a[i], parts.contacts.b[i]
    speeds = [motion[k, :2] + motion[k, 2] * np.array([-(place - parts.centre[k])[1], (place - parts.centre[k])[0]]) for k in (one, two)]
    return speeds[1] - speeds[0]
