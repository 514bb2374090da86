"""Sides beside which free ground goes on: ground without a structure moves as a strip of it; a small box with a structure as a wide one."""

import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import double_vertices, split_triangles, structured

WHAT = "free-field sides: ground equals its column, a small box a wide one; energy, static reactions, alpha, moving base"
SOURCE = "a strip of the same blocks whose vertices are held across the wave; a box of 300 m"
BY = "Quoin itself, a strip and a wider box"

LOW = {"density": 2200, "young": 2e9, "poisson": 0.25}
HIGH = {"density": 2200, "young": 0.5e9, "poisson": 0.25}
STIFF = {"density": 4000, "young": 20e9, "poisson": 0.2}
PULSE, LENGTH = 0.1, 0.15  # m/s, s
H = 2.5  # m

SCENE = {
    "strain": "small",
    "materials": {"low": LOW, "high": HIGH},
    "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}},
    "supports": {"bottom": {"fix": "xy", "boundary": "quiet", "input": "incident", "motion": "wave.csv"}, "sides": {"fix": "x", "boundary": "free_field"}},
    "relaxation": {"history_every": 1},
    "stages": [{"shake": {"type": "dynamic", "loads": [], "duration": 0.6, "dt_factor": 0.9, "frames": 5}}],
}


def ground(width, keep=None, structure=False, height=40, left=0.0):
    """Blocks of 2.5 m from x = left on, softer from y = 20 m on; structure: 50 t on two of them in the middle."""
    x, y = left + H * np.arange(round(width / H) + 1), H * np.arange(round(height / H) + 2)
    mesh = structured(np.stack(np.meshgrid(x, y), axis=2), "low")
    centre = mesh.vertices[mesh.blocks].mean(axis=1)
    on_top = centre[:, 1] > height
    stays = ~on_top | (structure & (abs(centre[:, 0] - left - width / 2) < H))
    if keep:
        stays &= keep(centre)
    used = np.unique(mesh.blocks[stays])
    row = np.cumsum(np.isin(np.arange(len(mesh.vertices)), used)) - 1
    vertices, blocks, centre = mesh.vertices[used], row[mesh.blocks[stays]], centre[stays]
    group = np.where(centre[:, 1] > height, 2, np.where(centre[:, 1] > 20, 1, 0)).astype(np.int32)
    sets = {"bottom": np.flatnonzero(centre[:, 1] < H)[:, None] * [1, 0]}
    sides = [np.flatnonzero(abs(centre[:, 0] - at) < H)[:, None] * [1, 0] + [0, k] for at, k in ((left, 3), (left + width, 1))]
    sets["sides"] = np.concatenate(sides)
    names = ["low", "high", "stiff"][: group.max() + 1]
    middle = int(np.argmin(abs(vertices - [left + width / 2, height]).sum(axis=1)))
    return BlockMesh(vertices, blocks, group, names, np.zeros(len(names), np.int32), sets, {"middle": middle})


def shake(**keys):
    return ("stages", [{"shake": SCENE["stages"][0]["shake"] | keys}])


def bell(t):
    return PULSE * np.sin(np.pi * t / LENGTH) ** 2 * (t < LENGTH)


def rows(x, y):
    t = np.arange(0, LENGTH + 1e-9, LENGTH / 150)
    return "".join(f"{a:.9g}, {x * b:.17g}, {y * b:.17g}\n" for a, b in zip(t, bell(t), strict=True))


WAVES = {"S": rows(1, 0), "P": rows(0, 1), "both": rows(0.8, -0.6)}


def shaken(case, mesh, wave, *changes, ranks=1):
    groups = {"materials": {name: {"low": LOW, "high": HIGH, "stiff": STIFF}[name] for name in mesh.group_names}}
    folder = case.prepare(mesh, changed(SCENE | groups, *changes))
    (folder / "wave.csv").write_text(WAVES[wave])
    return case.again(folder, ranks=ranks)


def strip(case, wave, dt, *changes, **keys):
    """One quadrilateral wide, held across the wave: a solution without any side, in steps of dt."""
    across = {"S": "y", "P": "x"}[wave]
    supports = {"bottom": dict(SCENE["supports"]["bottom"]), "low": {"fix": across}, "high": {"fix": across}}
    result, factor = None, 0.9
    while not result or abs(result.stage_summary("shake")["dt"] / dt - 1) > 1e-12:
        factor *= dt / result.stage_summary("shake")["dt"] if result else 1
        result = shaken(case, ground(H), wave, ("supports", supports), *changes, shake(**keys | {"dt_factor": factor}))
    return result


def states(run):
    return [run.stage(name) for name in (*run.frames("shake"), "shake")]


def deviation(box, column):
    """Largest distance of a vertex of the box from the strip at its height, over the largest displacement."""
    level = np.rint(box.mesh.vertices[:, 1] / H).astype(int)
    left = np.flatnonzero(column.mesh.vertices[:, 0] == 0)
    row = left[np.argsort(column.mesh.vertices[left, 1])][level]
    pairs = [(a.displacement, b.displacement[row]) for a, b in zip(states(box), states(column), strict=True)]
    peak = max(abs(b).max() for _, b in pairs)
    return max(abs(a - b).max() for a, b in pairs) / peak


LONG = ("condensed", "alone")  # parts that the short form leaves out


def run(case):
    alone(case)
    with_structure(case)
    two_columns(case)
    condensed(case)
    rest(case)
    ranks(case)
    restart(case)
    refused(case)


def same_as_strip(case, what, wave, *changes, shape=None, tolerance=1e-10, **keys):
    box = shaken(case, shape(ground(60)) if shape else ground(60), wave, *changes, shake(**keys))
    off = deviation(box, strip(case, wave, box.stage_summary("shake")["dt"], *changes, **keys))
    case.check(f"{what}: vertices from the strip, over its largest displacement", off, 0.0, absolute=tolerance)
    return box


def alone(case):
    """VS05: ground without a structure."""
    for wave in ("S", "P"):
        for shape, name in ((None, "quadrilaterals"), (split_triangles, "triangles")):
            box = same_as_strip(case, f"{wave} wave, {name}", wave, shape=shape)
        energy, field = (box.stage_summary("shake")[k] for k in ("energy", "free_field"))
        case.check("... energy balance over what came in", energy["balance"] / energy["incoming"], 0.0, absolute=1e-10)
        axis = "xy"[wave == "P"]
        case.check("... tops of its columns end where the middle of the surface does [m]", [c[f"end_displacement_{axis}"] for c in field], [box.history[f"middle_u{axis}_m"][-1]] * 2, relative=1e-7)
    same_as_strip(case, "S wave, alpha 3 against the ground", "S", alpha=3.0)
    same_as_strip(case, "S wave, alpha 3 against what rests", "S", alpha=3.0, frame="absolute")
    for shape, name in ((None, "quadrilaterals"), (split_triangles, "triangles")):
        same_as_strip(case, f"S wave, beta 2 ms above, 0.5 ms below, {name}", "S", ("materials.high.beta", 2e-3), shape=shape, beta=5e-4)
    same_as_strip(case, "P wave, beta and alpha", "P", alpha=3.0, beta=1e-3)
    rigid = ("supports.bottom", {"fix": "xy", "motion": "wave.csv"})
    for wave in ("S", "P"):
        same_as_strip(case, f"base that is moved, {wave} wave, alpha 3", wave, rigid, alpha=3.0)
    same_as_strip(case, "S wave, large strain", "S", ("strain", "large"), tolerance=3e-4)
    same_as_strip(case, "S wave, blocks of one point", "S", ("materials.low.element", "reduced"), ("materials.high.element", "reduced"))
    box = same_as_strip(case, "S wave, given as the motion of free ground", "S", ("supports.bottom.input", "outcrop"))
    free = shaken(case, ground(60), "S", ("supports", {"bottom": SCENE["supports"]["bottom"]}))
    case.check("... sides that are free instead: far from the strip", deviation(free, strip(case, "S", free.stage_summary("shake")["dt"])) > 0.3, True)


def with_structure(case):
    """50 t on the ground: a box of 60 m against one of 300 m."""
    def middle(result):
        return result.history["time_s"], result.history["middle_ux_m"]
    for shape, name in ((lambda m: m, "quadrilaterals"), (split_triangles, "triangles")):
        small = shaken(case, shape(ground(60, structure=True)), "S")
        wide = shaken(case, shape(ground(300, structure=True, left=-120.0)), "S")
        alone_ = shaken(case, shape(ground(60)), "S")
        rollers = shaken(case, shape(ground(60, structure=True)), "S", ("supports.sides", {"fix": "y"}))
        t, u = middle(wide)
        def off(result, t=t, u=u):
            return abs(np.interp(t, *middle(result)) - u).max() / abs(u).max()
        case.check(f"50 t on the ground, {name}: small box from the wide one, over its largest displacement", off(small), 0.0, absolute=0.015)
        case.check("... the structure changes the motion by more than that, rollers send it back", [bool(off(alone_) > 0.03), bool(off(rollers) > 2 * off(small))], [True, True])
        energy = small.stage_summary("shake")["energy"]
        case.check("... energy balance over what came in", energy["balance"] / energy["incoming"], 0.0, absolute=1e-8)


def two_columns(case):
    """Ground 10 m higher on the left: each side has its own column."""
    def stepped(width, left):
        return ground(width, keep=lambda c: (c[:, 0] < left + width / 2) | (c[:, 1] < 30), left=left)
    small, wide = (shaken(case, stepped(*at), "both") for at in ((120, 0.0), (420, -150.0)))
    quiet = shaken(case, stepped(120, 0.0), "both", ("supports.sides.boundary", "quiet"))
    row = {tuple(x): i for i, x in enumerate(np.rint(wide.mesh.vertices / H).astype(int))}
    rows_ = [row[tuple(x)] for x in np.rint(small.mesh.vertices / H).astype(int)]
    peak = max(abs(b.displacement).max() for b in states(wide))
    off = [max(abs(a.displacement - b.displacement[rows_]).max() for a, b in zip(states(box), states(wide), strict=True)) / peak for box in (small, quiet)]
    case.check("ground 10 m higher on the left: box of 120 m from one of 420 m, all vertices, over the largest displacement", off[0], 0.0, absolute=0.05)
    case.check("... with quiet sides it is far off", bool(off[1] > 0.3), True)
    tops = [c["top"] for c in small.stage_summary("shake")["free_field"]]
    case.check("... tops of its columns [m]", tops, [40, 30])


WEIGHT = {"w": {"type": "self_weight"}}

def with_modes(mesh, hertz, *groups):
    return [(f"materials.{g}.{key}", value) for g in groups or mesh.group_names for key, value in (("condensed", True), ("highest_frequency", hertz))]


def condensed(case):
    """Condensed ground beside free ground. With all modes inside it is the whole mesh; with a few it lacks what they leave out."""
    every, moved_base = 1e5, ("supports.bottom", {"fix": "xy", "motion": "wave.csv"})
    for what, wave, shape, groups, changes, keys in (
            ("S wave, quadrilaterals", "S", None, (), [], {}), ("P wave, triangles", "P", split_triangles, (), [], {}), ("S wave, alpha and beta", "S", None, (), [], {"alpha": 3.0, "beta": 5e-4}),
            ("P wave, the upper half condensed", "P", None, ("high",), [], {"alpha": 3.0}), ("S wave, base that is moved", "S", None, (), [moved_base], {"alpha": 3.0})):
        mesh = (shape or (lambda m: m))(ground(30))
        box = shaken(case, mesh, wave, *with_modes(mesh, every, *groups), *changes, shake(**keys | {"dt_factor": 0.4}))
        off = deviation(box, strip(case, wave, box.stage_summary("shake")["dt"], *changes, **keys))
        case.check(f"condensed ground, {what}: vertices from the strip, over its largest displacement", off, 0.0, absolute=1e-10)
        energy = box.stage_summary("shake")["energy"]
        case.check("... energy balance over what came in", energy["balance"] / max(energy["incoming"], energy["supports"]), 0.0, absolute=1e-10)
    off = []
    for hertz in (30, 60, 120):
        box = shaken(case, mesh, "S", *with_modes(mesh, hertz), shake(dt_factor=0.4))
        off.append(deviation(box, strip(case, "S", box.stage_summary("shake")["dt"])))
    for hertz, error, most in zip((30, 60, 120), off, (3e-3, 5e-4, 5e-5), strict=True):
        case.check(f"... modes to {hertz} Hz: vertices from the strip, over its largest displacement", error, 0.0, absolute=most)
    case.check("... falls", off[0] > 2 * off[1] > 4 * off[2] > 0, True)
    mesh = ground(60, structure=True)
    whole = shaken(case, mesh, "S")
    few = shaken(case, mesh, "S", *with_modes(mesh, 100), ("materials.stiff.condensed", True), ("materials.stiff.highest_frequency", 100))
    t = np.linspace(0, 0.6, 301)
    u = [np.interp(t, r.history["time_s"], r.history["middle_ux_m"]) for r in (whole, few)]
    case.check("50 t on the ground, modes to 100 Hz: the structure from that of the whole mesh, over its largest displacement", abs(u[1] - u[0]).max() / abs(u[0]).max(), 0.0, absolute=1e-3)
    sums = {shaken(case, ground(30), "both", *with_modes(ground(30), 60), shake(duration=0.1), ranks=n).stage_summary("shake")["checksum"] for n in case.ranks(1, 2, 3)}
    case.check("condensed ground: checksums on 1 to 3 ranks", len(sums), 1)


def there_and_back(first, second):
    """Static, dynamic, static, dynamic and static stages, these of so many seconds."""
    time = {"type": "dynamic", "loads": ["w"], "dt_factor": 0.9}
    at_rest = {"loads": ["w"]}
    return [{"weight": at_rest}, {"shake": time | {"duration": first, "alpha": 1.0}}, {"after": at_rest}, {"again": time | {"duration": second}}, {"last": at_rest}]


def late(text, by):
    return "0, 0, 0\n" + "".join(f"{float(t) + by:.9g},{rest}" for t, rest in (line.split(",", 1) for line in text.splitlines(keepends=True)))


def rest(case):
    """Weight, 0.3 s without a wave, a wave, weight again, time again: sides let go and hold without a move."""
    mesh = ground(20, structure=True)
    keys = [("loads", WEIGHT), ("stages", there_and_back(2.0, 0.2)), ("relaxation", {"tolerance": 1e-12, "history_every": 1}), ("materials", {"low": LOW, "high": HIGH, "stiff": STIFF})]
    folder = case.prepare(mesh, changed(SCENE, *keys))
    (folder / "wave.csv").write_text(late(WAVES["both"], 0.3))
    result = case.again(folder)
    h, name, t = result.history, result.history["stage"], result.history["time_s"]
    before = (name == "shake") & (t < 0.29)
    at_rest = [result.probe("weight", "middle")[i] for i in range(2)]
    moved = [abs(h[f"middle_u{k}_m"][before] - u).max() for k, u in zip("xy", at_rest, strict=True)]
    case.check("weight, then 0.3 s without a wave: the surface moves by [m]", moved, [0, 0], absolute=1e-10)
    shaken_, after, again, last = (np.array(result.probe(s, "middle")) for s in ("shake", "after", "again", "last"))
    case.check("... the wave has moved it [m]", bool(np.hypot(*(shaken_ - at_rest)) > 0.01), True)
    case.check("... behind the wave it is held, let go and held where it is [m]", abs(np.array([again - after, last - after])).max(), 0.0, absolute=1e-9)
    sums = [[result.stage_summary(s)["supports"][b][k] for b, k in (("bottom", "y"), ("sides", "x"))] for s in ("weight", "after", "last")]
    case.check("... reactions of base and sides behind it less those before, over the weight", np.subtract(sums[1:], sums[0]).ravel() / sums[0][0], [0] * 4, absolute=1e-5)


def ranks(case):
    for what, mesh, *keys in (("triangles, large strain", split_triangles(ground(30, structure=True)), ("strain", "large")),
                              ("base that is moved", ground(30, structure=True), ("supports.bottom", {"fix": "xy", "motion": "wave.csv"}))):
        keys += [shake(duration=0.15, alpha=2.0), ("relaxation.history_every", 50)]
        sums = {shaken(case, mesh, "both", *keys, ranks=n).stage_summary("shake")["checksum"] for n in case.ranks(1, 2, 3, 4)}
        case.check(f"{what}: checksums on 1 to 4 ranks", len(sums), 1)


def restart(case):
    keys = [("loads", WEIGHT), ("stages", there_and_back(0.25, 0.05)), ("checkpoint", {"every": 100, "keep": 100}), ("relaxation", {"tolerance": 1e-8, "history_every": 50}), ("materials", {"low": LOW, "high": HIGH | {"beta": 1e-3}, "stiff": STIFF})]
    folder = case.prepare(ground(20, structure=True), changed(SCENE, *keys))
    (folder / "wave.csv").write_text(WAVES["both"])
    whole = case.again(folder)
    case.again(folder, "-output", "kept")
    files, names = sorted((folder / "kept" / "checkpoints").iterdir()), ("shake", "after", "again", "last")
    start, steps = (whole.stage_summary(s)["cycles"] for s in ("weight", "shake"))
    files = [f for i, f in enumerate(files) if start < 100 * (i + 1) < start + steps] + files[-1:]
    same = []
    for number, file in enumerate(files):
        result = case.again(folder, "-restart", file, ranks=1 + number % 2)
        same.append(all(result.stage_summary(s)["checksum"] == whole.stage_summary(s)["checksum"] for s in names))
        same[-1] &= result.stage_summary("shake")["free_field"] == whole.stage_summary("shake")["free_field"]
    case.check("restart in the shaking and behind it, on 1 and 2 ranks: same bits, same columns", [len(files) > 3, all(same)], [True, True])


def moved(mesh, x, y, dx, dy):
    mesh.vertices[np.argmin(abs(mesh.vertices - [x, y]).sum(axis=1))] += [dx, dy]
    return mesh


def of_other_ground(mesh):
    inner = np.setdiff1d(np.flatnonzero((mesh.vertices[mesh.blocks[:, :3]][:, :, 0] == 0).any(axis=1)), mesh.face_sets["sides"][:, 0])
    mesh.block_group[inner[2]] = 1
    return mesh


def jointed(mesh, y):
    row = np.flatnonzero(mesh.vertices[:, 1] == y)
    row = row[np.argsort(mesh.vertices[row, 0])]
    return double_vertices(mesh, np.column_stack([row[:-1], row[1:]]))


def shortened(mesh):
    mesh.face_sets["sides"] = np.delete(mesh.face_sets["sides"], 5, axis=0)
    return mesh


def refused(case):
    """What a column of level layers cannot stand for: one line each."""
    entries = [
        ("side that leans", moved(ground(10), 0, 40, -1, 0), (), "is not vertical"),
        ("levels that do not match", moved(ground(10), H, 10, 0, 0.5), (), "expected blocks with level tops and bottoms"),
        ("layers that are not level", of_other_ground(split_triangles(ground(10))), (), "of other ground"),
        ("base that is not flat", moved(ground(10), 5, 0, 0, 0.5), (), "bottom is not flat"),
        ("joint that meets the side", jointed(ground(10), 10), (), "a joint meets the side at (0, 10)"),
        ("side with a gap", shortened(ground(10)), (), "end at y = 12.5 and go on at 15"),
        ("base without a motion", ground(10), (("supports.bottom", {"fix": "xy", "boundary": "quiet"}),), "meets no base with a motion"),
        ("base that is moved and held along x only", ground(10), (("supports.bottom", {"fix": "x", "motion": "wave.csv"}), ("supports.low", {"fix": "y"})), "expected fix: xy"),
        ("motion at the side", ground(10), (("supports.sides.motion", "wave.csv"),), "has the motion of its base"),
        ("side of a rigid body", ground(10), (("materials.low", LOW | {"rigid": True}), ("supports.bottom", {"fix": "xy", "motion": "wave.csv"})), "supports.sides.boundary: free_field"),
        ("other damping beside the side", of_other_ground(split_triangles(ground(10))), (("materials.high", LOW | {"beta": 1e-3}),), "of other ground"),
        ("side that is a group", ground(10), (("supports.sides.target", "low"),), "is no face set"),
    ]
    for what, mesh, keys, words in entries:
        result = shaken(case, mesh, "S", *keys)
        lines = [line for line in result.stderr.splitlines() if line.strip()]
        case.check(f"{what}: refused in one line that says why", [result.exit_code, len(lines), words in result.stderr], [2, 1, True])
