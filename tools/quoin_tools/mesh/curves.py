"""Entities of a drawing as polylines in their own coordinates. Corners of a polyline lie on the curve, and no point of the curve is farther than `chord` from it.

Arcs, bulges and ellipses are divided by their angle. A spline of any degree, rational or not, lives on the knots from the degree-th on to the degree-th last one,
whatever stands beyond them. Between two knots it is a Bezier curve; one with positive weights lies in the hull of its control points, so these bound the chord."""

import math

import numpy as np
import scipy
import shapely

READ = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")
MOST_POINTS = 200_000  # of one entity
TURN = math.pi / 8  # an arc has a corner at least so often
DEEPEST = 40  # halvings of a piece of a spline
DEGREES = {5: 2, 6: 3}  # kinds of spline-fit polylines
FRAME = 16  # flag of a vertex: it is a control point of the curve, which does not pass through it


class CurveError(ValueError):
    """An entity is no curve; the message says why."""


def is_curve(entity):
    kind = entity.dxftype()
    return kind in READ and not (kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline))


def points_of(entity, chord):
    """Returns (n, 3) points of an entity, in the coordinates of the model or of the block around it."""
    kind, dxf = entity.dxftype(), entity.dxf
    if kind == "LINE":
        xyz = np.array([dxf.start, dxf.end])
    elif kind == "LWPOLYLINE":
        xyz = in_world(entity, bulged([point[:3] for point in entity.get_points("xyb")], entity.closed, chord), dxf.elevation)
    elif kind == "POLYLINE":
        xyz = polyline(entity, chord)
    elif kind in ("ARC", "CIRCLE"):
        start, turn = (math.radians(dxf.start_angle), math.radians((dxf.end_angle - dxf.start_angle) % 360 or 360)) if kind == "ARC" else (0.0, 2 * math.pi)
        radius = abs(dxf.radius)
        angle = start + np.linspace(0, turn, 1 + steps(turn, radius, chord))
        xyz = in_world(entity, np.array(dxf.center)[:2] + radius * np.column_stack([np.cos(angle), np.sin(angle)]), dxf.center[2])
        if turn == 2 * math.pi:
            xyz[-1] = xyz[0]
    elif kind == "ELLIPSE":
        xyz = ellipse(dxf, chord)
    else:
        xyz = spline(entity, chord)
    if not np.isfinite(xyz).all():
        raise CurveError("it has coordinates that are no numbers")
    return xyz


def in_world(entity, xy, elevation):
    """Moves points out of the plane of an entity, whose normal is its extrusion."""
    xyz = np.column_stack([xy, np.full(len(xy), float(elevation))])
    ocs = entity.ocs()
    return xyz @ np.array([ocs.ux, ocs.uy, ocs.uz]) if ocs.transform else xyz


def steps(turn, radius, chord):
    """Returns the number of chords of an arc: a chord of the angle a is at most radius (1 - cos(a / 2)) away from it."""
    count = turn / min(TURN, 4 * math.asin(math.sqrt(min(1.0, chord / (2 * radius))))) if radius > 0 else 1.0
    if not count <= MOST_POINTS:
        raise CurveError(f"it would have {count:.2g} points within {chord:.2g} of the curve, expected at most {MOST_POINTS:g}: a larger chord")
    return max(1, math.ceil(count * (1 - 1e-12)))


def bulged(rows, closed, chord):
    """Rows (x, y, bulge): the tangent of a quarter of the angle to the next row, positive to the left."""
    rows = np.array(rows, dtype=float).reshape(-1, 3)
    if len(rows) < 2:
        return rows[:, :2]
    ends, found = np.vstack([rows[1:], rows[:1]]) if closed else rows[1:], [rows[:1, :2]]
    for (x, y, bulge), (x1, y1, _) in zip(rows.tolist(), ends.tolist()):
        length = math.hypot(x1 - x, y1 - y)
        if bulge and length > 0:
            turn, radius = 4 * math.atan(bulge), length * (1 + bulge**2) / (4 * abs(bulge))
            centre = (0.5 * (x + x1) - (y1 - y) * (1 - bulge**2) / (4 * bulge), 0.5 * (y + y1) + (x1 - x) * (1 - bulge**2) / (4 * bulge))
            angle = math.atan2(y - centre[1], x - centre[0]) + np.linspace(0, turn, 1 + steps(abs(turn), radius, chord))[1:-1]
            found.append(np.array(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)]))
        found.append(np.array([[x1, y1]]))
    return np.concatenate(found)


def polyline(entity, chord):
    """Returns for a spline-fit polyline the curve of its control points (vertices with a flag), where the other vertices lie on it; else these alone."""
    every = list(entity.vertices)
    vertices, flat, closed = [vertex for vertex in every if not vertex.dxf.flags & FRAME] or every, not entity.is_3d_polyline, entity.is_closed
    if not vertices:
        return np.zeros((0, 3))
    elevation = entity.dxf.elevation[2] if entity.dxf.hasattr("elevation") else vertices[0].dxf.location[2]
    places = np.array([vertex.dxf.location for vertex in vertices], dtype=float)
    frame = np.array([vertex.dxf.location for vertex in every if vertex.dxf.flags & FRAME], dtype=float).reshape(-1, 3)
    curve = frame_curve(frame, DEGREES.get(entity.dxf.get("smooth_type", 0)), closed, chord)
    if curve is not None and len(vertices) < len(every):
        away = shapely.distance(shapely.LineString(curve[:, :2]), shapely.points(places[:, :2]))
        if away.max() <= 1.01 * chord:
            return in_world(entity, curve[:, :2], elevation) if flat else curve
    if flat:
        bulges = [vertex.dxf.get("bulge", 0.0) for vertex in vertices]
        return in_world(entity, bulged(np.column_stack([places[:, :2], bulges]), closed, chord), elevation)
    return np.vstack([places, places[:1]]) if closed else places


def frame_curve(frame, degree, closed, chord):
    """Returns points of the uniform spline with these control points, clamped at its ends or closed; None: there is none."""
    if degree is None or len(frame) <= degree:
        return None
    if closed:
        frame = np.vstack([frame, frame[:degree]])
    knots = np.arange(len(frame) + degree + 1, dtype=float)
    knots = knots if closed else np.clip(knots, degree, len(frame))
    return through(np.column_stack([frame, np.ones(len(frame))]), knots, degree, chord)


def ellipse(dxf, chord):
    """Divides an ellipse by equal steps a of the parameter: its chords are at most a^2 / 8 times the larger half axis away from it, as those of a circle are."""
    major = np.array(dxf.major_axis)
    normal = np.array(dxf.extrusion) / np.linalg.norm(dxf.extrusion)
    minor = np.cross(normal, major) * dxf.ratio
    turn = (dxf.end_param - dxf.start_param) % (2 * math.pi)
    whole = min(turn, 2 * math.pi - turn) < 1e-9
    turn = 2 * math.pi if whole else turn
    t = dxf.start_param + np.linspace(0, turn, 1 + steps(turn, max(np.linalg.norm(major), np.linalg.norm(minor)), chord))
    xyz = np.array(dxf.center) + np.cos(t)[:, None] * major + np.sin(t)[:, None] * minor
    if whole:
        xyz[-1] = xyz[0]
    return xyz


# ---- splines ---------------------------------------------------------------------------------------------

def spline(entity, chord):
    return through(*parts_of(entity), chord)


def through(points, knots, degree, chord):
    """Returns (n, 3) points on the curve of the control points (n, 4) as x w, y w, z w, w."""
    if not np.isfinite(points).all():
        raise CurveError("it has coordinates that are no numbers")
    found = []
    for piece in bezier_pieces(points, knots, degree):
        corners = flattened(piece, chord, MOST_POINTS - len(found))
        found += corners if not found else corners[1:]
    return np.array(found)


def parts_of(entity):
    """Returns (control points, knots, degree) of a SPLINE entity, as through() takes them."""
    points = np.array(entity.control_points, dtype=float).reshape(-1, 3)
    if not len(points):
        return fitted(entity)
    knots, weights = np.array(entity.knots, dtype=float), np.array(entity.weights or [1.0] * len(points), dtype=float)
    degree = entity.dxf.degree if entity.dxf.hasattr("degree") else len(knots) - len(points) - 1  # a file without a header loses it
    if not 1 <= degree < len(points):
        raise CurveError(f"{len(points)} control points, expected more than its degree, {degree}")
    if not len(knots):
        knots = np.concatenate([np.zeros(degree), np.arange(len(points) - degree + 1), np.full(degree, len(points) - degree)])
    if len(knots) != len(points) + degree + 1:
        raise CurveError(f"{len(knots)} knots, expected {len(points) + degree + 1} for {len(points)} control points and degree {degree}")
    if not np.isfinite(knots).all() or (np.diff(knots) < 0).any() or not knots[degree] < knots[len(points)]:
        raise CurveError("expected knots that ascend")
    if len(weights) != len(points) or not (np.isfinite(weights) & (weights > 0)).all():
        raise CurveError(f"expected {len(points)} weights above 0, one for each control point")
    return np.column_stack([points * weights[:, None], weights]), knots, degree


def fitted(entity):
    """Returns the cubic through the fit points of a spline that has no control points; a closed one is as smooth where it begins as elsewhere."""
    from ezdxf.math import fit_points_to_cad_cv

    points = np.array(entity.fit_points, dtype=float).reshape(-1, 3)
    if len(points) < 2:
        raise CurveError("neither control points nor fit points")
    if entity.closed and len(points) > 2:
        ring = points if np.allclose(points[0], points[-1], rtol=0, atol=1e-9 * np.ptp(points)) else np.vstack([points, points[:1]])
        ring[-1] = ring[0]
        at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
        if (np.diff(at) <= 0).any():
            raise CurveError("two fit points at one place")
        curve = scipy.interpolate.make_interp_spline(at, ring, k=3, bc_type="periodic")
        return np.column_stack([curve.c, np.ones(len(curve.c))]), curve.t, 3
    ends = [entity.dxf.start_tangent, entity.dxf.end_tangent] if entity.dxf.hasattr("start_tangent") and entity.dxf.hasattr("end_tangent") else None
    curve = fit_points_to_cad_cv(entity.fit_points, tangents=ends)
    points = np.array(curve.control_points, dtype=float)
    return np.column_stack([points, np.ones(len(points))]), np.array(curve.knots()), curve.degree


def bezier_pieces(points, knots, degree):
    """Control points (degree + 1, 4) of the curve between each two knots of its range. Control point j is the blossom at `degree - j` times the first knot and j times the second."""
    for span in range(degree, len(points)):
        a, b = knots[span], knots[span + 1]
        if b > a:
            yield np.array([blossom(points, knots, degree, span, [a] * (degree - j) + [b] * j) for j in range(degree + 1)])


def blossom(points, knots, degree, span, arguments):
    """Evaluates de Boor's algorithm with another argument in each of its rounds."""
    d = points[span - degree:span + 1].copy()
    for r, u in enumerate(arguments, 1):
        left, right = knots[span - degree + r:span + 1], knots[span + 1:span + 2 + degree - r]
        part = ((u - left) / (right - left))[:, None]
        d = (1 - part) * d[:-1] + part * d[1:]
    return d[0]


def flattened(piece, chord, most):
    """Returns points on a Bezier curve: halves it until no control point is farther than the chord from the line between its ends."""
    found, left = [piece[0, :3] / piece[0, 3]], [(piece, 0)]
    while left:
        piece, depth = left.pop()
        hull = piece[:, :3] / piece[:, 3:]
        along = hull[-1] - hull[0]
        square = along @ along
        at = np.clip((hull - hull[0]) @ along / square, 0, 1) if square > 0 else np.zeros(len(hull))
        if depth == DEEPEST or np.linalg.norm(hull[0] + at[:, None] * along - hull, axis=1).max() <= chord:
            found.append(hull[-1])
            if len(found) > most:
                raise CurveError(f"it has more than {MOST_POINTS} points within {chord:.2g} of the curve: expected a larger chord")
            continue
        first, second = [piece[0]], [piece[-1]]
        while len(piece) > 1:
            piece = 0.5 * (piece[1:] + piece[:-1])
            first.append(piece[0])
            second.append(piece[-1])
        left += [(np.array(second[::-1]), depth + 1), (np.array(first), depth + 1)]
    return found
