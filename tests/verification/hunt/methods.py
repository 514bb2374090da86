"""Dams, slopes, walls and columns: the explicit method against the others."""

import numpy as np
from quoin_tools.mesh.dam import dam_mesh, gravity_section
from quoin_tools.mesh.meshing import join, rectangle, renamed
from quoin_tools.mesh.stacks import block_on_plane
from quoin_tools.mesh.walls import wall
from runs import Scene, bracket, elastic, frame, gap_of, joint, reduction, solved


def dam_scene(rng, **shape):
    section = gravity_section(float(rng.uniform(20, 80)), float(rng.uniform(3, 8)), float(rng.uniform(0, 0.1)),
                              slope=float(rng.uniform(0.65, 0.85)), base_slope=float(rng.choice([0.0, 0.03, 0.08])))
    level = float(rng.uniform(0.6, 0.95) * section.height())
    loads = {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": level}}
    keys = frame(materials={"dam": elastic(rng), "rock": elastic(rng)}, joints={"default": {"law": "elastic", "k_n": 1e10, "k_s": 3e9}, "base": {"law": "mohr_coulomb"} | joint(rng, friction=(45, 60))},
                 supports={"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "y"}}, loads=loads,
                 stages=[{"sw": {"loads": ["weight"]}}, {"swhp": {"loads": ["weight", "water"]}}, reduction(["weight", "water"])])
    keys["relaxation"]["groups"] = ["dam"]
    columns = int(rng.integers(5, 11))
    rock = int(rng.integers(4, 14)) if shape.get("unmatched") else None
    return Scene("dam", dam_mesh(section, columns, rock_columns=rock, rock_extent=1.5), keys, condensed=["dam", "rock"])


def slope_scene(rng):
    dip = float(rng.uniform(10, 35))
    rigid = bool(rng.random() < 0.5)
    mesh = block_on_plane(float(rng.uniform(1, 3)), float(rng.uniform(0.2, 0.8)), dip, rigid=rigid)
    block = {"density": 2400.0} if rigid else elastic(rng)
    row = joint(rng, (9, 10.5), (dip + 8, dip + 25))
    keys = frame(materials={"base": {"density": 2400}, "block": block}, joints={"default": row}, supports={"base": {"fix": "xy"}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}},
                 stages=[{"stand": {"loads": ["weight"]}}, reduction(["weight"])])
    def by_hand(run):
        stage = run.stages()["limit"]
        if bracket(stage):
            yield f"limit by hand {dip:.3f}", gap_of(bracket(stage), (dip, dip))
    return Scene("slope", mesh, keys, by_hand=by_hand, condensed=[] if rigid else ["block"])


def wall_scene(rng):
    rigid = bool(rng.random() < 0.5)
    blocks, courses = int(rng.integers(3, 7)), int(rng.integers(4, 9))
    mesh = wall(blocks, courses, divide=(1, 1), rigid=rigid)
    block = {"density": 2200.0} if rigid else elastic(rng, 2200.0)
    weight = 2200 * 9.81 * blocks * courses * 0.5
    push = float(rng.uniform(0.02, 0.1) * weight / (0.5 * courses))
    keys = frame(materials={"base": {"density": 2200}, "block": block}, joints={"default": joint(rng, (9, 10.5), (30, 45))},
                 supports={"base": {"fix": "xy"}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "traction", "faces": "left", "value": [push, 0.0]}},
                 stages=[{"sw": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}}, reduction(["weight", "push"], 0.25)])
    return Scene("wall", mesh, keys, condensed=[] if rigid else ["block"])


def column_scene(rng):
    n, size = int(rng.integers(2, 7)), float(rng.uniform(0.5, 2))
    rigid = bool(rng.random() < 0.3)
    divide = 1 if rigid else int(rng.integers(1, 4))
    bodies = [rectangle(-size, -size, 3 * size, size, group="base", rigid=True)]
    bodies += [rectangle(0, i * size, size, size, divide, divide, group="block", rigid=rigid) for i in range(n)]
    mesh = join([renamed(body, {"pushed": "left"} if i else {}, {f"block_{i}": "top_left"}) for i, body in enumerate(bodies)])
    block = {"density": 2400.0} if rigid else elastic(rng)
    push = float(rng.uniform(0.05, 0.25) * 2400 * 9.81 * size / n)  # it overturns at size/n of the weight
    keys = frame(materials={"base": {"density": 2400}, "block": block}, joints={"default": joint(rng, (9, 11), (35, 50))},
                 supports={"base": {"fix": "xy"}},
                 loads={"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "traction", "faces": "pushed", "value": [push, 0.0]}},
                 stages=[{"sw": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}}])
    return Scene("column", mesh, keys, condensed=[] if rigid else ["block"])


PLAIN = (dam_scene, slope_scene, wall_scene, column_scene)


def ranks(rng):
    return (2, 3) if rng.random() < 0.3 else (2,)


def methods(make):
    def kind(rng):
        return solved(make(rng), ranks=ranks(rng))
    kind.__name__ = make.__name__.removesuffix("_scene")
    return kind


KINDS = tuple(methods(make) for make in PLAIN)


def any_of(rng, makers=PLAIN):
    return makers[int(rng.integers(len(makers)))](rng)


def rounded(mesh, step=1e-3):
    """Coordinates to a multiple of step [m]."""
    return with_vertices(mesh, np.round(mesh.vertices / step) * step)


def with_vertices(mesh, vertices):
    return type(mesh)(vertices, mesh.blocks, mesh.block_group, mesh.group_names, mesh.group_rigid, dict(mesh.face_sets), dict(mesh.points))
