"""Ground that lets waves out: quiet boundaries with and without waves that come in; from static stages to shaking and back."""

import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "quiet boundaries: waves leave and come in, layered ground, energy, static reactions kept and given back"
SOURCE = "one-dimensional waves; Haskell's layers; reflection of a discrete end tan^2(k h / 4); E = rho c int v^2 dt"
BY = "closed forms of one-dimensional waves, by hand; Haskell's layers"

RHO, CS, NU = 2500.0, 1200.0, 0.2
HEIGHT, PULSE = 100.0, 0.1  # m; m/s of the wave that comes in


def elastic(rho, cs):
    return {"density": rho, "young": 2 * (1 + NU) * rho * cs**2, "poisson": NU}


SCENE = {
    "strain": "small",
    "materials": {"ground": elastic(RHO, CS)},
    "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}},
    "supports": {"bottom": {"fix": "xy", "boundary": "quiet", "input": "incident", "motion": "wave.csv"}, "level": {"target": "ground", "fix": "y"}},
    "relaxation": {"history_every": 1},
    "stages": [{"shake": {"type": "dynamic", "loads": [], "duration": 0.6, "dt_factor": 0.9}}],
}


def rows(t, x, y=None):
    y = np.zeros_like(t) if y is None else y
    return "".join(f"{a:.9g}, {b:.17g}, {c:.17g}\n" for a, b, c in zip(t, x, y, strict=True))


def bell(t, length=0.2):
    return PULSE * np.sin(np.pi * t / length) ** 2 * (t < length)


TIMES = np.arange(0, 0.2001, 5e-4)


def shaken(case, mesh, text, *changes, ranks=1):
    folder = case.prepare(mesh, changed(SCENE, *changes))
    (folder / "wave.csv").write_text(text)
    return case.again(folder, ranks=ranks)


LONG = ("oblique", "restart")  # parts that the short form leaves out


def run(case):
    pulse(case)
    pressure_wave(case)
    oblique(case)
    layers(case)
    half_space(case)
    reflection(case)
    static_start(case)
    order_of_loads(case)
    damped(case)
    ranks(case)
    restart(case)


def velocity(result, probe, axis="x"):
    t, u = result.history["time_s"], result.history[f"{probe}_u{axis}_m"]
    return 0.5 * (t[1:] + t[:-1]), np.diff(u) / np.diff(t)


def pulse(case):
    """VS01: a wave runs up, is doubled at the free top and leaves."""
    result = shaken(case, rectangle(0, 0, 1, HEIGHT, 1, 100, group="ground"), rows(TIMES, bell(TIMES)))
    t, v = velocity(result, "top_left")
    energy = result.stage_summary("shake")["energy"]
    brought = RHO * CS * 3 / 8 * 0.2 * PULSE**2
    case.check("wave of 0.1 m/s, elements of 1 m: top moves at most [m/s]", v.max(), 2 * PULSE, relative=2e-3)
    case.check("... at [s]", t[v.argmax()], 0.1 + HEIGHT / CS, absolute=5e-4)
    case.check("... base and top end at [m]", [result.history[f"{p}_ux_m"][-1] for p in ("bottom_left", "top_left")], [0.02, 0.02], relative=1e-6)
    case.check("... then nothing moves [m/s]", abs(v[t > 0.55]).max(), 0.0, absolute=1e-6)
    case.check("... energy that came in, that went out [J]", [energy["incoming"], energy["radiated"]], [brought, brought], relative=1e-4)
    case.check("... balance over it", energy["balance"] / brought, 0.0, absolute=1e-12)
    outcrop = shaken(case, rectangle(0, 0, 1, HEIGHT, 1, 100, group="ground"), rows(TIMES, 2 * bell(TIMES)), ("supports.bottom.input", "outcrop"))
    case.check("... given as the motion of free ground: same bits", outcrop.stage_summary("shake")["checksum"], result.stage_summary("shake")["checksum"])
    coarse = shaken(case, rectangle(0, 0, 1, HEIGHT, 1, 20, group="ground"), rows(TIMES, bell(TIMES)))
    t, v = velocity(coarse, "top_left")
    case.check("... elements of 5 m: top [m/s]", v.max(), 0.20008, relative=2e-3)
    large = shaken(case, rectangle(0, 0, 1, HEIGHT, 1, 100, group="ground"), rows(TIMES, bell(TIMES)), ("strain", "large"))
    t, v = velocity(large, "top_left")
    case.check("... large strain: top [m/s]", v.max(), 2 * PULSE, relative=2e-3)
    split = triangles(rectangle(0, 0, 1, HEIGHT, 1, 100, group="ground"))
    result = shaken(case, split, rows(TIMES, bell(TIMES)))
    t, v = velocity(result, "top_left")
    energy = result.stage_summary("shake")["energy"]
    case.check("... triangles: top [m/s]", v.max(), 2 * PULSE, relative=2e-3)
    case.check("... energy out over in, balance", [energy["radiated"] / energy["incoming"], energy["balance"] / energy["incoming"]], [1.0, 0.0], absolute=1e-8)


def triangles(mesh):
    """Each quadrilateral cut in two, first diagonal; face sets keep their outer faces."""
    b = mesh.blocks
    cut = np.concatenate([np.stack([b[:, 0], b[:, 1], b[:, 2], 0 * b[:, 0] - 1], 1), np.stack([b[:, 0], b[:, 2], b[:, 3], 0 * b[:, 0] - 1], 1)])
    n = len(b)
    sets = {}
    for name, faces in mesh.face_sets.items():
        first = faces[:, 1] < 2
        sets[name] = np.where(first[:, None], faces, np.stack([faces[:, 0] + n, faces[:, 1] - 1], 1))
    return BlockMesh(mesh.vertices, cut, np.tile(mesh.block_group, 2), mesh.group_names, mesh.group_rigid, sets, mesh.points)


def pressure_wave(case):
    """The same along the axis of the column: it meets rho c_p."""
    cp = CS * np.sqrt(2 * (1 - NU) / (1 - 2 * NU))
    result = shaken(case, rectangle(0, 0, 1, HEIGHT, 1, 100, group="ground"), rows(TIMES, 0 * TIMES, bell(TIMES)), ("supports.level.fix", "x"))
    t, v = velocity(result, "top_left", "y")
    energy = result.stage_summary("shake")["energy"]
    case.check("pressure wave: top moves at most [m/s]", v.max(), 2 * PULSE, relative=2e-3)
    case.check("... at [s]", t[v.argmax()], 0.1 + HEIGHT / cp, absolute=5e-4)
    case.check("... energy that came in [J]", energy["incoming"], RHO * cp * 3 / 8 * 0.2 * PULSE**2, relative=1e-4)
    case.check("... went out over it, balance over it", [energy["radiated"] / energy["incoming"], energy["balance"] / energy["incoming"]], [1, 0], absolute=1e-6)


def turned(mesh, angle):
    c, s = np.cos(angle), np.sin(angle)
    mesh.vertices = mesh.vertices @ np.array([[c, s], [-s, c]])
    return mesh


def oblique(case):
    """VS06: a strip without supports at its sides, upright and turned by 30 degrees: x and y of its dashpots couple."""
    found, factor = [], 0.5
    for a in (0.0, np.radians(30)):
        def strip(factor, a=a):
            wave = bell(TIMES)
            return shaken(case, turned(rectangle(0, 0, 5, 50, 2, 20, group="ground"), a), rows(TIMES, np.cos(a) * wave, np.sin(a) * wave),
                          ("supports", {"bottom": SCENE["supports"]["bottom"]}), ("stages", [{"shake": SCENE["stages"][0]["shake"] | {"dt_factor": factor}}]))
        result = strip(factor)
        if found:  # the bound of the step depends on the axes: the same step for both
            result = strip(factor * found[0][2] / result.stage_summary("shake")["dt"])
        x, y = (result.history[f"bottom_right_u{k}_m"] for k in "xy")
        found.append((np.cos(a) * x + np.sin(a) * y, -np.sin(a) * x + np.cos(a) * y, result.stage_summary("shake")["dt"]))
    off = max(abs(turned_ - upright).max() for upright, turned_ in zip(found[0][:2], found[1][:2], strict=True))
    case.check("strip turned by 30 degrees: its base moves as that of the upright one, over the largest [m]", off / abs(found[0][0]).max(), 0.0, absolute=1e-7)


def layers(case):
    """VS02: two layers on a half space: what the surface does over what free rock would do, by frequency."""
    mesh = rectangle(0, 0, 1, 60, 1, 120, group="rock")
    y = mesh.vertices[mesh.blocks].mean(axis=1)[:, 1]
    mesh.group_names, mesh.group_rigid = ["rock", "stiff", "soft"], np.zeros(3, np.int32)
    mesh.block_group = np.where(y < 10, 0, np.where(y < 40, 1, 2)).astype(np.int32)
    materials = {"rock": elastic(2500, 1500), "stiff": elastic(2100, 600), "soft": elastic(1900, 300)}
    t = np.arange(0, 0.0601, 1e-4)
    wave = PULSE * np.sin(np.pi * t / 0.06) ** 2
    result = shaken(case, mesh, rows(t, wave), ("materials", materials), ("supports.bottom.input", "outcrop"), ("stages", [{"shake": SCENE["stages"][0]["shake"] | {"duration": 6.0}}]),
                    ("supports", {"bottom": SCENE["supports"]["bottom"] | {"input": "outcrop"}} | {g: {"fix": "y"} for g in materials}))
    time, v = velocity(result, "top_left")
    wanted = {1: 1.2101, 2: 2.4389, 3: 4.2163, 4: 2.1721, 5: 2.3459, 6: 3.4947, 8: 1.1587, 10: 1.9341, 12: 1.9763}
    step = np.diff(time).mean()
    found = [abs(np.sum(v * np.exp(-2j * np.pi * f * time)) * step) / abs(np.trapezoid(wave * np.exp(-2j * np.pi * f * t), t)) for f in wanted]
    case.check("two layers on rock: surface over outcrop at 1 to 12 Hz", found, list(wanted.values()), relative=0.02)


def half_space(case):
    """A pulse comes through a soft row at the end of a mesh of rock. Out of ground like the row the rock gets 2 Z_row / (Z_row + Z_rock) of it, reported; out of
    a half space of rock all of it, but for the row's own compliance; ground between free-field sides, too. Ground that is hardly softer is not told."""
    t = np.arange(0, 0.1001, 1e-4)
    wave = PULSE * np.sin(np.pi * t / 0.1) ** 2

    def ran(row, low, sides, keys):
        mesh = rectangle(0, 0, 2 if sides else 1, 60, 2 if sides else 1, 120, group="rock")
        y = mesh.vertices[mesh.blocks].mean(axis=1)[:, 1]
        mesh.group_names, mesh.group_rigid, mesh.block_group = ["rock", "low"], np.zeros(2, np.int32), (y < row).astype(np.int32)
        held = {side: {"fix": "x", "boundary": "free_field"} for side in ("left", "right")} if sides else {"rock": {"fix": "y"}, "low": {"fix": "y"}}
        return shaken(case, mesh, rows(t, wave), ("materials", {"rock": elastic(RHO, CS), "low": elastic(RHO, low)}),
                      ("supports", {"bottom": SCENE["supports"]["bottom"] | {"input": "outcrop"} | keys} | held),
                      ("stages", [{"shake": SCENE["stages"][0]["shake"] | {"duration": 0.25}}]))  # fmt: skip

    def found(row, low, sides=False, **keys):
        result = ran(row, low, sides, keys)
        return velocity(result, "top_left")[1].max() / PULSE, "softer than rock above it" in result.stderr, result

    for row in (0.5, 1.0):
        part, told, result = found(row, CS / 2)
        case.check(f"a soft row of {row} m below rock: a pulse at the top over that of free ground", part, 2 / 3, relative=3e-3)
        case.check("... reported, with the number", [told, "gets 0.667 of what" in result.stderr], [True, True])
        part, told, result = found(row, CS / 2, half_space="rock")
        case.check("... out of a half space of rock", part, 1.0, relative=3e-3)
        energy = result.stage_summary("shake")["energy"]
        case.check("... not reported; balance over what came in", [told, energy["balance"] / energy["incoming"]], [False, 0.0], absolute=1e-12)
    case.check("a row 5 % softer, a stiffer one: not reported", [found(0.5, 0.95 * CS)[1], found(0.5, 1.5 * CS)[1]], [False, False])
    case.check("between free-field sides, out of a half space of rock", found(0.5, CS / 2, sides=True, half_space="rock")[0], 1.0, relative=3e-3)
    for keys, words in (({"half_space": "roc"}, "supports.bottom: the mesh has no group 'roc'"), ({"half_space": "rock", "boundary": "fixed", "input": "outcrop"}, "it is for boundary: quiet")):
        refused = ran(0.5, CS / 2, False, keys)
        case.check(f"half_space refused: {words}", [refused.exit_code, words in refused.stderr], [2, True])


def reflection(case):
    """VS03: the end of a mesh lets a wave of 10, 20 elements a length out but for tan^2(k h / 4) of it."""
    for n, wanted in ((10, np.tan(np.pi / 20) ** 2), (20, np.tan(np.pi / 40) ** 2)):
        h, length = 1.0, n * 1.0
        f, cycles, height = CS / length, 8, 16 * length
        t = np.linspace(0, cycles / f, 40 * cycles + 1)
        burst = PULSE * np.sin(2 * np.pi * f * t) * np.sin(np.pi * t * f / cycles) ** 2
        mesh = rectangle(0, 0, 1, height, 1, round(height / h), group="ground")
        mesh.points["middle"] = int(np.argmin(abs(mesh.vertices - [0, height / 2]).sum(axis=1)))
        # the wave goes up, comes back from the free top, and of that the base sends a part up again
        result = shaken(case, mesh, rows(t, burst), ("supports.bottom.input", "incident"),
                        ("stages", [{"shake": SCENE["stages"][0]["shake"] | {"duration": float((cycles + 50) / f), "dt_factor": 0.2}}]))
        time, v = velocity(result, "middle")
        arrivals = [height / 2 / CS + k * height / CS for k in (0, 2)]
        up = [abs(v[(time > a) & (time < a + cycles / f)]).max() for a in arrivals]
        case.check(f"{n} elements a wave: the end sends back, of what comes", up[1] / up[0], wanted, relative=0.1)


def static_start(case):
    """VS04: weight, then time: nothing moves; after the shaking the ground holds again."""
    weight = {"w": {"type": "self_weight"}}
    base = {"bottom": {"fix": "xy", "boundary": "quiet"}, "level": {"target": "ground", "fix": "x"}}
    keys = [("supports", base), ("loads", weight), ("relaxation", {"tolerance": 1e-12, "history_every": 1})]
    mesh = rectangle(0, 0, 1, HEIGHT, 1, 100, group="ground")
    still = shaken(case, mesh, "", *keys, ("stages", [{"rest": {"loads": ["w"]}}, {"shake": {"type": "dynamic", "loads": ["w"], "duration": 2.0, "dt_factor": 0.9}}, {"after": {"loads": ["w"]}}]))
    u = still.history["top_left_uy_m"][still.history["stage"] == "shake"] if "stage" in still.history else still.history["top_left_uy_m"]
    case.check("weight, then 2 s without a wave: the top moves by [m]", abs(np.asarray(u[-100:]) - still.probe("rest", "top_left")[1]).max(), 0.0, absolute=2e-10)
    sums = [still.stage_summary(s)["supports"]["bottom"] for s in ("rest", "after")]
    case.check("... reaction of the base before and after [N]", [s["y"] for s in sums], [RHO * 9.81 * HEIGHT] * 2, relative=1e-9)
    wave = dict(base, bottom=base["bottom"] | {"motion": "wave.csv", "input": "incident"})
    shaken_ = shaken(case, mesh, rows(TIMES, 0 * TIMES, bell(TIMES)), *keys, ("supports", wave), ("stages", [{"rest": {"loads": ["w"]}}, {"shake": {"type": "dynamic", "loads": ["w"], "duration": 0.6, "dt_factor": 0.9}}, {"after": {"loads": ["w"]}}]))
    moved = [shaken_.probe(s, "bottom_left")[1] for s in ("rest", "shake", "after")]
    case.check("a wave: the base has risen by [m], and is held there", [moved[1] - moved[0], moved[2] - moved[1]], [0.02, 0.0], absolute=1e-6)
    case.check("... reaction of the base after it [N]", shaken_.stage_summary("after")["supports"]["bottom"]["y"], RHO * 9.81 * HEIGHT, relative=1e-6)


def order_of_loads(case):
    """The loads of the stage before, named in another order, are the same loads; others are refused."""
    keys = [("supports.bottom", {"fix": "xy", "boundary": "quiet"}), ("loads", {"w": {"type": "self_weight"}, "p": {"type": "traction", "faces": "top", "value": [0, -1e5]}})]
    shake = SCENE["stages"][0]["shake"] | {"duration": 0.01}
    codes = [shaken(case, rectangle(0, 0, 1, 10, 1, 10, group="ground"), "", *keys, ("stages", [{"rest": {"loads": before}}, {"shake": shake | {"loads": loads}}])).exit_code
             for before, loads in ((["w", "p"], ["p", "w"]), (["w"], ["p", "w"]), (["w", "p"], ["w"]))]
    case.check("loads in another order, one more, one less: exit codes", codes, [0, 2, 2])
    above = renamed(rectangle(0, 10, 1, 2, group="ground"), {"lake": "left", "end": "right"})
    lake = {"r": {"type": "head", "faces": "lake", "level": 12, "levels": "wave.csv"}, "e": {"type": "head", "faces": "end", "level": 10}}
    drawdown = {"drawdown": {"type": "transient", "loads": ["r", "e"], "duration": 100, "time_step": 50}}
    drawn = [shaken(case, join([rectangle(0, 0, 1, 10, 1, 10, group="ground"), above]), "0, 12\n100, 11\n", keys[0], ("loads", lake), ("joints", {"default": SCENE["joints"]["default"] | {"aperture": 2e-4, "aperture_residual": 1e-5}}),
                    ("stages", [{"rest": {"loads": ["r", "e"]}}, drawdown, *between, {"shake": shake | {"loads": ["r", "e"]}}])) for between in ([], [{"held": {"loads": ["r", "e"]}}])]
    case.check("behind a drawdown, which ends at another level; with a static stage between: exit codes", [run.exit_code for run in drawn], [2, 0])
    case.check("... it says so", "expected a static stage between them" in drawn[0].stderr, True)


def damped(case):
    """Damping by mass holds against free ground: low ground that rides on a long wave is not dragged."""
    t = np.linspace(0, 2, 201)
    for kind, factor in (("incident", 1), ("outcrop", 2)):
        result = shaken(case, rectangle(0, 0, 2, 10, 1, 5, group="ground"), rows(t, factor * PULSE * np.sin(np.pi * t / 2) ** 2), ("supports.bottom.input", kind),
                        ("stages", [{"shake": SCENE["stages"][0]["shake"] | {"duration": 3.0, "alpha": 1.5}}]))
        ends = [result.history[f"{p}_ux_m"][-1] for p in ("bottom_left", "top_left")]
        case.check(f"low ground on a wave of 2 s, alpha 1.5, {kind}: base and top end at [m]", ends, [2 * PULSE] * 2, relative=1e-5)


def ranks(case):
    mesh, text = rectangle(0, 0, 4, 40, 4, 40, group="ground"), rows(TIMES, bell(TIMES), 0.5 * bell(TIMES))
    keys = [("supports.level", {"target": "top_left", "fix": "x"}), ("relaxation.history_every", 50), ("stages", [{"shake": SCENE["stages"][0]["shake"] | {"duration": 0.1}}])]
    sums = {shaken(case, mesh, text, *keys, ranks=n).stage_summary("shake")["checksum"] for n in case.ranks(1, 2, 3, 4)}
    case.check("strip with waves in x and y: checksums on 1 to 4 ranks", len(sums), 1)


def restart(case):
    mesh, text = rectangle(0, 0, 4, 40, 2, 20, group="ground"), rows(TIMES, bell(TIMES), 0.5 * bell(TIMES))
    keys = [("supports.level", {"target": "top_left", "fix": "x"}), ("checkpoint", {"every": 150, "keep": 100}), ("relaxation.history_every", 50), ("loads", {"w": {"type": "self_weight"}}),
            ("stages", [{"rest": {"loads": ["w"]}}, {"shake": {"type": "dynamic", "loads": ["w"], "duration": 0.3, "dt_factor": 0.9}}, {"after": {"loads": ["w"]}}])]
    folder = case.prepare(mesh, changed(SCENE, *keys))
    (folder / "wave.csv").write_text(text)
    whole = case.again(folder)
    case.again(folder, "-output", "kept")
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    same = []
    for number, file in enumerate(files):
        again = case.again(folder, "-restart", file, ranks=2 if number % 3 == 0 else 1)
        same.append([again.stage_summary(s)["checksum"] == whole.stage_summary(s)["checksum"] for s in ("shake", "after")])
        same[-1].append(again.stage_summary("shake")["energy"]["radiated"] == whole.stage_summary("shake")["energy"]["radiated"] or number % 3 == 0)
    case.check("restart from each checkpoint, on 1 and 2 ranks: same bits", [len(files) > 3, bool(np.all(same))], [True, True])
