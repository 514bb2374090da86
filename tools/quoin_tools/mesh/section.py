"""Makes the mesh of a section declared in one YAML file: dam, rock, galleries, lifts, seams, joint sets; meshed by gmsh, without any Python of the user's.

    quoin import dam.yaml -o model.h5

docs/generators.md has the keys. Names are those of mesh/dam.py: groups dam and rock; joint base; faces upstream, downstream, crest,
rock_sides, rock_bottom, rock_top_upstream, rock_top_downstream, and those of galleries; points heel, toe, crest_upstream, crest_downstream,
rock_heel, rock_toe."""

import math
import os
import sys

import numpy as np
import shapely

from quoin_tools.base.command import Parser, words_of
from quoin_tools.base.files import write_file
from quoin_tools.mesh import declared, drawing, patterns, plan
from quoin_tools.mesh.blockmesh import MeshError, areas, macroblocks, quality, write, xy_text
from quoin_tools.mesh.declared import DeclaredError
from quoin_tools.mesh.draft import draft
from quoin_tools.mesh.plan import Line, Plan, Region
from quoin_tools.mesh.rock import JointSet

ARC = 16  # chords of the half circle over a gallery
ANY = ("title", "growth", "elements", "size", "joints", "faces", "points", "drains")
DAM = ("upstream", "downstream", "base", "rigid", "galleries", "lifts", "pattern")
ROCK = ("upstream", "downstream", "depth", "ground_upstream", "ground_downstream", "rigid", "size", "seams", "joints")
# what people have beside sections, by the end of its name
FOREIGN = dict.fromkeys((".inp", ".bdf", ".nas", ".unv", ".med", ".vtk", ".vtu", ".stl", ".obj", ".ply", ".off", ".su2", ".xdmf", ".exo", ".e", ".cgns", ".mesh"),
                        "a mesh of another program, which `meshio convert` may turn into .msh") | {
    ".dwg": "a drawing that only its own program reads, to be saved as DXF", ".geo": "a geometry of Gmsh, of which gmsh -2 makes a mesh",
    ".geo_unrolled": "a geometry of Gmsh, of which gmsh -2 makes a mesh", ".h5": "a file of HDF5, perhaps a block mesh already",
    ".step": "a model of solids", ".stp": "a model of solids", ".iges": "a model of solids", ".igs": "a model of solids", ".ifc": "a model of a building",
    ".pdf": "a document", ".png": "a picture", ".jpg": "a picture", ".svg": "a picture", ".xlsx": "a spreadsheet", ".csv": "a table"}  # fmt: skip
OVERHANG = 0.15  # of the height: faces that hang over by more bring a warning
SHARPEST = 10.0  # degrees: sharper corners of blocks bring a warning


def load(path):
    """Reads (Plan, list of notes) from a section file; DeclaredError has a line for each of its mistakes."""
    top = declared.read(path)
    made, notes = Plan(), []
    made.title = top.text("title", "") or ""
    made.growth = top.number("growth", 0.15, least=0.01, most=10, unit="-")
    made.triangles = top.choice("elements", ("quadrilaterals", "triangles"), "quadrilaterals") == "triangles"
    if "drawing" in top:
        size = top.number("size", above=0)
        notes = drawing.add(made, top, size) if size else []
        rock = top.below("rock")
        if rock and made.regions and not top.faults:
            add_rock_below(made, rock, size)
        drawing.finish(made, top)
        top.done(*ANY, "drawing", "layers", "rock")
    else:
        notes = add_section(made, top)
        top.done(*ANY, "dam", "rock", "columns")
    if made.regions:
        add_lines(made, top)
    for region, pattern, keys in made.patterns if not top.faults else ():
        lay(made, region, pattern, keys)
    if not top.faults:
        check_names(made, top)
    if top.faults:
        raise DeclaredError(declared.in_order(top.faults))
    return made, notes


def add_section(made, top):
    """Dam and rock by their keys; notes about what no dam has."""
    size, dam, rock = Size(top), top.below("dam", required=True), top.below("rock")
    outline = Outline(dam) if dam else None
    if outline and outline.good:
        size.of(outline)
        add_dam(made, dam, outline, size)
        if rock:
            add_rock(made, rock, outline)
        lay_stones(made, dam, outline)
        if rock:
            lay_joint_sets(made, rock)
    for keys, known in ((dam, DAM), (rock, ROCK)):
        if keys:
            keys.done(*known)
    return doubts(outline, size.value) if outline and outline.good else []


def doubts(outline, size):
    """Returns lines about faces that hang over, as when the sign of a batter is wrong, and about blocks larger than the dam."""
    height, problems = outline.height(), []
    over = {"upstream": outline.base[0][0] - min(x for x, _ in outline.upstream), "downstream": max(x for x, _ in outline.downstream) - outline.base[-1][0]}
    for face, length in over.items():
        if length > OVERHANG * height:
            problems.append(f"dam.{face}: the face hangs over by {length:.4g} m of {height:.4g} m height: a batter > 0 leans into the dam as the face rises")
    if size > 0.5 * height:
        problems.append(f"size: blocks of {size:.4g} m in a dam of {height:.4g} m height: expected metres, less than half the height")
    return problems


def mesh_of(path):
    """Makes (BlockMesh, Plan, notes) from a section file."""
    if os.fspath(path).lower().endswith(".dxf"):
        raise DeclaredError([f"{path}: is a drawing, expected a section file that names it (drawing: {{file: ...}}) and says what its layers are"])
    foreign = FOREIGN.get(os.path.splitext(path)[1].lower())
    if foreign:
        raise DeclaredError([f"{path}: is {foreign}; expected a section or the table of a drawing (YAML), or a mesh of Gmsh (.msh)"])
    made, notes = load(path)
    try:
        mesh = plan.mesh_of(made)
        return mesh, made, notes + made.notes
    except DeclaredError:
        raise
    except MeshError as error:
        raise DeclaredError([f"{path}: {error}"]) from None


class Size:
    """Size of the blocks of the dam: given, or from how many there are along the base."""

    def __init__(self, top):
        self.value, self.columns = None, None
        key = top.one_of("size", "columns")
        if key == "size":
            self.value = top.number("size", above=0)
        elif key:
            self.columns = top.whole("columns")

    def of(self, outline):
        length = shapely.LineString(outline.base).length
        if self.value is None:
            self.value = length / (self.columns or 10)  # without either a mistake is noted already
        self.columns = self.columns or max(1, math.ceil(length / self.value - 1e-6))


class Outline:
    """Faces and base of the dam, upwards and from heel to toe."""

    def __init__(self, dam):
        self.upstream, self.downstream = dam.points("upstream"), dam.points("downstream", leans=-1)
        between = dam.points("base", [], least=1)
        self.good = None not in (self.upstream, self.downstream, between)
        if self.good:
            self.base = [self.upstream[0], *between, self.downstream[0]]
            self.good = self.checked(dam)

    def checked(self, dam):
        heel, toe, left, right = self.base[0], self.base[-1], self.upstream[-1], self.downstream[-1]
        faults = len(dam.faults)
        if heel[0] >= toe[0]:
            dam.fault("downstream", "begins at the toe: expected right of the heel, where upstream begins", toe)
        if min(left[1], right[1]) <= max(heel[1], toe[1]):
            dam.fault("upstream", "ends at the crest: expected above heel and toe", left)
        elif left[0] > right[0] or abs(left[1] - right[1]) > 0.2 * abs(left[1] - heel[1]):
            dam.fault("downstream", f"ends at the crest: expected about level with, and not left of, {list(left)}, where upstream ends", right)
        if len(dam.faults) > faults:
            return False
        polygon = self.polygon() if len(self.corners()) >= 3 else shapely.Polygon()
        if polygon.is_empty or not polygon.is_valid or not polygon.exterior.is_ccw:
            dam.fault("upstream", f"upstream, downstream and base cross each other ({shapely.is_valid_reason(polygon)})")
        return len(dam.faults) == faults

    def corners(self):
        """Counter-clockwise from the heel."""
        ring = [*self.base, *self.downstream[1:], *self.upstream[:0:-1]]
        return [p for i, p in enumerate(ring) if p != ring[i - 1]]

    def polygon(self):
        return shapely.Polygon(self.corners())

    def height(self):
        return self.upstream[-1][1] - self.base[0][1]


class DrawnOutline(Outline):
    """Returns the base of a drawn dam, between the corners that the keys heel and toe of its rock name."""

    def __init__(self, made, rock):
        heel, toe = rock.point("heel"), rock.point("toe")
        whole = shapely.union_all([region.shape for region in made.regions])
        self.good = heel is not None and toe is not None and self.found(whole, {"heel": heel, "toe": toe}, rock)

    def found(self, whole, corners, rock):
        if whole.geom_type != "Polygon":
            rock.fault(None, "expected one drawn dam: its groups do not touch each other")
            return False
        ring = [tuple(xy) for xy in shapely.geometry.polygon.orient(whole).exterior.coords[:-1]]
        at = {}
        for key, xy in corners.items():
            at[key] = min(range(len(ring)), key=lambda i, xy=xy: math.dist(ring[i], xy))
            if math.dist(ring[at[key]], xy) > 1e-3:
                rock.fault(key, f"expected a corner of the dam, the nearest is {xy_text(ring[at[key]])}", xy)
                return False
        ring = ring[at["heel"]:] + ring[:at["heel"]]
        toe = (at["toe"] - at["heel"]) % len(ring)
        high = [i for i in range(toe, len(ring)) if ring[i][1] > max(y for _, y in ring) - 1e-6]
        if not 0 < toe < len(ring) - 1 or not high or ring[toe][0] <= ring[0][0]:
            rock.fault("toe", "expected right of the heel, both below the crest", corners["toe"])
            return False
        self.base, self.downstream, self.upstream = ring[:toe + 1], ring[toe:high[0] + 1], [ring[0], *ring[:high[-1] - 1:-1]]
        return True


# ---- dam -------------------------------------------------------------------------------------------------

def add_dam(made, dam, outline, size):
    shape, holes = outline.polygon(), galleries(made, dam, outline, size)
    body = shape.difference(shapely.union_all(holes)) if holes else shape
    made.regions.append(Region("dam", body, size.value, dam.flag("rigid")))
    name_dam(made, outline, size.columns, ("dam", "facing"))
    for i, level in enumerate(lifts(dam, outline), 1):
        low, _, high, _ = shape.bounds
        across = shapely.get_parts(body.intersection(shapely.LineString([(low - 1, level), (high + 1, level)])))
        inside = (shapely.length(across) > 0) & ~shapely.covers(body.boundary.buffer(1e-6), across)  # not on the floor of a gallery
        for part in across[inside]:
            made.lines += [Line(name, list(part.coords), joint=True) for name in ("lift", f"lift_{i}")]


def name_dam(made, outline, columns, groups):
    """Base, faces, crest and their ends; groups: those of the dam."""
    crest = [outline.upstream[-1], outline.downstream[-1]]
    made.lines += [Line("base", outline.base, count=columns), Line("upstream", outline.upstream), Line("downstream", outline.downstream)]
    if crest[0] != crest[1]:
        made.lines.append(Line("crest", crest))
    ends = {"heel": outline.base[0], "toe": outline.base[-1], "crest_upstream": crest[0], "crest_downstream": crest[1]}
    made.points |= {name: (*xy, groups) for name, xy in ends.items()}


def galleries(made, dam, outline, size):
    holes = []
    for name, keys in dam.named("galleries"):
        at, width, height = keys.point("floor"), keys.number("width", above=0), keys.number("height", above=0)
        arch, fine = keys.flag("arch"), keys.number("size", None, above=0)
        keys.done()
        if None in (at, width, height, arch):
            continue
        if arch and height < width / 2:
            keys.fault("height", f"expected at least half the width, {width / 2:g}, for the half circle of the arch", height)
            continue
        hole = gallery(at, width, height, arch)
        if not outline.polygon().contains_properly(hole) or any(hole.intersects(other) for other in holes):
            keys.fault(None, "expected inside the dam, clear of its faces and of other galleries")
            continue
        holes.append(hole)
        made.lines.append(Line(name, list(hole.exterior.coords)))
        made.fine.append((hole, fine or min(size.value, width / 3)))
    return holes


def gallery(floor, width, height, arch):
    (x, y), half = floor, width / 2
    if not arch:
        return shapely.box(x - half, y, x + half, y + height)
    angle = np.linspace(0, math.pi, ARC + 1)[1:-1]
    springing = y + height - half
    over = np.column_stack([x + half * np.cos(angle), springing + half * np.sin(angle)])
    return shapely.Polygon([(x - half, y), (x + half, y), (x + half, springing), *over.tolist(), (x - half, springing)])


def lifts(dam, outline):
    """Elevations of the level joints."""
    low, high = max(outline.base[0][1], outline.base[-1][1], *(y for _, y in outline.base)), min(outline.upstream[-1][1], outline.downstream[-1][1])
    if "lifts" not in dam:
        return []
    if isinstance(dam.values["lifts"], list):
        levels = dam.numbers("lifts", "a list of elevations [m]") or []
    else:
        keys = dam.below("lifts", required=True)
        if keys is None:
            return []
        first, spacing = keys.number("from"), keys.number("spacing", above=0)
        last = keys.number("to", high)
        keys.done()
        if None in (first, spacing, last):
            return []
        levels = [first + i * spacing for i in range(min(10_000, math.floor((last - first) / spacing + 1e-9) + 1))]
        levels = [level for level in levels if level < high - 1e-6 * spacing]
    for level in levels:
        if not low < level < high:
            dam.fault("lifts", f"expected elevations between base and crest, above {low:g} and below {high:g}", level)
            return []
    if not levels or sorted(set(levels)) != levels:
        dam.fault("lifts", "expected at least one elevation, each above the one before", levels)
        return []
    return levels


# ---- rock ------------------------------------------------------------------------------------------------

def add_rock(made, rock, outline):
    reach = 3 * outline.height()
    left, right, depth = (rock.number(key, reach, above=0) for key in ("upstream", "downstream", "depth"))
    ground = {side: rock.points(f"ground_{side}", [], least=1) for side in ("upstream", "downstream")}
    rigid, coarse = rock.flag("rigid"), rock.number("size", None, above=0)
    if None in (left, right, depth, *ground.values()):
        return
    heel, toe = outline.base[0], outline.base[-1]
    x0, x1, bottom = heel[0] - left, toe[0] + right, min(y for _, y in outline.base) - depth
    over = {"upstream": reaching([heel, *ground["upstream"]], x0), "downstream": reaching([toe, *ground["downstream"]], x1)}
    corners = [(x0, bottom), (x1, bottom), *over["downstream"][::-1], *outline.base[1:-1][::-1], *over["upstream"]]
    shape = shapely.Polygon(corners)
    for side, points in over.items():
        beyond = [p for p in points[1:-1] if not x0 < p[0] < x1 or p[1] <= bottom]
        if beyond:
            rock.fault(f"ground_{side}", f"expected within the rock, x more than {x0:g} and less than {x1:g}, y above {bottom:g}; from its last point the ground goes on level", beyond[0])
            return
    if not shape.is_valid:
        rock.fault(None, f"its outline crosses itself ({shapely.is_valid_reason(shape)})")
        return
    common = shape.intersection(outline.polygon())
    if common.area > 1e-9 * shape.area:
        at = common.representative_point()
        rock.fault(None, f"ground and dam overlap at {xy_text((at.x, at.y))}")
        return
    made.regions.append(Region("rock", shape, coarse, rigid))
    next(line for line in made.lines if line.name == "base").joint = True
    sides = {"rock_bottom": [(x0, bottom), (x1, bottom)], "rock_top_upstream": over["upstream"], "rock_top_downstream": over["downstream"]}
    made.lines += [Line(name, points) for name, points in sides.items()]
    made.lines += [Line("rock_sides", [over["upstream"][-1], (x0, bottom)]), Line("rock_sides", [over["downstream"][-1], (x1, bottom)])]
    made.points |= {"rock_heel": (*heel, ("rock",)), "rock_toe": (*toe, ("rock",))}
    seams(made, rock, shape)


def add_rock_below(made, rock, size):
    """A box of rock below a drawn dam, whose faces get the names of a section's."""
    outline = DrawnOutline(made, rock)
    if outline.good:
        groups = tuple(dict.fromkeys(region.group for region in made.regions))
        name_dam(made, outline, max(1, math.ceil(shapely.LineString(outline.base).length / size - 1e-6)), groups)
        add_rock(made, rock, outline)
        lay_joint_sets(made, rock)
    rock.done(*ROCK, "heel", "toe")


def reaching(points, x):
    """Returns the points, continued level from the last one to x."""
    return [*points, (x, points[-1][1])]


def seams(made, rock, shape):
    for name, keys in rock.named("seams"):
        if keys.one_of("through", "points") == "points":
            points = keys.points("points")
            keys.done()
            lines = [shapely.LineString(points)] if points else []
            if lines and not shape.buffer(1e-6).contains(lines[0]):
                keys.fault("points", "expected inside the rock")
                continue
        else:
            at, dip = keys.point("through", None), keys.number("dip", above=-90, most=90, unit="degree")
            keys.done()
            lines = across(shape, at, dip) if at and dip is not None else []
            if at and dip is not None and not lines:
                keys.fault(None, "its line does not meet the rock")
        made.lines += [Line(name, list(line.coords), joint=True) for line in lines]


def across(shape, at, dip):
    """Pieces within the shape of the line through a point. dip: degrees below the horizontal to the right."""
    angle = math.radians(dip)
    along, reach = np.array([math.cos(angle), -math.sin(angle)]), 2 * shapely.Point(at).hausdorff_distance(shape)
    parts = shapely.get_parts(shape.intersection(shapely.LineString([at - reach * along, at + reach * along])))
    return [part for part in parts if part.length > 1e-6 * reach]


# ---- stones ----------------------------------------------------------------------------------------------

def lay_stones(made, dam, outline):
    """The pattern of the dam, whose joints are those of its stones."""
    keys = dam.below("pattern")
    if keys is None:
        return
    if "lifts" in dam:
        dam.fault("lifts", "expected lifts or a pattern: beds of courses are its lifts")
        return
    found = patterns.read(keys, outline.corners(), len(outline.base) - 1)
    if found:
        made.patterns += [(region, found, keys) for region in made.regions if region.group == "dam"]


def lay_joint_sets(made, rock):
    """Joint sets between the seams, which stay straight."""
    found = []
    for name, keys in rock.named("joints"):
        values = keys.number("dip", above=-90, most=90, unit="degree"), keys.number("spacing", above=0), keys.point("through", [0.0, 0.0])
        keys.done()
        if None not in values:
            found.append(JointSet(name, values[0], values[1], tuple(values[2])))
    if not found or rock.faults:
        return
    region = next(region for region in made.regions if region.group == "rock")
    seams = [shapely.LineString(line.points) for line in made.lines if line.joint and line.name in (rock.values.get("seams") or {})]
    cuts = shapely.union_all([region.shape.boundary, *seams], grid_size=1e-3 * made.grid())
    parts = [part for part in shapely.polygonize([cuts]).geoms if region.shape.contains(part.representative_point())]
    made.regions.remove(region)
    pieces = [Region("rock", part, region.size, region.rigid) for part in sorted(parts, key=lambda part: part.bounds)]
    made.regions += pieces
    made.patterns += [(piece, patterns.Joints(found), rock) for piece in pieces]


def lay(made, region, pattern, keys):
    wrong = patterns.too_many(pattern, region.shape)
    if wrong:
        keys.fault(None, wrong)
        return
    try:
        patterns.lay(made, region, pattern)
    except MeshError as error:
        keys.fault(None, str(error))


# ---- members of any section -----------------------------------------------------------------------------

def add_lines(made, top):
    """Reads points, joints and faces by coordinates."""
    for joint in (True, False):
        below = top.below("joints" if joint else "faces")
        for name in below.values if below else ():
            points = below.points(name)
            if points and below.checked_name(name, name):
                made.lines.append(Line(name, points, joint))
    below = top.below("drains")
    for name in below.values if below else ():
        points = below.points(name)
        if points and below.checked_name(name, name):
            made.drains[name] = [points[0], points[-1]]
    below = top.below("points")
    for name in below.values if below else ():
        at = below.point(name)
        if name in made.points:
            below.fault(name, "a point that has this name already is there")
        elif at and below.checked_name(name, name):
            if not any(region.shape.distance(shapely.Point(at)) <= max(1e-6, made.meet()) for region in made.regions):
                below.fault(name, "expected inside a group", at)
            made.points[name] = (*at, ())


def check_names(made, top):
    """Groups, joints, faces and points have names of their own."""
    groups = {region.group for region in made.regions}
    kinds = {}
    for line in made.lines:
        kind = "joint" if line.joint else "faces"
        if line.name in groups or kinds.setdefault(line.name, kind) != kind:
            top.fault(None, f"{line.name!r} names two things, each needs a name of its own")
            return


# ---- command line ----------------------------------------------------------------------------------------

def report(mesh):
    """Describes the mesh in lines."""
    area, body = areas(mesh), macroblocks(mesh)
    lines = [f"{len(mesh.blocks)} blocks, {len(mesh.vertices)} vertices, {body.max() + 1} bodies; smallest angle {quality(mesh)[0]:.1f} degrees"]
    for row, name in enumerate(mesh.group_names):
        lines.append(f"group   {name}: {(mesh.block_group == row).sum()} blocks, {area[mesh.block_group == row].sum():.6g} m2")
    lines += [f"faces   {name}: {len(rows)}" for name, rows in sorted(mesh.face_sets.items())]
    lines += [f"point   {name}: {xy_text(mesh.vertices[vertex])}" for name, vertex in sorted(mesh.points.items())]
    return lines


def check_new(path, mesh_path):
    """Refuses, before any work, a draft that would take the place of a file: what someone has written by hand stays."""
    if os.path.realpath(path) == os.path.realpath(mesh_path):
        raise MeshError(f"{path}: is the mesh already, expected a new file for the draft")
    if os.path.lexists(path):
        raise MeshError(f"{path}: is there already, expected a new file for the draft")


def main(arguments=None):
    parser = Parser(prog="quoin import", description="Mesh of a section declared in a YAML file, or of a drawing (DXF) with its table of layers "
                                                     "(docs/generators.md).")
    parser.add_argument("section", help="YAML file")
    parser.add_argument("-o", "--output", required=True, help="block mesh to write")
    parser.add_argument("--scene", help="a first scene to write, with the names of the mesh")
    options = parser.parse_args(arguments)
    try:
        if options.scene:
            check_new(options.scene, options.output)
        mesh, made, notes = mesh_of(options.section)
        write(options.output, mesh)
        if options.scene:
            beside = os.path.dirname(options.scene) == os.path.dirname(options.output)
            write_file(options.scene, draft(made, mesh, os.path.basename(options.output) if beside else options.output, made.title))
    except DeclaredError as error:
        print("\n".join(error.faults), file=sys.stderr)
        return 2
    except (MeshError, OSError) as error:
        print(words_of(error), file=sys.stderr)
        return 2
    print("\n".join([f"wrote {options.output}", *report(mesh), *notes]))
    angle, _, vertex = quality(mesh)
    if angle < SHARPEST:
        print(f"warning: at {xy_text(mesh.vertices[vertex])} a block has a corner of {angle:.1f} degrees: lines meet there at such an angle or nearly coincide", file=sys.stderr)
    return 0
