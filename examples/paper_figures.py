"""Figures 11 to 18 of the paper (section 4, the Guilhofrei dam) from results of our own, its numbers marked.

Each figure's function takes runs (Results), writes one picture and returns what it drew as numbers. The section is a reconstruction: what the
figures show beside the paper's numbers says how near it comes, and no more.
"""

import math

import numpy as np
from matplotlib import pyplot
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import BoundaryNorm
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation
from quoin_tools.base.files import save_figure
from quoin_tools.show.mechanism import draw_mechanism
from quoin_tools.show.stress import cross_panel, thinned, triangles
from quoin_tools.show.style import FILLS, GREY, LINES, STYLE, set_view, view

FACTORS = (1, 1.5, 2, 2.5, 3, 4, 5, 7.5, 10, 15, 20)  # steps of colour in Fig. 13
MODES = {1: "t", 2: "c", 3: "s"}  # safety_mode of results.h5; letters as in Fig. 13
NOTE = "section G1, a reconstruction"


def save(figure, path):
    save_figure(figure, path)
    pyplot.close(figure)


def base_profile(results, stage, joints=("key", "base")):
    """Contacts of the joints along the base, from the heel: distance [m] and sigma [Pa] of their ends, each (n, 2); chord [m]."""
    names, contacts = results.mesh.joint_names, results.stage(stage).contacts
    mine = np.isin(contacts.joint, [names.index(name) for name in joints if name in names])
    point, sigma = contacts.point[mine], contacts.sigma[mine]
    corners = point.reshape(-1, 2)
    heel, toe = corners[corners[:, 0].argmin()], corners[corners[:, 0].argmax()]
    chord = float(np.hypot(*(toe - heel)))
    distance = (point - heel) @ (toe - heel) / chord
    order = np.argsort(distance, axis=1, kind="stable")
    distance, sigma = (np.take_along_axis(array, order, axis=1) for array in (distance, sigma))
    rows = np.argsort(distance.sum(axis=1), kind="stable")
    return distance[rows], sigma[rows], chord


def draw_profile(axes, distance, sigma, **style):
    """Contact by contact, with a gap between contacts that do not join."""
    x, y = (np.column_stack([array, np.full(len(array), np.nan)]).ravel() for array in (distance, sigma / 1e6))
    axes.plot(x, y, ".-", ms=4, lw=1.7, **style)


def straight_line(distance, sigma, chord):
    """Stress at heel and toe [Pa] of the straight line with the same N and M: -N/L -+ 6 M/L^2."""
    size = np.diff(distance, axis=1)[:, 0]
    N = -(sigma.mean(axis=1) * size).sum()
    first = (size * (distance[:, 0] * (2 * sigma[:, 0] + sigma[:, 1]) + distance[:, 1] * (sigma[:, 0] + 2 * sigma[:, 1])) / 6).sum()
    M = first + N * chord / 2  # of the tension about the middle: positive when it pulls at the toe
    return -N / chord - 6 * M / chord**2, -N / chord + 6 * M / chord**2


def figure_11(results, path, stage="swhp", group="dam", paper=4.0):
    """Principal stresses at the centres of blocks (a) and displacements (b) under self-weight and water. paper: its largest u_x [mm]."""
    mesh, fields, facts = results.mesh, results.stage(stage), results.stage_summary(stage)["stress_by_group"][group]
    box, _ = view(mesh)
    mine = mesh.block_group == mesh.group_names.index(group)
    vertices = np.unique(mesh.blocks[mine][mesh.blocks[mine] >= 0])
    u = 1e3 * fields.displacement
    most = vertices[u[vertices, 0].argmax()]
    outline = mesh.vertices[mesh.outline()]
    with pyplot.rc_context(STYLE):
        figure, (left, right) = pyplot.subplots(1, 2, figsize=(10.5, 6.4), sharey=True)
        cross_panel(left, mesh, fields, np.ones(len(mesh.blocks), dtype=bool), box)
        least, largest = facts["s2_min"]["value"] / 1e6, facts["s1_max"]["value"] / 1e6
        left.set_title(f"(a) principal stresses; in the dam {least:.2f} to {largest:.3f} MPa\nthe paper: -0.96 at the toe, no tension".replace("-", "−"))
        corners = triangles(mesh, np.ones(len(mesh.blocks), dtype=bool))
        filled = right.tricontourf(Triangulation(*mesh.vertices.T, corners), u[:, 0], levels=MaxNLocator(14).tick_values(0, u[most, 0]),
                                   cmap="viridis", extend="both")  # fmt: skip
        figure.colorbar(filled, ax=right, label="horizontal displacement [mm], downstream positive")
        rows, _ = thinned(mesh.vertices, np.ones(len(mesh.vertices), dtype=bool), box)
        right.quiver(*mesh.vertices[rows].T, *u[rows].T, angles="xy", color="white", edgecolor="black", linewidth=0.4, width=0.003)
        right.plot(*mesh.vertices[most], "o", ms=9, mfc="none", mec="black", mew=1.4, clip_on=False, zorder=5)
        right.set_title(f"(b) displacements; largest to downstream {u[most, 0]:.2f} mm (ring)\nthe paper: {paper:g} mm")
        for axes in (left, right):
            axes.add_collection(LineCollection(outline, colors="black", linewidths=0.6))
            set_view(axes, box)
        left.set_ylabel("y [m]")
        figure.suptitle(f"Fig. 11: self-weight and full reservoir, joint with friction ({NOTE})")
        save(figure, path)
    return {"u_x": float(u[most, 0]), "at": mesh.vertices[most], "s2": least, "s1": largest}


def figure_12(results, path, stage="swhp"):
    """Stress along the base under self-weight and water against the straight line of the gravity method (LEM)."""
    distance, sigma, chord = base_profile(results, stage)
    heel, toe = straight_line(distance, sigma, chord)
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(figsize=(8.2, 4.4))
        draw_profile(axes, distance, sigma, color=LINES[0], label="block model, ends of contacts")
        axes.plot([0, chord], [heel / 1e6, toe / 1e6], "--", color=LINES[1], label="gravity method, same N and M")
        axes.axhline(0.0, color=GREY, lw=0.7)
        for x, value, to, shift in ((0.0, heel, "left", (12, 6)), (chord, toe, "right", (-42, -16))):  # clear of both lines
            axes.annotate(f"{value / 1e6:.3f} MPa".replace("-", "−"), (x, value / 1e6), shift, textcoords="offset points",
                          color=LINES[1], ha=to)  # fmt: skip
        axes.set_xlabel("distance from the heel along the base [m]")
        axes.set_ylabel("normal stress [MPa], tension positive")
        axes.set_title(f"Fig. 12: base of the Guilhofrei dam, self-weight and full reservoir\n({NOTE}; the paper prints no numbers here)")
        axes.legend(loc="lower left")
        axes.grid(alpha=0.3)
        save(figure, path)
    return {"heel": heel, "toe": toe, "peak": float(sigma.min())}


def figure_13(runs, path, stage="swhp", group="dam"):
    """Local failure factor of every block. runs: (title, Results, the paper's least factor as text)."""
    found = []
    with pyplot.rc_context(STYLE):
        figure, panels = pyplot.subplots(1, len(runs), figsize=(4 * len(runs), 5.2), sharey=True, squeeze=False)
        norm = BoundaryNorm(FACTORS, 256, extend="both")
        for axes, (title, results, paper) in zip(panels[0], runs):
            mesh, fields, least = results.mesh, results.stage(stage), results.stage_summary(stage)["safety"][group]
            mine = mesh.block_group == mesh.group_names.index(group)
            cells = PolyCollection(mesh.rings()[mine], array=fields.safety_factor[mine], cmap="RdYlBu", norm=norm,
                                   edgecolors="#8a8a8a", linewidths=0.2)  # fmt: skip
            axes.add_collection(cells)
            for k in np.flatnonzero(mine & (fields.safety_mode != 3)):  # shear governs nearly everywhere
                axes.text(*mesh.centres()[k], MODES.get(int(fields.safety_mode[k]), ""), ha="center", va="center", color="white", fontsize=6)
            axes.plot(least["x"], least["y"], "o", ms=9, mfc="none", mec="black")
            axes.set_title(f"{title}: least {least['value']:.2f} (ring)\nthe paper: {paper}")
            axes.set_aspect("equal")
            axes.autoscale_view()
            axes.set_xlabel("x [m]")
            found.append(least["value"])
        panels[0][0].set_ylabel("y [m]")
        figure.colorbar(cells, ax=panels, label="local failure factor [-]; t, c: tension, compression governs, else shear")
        figure.suptitle(f"Fig. 13: local failure factors, self-weight and full reservoir ({NOTE})")
        save(figure, path)
    return found


def mechanisms(runs, path, title):
    """Panels side by side, to one scale. runs: (title, Results, stage)."""
    boxes = np.array([view(results.mesh)[0] for _, results, _ in runs])
    low, high = boxes[:, 2].min(), boxes[:, 3].max()
    widths = boxes[:, 1] - boxes[:, 0]
    with pyplot.rc_context(STYLE):
        size = (1.5 + 5.0 * widths.sum() / (high - low), 6.0)
        figure, panels = pyplot.subplots(1, len(runs), figsize=size, sharey=True, squeeze=False, width_ratios=widths)
        for axes, (head, results, stage) in zip(panels[0], runs):
            cells = draw_mechanism(axes, results, stage)
            axes.set_ylim(low, high)
            axes.set_title(head)
        panels[0][0].set_ylabel("y [m]")
        figure.colorbar(cells, ax=panels, label="velocity of the first failing trial [-], the fastest vertex 1")
        figure.suptitle(title + "\n")
        save(figure, path)


def figure_14(runs, path):
    """Voronoi dams without cohesion. runs: (title, Results, stage)."""
    mechanisms(runs, path, f"Fig. 14: Voronoi polygons without cohesion ({NOTE}; the paper's polygons are not known)")


MOVES = 0.02  # of the fastest vertex: sides of a contact that move apart by less stay together in a mechanism
STAYS, OPENS, SLIDES = 0, 1, 2


def parting(mesh, contacts, velocity):
    """Velocity of side a against side b at the ends of each contact, (n, 2, 2): across, positive when they part, and along."""
    sides = []
    for block, k in (contacts.face[:, :2].T, contacts.face[:, 2:].T):
        n = np.where(mesh.blocks[block, 3] < 0, 3, 4)
        first, second = mesh.blocks[block, k], mesh.blocks[block, (k + 1) % n]
        A, B = mesh.vertices[first][:, None], mesh.vertices[second][:, None]
        t = (((contacts.point - A) * (B - A)).sum(axis=2) / ((B - A) ** 2).sum(axis=2))[..., None]
        sides.append((1 - t) * velocity[first][:, None] + t * velocity[second][:, None])
    jump, normal = sides[0] - sides[1], contacts.normal
    return np.stack([(jump * normal).sum(axis=2), np.abs(jump[..., 1] * normal[..., 0] - jump[..., 0] * normal[..., 1])], axis=2)


def failure_path(results, stage):
    """Contacts that part or slide in the mechanism of a stage: their ends (n, 2, 2), what they do, names of their joints."""
    mesh, fields = results.mesh, results.stage(stage)
    contacts = fields.contacts
    if fields.mechanism is None or (contacts.face < 0).any():
        return np.zeros((0, 2, 2)), np.zeros(0, dtype=int), np.zeros(0, dtype=str)
    across, along = parting(mesh, contacts, fields.mechanism).mean(axis=1).T
    does = np.where(np.maximum(across, along) < MOVES, STAYS, np.where(across > along, OPENS, SLIDES))
    order = np.flatnonzero(does)
    order = order[np.argsort(contacts.point[order, :, 0].mean(axis=1), kind="stable")]
    return contacts.point[order], does[order], np.array(mesh.joint_names)[contacts.joint[order]]


def figure_15(runs, path):
    """Detail of the failure paths: what slides or opens in each mechanism. runs: (title, Results, stage, joint of the shear key or None)."""
    found = []
    ends = np.concatenate([failure_path(results, stage)[0].reshape(-1, 2) for _, results, stage, _ in runs])
    box = (ends[:, 0].min() - 4, ends[:, 0].max() + 4, ends[:, 1].min() - 3, ends[:, 1].max() + 4)
    with pyplot.rc_context(STYLE):
        size = (12, 1.2 + len(runs) * (0.5 + 11 * (box[3] - box[2]) / (box[1] - box[0])))
        figure, panels = pyplot.subplots(len(runs), 1, figsize=size, sharex=True, squeeze=False)
        for axes, (title, results, stage, key) in zip(panels[:, 0], runs):
            mesh, (lines, does, names) = results.mesh, failure_path(results, stage)
            for row in np.unique(mesh.block_group):
                axes.add_collection(PolyCollection(mesh.rings()[mesh.block_group == row], facecolors=FILLS[row], edgecolors="#a0a0a0", linewidths=0.3))
            for width, chosen, colour in ((7, names == key, LINES[4]), (2.5, does == SLIDES, LINES[1]), (2.5, does == OPENS, LINES[0])):
                axes.add_collection(LineCollection(lines[chosen], colors=colour, linewidths=width, capstyle="butt", zorder=4))
            first, last = lines.reshape(-1, 2)[[lines[..., 0].argmin(), lines[..., 0].argmax()]]
            length, rise = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum(), (last[1] - first[1]) / (last[0] - first[0])
            centres, velocity = mesh.centres(), results.stage(stage).mechanism
            motion = mesh.rings(velocity).mean(axis=1)
            moving = np.flatnonzero(np.hypot(*motion.T) > MOVES)
            lowest = moving[thinned(centres[moving], np.ones(len(moving), dtype=bool), box)[0][::3]]
            axes.quiver(*centres[lowest].T, *motion[lowest].T, angles="xy", scale=25, width=0.0015, zorder=5)
            set_view(axes, box)
            axes.set_xlabel("")
            axes.set_ylabel("y [m]")
            axes.set_title(f"{title}: {length:.1f} m, rises by {100 * rise:.1f} %")
            found.append({"length": float(length), "rise": float(rise), "from": first, "to": last, "slides": float((does == SLIDES).mean())})
        axes.set_xlabel("x [m]")
        handles = [Line2D([], [], color=colour, lw=width, label=label) for colour, width, label in (
            (LINES[1], 2.5, "slides"), (LINES[0], 2.5, "opens"), (LINES[4], 7, "shear key: cohesion and tensile strength"))]  # fmt: skip
        figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
        figure.suptitle(f"Fig. 15: failure paths, with the motion of the first failing trial ({NOTE})")
        save(figure, path)
    return found


def figure_18(runs, path):
    """Failure mechanisms of the sliding analyses. runs: (title, Results, stage)."""
    mechanisms(runs, path, f"Fig. 18: failure mechanisms ({NOTE})")


def reduction_curve(results, stage, point, to_angle):
    """Friction angle [degree], descending, and u_x [m] of a point in the stable trials of a strength reduction."""
    trials = results.stage_summary(stage)["strength_reduction"]["trials"]
    rows = sorted(((to_angle(t["value"]), t["probes"][point]["u_x"]) for t in trials if t["outcome"] == "stable"), reverse=True)
    return np.array(rows).reshape(-1, 2)


def reduced_angle(friction):
    """Angle of a reduction of all strengths by a factor: that of the reduced friction [degree]."""
    return lambda factor: math.degrees(math.atan(factor * math.tan(math.radians(friction))))


def figure_16(runs, path, point="crest_upstream"):
    """Crest against friction. runs: (name, Results, stage, the paper's factor or None); by angle or by factor on 45 degrees."""
    curves = {}
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(figsize=(8.2, 4.8))
        for colour, (name, results, stage, paper) in zip(LINES, runs):
            facts = results.stage_summary(stage)["strength_reduction"]
            to_angle = (lambda value: value) if facts["what"] == "friction" else reduced_angle(45.0)
            curve = curves[name] = reduction_curve(results, stage, point, to_angle)
            axes.plot(curve[:, 0], 1e3 * curve[:, 1], "o-", ms=4, color=colour, label=f"{name}: stable trials")
            if facts["failing"] is not None:
                axes.axvline(to_angle(facts["failing"]), color=colour, lw=1)
            if paper:
                angle = math.degrees(math.atan(1 / paper))
                axes.axvline(angle, color=colour, ls="--", lw=1, label=f"{name}: the paper's failure, {angle:.1f}° (factor {paper:g})")
        axes.invert_xaxis()
        axes.set_xlabel("friction angle [degree] (reduced strengths: of the reduced 45°)")
        axes.set_ylabel(f"{point.replace('_', ' ')} $u_x$ [mm]")
        axes.set_title(f"Fig. 16: sliding; solid lines: our first failing trial ({NOTE})")
        axes.legend(fontsize=8)
        axes.grid(alpha=0.3)
        save(figure, path)
    return curves


def flood_curve(results, stage, crest):
    """Rows (rise above the crest [m], crack [m], compression at the toe [Pa]) of the stable trials of a flood."""
    rows = [(t["value"] - crest, sum(j["open_length"] for j in t["joints"].values()), -t["joints"]["base"]["end"]["sigma"])
            for t in results.stage_summary(stage)["flood"]["trials"] if t["outcome"] == "stable"]  # fmt: skip
    return np.array(sorted(rows)).reshape(-1, 3)


def figure_17(levels, flood, path, hand, stable_in_paper=5.0):
    """Flood S4. levels: (rise [m], Results, stage) to draw along the base; flood: (Results, stage, crest [m]).

    hand: rows (rise [m], crack [m], toe [MPa]) of the rigid section without tension."""
    hand, curve = np.asarray(hand, dtype=float), flood_curve(*flood)
    with pyplot.rc_context(STYLE):
        figure, (left, right) = pyplot.subplots(1, 2, figsize=(12, 4.8))
        for colour, (rise, results, stage) in zip(LINES, levels):
            distance, sigma, chord = base_profile(results, stage)
            draw_profile(left, distance, sigma, color=colour, label=f"+{rise:.1f} m")
            for _, crack, toe in hand[(hand[:, 0] == rise) & (hand[:, 1] > 0)]:
                left.plot([crack, chord], [0, -toe], "--", color=colour, lw=1)
        left.axhline(0.0, color=GREY, lw=0.7)
        left.set_xlabel("distance from the heel along the base [m]")
        left.set_ylabel("effective normal stress [MPa], tension positive")
        left.set_title("along the base; dashed: rigid section, no tension")
        left.legend(title="water above the crest", fontsize=8)
        right.plot(curve[:, 0], curve[:, 1], "o-", color=LINES[0], label="crack [m]: block model")
        right.plot(hand[:, 0], hand[:, 1], "x", ms=9, color=LINES[0], label="crack [m]: rigid section, by hand")
        right.axvline(stable_in_paper, color=LINES[3], ls="--", lw=1, label=f"the paper: stable up to +{stable_in_paper:g} m")
        right.set_xlabel("water above the crest [m]")
        right.set_ylabel("crack [m]")
        second = right.twinx()
        second.plot(curve[:, 0], curve[:, 2] / 1e6, "s-", color=LINES[1], label="toe [MPa]: block model, end of the joint")
        second.plot(hand[:, 0], hand[:, 2], "+", ms=10, color=LINES[1], label="toe [MPa]: by hand")
        second.set_ylabel("compression at the toe [MPa]")
        second.set_ylim(bottom=0)
        handles = [axes.get_legend_handles_labels() for axes in (right, second)]
        right.legend(handles[0][0] + handles[1][0], handles[0][1] + handles[1][1], fontsize=8, loc="upper left")
        right.set_title("crack and toe, level by level")
        figure.suptitle(f"Fig. 17: flood S4 ({NOTE})")
        save(figure, path)
    return curve
