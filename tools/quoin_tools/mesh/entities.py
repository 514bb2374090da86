"""Reads the curves and points of a drawing (DXF) by layer, and takes blocks apart; counts and names entities that it does not read.

A drawing comes from other programs: it is read within limits, and an error names the kind, the handle and the layer of the entity."""

import contextlib
import os
import stat
from collections import Counter, defaultdict

import numpy as np

from quoin_tools.mesh import curves

MOST_BYTES = 200_000_000  # of a drawing
MOST = 500_000  # entities, once blocks are taken apart
DEEPEST = 100  # blocks in blocks
LEVEL = 1e-3  # m: a curve whose z varies by more is not level


class DrawingError(ValueError):
    """A drawing is wrong; the message says how."""


class Sheet:
    """The content of the layers, in units of the drawing: polylines (with their largest difference of z) and points by layer, counts of unread entities by layer and kind, remarks."""

    def __init__(self):
        self.curves, self.points, self.others, self.tilted, self.wide, self.clipped = defaultdict(list), defaultdict(list), Counter(), Counter(), Counter(), set()
        self.unread = set()  # layers that are not asked for and have something

    def layers(self):
        return sorted(set(self.curves) | set(self.points) | self.unread | {layer for layer, _ in self.others})


def opened(path):
    """Opens a drawing with ezdxf; DrawingError says why it cannot."""
    import ezdxf  # here: only drawings need it

    status = os.stat(path)
    if not stat.S_ISREG(status.st_mode):
        raise DrawingError("it is no regular file")
    if status.st_size > MOST_BYTES:
        raise DrawingError(f"it has {status.st_size / 1e6:.0f} MB, expected at most {MOST_BYTES / 1e6:.0f} MB: leave out what is not needed")
    with open(path, "rb") as file:
        head = file.read(4096)
    if not head.startswith(b"AutoCAD Binary DXF") and (b"\0" in head or b"SECTION" not in head and not head.lstrip().startswith(b"999")):
        raise DrawingError("it is no DXF file")
    try:
        with tolerant():
            return ezdxf.readfile(path)
    except (OSError, DrawingError):
        raise
    except RecursionError:
        raise DrawingError("it is nested too deep") from None
    except Exception as error:  # noqa: BLE001 (a broken file ends ezdxf in any way)
        raise DrawingError(words_of(error)) from None


@contextlib.contextmanager
def tolerant():
    """Keeps entities that ezdxf cannot read as unknown ones, which are counted; a curve, point or block that it cannot read is an error that names it."""
    from ezdxf.entities import DXFTagStorage, factory

    load = factory.load

    def loaded(tags, doc=None):
        try:
            return load(tags, doc)
        except Exception as error:  # noqa: BLE001
            if tags.dxftype() in (*curves.READ, "VERTEX", "INSERT", "POINT", "BLOCK", "LAYER"):
                raise DrawingError(f"{tags.dxftype()} #{tags.get_handle() or '?'}: {words_of(error)}") from None
            return DXFTagStorage.load(tags, doc)

    factory.load = loaded
    try:
        yield
    finally:
        factory.load = load


def words_of(error):
    return " ".join(str(error).split()) or type(error).__name__


def collected(document, used, chord):
    """Reads the Sheet of the model space. used: layers of the table, in capitals; chord: how far polylines may be from curves."""
    walk = Walk(document, used)
    walk.check_count(document.modelspace())
    for entity, layer, matrix in walk.entities(document.modelspace(), np.eye(4), None, None):
        try:
            add(walk.sheet, entity, layer, matrix, chord)
        except Exception as error:  # noqa: BLE001 (a broken entity ends ezdxf in any way)
            raise DrawingError(f"{named(entity)} on layer {layer}: {words_of(error)}") from None
    return walk.sheet


def named(entity):
    return f"{entity.dxftype()} #{entity.dxf.get('handle') or '?'}"


def add(sheet, entity, layer, matrix, chord):
    kind = entity.dxftype()
    if kind == "POINT":
        xyz = moved(np.array([entity.dxf.location]), matrix)
        if not np.isfinite(xyz).all():
            raise DrawingError("it has coordinates that are no numbers")
        sheet.points[layer].append(xyz[0, :2])
        return
    if not curves.is_curve(entity):
        sheet.others[layer, kind] += 1
        return
    stretch = np.linalg.norm(matrix[:3, :3], 2)  # of lengths, at most
    xyz = moved(curves.points_of(entity, chord / max(stretch, 1e-12)), matrix)
    keep = np.append(True, np.hypot(*np.diff(xyz[:, :2], axis=0).T) > 0) if len(xyz) else np.zeros(0, dtype=bool)
    if keep.sum() < 2:
        sheet.others[layer, f"{kind} without length"] += 1
        return
    sheet.curves[layer].append(xyz[keep, :2])
    sheet.tilted[layer] = max(sheet.tilted[layer], np.ptp(xyz[:, 2]))
    if kind in ("LWPOLYLINE", "POLYLINE") and has_width(entity):
        sheet.wide[layer] += 1


def has_width(entity):
    dxf = entity.dxf
    if entity.dxftype() == "LWPOLYLINE":
        return bool(dxf.get("const_width", 0)) or any(a or b for a, b in entity.get_points("se"))
    return bool(dxf.get("default_start_width", 0) or dxf.get("default_end_width", 0))


def moved(xyz, matrix):
    return xyz @ matrix[:3, :3] + matrix[3, :3]


class Walk:
    """Walks through the model space and the blocks in it."""

    def __init__(self, document, used):
        self.document, self.used, self.sheet, self.counts = document, used, Sheet(), {}
        self.frozen = {layer.dxf.name.upper() for layer in document.layers if layer.is_frozen()}

    def check_count(self, space):
        count = sum(self.count(entity)[0] for entity in space)
        if count > MOST:
            raise DrawingError(f"it has {float(count):.3g} entities once its blocks are taken apart, expected at most {MOST}: leave out what is not needed")

    def count(self, entity, depth=0):
        """Returns the number of entities into which an entity is taken apart, and how deep blocks are nested in it; each block is counted once."""
        if entity.dxftype() != "INSERT" or invisible(entity):
            return 1, 0
        name = entity.dxf.get("name", "").lower()
        if name not in self.counts:
            block = self.document.blocks.get(name)
            if block is None:
                raise DrawingError(f"{named(entity)} on layer {entity.dxf.layer}: there is no block '{entity.dxf.get('name', '')}'")
            self.counts[name] = None  # under way
            found = [] if outside(block) or depth > DEEPEST else [self.count(one, depth + 1) for one in block]
            self.counts[name] = sum(count for count, _ in found), 1 + max((deep for _, deep in found), default=0)
        if self.counts[name] is None:
            raise DrawingError("a block of it holds itself")
        count, deep = self.counts[name]
        if depth > DEEPEST or deep > DEEPEST:
            raise DrawingError(f"its blocks are nested more than {DEEPEST} deep")
        rows, columns = grid_of(entity)
        return 1 + rows * columns * count, deep

    def entities(self, space, matrix, around, hidden):
        """(entity, its layer, matrix to the model space) of what is no block and of what is in blocks: on layer 0 it is on the layer of the block that holds it, `around`.
        hidden: the words for a block on a frozen layer, which hides all that it holds on layers of their own."""
        for entity in space:
            own = entity.dxf.get("layer", "0") if entity.is_supported_dxf_attrib("layer") else "0"
            layer, kind = around if around is not None and own == "0" else own, entity.dxftype()
            if invisible(entity):
                self.sheet.others[layer, f"invisible {kind}"] += 1
            elif kind == "INSERT":
                yield from self.inserted(entity, layer, matrix, hidden)
            elif hidden and own != "0":
                self.sheet.others[layer, f"{kind} in {hidden}"] += 1
            elif layer.upper() in self.used:
                yield entity, layer, matrix
            else:
                self.sheet.unread.add(layer)

    def inserted(self, entity, layer, matrix, hidden):
        block = self.document.blocks.get(entity.dxf.name)
        if outside(block):
            self.sheet.others[layer, f"INSERT of {entity.dxf.name}, which is another file (XREF),"] += 1
            return
        if is_clipped(entity):
            self.sheet.clipped.add(entity.dxf.name)
        if layer.upper() in self.frozen and not hidden:
            hidden = f"block {entity.dxf.name} on the frozen layer {layer}"
        try:
            places = placed(entity, block)
        except Exception as error:  # noqa: BLE001
            raise DrawingError(f"{named(entity)} on layer {layer}: {words_of(error)}") from None
        for place in places:
            yield from self.entities(block, place @ matrix, layer, hidden)


def invisible(entity):
    return entity.is_supported_dxf_attrib("invisible") and bool(entity.dxf.get("invisible", 0))


def outside(block):
    """Tells whether a block stands for another file."""
    return block.block is not None and (block.block.is_xref or block.block.is_xref_overlay)


def is_clipped(entity):
    from ezdxf.xclip import XClip

    return entity.has_extension_dict and XClip(entity).has_clipping_path


def grid_of(entity):
    """Returns rows and columns of a block that is inserted in a grid; without a distance they coincide and count as one."""
    dxf = entity.dxf
    return (max(1, dxf.row_count) if dxf.row_spacing else 1), (max(1, dxf.column_count) if dxf.column_spacing else 1)


def placed(entity, block):
    """Returns matrices, one for each place of the grid, from the coordinates of a block to those around the INSERT. A section is plane, so a scale of 0 along z is taken as 1."""
    dxf, (rows, columns) = entity.dxf, grid_of(entity)
    if not dxf.zscale:
        dxf.zscale = 1.0
    matrix = np.array(entity.matrix44().get_row(0) + entity.matrix44().get_row(1) + entity.matrix44().get_row(2) + entity.matrix44().get_row(3)).reshape(4, 4)
    if not np.isfinite(matrix).all() or not abs(np.linalg.det(matrix[:3, :3])) > 0:
        raise DrawingError(f"a block scaled by {dxf.xscale:g} and {dxf.yscale:g}, expected neither 0")
    ocs, angle, found = entity.ocs(), np.radians(dxf.rotation), []
    for row in range(rows):
        for column in range(columns):
            x, y = column * dxf.column_spacing, row * dxf.row_spacing
            offset = ocs.to_wcs((x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), 0))
            place = matrix.copy()
            place[3, :3] += offset
            found.append(place)
    return found
