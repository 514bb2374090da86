"""Meshes and tables of the published problems: MESHES[name]() is the block mesh of NAME.yaml, TABLES[name][file]() the text of a table that it names."""

import numpy as np
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, line, quad_patch, rectangle, renamed, structured, vertex_at
from quoin_tools.mesh.walls import arch, slope


def dam_on_joint(n=50):
    """Trapezoid 5 m wide and 10 m high on 15 m by 5 m of rock, n columns along the base, the same nodes on both sides."""
    dam = renamed(quad_patch((0, 0), (5, 0), (1.5, 10), (0, 10), n, n, "dam"), {"upstream": "left", "downstream": "right", "base": "bottom"}, {"heel": "bottom_left", "toe": "bottom_right", "crest": "top_left"})
    rock = rectangle(-5, -5, 15, 5, 3 * n, n, "rock")
    sides = np.concatenate([rock.face_sets[name] for name in ("left", "right", "bottom")])
    rock.face_sets, rock.points = {"around": sides}, {}
    return join([rock, dam])


def plate_on_friction(n=32):
    """Square of 40 mm, n by n / 3 blocks, on a rigid plane; points A to E at its foot."""
    plate = rectangle(0, 0, 0.04, 0.04, n, round(10 * n / 32), "plate")
    plate.face_sets, plate.points = {name: plate.face_sets[name] for name in ("top", "left", "right")}, {}
    for name, x in zip("ABCDE", (0, 0.00125, 0.005, 0.0075, 0.01125)):
        plate.points[name] = vertex_at(plate, x, 0)
    return join([renamed(rectangle(-0.01, -0.01, 0.06, 0.01, group="plane", rigid=True)), plate])


WALLS = {1: ["H1111H", "11111"] * 3, 2: ["H1111H", "11111"] * 5,
         3: ["1111", "H111H", "1111", "H1-1H", "1H-H1", "H1-1H", "1H-H1", "H1-1H", "1111", "H111H", "1111"]}


def wall(number):
    """Courses from below of blocks of 0.4 m (1) and 0.2 m (H), 0.175 m high, and openings of one block (-), on a rigid base."""
    bodies = []
    for row, course in enumerate(WALLS[number]):
        x = 0.0
        for block in course:
            width = 0.2 if block == "H" else 0.4
            if block != "-":
                bodies.append(renamed(rectangle(round(x, 9), round(0.175 * row, 9), width, 0.175, group="block", rigid=True)))
            x += width
    return join([renamed(rectangle(-0.5, -0.2, x + 1, 0.2, group="base", rigid=True)), *bodies])


def wall_with_crest(number):
    """The wall with the point crest, its upper right corner."""
    mesh = wall(number)
    high = mesh.vertices[:, 1].max()
    mesh.points = {"crest": vertex_at(mesh, mesh.vertices[np.isclose(mesh.vertices[:, 1], high), 0].max(), high)}
    return mesh


def arch_of_lemos(points=1):
    """17 voussoirs of radii 3.75 and 4.25 m; each joint in this many faces across; points left and right of the crown, on the extrados, and of the ground."""
    mesh = arch(17, 3.75, 0.5, 180, (1, points))
    half = np.pi / 34
    top = {name: vertex_at(mesh, sign * 4.25 * np.sin(half), 4.25 * np.cos(half), "voussoir") for name, sign in (("crown_left", -1), ("crown_right", 1))}
    mesh.points = top | {"ground": vertex_at(mesh, 3.75, 0, "abutment")}
    return mesh


def pulse():
    """Acceleration of the ground against which the body force 0.15 g sin(4 pi t) pushes for 0.25 s, g = 10 m/s2: t, x, y."""
    times = np.linspace(0, 0.25, 251)
    rows = [f"{t:.3f}, {-1.5 * np.sin(4 * np.pi * t):.9g}, 0" for t in times]
    return "\n".join([*rows, "0.251, 0, 0", "10, 0, 0"]) + "\n"


CYCLES, STRESS_OVER_STRENGTH = 4, (1.0, 0.9, 0.75, 0.5, 0.25, 0.1, 0.02)


def sheared_joint(n=20):
    """A joint at y = 0 between two bodies of a quarter of a wave length (31.6 m) each, n blocks high; points at the joint and below the wave's way in."""
    below, above = (rectangle(0, y, 1, 31.6227766, 1, n, "rock") for y in (-31.6227766, 0))
    return join([renamed(below, {"bottom": "bottom"}, {"below": "top_left"}), renamed(above, {"top": "top", "joint": "bottom"}, {"above": "bottom_left"})])


def column(n=50):
    """A column of 50 m, n blocks high; a point half way up."""
    ground = renamed(rectangle(0, 0, 1, 50, 1, n, "ground"), {"bottom": "bottom"})
    ground.points = {"middle": vertex_at(ground, 0, 25)}
    return ground


def column_of_blocks(n=5):
    """Eight square blocks of 100 m on each other, n by n elements each, on a rigid base."""
    blocks = [renamed(rectangle(0, 100 * i, 100, 100, n, n, "block")) for i in range(8)]
    return join([renamed(rectangle(-50, -50, 200, 50, group="base", rigid=True)), *blocks])


def bell():
    """Incident velocity [m/s] of a displacement of 1 mm exp(-((t - 0.1771 s)/0.0503 s)^2), whose largest velocity and its time are those of Code_Aster's table: t, x, y."""
    times = np.linspace(0, 0.4, 401)
    delay = (times - 0.1771) / 0.0503
    return "".join(f"{t:.4f}, {v:.9g}, 0\n" for t, v in zip(times, -2e-3 / 0.0503 * delay * np.exp(-(delay**2)), strict=True)) + "10, 0, 0\n"


def harmonic():
    """Incident velocity of 0.1 m/s at 10 Hz for four cycles: t, x, y."""
    times = np.linspace(0, CYCLES / 10, 100 * CYCLES + 1)
    return "".join(f"{t:.6f}, {0.1 * np.sin(20 * np.pi * t):.12g}, 0\n" for t in times) + "10, 0, 0\n"


def gravity_dam(levels, n=20):
    """One rigid body between the (left, right) points of its levels from below, its base in n faces, on a rigid foundation; points face_0 ... on the face."""
    dam = renamed(structured(np.array([line(left, right, n) for left, right in levels]), "dam", True), {"upstream": "left", "downstream": "right", "base": "bottom"})
    dam.points = {f"face_{i}": i * (n + 1) for i in range(len(levels))}
    width, bottom = levels[0][1]
    return join([renamed(rectangle(-width, bottom - 0.5 * width, 3 * width, 0.5 * width, group="rock", rigid=True)), dam])


DAMS = {"textbook_dam_45": [((0, 0), (4.5, 0)), ((0, 6), (1.5, 6))],
        "textbook_dam_90": [((0, 0), (73.1, 0)), ((8, 28), (53.5, 28)), ((8, 83), (15, 83)), ((8, 90), (15, 90))],
        "textbook_dam_84": [((0, 0), (56, 0)), ((0, 75), (6, 75)), ((0, 84), (6, 84))],
        "textbook_zangar": [((0, 50), (30, 50)), ((7.5, 100), (30, 100))],
        "textbook_retaining": [((0, 0), (3.5, 0)), ((0, 6), (1.5, 6))],
        "textbook_dam_6": [((0, 0), (4.94, 0)), ((0, 6), (1.5, 6))],
        "textbook_dam_10": [((0, 0), (8.25, 0)), ((1, 10), (2, 10))],
        "textbook_dam_70": [((0, 0), (52.5, 0)), ((3.5, 35), (28, 35)), ((3.5, 60), (10.5, 60)), ((3.5, 70), (10.5, 70))]}


def oscillator():
    """A flat block of 1 m on the ground, a post 2 m to its right; the spring between them is an anchor."""
    block = renamed(rectangle(0, 0, 1, 0.02, group="block", rigid=True), {}, {"middle": "top_left"})
    fixed = [renamed(rectangle(*place, group="base", rigid=True)) for place in ((-1, -0.5, 6, 0.5), (3, 0.0, 1, 1))]
    return join([*fixed, block])


def leaning_block():
    """A block of 0.4 m by 2 m on the ground, turned about its right foot by half of what overturns it."""
    lean = 0.5 * np.arctan(0.2)
    c, s = np.cos(lean), np.sin(lean)
    block = renamed(rectangle(-0.4, 0, 0.4, 2, group="block", rigid=True), {}, {"foot": "bottom_right", "top": "top_right"})
    block.vertices = block.vertices @ np.array([[c, -s], [s, c]])
    return join([renamed(rectangle(-2, -0.5, 4, 0.5, group="base", rigid=True)), block])


def plates():
    """Two rigid plates of 2 m, one on the other; faces inlet and outlet of the lower one at the ends of the gap."""
    lower = renamed(rectangle(0, -0.5, 2, 0.5, 20, 1, group="plate", rigid=True), {"inlet": "left", "outlet": "right", "gap": "top"})
    return join([lower, renamed(rectangle(0, 0, 2, 0.5, 20, 1, group="cover", rigid=True))])


def prestressed_beam(n=40):
    """A beam of 10 m by 0.2 m, n by 4 blocks, clamped at its left end; points a quarter and half way along its axis."""
    beam = rectangle(0, -0.1, 10, 0.2, n, 4, "beam")
    beam.face_sets = {"clamped": beam.face_sets["left"]}
    beam.points = {"quarter": vertex_at(beam, 2.5, 0), "half": vertex_at(beam, 5, 0), "end": vertex_at(beam, 10, 0.05)}
    return beam


def wedge():
    """A block between a wall at its left and a wedge of 20 degrees on the floor, which is pushed to the left."""
    rise = np.tan(np.radians(20))
    body = quad_patch((0, 0), (3, 0), (3, 0.3 + 3 * rise), (0, 0.3), 1, 1, "wedge", True)
    block = quad_patch((0.5, 0.3 + 0.5 * rise), (1.5, 0.3 + 1.5 * rise), (1.5, 2.5), (0.5, 2.5), 1, 1, "block", True)
    fixed = [renamed(rectangle(*place, group="base", rigid=True)) for place in ((-1, -0.5, 6, 0.5), (-0.5, 0.7, 1, 1.8))]
    return join([*fixed, renamed(body, {"push": "right"}), renamed(block)])


def least_arch(thickness=0.11, cut="radial", n=120):
    """Half circle of mean radius 1 m, n stones cut along radii, or along verticals as Makris and Alexakis do, on rigid ground."""
    inner, outer = 1 - thickness / 2, 1 + thickness / 2
    if cut == "radial":
        return arch(n, inner, thickness)
    x = np.concatenate([-inner * np.cos(np.linspace(0, np.pi, n + 1)), outer - (outer - inner) * np.linspace(0, 1, 9)[:-1] ** 1.0])
    x = np.unique(np.concatenate([x, -x]).round(12))
    low, high = np.sqrt(np.maximum(inner**2 - x**2, 0)), np.sqrt(np.maximum(outer**2 - x**2, 0))
    stones = []
    for i in range(len(x) - 1):
        a, b, c, d = ((x[i], low[i]), (x[i + 1], low[i + 1]), (x[i + 1], high[i + 1]), (x[i], high[i]))
        ring = [p for k, p in enumerate((a, b, c, d)) if p != (a, b, c, d)[k - 1]]
        stones.append(BlockMesh(np.array(ring), [[0, 1, 2, 3 if len(ring) == 4 else -1]], [0], ["voussoir"], [1]))
    ground = [renamed(rectangle(at, -0.2, 0.4, 0.2, group="abutment", rigid=True)) for at in (-inner - 0.3, inner - 0.1)]
    return join([*ground, *stones])


def block_on_joint():
    """A block of 1 m by 1 m on the joint `joint` with a wider base."""
    block = renamed(rectangle(0, 0, 1, 1, 1, 1, "block"), {"joint": "bottom", "top": "top", "sides": "left"})
    return join([renamed(rectangle(-1, -1, 3, 1, group="base", rigid=True)), block])


def slipping_crack(n=32, crack=0.54):
    """A block of 1 m by 2 m, n by 2 n blocks, cut at 45 degrees by a joint whose middle is the crack, between two rigid plates."""
    half = crack / 2 / np.sqrt(2)
    x = np.unique(np.concatenate([np.linspace(a, b, max(2, round(n * (b - a))) + 1) for a, b in ((0, 0.5 - half), (0.5 - half, 0.5 + half), (0.5 + half, 1))]).round(12))
    lower, upper = (structured(np.array([np.column_stack([x, low(x) + part * (high(x) - low(x))]) for part in np.linspace(0, 1, n + 1)]), "block")
                    for low, high in ((np.zeros_like, lambda x: 0.5 + x), (lambda x: 0.5 + x, lambda x: 2 + 0 * x)))  # fmt: skip
    in_crack = abs(0.5 * (x[1:] + x[:-1]) - 0.5) < half
    upper.face_sets, upper.points = {"crack": upper.face_sets["bottom"][in_crack]}, {}
    plate = rectangle(-0.1, 2, 1.2, 0.1, 2, 1, group="plate", rigid=True)
    plate.face_sets, plate.points = {}, {"push": vertex_at(plate, 0.5, 2.1)}
    bed = renamed(rectangle(-0.1, -0.1, 1.2, 0.1, group="plate", rigid=True), {"bed": "bottom"})
    return join([bed, renamed(lower), upper, plate])


def grouted_joint(n=20, rows=40):
    """Two blocks of 5 m by 10 m side by side, n elements across and so many rows each."""
    left, right = (rectangle(x, 0, 5, 10, n, rows, group) for x, group in ((-5, "left"), (0, "right")))
    points = {f"{side}_{10 * y:.0f}": vertex_at(block, 0, y) for side, block in (("l", left), ("r", right)) for y in (2, 4.5, 5, 8, 8.5)}
    for block, face in ((left, "right"), (right, "left")):
        block.face_sets, block.points = {"joint": block.face_sets[face], "base": block.face_sets["bottom"]}, {name: at for name, at in points.items() if name[0] == block.group_names[0][0]}
    return join([left, right])


def slender_block():
    """A block of 0.2 m by 2 m on the ground."""
    block = renamed(rectangle(-0.1, 0, 0.2, 2, group="block", rigid=True), {}, {"foot": "bottom_right", "top": "top_right"})
    return join([renamed(rectangle(-4, -0.5, 8, 0.5, group="base", rigid=True), {}, {"ground": "top_left"}), block])


def sliding_block():
    """A block of 1 m by 0.5 m on the ground."""
    block = renamed(rectangle(-0.5, 0, 1, 0.5, group="block", rigid=True), {}, {"foot": "bottom_left"})
    return join([renamed(rectangle(-2, -0.5, 4, 0.5, group="base", rigid=True), {}, {"ground": "top_left"}), block])


def rectangular_pulse(duration, until=10):
    """Acceleration of 1 for a time, from rest: t [s], a."""
    edge = 1e-5
    return "".join(f"{t:.9g}, {a}\n" for t, a in ((0, 1), (duration - edge, 1), (duration + edge, 0), (until, 0)))


def pulse_that_overturns():
    """Of such length that twice the acceleration that begins to rock the block just overturns it: ln 2 / p, p^2 = 3 g / (4 R)."""
    p = np.sqrt(3 * 9.81 / (4 * np.hypot(0.1, 1)))
    return rectangular_pulse(np.log(2) / p)


def elastic_dam(levels, n, rows):
    """One elastic body between the (left, right) points of its levels from below, n blocks across and so many rows between two levels."""
    lines = [line(*levels[0], n)]
    for (a, b), (c, d), many in zip(levels[:-1], levels[1:], rows, strict=True):
        for part in np.arange(1, many + 1) / many:
            left, right = (tuple(np.array(low) + part * (np.array(high) - low)) for low, high in ((a, c), (b, d)))
            lines.append(line(left, right, n))
    return renamed(structured(np.array(lines), "dam"), {"upstream": "left", "base": "bottom"})


def koyna(n=40, rows=(56, 40), base=70):
    """The highest section without a spillway: 103 m high, its downstream face steeper above 66.5 m."""
    return elastic_dam([((0, 0), (base, 0)), ((0, 66.5), (19.25, 66.5)), ((0, 103), (14.8, 103))], n, rows)


def koyna_lifts(n=8):
    """The same section cut into lifts by joints j0 (base) to j5, of which j3 is where the downstream face bends, on a rigid base."""
    heights, bends = (0, 22, 44, 66.5, 78, 90, 103), ((0, 66.5, 103), (70, 19.25, 14.8))
    widths = np.interp(heights, *bends)
    lifts = []
    for i, (low, high) in enumerate(zip(heights[:-1], heights[1:])):
        lift = elastic_dam([((0, low), (widths[i], low)), ((0, high), (widths[i + 1], high))], n, (max(3, round((high - low) / 4)),))
        lifts.append(renamed(lift, {"upstream": "upstream", f"j{i}": "base"}))
    return join([renamed(rectangle(-20, -10, 110, 10, group="rock", rigid=True)), *lifts])


def growing():
    """Acceleration of the ground that swings at 2.6 Hz and grows by 0.1 g a second: t [s], a [m/s2]."""
    times = np.linspace(0, 5, 1001)
    return "".join(f"{t:.4f}, {0.981 * t * np.sin(2 * np.pi * 2.6 * t):.9g}\n" for t in times)


def pine_flat(n=20):
    """121.92 m high, 95.8 m at its base, 9.75 m at its crest; faces that lean 0.05 and 0.78, the latter up to a vertical face."""
    edge = 0.05 * 121.92 + 9.75
    neck = (95.8 - edge) / 0.78
    return elastic_dam([((0, 0), (95.8, 0)), ((0.05 * neck, neck), (edge, neck)), ((0.05 * 121.92, 121.92), (edge, 121.92))], n, (round(1.35 * n), n // 4))


BOUZEY_LIFTS = (0, 3, 6, 9, 11.38, 14, 17, 22)  # m above the foundation: j0 (foundation) to j4 (ground) to j6, crest


def bouzey(free=0, ground=11.38, n=20):
    """22 m above its foundation (349.95 m) and 11.35 m thick there, 5.60 m at the ground, 4 m at its crest: vertical faces, downstream a parabola from some depth on.
    Rigid lifts on joints in n faces; what stands below the joint of the number `free` is one fixed body with the rock."""
    ratio = np.sqrt((11.35 - 4) / (5.60 - 4))
    start = (ratio * (22 - ground) - 22) / (ratio - 1)  # m below the crest, where the face leaves the vertical
    levels = [ground if level == 11.38 else level for level in BOUZEY_LIFTS]

    def part(low, high, group, faces):
        thick = [(y, 4 + (11.35 - 4) * (max(22 - y - start, 0) / (22 - start)) ** 2) for y in np.linspace(low, high, 5)]
        return renamed(structured(np.array([line((0, y), (width, y), n) for y, width in thick]), group, True), faces)

    lifts = [part(*levels[i : i + 2], "dam", {"upstream": "left", f"j{i}": "bottom"}) for i in range(free, 7)]
    return join([part(0, levels[free], "rock", None) if free else renamed(rectangle(-10, -5, 35, 5, group="rock", rigid=True)), *lifts])


MESHES = {
    "grouted_joint": grouted_joint,
    "slipping_crack": slipping_crack,
    "elastic_joint_wave": sheared_joint,
    "column_wave": column,
    "column_of_blocks": column_of_blocks,
    "pulse_block": slender_block,
    "newmark_block": sliding_block,
    "koyna": koyna,
    "koyna_shaken": koyna_lifts,
    "barton": block_on_joint,
    "pine_flat": pine_flat,
    "bouzey_1884": bouzey,
    "bouzey_1895": lambda: bouzey(4),
    "joint_friction": block_on_joint,
    "wedge": wedge,
    "prestressed_beam": prestressed_beam,
    "plates": plates,
    "rocking_block": leaning_block,
    "friction_oscillator": oscillator,
    "toppling_slope": slope,
    "dam_on_joint": dam_on_joint,
    "dam_on_joint_flow": lambda: dam_on_joint(20),
    "plate_on_friction": plate_on_friction,
    "wall_1": lambda: wall(1),
    "wall_2": lambda: wall(2),
    "wall_3": lambda: wall(3),
    "walls_pushed": lambda: wall_with_crest(1),
    "arch_pulse": lambda: arch_of_lemos(2),
    "arch_elastic": lambda: arch_of_lemos(2),
    "arch_radial": least_arch,
    "arch_vertical": lambda: least_arch(cut="vertical"),
    "sheared_joint": sheared_joint,
} | {name: (lambda levels=levels: gravity_dam(levels)) for name, levels in DAMS.items()}
TABLES = {"arch_pulse": {"pulse.csv": pulse}, "arch_elastic": {"pulse.csv": pulse}, "sheared_joint": {"wave.csv": harmonic}, "elastic_joint_wave": {"wave.csv": harmonic},
          "column_wave": {"pulse.csv": bell}, "koyna_shaken": {"growing.csv": growing}, "pulse_block": {"pulse.csv": pulse_that_overturns}, "newmark_block": {"pulse.csv": lambda: rectangular_pulse(0.3)}}
