"""Drawings made by a script, whose areas are known: polylines with arcs, circles, ellipses, splines and blocks that are turned, scaled and mirrored, in some unit."""

import math

import numpy as np
from quoin_tools.mesh import section
from quoin_tools.mesh.blockmesh import MeshError, areas, check, face_ends
from runs import AGREE, note

UNITS = {"m": (1.0, 6), "mm": (1e-3, 4), "cm": (1e-2, 5), "ft": (0.3048, 2)}  # metres, and the code of the drawing
HOLES = ("circle", "arcs", "ellipse", "spline", "closed spline", "bulges", "lines", "half ellipse", "block")


def bulge_area(points):
    """Of a polyline (x, y, bulge): its polygon and the segments of its arcs, positive to the right of the chord for a counter-clockwise arc."""
    x, y, bulge = np.array(points).T
    polygon = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    chord, turn = np.hypot(np.roll(x, -1) - x, np.roll(y, -1) - y), 4 * np.arctan(bulge)
    curved = np.abs(bulge) > 0
    radius = np.where(curved, chord / (2 * np.sin(np.where(curved, turn, 1) / 2)), 0)
    return polygon + 0.5 * float(np.sum(radius**2 * (turn - np.sin(turn))))


def spline_area(curve):
    """Of a closed curve of ezdxf, by many points."""
    xy = np.array([(p.x, p.y) for p in curve.points(np.linspace(0, curve.max_t, 40001))])
    return 0.5 * abs(float(np.sum(xy[:-1, 0] * xy[1:, 1] - xy[1:, 0] * xy[:-1, 1])))


def add_hole(rng, kind, layout, at, r, layer):
    """Draws a hole of about the radius r about `at`, a list of (x, y); its area."""
    from ezdxf.math import BSpline, rational_bspline_from_arc

    x, y = at
    on = {"layer": layer}
    if kind == "circle":
        layout.add_circle((x, y), r, dxfattribs=on)
        return math.pi * r * r
    if kind == "arcs":
        layout.add_arc((x, y), r, 0, 180, dxfattribs=on)
        layout.add_arc((x, y), r, 180, 360, dxfattribs=on)
        return math.pi * r * r
    if kind == "ellipse":
        angle, ratio = float(rng.uniform(0, 6)), float(rng.uniform(0.3, 0.95))
        layout.add_ellipse((x, y), (r * math.cos(angle), r * math.sin(angle)), ratio, 0, 2 * math.pi, dxfattribs=on)
        return math.pi * r * r * ratio
    if kind == "half ellipse":
        ratio = float(rng.uniform(0.3, 0.95))
        layout.add_ellipse((x, y), (r, 0), ratio, 0, math.pi, dxfattribs=on)
        layout.add_line((x - r, y), (x + r, y), dxfattribs=on)
        return 0.5 * math.pi * r * r * ratio
    if kind == "spline":  # rational: three quarters of a circle, and two radii
        curve = rational_bspline_from_arc((x, y), r, 0, 270, segments=int(rng.integers(1, 5)))
        layout.add_rational_spline(curve.control_points, curve.weights(), degree=curve.degree, knots=curve.knots(), dxfattribs=on)
        layout.add_lwpolyline([(x, y - r), (x, y), (x + r, y)], dxfattribs=on)
        return 0.75 * math.pi * r * r
    if kind == "closed spline":  # clamped, of degree 2 to 5, with uneven knots; it begins where it ends
        n, degree = int(rng.integers(7, 12)), int(rng.integers(2, 6))
        angle = np.linspace(0, 2 * np.pi, n + 1)
        far = r * rng.uniform(0.7, 1.0, n + 1)
        far[-1] = far[0]
        points = np.column_stack([x + far * np.cos(angle), y + far * np.sin(angle), np.zeros(n + 1)])
        points[-1] = points[0]
        inner = np.sort(rng.uniform(0.05, 0.95, n - degree))
        knots = [0.0] * (degree + 1) + inner.tolist() + [1.0] * (degree + 1)
        entity = layout.add_spline(dxfattribs=on)
        entity.dxf.degree, entity.control_points, entity.knots = degree, points.tolist(), knots
        return spline_area(BSpline(points.tolist(), degree + 1, knots))
    if kind == "bulges":
        n = int(rng.integers(2, 6))
        angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
        points = [(x + 0.7 * r * math.cos(a), y + 0.7 * r * math.sin(a), float(rng.uniform(0.05, 0.4 if n > 2 else 1.0))) for a in angle]
        layout.add_lwpolyline(points, format="xyb", close=True, dxfattribs=on)
        return abs(bulge_area(points))
    n = int(rng.integers(3, 8))
    angle = np.sort(rng.uniform(0, 1, n) * 0.5 + np.arange(n)) * 2 * np.pi / n
    points = [(x + r * math.cos(a), y + r * math.sin(a)) for a in angle]
    if rng.random() < 0.5:
        layout.add_polyline2d(points, close=True, dxfattribs=on)
    else:
        for a, b in zip(points, points[1:] + points[:1]):
            layout.add_line(*((a, b) if rng.random() < 0.5 else (b, a)), dxfattribs=on)
    return abs(bulge_area([(*p, 0.0) for p in points]))


def add_block(rng, document, space, at, r, unit, layer):
    """A hole in a block on layer 0, which is inserted turned, scaled and mirrored, perhaps within another block."""
    kind = HOLES[int(rng.integers(len(HOLES) - 1))]
    inner = document.blocks.new(f"B{layer}", base_point=(0.5, 0.25))
    area = add_hole(rng, kind, inner, (0.5, 0.25), 1.0, "0")
    name = inner.name
    if rng.random() < 0.5:
        outer = document.blocks.new(f"C{layer}")
        outer.add_blockref(name, (0, 0), dxfattribs={"layer": "0", "xscale": -0.5, "yscale": 0.5, "rotation": float(rng.uniform(0, 360))})
        name, area = outer.name, area * 0.25
        r *= 2
    sx, sy = r * float(rng.choice([-1, 1])), r * float(rng.choice([1.0, rng.uniform(0.5, 1)]))
    if sx * sy < 0 and rng.random() < 0.3:  # seen from behind
        at, sx = (-at[0], at[1]), -sx
        reference = {"extrusion": (0, 0, -1)}
    else:
        reference = {}
    space.add_blockref(name, at, dxfattribs={"layer": layer, "xscale": sx, "yscale": sy, "zscale": r, "rotation": float(rng.uniform(0, 360))} | reference)
    return kind, area * abs(sx * sy)


def drawing(rng):
    return lambda seed, folder, counts: drawn(rng, seed, folder, counts)


def drawn(rng, seed, folder, counts):
    import ezdxf

    folder.mkdir(parents=True, exist_ok=True)
    unit = list(UNITS)[int(rng.integers(len(UNITS)))]
    metre, code = 1 / UNITS[unit][0], UNITS[unit][1]
    width, height = (float(value) for value in rng.uniform(20, 60, 2))
    origin = [float(value) for value in rng.choice([0, 1]) * rng.uniform(-1e5, 1e5, 2)]
    document = ezdxf.new(rng.choice(["R2000", "R2010", "R2018"]), units=code)
    space = document.modelspace()
    def xy(x, y):
        return (x + origin[0]) * metre, (y + origin[1]) * metre
    crest = float(rng.uniform(0, 0.5))  # bulge of the outline's top, its base straight
    outline = [(*xy(0, 0), 0.0), (*xy(width, 0), 0.0), (*xy(width, height), crest), (*xy(0, height), 0.0)]
    space.add_lwpolyline(outline, format="xyb", close=True, dxfattribs={"layer": "DAM"})
    whole, kinds = abs(bulge_area(outline)) / metre**2, []
    layers = {"DAM": {"group": "dam"}}
    holes = {}
    for i in range(int(rng.integers(1, 4))):
        r = 0.1 * min(width, height)
        at = ((0.2 + 0.3 * i) * width, float(rng.uniform(0.3, 0.7)) * height)
        kind, layer = HOLES[int(rng.integers(len(HOLES)))], f"H{i}"
        if kind == "block":
            kind, area = add_block(rng, document, space, xy(*at), r * metre, metre, layer)
            kind = f"block of {kind}"
        else:
            area = add_hole(rng, kind, space, xy(*at), r * metre, layer)
        kinds.append(kind)
        holes[f"hole_{i}"] = area / metre**2
        layers[layer] = {"hole": f"hole_{i}"}
    document.saveas(folder / "dam.dxf")
    table = [f"drawing: {{file: dam.dxf, units: {unit}, origin: [{origin[0] * metre!r}, {origin[1] * metre!r}], chord: 0.002}}", f"size: {0.1 * width}", "layers:"]
    table += [f"  {name}: {{{', '.join(f'{key}: {value}' for key, value in keys.items())}}}" for name, keys in layers.items()]
    (folder / "dam.yaml").write_text("\n".join(table) + "\n", encoding="utf-8")
    said, notes = [], []
    try:
        mesh, _, notes = section.mesh_of(folder / "dam.yaml")
        check(mesh)
        found = [(f"{', '.join(kinds)}: whole area", abs(areas(mesh).sum() / (whole - sum(holes.values())) - 1))]
        for (name, area), kind in zip(holes.items(), kinds):
            ends = mesh.vertices[face_ends(mesh, mesh.face_sets[name])]
            a, b = ends[:, 0] - ends.mean(axis=(0, 1)), ends[:, 1] - ends.mean(axis=(0, 1))
            found.append((f"{kind}: area of the hole", abs(abs(0.5 * float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))) / area - 1)))
    except MeshError as error:
        found, notes = [(str(error), np.inf)], [str(error)]
    told = [line for line in notes if "layers of the drawing" not in line]
    note(seed, "drawing", "known areas", found, told, counts, said, AGREE)
    if not said and max(pair[1] for pair in found) > AGREE:
        print(f"  told: {told}; {max(found, key=lambda pair: pair[1])}", flush=True)
    return said


KINDS = (drawing,)
