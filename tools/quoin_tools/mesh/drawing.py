"""Reads a drawing (DXF) as a plan: layers become groups, galleries, joints, faces, drains, anchors and points, by a small table in the section file.

Outlines are closed polylines, or lines and arcs that meet at their ends. What is not closed, crosses or misses is named with its coordinates."""

import os

import numpy as np
import scipy
import shapely

from quoin_tools.mesh import entities, patterns
from quoin_tools.mesh.blockmesh import xy_text
from quoin_tools.mesh.lengths import UNITS
from quoin_tools.mesh.plan import Line, Region

# codes of the head of a drawing; those in capitals are of no section
INSUNITS = {1: "in", 2: "ft", 3: "MILES", 4: "mm", 5: "cm", 6: "m", 7: "km", 8: "MICROINCHES", 9: "MILS", 10: "yd", 11: "ANGSTROMS", 12: "NANOMETRES", 13: "MICRONS", 14: "dm",
            15: "DECAMETRES", 16: "HECTOMETRES", 17: "GIGAMETRES", 18: "ASTRONOMICAL UNITS", 19: "LIGHT YEARS", 20: "PARSECS", 21: "ft_us"}  # fmt: skip
ROLES = ("group", "hole", "joint", "faces", "drain", "anchor", "point")
MISS = 0.01  # of the size of blocks: lines that come so near without meeting are meant to meet
LARGEST, SMALLEST = 5000.0, 0.1  # m, of a section


def add(made, top, size):
    """Reads the drawing that a section file names into a plan; returns notes."""
    keys, table = top.below("drawing", required=True), top.named("layers", free=True)
    if not table and "layers" not in top:
        top.fault(None, f"'layers' is missing, expected a table of layers, each with {' or '.join(ROLES)}")
    if keys is None or not table:
        return []
    used = {layer.upper() for layer, _ in table}
    sheet, gap, notes = read(keys, used)
    if sheet is None:
        return []
    made.rough = max(made.rough, gap)
    there = sheet.layers()
    missing = [layer for layer, _ in table if layer.upper() not in {name.upper() for name in there}]
    for layer in missing:
        top.fault(("layers", layer), f"no such layer in the drawing, which has {', '.join(there)}")
    unused = [name for name in there if name.upper() not in used]
    if unused:
        notes.append(f"layers of the drawing that are not in the table: {', '.join(unused)}")
    notes += [f"layer {layer}: {count} {kind} not read" for (layer, kind), count in sorted(sheet.others.items()) if layer.upper() in used]
    rows = [Layer(layer, below, sheet, gap, notes) for layer, below in table if layer not in missing]
    for role in ROLES:  # holes are cut out of groups, which come before
        for row in rows if role == "group" or not top.faults else ():
            if row.role == role:
                getattr(row, role)(made, size)
    return notes


def finish(made, top):
    """Once all groups are there."""
    if made.regions and not top.faults:
        check_misses(made, top)
        clip_joints(made)


def read(keys, used):
    """Reads (Sheet, gap, notes) of the file that the keys name; (None, 0, []) where it cannot be read. used: layers of the table, by which its size is judged."""
    name, unit = keys.text("file"), keys.choice("units", tuple(UNITS), None)
    scale, chord, gap = keys.number("scale", 1.0, above=0, unit="-"), keys.number("chord", 0.02, above=0), keys.number("gap", 0.0, least=0, most=0.5)
    origin = keys.point("origin", [0.0, 0.0], far=1e12)
    keys.done()
    if None in (name, scale, chord, gap, origin):
        return None, 0.0, []
    path = os.path.join(os.path.dirname(keys.path), name)
    try:
        document = entities.opened(path)
    except (OSError, entities.DrawingError) as error:
        keys.fault("file", f"no drawing that can be read ({getattr(error, 'strerror', None) or error})", name)
        return None, 0.0, []
    # files older than AC1015 (R2000) have no units; ezdxf gives them its own default
    own, notes = INSUNITS.get(document.units) if getattr(document, "_loaded_dxfversion", document.dxfversion) >= "AC1015" else None, []
    if unit is None and (own is None or own.isupper()):
        stated = f"the drawing says that its units are {own.lower()}" if own else "the drawing does not say its units"
        keys.fault(None, f"{stated}, expected units: {' or '.join(UNITS)}")
        return None, 0.0, []
    if unit and own and unit != own:
        notes.append(f"the drawing says that its units are {own}; they are taken as {unit}, as the section file says")
    hidden = [layer for layer in document.layers if layer.dxf.name.upper() in used and (layer.is_frozen() or layer.is_off())]
    notes += [f"layer {layer.dxf.name} is {'frozen' if layer.is_frozen() else 'off'} in the drawing; it is read, since the table has it" for layer in hidden]
    metre = UNITS[unit or own] * scale
    try:
        sheet = entities.collected(document, used, chord / metre)
    except entities.DrawingError as error:
        keys.fault("file", f"no drawing that can be read ({error})", name)
        return None, 0.0, []
    for rows in (*sheet.curves.values(), *sheet.points.values()):
        rows[:] = [(xy - np.array(origin)) * metre for xy in rows]
    measured = [xy for rows in sheet.curves.values() for xy in rows]
    extent = np.ptp(np.concatenate(measured), axis=0).max() if measured else 0.0
    if not sheet.layers():
        keys.fault("file", "a drawing without lines", name)
        return None, 0.0, []
    if measured and not SMALLEST <= extent <= LARGEST:
        keys.fault("units" if unit else None, f"the drawing would be {extent:g} m across: wrong units or scale", unit)
        return None, 0.0, []
    return sheet, gap, notes + remarks(sheet, metre)


def remarks(sheet, metre):
    """Returns notes on curves, widths and clipped blocks that are read otherwise than drawn."""
    notes = [f"layer {layer}: its curves are not level (z varies by up to {rise * metre:.3g} m); x and y are read" for layer, rise in sorted(sheet.tilted.items()) if rise * metre > entities.LEVEL]
    notes += [f"layer {layer}: {count} polylines have a width; their centre lines are read" for layer, count in sorted(sheet.wide.items())]
    return notes + [f"block {name} is clipped in the drawing (XCLIP); it is read whole" for name in sorted(sheet.clipped)]


class Layer:
    """One row of the table, and what the drawing has on it."""

    def __init__(self, layer, keys, sheet, gap, notes):
        self.layer, self.keys, self.gap, self.notes = layer, keys, gap, notes
        self.curves = [xy for name, rows in sheet.curves.items() if name.upper() == layer.upper() for xy in rows]
        self.places = [xy for name, rows in sheet.points.items() if name.upper() == layer.upper() for xy in rows]
        self.role = keys.one_of(*ROLES)
        self.name = keys.name(self.role) if self.role else None
        self.size, self.rigid, self.sides = keys.number("size", None, above=0), keys.flag("rigid"), keys.flag("sides")
        below = keys.below("pattern")
        self.pattern = patterns.read(below, [], 0) if below else None
        keys.done()
        self.near = max(gap, 1e-6)
        self.without_doubles()
        unread = f"{len(self.places)} POINT" if self.places and self.role != "point" else ""  # only a layer of points reads points
        if unread and self.curves:
            notes.append(f"layer {layer}: {unread} not read")
        if self.name is None or (self.role != "point" and not self.curves):
            if self.name is not None:
                passed_over = [f"{count} {kind}" for (name, kind), count in sorted(sheet.others.items()) if name.upper() == layer.upper()]
                there = " and ".join([*passed_over, unread] if unread else passed_over)
                self.fault(f"expected lines on this layer, there are {f'only {there}' if there else 'none'}")
            self.role = None

    def fault(self, reason):
        self.keys.fault(None, reason)

    def without_doubles(self):
        """Leaves out, and tells, curves that are drawn twice."""
        seen, kept = set(), []
        for xy in self.curves:
            places = np.round(xy / self.near).astype(np.int64).tolist()
            key = min(str(places), str(places[::-1]))
            if key in seen:
                self.notes.append(f"layer {self.layer}: drawn twice, from {xy_text(xy[0])} to {xy_text(xy[-1])}; once is used")
            else:
                seen.add(key)
                kept.append(xy)
        self.curves = kept

    def outlines(self):
        """Polygons of the closed curves and of those that meet at their ends."""
        rings, open_ones = [], []
        for xy in self.curves:
            (rings if len(xy) > 3 and np.hypot(*(xy[-1] - xy[0])) <= self.near else open_ones).append(xy)
        rings += self.chains(open_ones)
        shapes = []
        for ring in rings:
            corners = ring[:-1] if np.hypot(*(ring[-1] - ring[0])) <= self.near else ring
            hull = shapely.MultiPoint(corners).convex_hull
            if hull.area <= self.near * hull.length:
                self.fault(f"its outline at {xy_text(ring[0])} has no area, expected one in the plane of x and y")
                return []
            shape = shapely.Polygon(corners)
            if not shape.is_valid:
                self.fault(f"its outline crosses itself ({shapely.is_valid_reason(shape)})")
                return []
            shapes.append(shape)
        return self.apart(shapes)

    def chains(self, pieces):
        """Rings of open pieces, joined where their ends are within the gap."""
        if not pieces:
            return []
        ends = np.concatenate([[xy[0], xy[-1]] for xy in pieces])
        tree = scipy.spatial.cKDTree(ends)
        close = [[j for j in found if j != i] for i, found in enumerate(tree.query_ball_point(ends, self.near))]
        crowd = next((i for i, others in enumerate(close) if len(others) > 1), None)
        if crowd is not None:
            self.fault(f"{len(close[crowd]) + 1} lines meet at {xy_text(ends[crowd])}, expected two: an outline is one ring")
            return []
        lonely = [i for i, others in enumerate(close) if not others]
        if lonely:
            distance, at = scipy.spatial.cKDTree(ends[lonely]).query(ends[lonely[0]], k=2)  # ends are even in number
            self.fault(f"not closed: an end at {xy_text(ends[lonely[0]])}, the next open end, at {xy_text(ends[lonely[at[1]]])}, is {distance[1]:.3g} m away")
            return []
        partner = {i: others[0] for i, others in enumerate(close)}
        rings, left = [], set(range(len(pieces)))
        while left:
            piece, start = min(left), 0
            first, ring = piece, []
            while piece in left:
                left.discard(piece)
                xy = pieces[piece] if start == 0 else pieces[piece][::-1]
                ring.append(xy[:-1])
                following = partner[2 * piece + 1 - start]
                piece, start = following // 2, following % 2
            if piece != first:
                self.fault(f"its outline comes back on itself at {xy_text(ring[-1][-1])}")
                return []
            rings.append(np.concatenate([*ring, ring[0][:1]]))
        return rings

    def apart(self, shapes):
        """Returns polygons, with a polygon inside another cut out of it. One that is drawn twice, by other lines or from another corner, is used once, with a note."""
        for i, one in reversed([*enumerate(shapes)]):
            if any(one.hausdorff_distance(other) <= self.near and one.symmetric_difference(other).area <= self.near * one.length for other in shapes[:i]):
                self.notes.append(f"layer {self.layer}: the outline at {xy_text(one.exterior.coords[0])} is drawn twice; once is used")
                del shapes[i]
        for i, one in enumerate(shapes):
            for other in shapes[:i]:
                common = shapely.intersection(one.exterior, other.exterior)
                if one.exterior.crosses(other.exterior):
                    at = shapely.get_coordinates(common)[0]
                    self.fault(f"two of its outlines cross or touch at {xy_text(at)}")
                    return []
        shapes = sorted(shapes, key=lambda shape: -shape.area)
        whole = []
        for shape in shapes:
            outer = next((i for i, other in enumerate(whole) if other.contains(shape)), None)
            if outer is None:
                whole.append(shape)
            else:
                whole[outer] = whole[outer].difference(shape)
        return whole

    # ---- roles

    def group(self, made, size):
        pieces = [Region(self.name, shape, self.size or size, self.rigid) for shape in self.outlines()]
        made.regions += pieces
        for region in pieces:
            if self.sides:
                made.lines += sides(self.name, region.shape)
            if self.pattern:
                made.patterns.append((region, self.pattern, self.keys))

    def hole(self, made, size):
        for shape in self.outlines():
            around = next((region for region in made.regions if region.shape.contains(shape)), None)
            if around is None:
                self.fault(f"its outline at {xy_text(shape.exterior.coords[0])} is not inside a group")
                return
            around.shape = around.shape.difference(shape)
            made.lines.append(Line(self.name, list(shape.exterior.coords)))
            made.fine.append((shape, self.size or min(size, np.sqrt(shape.area) / 3)))

    def joint(self, made, _size):
        made.lines += [Line(self.name, xy.tolist(), joint=True) for xy in self.curves]

    def faces(self, made, _size):
        made.lines += [Line(self.name, xy.tolist()) for xy in self.curves]

    def drain(self, made, _size):
        self.check_inside(made)
        made.drains |= numbered(self.name, [[tuple(xy[0].tolist()), tuple(xy[-1].tolist())] for xy in self.curves])

    def anchor(self, made, _size):
        """Adds anchors; the head of each is its upper end."""
        self.check_inside(made)
        made.anchors |= numbered(self.name, [sorted(map(tuple, xy[[0, -1]].tolist()), key=lambda p: -p[1]) for xy in self.curves])

    def check_inside(self, made):
        """Drains and anchors go through groups."""
        whole = shapely.union_all([region.shape for region in made.regions])
        lost = next((xy for xy in self.curves if not whole.intersects(shapely.LineString(xy))), None)
        if lost is not None:
            self.fault(f"from {xy_text(lost[0])} to {xy_text(lost[-1])} it lies outside all groups")

    def point(self, made, _size):
        places = self.places + [np.mean([xy.min(axis=0), xy.max(axis=0)], axis=0) for xy in self.curves]
        if not places:
            self.fault("expected points or circles on this layer, there are none")
        made.points |= {name: (*xy.tolist(), ()) for name, xy in numbered(self.name, places).items()}


def numbered(name, found):
    return {name: found[0]} if len(found) == 1 else {f"{name}_{i}": one for i, one in enumerate(found, 1)}


def sides(name, shape):
    """Faces of the upright ends and of the bottom of a box, for supports."""
    low_x, low_y, high_x, _ = shape.bounds
    lines = []
    for a, b in zip(shape.exterior.coords[:-1], shape.exterior.coords[1:]):
        for side, axis, value in (("sides", 0, low_x), ("sides", 0, high_x), ("bottom", 1, low_y)):
            if abs(a[axis] - value) < 1e-6 and abs(b[axis] - value) < 1e-6:
                lines.append(Line(f"{name}_{side}", [a, b]))
    return lines


def check_misses(made, top):
    """Refuses ends and corners that nearly meet an outline or a joint: a drawing is meant to meet there."""
    near, limit = made.near(), MISS * made.least()
    drawn = [(f"group {region.group!r}", region.shape.boundary) for region in made.regions]
    drawn += [(f"{'joint' if line.joint else 'faces'} {line.name!r}", shapely.LineString(line.points)) for line in made.lines]
    whole = shapely.union_all([region.shape for region in made.regions])
    tree = shapely.STRtree([line for _, line in drawn])
    for i, (what, line) in enumerate(drawn):
        corners = shapely.get_coordinates(line)
        points = shapely.points(corners)
        for k, j in tree.query(points, predicate="dwithin", distance=limit).T.tolist():
            distance = shapely.distance(points[k], drawn[j][1])
            beyond = what.startswith("joint") and not whole.intersects(points[k])  # the end of a joint beyond the outline is cut off
            if i != j and distance > near and not beyond and not drawn[j][0].startswith("faces"):
                advice = f"draw it there, or give the drawing a gap above {distance:.2g}"
                top.fault("drawing", f"{what}: {xy_text(corners[k])} misses {drawn[j][0]} by {distance:.3g} m: {advice}")
                return


def clip_joints(made):
    """Joints end at the outline of the groups, which drawn ones often overshoot."""
    near = made.near()
    wide = shapely.union_all([region.shape for region in made.regions]).buffer(near, join_style="mitre")
    whole, lines = wide.buffer(-near, join_style="mitre"), []  # without gaps between groups
    for line in made.lines:
        if line.joint and not wide.contains(shapely.LineString(line.points)):
            parts = shapely.get_parts(shapely.intersection(shapely.LineString(line.points), whole))
            found = [list(part.coords) for part in parts if part.geom_type == "LineString" and part.length > 10 * near]
            lines += [Line(line.name, points, True) for points in found] or [line]
        else:
            lines.append(line)
    made.lines = lines
