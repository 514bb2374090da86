"""Water that moves with a dam: periods of rigid and elastic dams, their masses of water, a wet block that is shaken and slides."""

import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.dam import G1, dam_part
from quoin_tools.mesh.meshing import face_set_on, join, quad_patch, rectangle, renamed, split_triangles, vertex_at
from triangle_dam import DAMS

WHAT = "added mass: periods of rigid and elastic dams with water, also on ground that lets waves out; a wet block that slides in an earthquake; energy, ranks, restart"
SOURCE = "rigid body on a joint (eigenvalues of 3x3, water integrated again); independent finite elements of elastic dams; Newmark's integration of a block that slides and rocks"
BY = "by hand; independent finite elements and Newmark integration of this project"

G, RHO = 9.81, 1000.0
C_M = 0.7412  # of Zangar's vertical wall


LONG = ("elastic_dams", "earthquake")  # parts that the short form leaves out


def run(case):
    rigid_block(case)
    elastic_dams(case)
    on_ground(case)
    earthquake(case)
    held(case)
    static_stages(case)
    ranks(case)
    restart(case)


# ---- periods from histories

def shake(result, probe="top_right"):
    """Time and displacements of a probe in the dynamic stage, at equal steps: the row of its first step is left out."""
    rows = np.flatnonzero(result.history["stage"] == "shake")[1:]
    u = np.column_stack([result.history[f"{probe}_u{x}_m"][rows] for x in "xy"])
    return result.history["time_s"][rows], u


def poles(t, u, n, step):
    """The n complex s [1/s] of a sum of exp(s t), by their invariance under a shift of `step`; oscillations only, by frequency."""
    every = max(1, round(step / (t[1] - t[0])))
    u = u[::every]
    hankel = np.lib.stride_tricks.sliding_window_view(u, len(u) // 2)
    vectors = np.linalg.svd(hankel, full_matrices=False)[0][:, :n]
    s = np.log(np.linalg.eigvals(np.linalg.lstsq(vectors[:-1], vectors[1:], rcond=None)[0]).astype(complex)) / (every * (t[1] - t[0]))
    return sorted(s[s.imag > 1e-6], key=lambda x: x.imag)


def hertz(s):
    return np.imag(s) / (2 * np.pi)


def peaks(t, u, n):
    """The lowest n frequencies [Hz] of a swing of many, from its spectrum."""
    window = np.hanning(len(u))
    size = np.log(abs(np.fft.rfft((u - u.mean()) * window)) + 1e-300)
    top = [k for k in range(2, len(size) - 2) if size[k] == size[k - 2:k + 3].max() and size[k] > size.max() - 9.0][:n]
    shift = [0.5 * (size[k - 1] - size[k + 1]) / (size[k - 1] - 2 * size[k] + size[k + 1]) for k in top]
    return (np.array(top) + shift) / (len(u) * (t[1] - t[0]))


# ---- a rigid block on an elastic joint

WIDTH, HEIGHT = 20.0, 30.0
ELASTIC = {
    "strain": "small", "relaxation": {"history_every": 1},
    "materials": {"dam": {"density": 2400, "rigid": True, "velocity": [0.1, 0.05]}, "base": {"density": 2400, "rigid": True}},
    "joints": {"default": {"law": "elastic", "k_n": 10e9, "k_s": 3e9}}, "supports": {"base": {"fix": "xy"}},
    "loads": {"hydro": {"type": "added_mass", "faces": "upstream", "level": HEIGHT}},
    "stages": [{"shake": {"type": "dynamic", "loads": ["hydro"], "duration": 1.0, "dt_factor": 0.1}}],
}  # fmt: skip


def block(width, height, n, lean=0.0):
    """A rigid block on a base, n contacts between them; its upstream face leans by so many degrees."""
    base = renamed(rectangle(0, -5, width, 5, n, 1, group="base", rigid=True), {}, {"foot": "top_left"})
    crest = height * np.tan(np.radians(lean))
    dam = quad_patch((0, 0), (width, 0), (width, height), (crest, height), n, 1, group="dam", rigid=True)
    return join([base, renamed(dam, {"upstream": "left", "crest": "top"}, {"heel": "bottom_left", "top_right": "top_right"})])


def at_rest(lean=0.0, rule=None):
    """Mass, added mass and stiffness (3x3) of the block about its mass centre, the water integrated again."""
    theta = np.radians(lean)
    crest, n = HEIGHT * np.tan(theta), 200000
    area, cut = WIDTH * HEIGHT, crest * HEIGHT / 2  # a rectangle less a triangle
    xc, yc = (area * WIDTH / 2 - cut * crest / 3) / (area - cut), (area * HEIGHT / 2 - cut * 2 * HEIGHT / 3) / (area - cut)
    polar = area * ((WIDTH**2 + HEIGHT**2) / 12 + (WIDTH / 2 - xc)**2 + (HEIGHT / 2 - yc)**2)
    polar -= cut * ((crest**2 + HEIGHT**2) / 18 + (crest / 3 - xc)**2 + (2 * HEIGHT / 3 - yc)**2)
    m = 2400 * (area - cut)
    water = np.zeros((3, 3))
    s = ((np.arange(n) + 0.5) / n)**2  # finer at the surface
    zangar = (C_M - 0.0073 * lean) / 2 * (s * (2 - s) + np.sqrt(s * (2 - s))) / np.cos(theta)
    q = {"westergaard": 7 / 8 * np.sqrt(s), "zangar": zangar}.get(rule, 0 * s)
    weight = RHO * HEIGHT * q * 2 * np.sqrt(s) / n * HEIGHT / np.cos(theta)
    y = HEIGHT * (1 - s)
    normal = np.array([-np.cos(theta) + 0 * s, np.sin(theta) + 0 * s])
    moves = np.array([normal[0], normal[1], normal[1] * (y * np.tan(theta) - xc) - normal[0] * (y - yc)])
    water += np.einsum("k,ik,jk->ij", weight, moves, moves)
    k_n, k_s, arm = 10e9 * WIDTH, 3e9 * WIDTH, WIDTH / 2 - xc
    stiffness = np.array([[k_s, 0, k_s * yc], [0, k_n, k_n * arm], [k_s * yc, k_n * arm, k_s * yc**2 + k_n * arm**2 + k_n * WIDTH**2 / 12]])
    return np.diag([m, m, 2400 * polar]), water, stiffness


def roots(mass, damping, stiffness):
    """s [1/s] of mass s^2 + damping s + stiffness, upper half plane, by frequency."""
    inverse, one = np.linalg.inv(mass), np.eye(3)
    s = np.linalg.eigvals(np.block([[np.zeros((3, 3)), one], [-inverse @ stiffness, -inverse @ damping]]))
    return sorted(s[s.imag > 0], key=lambda x: x.imag)


def rigid_block(case):
    """VS11, and faces that lean: three frequencies, the masses in the summary, what does not change."""
    dry = case.run(block(WIDTH, HEIGHT, 40), changed(ELASTIC, ("stages", [{"shake": swing(loads=[])}])))
    for lean, rule, alpha in ((0, None, 0), (0, "westergaard", 0), (0, "westergaard", 10), (0, "zangar", 0), (20, "westergaard", 0), (20, "zangar", 0)):
        keys = [("loads.hydro.rule", rule or "westergaard"), ("stages", [{"shake": swing(alpha=alpha, loads=["hydro"] if rule else [])}])]
        result = case.run(block(WIDTH, HEIGHT, 40, lean), changed(ELASTIC, *keys))
        mass, water, stiffness = at_rest(lean, rule)
        expected = np.array(roots(mass + water, alpha * mass, stiffness))
        t, u = shake(result)
        found = np.array(poles(t, u.sum(axis=1), 6, 0.003))
        what = f"rigid block, {rule or 'dry'}" + (f", face leans by {lean} degrees" if lean else "") + (f", alpha {alpha}" if alpha else "")
        case.check(f"{what}: frequencies [Hz]", hertz(found), hertz(expected), relative=1e-4)
        if alpha:
            case.check("... decay: alpha damps the block, not the water [1/s]", found.real, expected.real, relative=1e-4)
        s = result.stage_summary("shake")
        energy = s["energy"]
        case.check("... energy balance over the energy", energy["balance"] / (energy["kinetic"] + energy["joints"] + energy["damping"]), 0.0, absolute=1e-9)
        if rule:
            facts = s["added_mass"]["hydro"]
            case.check("... mass along x, along y [kg]", [facts["mass_x"], facts["mass_y"]], [water[0, 0], water[1, 1]], absolute=1e-8 * water[0, 0])
        if not lean and rule:
            case.check("... time step over that without water", s["dt"] / dry.stage_summary("shake")["dt"], 1.0)
    case.check("... elevation of the mass, vertical face [m]", s_of(case, 0, "westergaard")["elevation"], 0.4 * HEIGHT, relative=1e-12)
    case.check("... its mass [kg]", s_of(case, 0, "westergaard")["mass_x"], 7 / 12 * RHO * HEIGHT**2, relative=1e-12)
    upwards = changed(ELASTIC, ("materials.dam.velocity", [0.0, 0.1]))
    u = [shake(case.run(block(WIDTH, HEIGHT, 40), changed(upwards, ("stages", [{"shake": swing(loads=loads)}]))))[1] for loads in (["hydro"], [])]
    case.check("vertical face, vertical motion: as without water, over the largest", abs(u[0] - u[1]).max() / abs(u[1]).max(), 0.0, absolute=1e-9)
    exact = {0: 0.5427, 15: 0.4552, 30: 0.3744, 45: 0.2947}  # of potential flow
    for rule, worst in (("zangar", 0.025), ("westergaard", 0.41)):
        ours = [s_of(case, lean, rule)["mass_x"] / (RHO * HEIGHT**2) for lean in exact]
        case.check(f"{rule}, faces that lean by 0, 15, 30, 45 degrees: mass along x over that of potential flow, less 1, at most", max(a / b for a, b in zip(ours, exact.values(), strict=True)) - 1, worst, absolute=0.02)
    warnings = {lean: case.run(block(WIDTH * 2, HEIGHT, 4, lean), few()).stderr for lean in (14, 16, 30)}
    words = {lean: text.split("westergaard gives ")[1][:4] if text else "" for lean, text in warnings.items()}
    case.check("westergaard, faces that lean by 14, 16, 30 degrees: reported to be too much by", words, {14: "", 16: "24 %", 30: "35 %"})


def swing(**keys):
    return ELASTIC["stages"][0]["shake"] | keys


def few(**keys):
    """The block for a moment."""
    return changed(ELASTIC, ("loads.hydro", ELASTIC["loads"]["hydro"] | keys), ("stages", [{"shake": swing(duration=1e-3)}]))


def s_of(case, lean, rule):
    """What the summary says of the water at a face."""
    return case.run(block(WIDTH * 2, HEIGHT, 4, lean), few(rule=rule)).stage_summary("shake")["added_mass"]["hydro"]


# ---- elastic dams on a fixed base

def elastic(young, level, force):
    """A dam that is let go from a push at its crest."""
    return {
        "strain": "small", "relaxation": {"history_every": 4, "tolerance": 1e-8},
        "materials": {"dam": {"density": 2400, "young": young, "poisson": 0.2}},
        "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}}, "supports": {"bottom": {"fix": "xy"}},
        "loads": {"push": {"type": "point_force", "point": "crest", "value": force}, "hydro": {"type": "added_mass", "faces": "left", "level": level}},
        "stages": [{"push": {"loads": ["push"]}}, {"shake": {"type": "dynamic", "loads": ["hydro"], "duration": 6.0, "dt_factor": 0.5}}],
    }  # fmt: skip


def triangle(n):
    """The dam of figure 6: its heel at (0, 0), 80 m wide, 100 m high."""
    vertices, quads, triangles = DAMS["M"](n)
    triangles = np.column_stack([np.reshape(triangles, (-1, 3)), np.full(len(triangles), -1)])
    blocks = np.concatenate([np.reshape(quads, (-1, 4)), triangles])
    mesh = BlockMesh(np.asarray(vertices, dtype=float), blocks, np.zeros(len(blocks), int), ["dam"], [0], {}, {})
    mesh.face_sets = {"bottom": face_set_on(mesh, (0, 0), (80, 0)), "left": face_set_on(mesh, (0, 0), (0, 100))}
    mesh.points = {"crest": vertex_at(mesh, 0, 100)}
    return mesh


def battered(n=16):
    mesh = quad_patch((0, 0), (80, 0), (28, 100), (20, 100), n, n, group="dam")
    mesh.points = {"crest": mesh.points["top_left"]}
    return mesh


def section_g1():
    """Section G1, 12 x (20 + 4)."""
    mesh = dam_part(G1, 12, (20, 4))
    heel, toe, _, _, left = G1.corners()
    mesh.face_sets = {"bottom": face_set_on(mesh, heel, toe), "left": face_set_on(mesh, heel, left)}
    mesh.points = {"crest": vertex_at(mesh, *left)}
    return mesh


def elastic_dams(case):
    """VS12: f1, f2, f3 without water and with."""
    for what, mesh, young, level, force, dry, wet in (
            ("triangle", triangle(16), 30e9, 100, [1e6, 2e6], (4.9159, 11.1635, 12.9404), (3.5386, 8.1289, 12.6064)),
            ("battered dam", battered(), 30e9, 100, [1e6, 1e6], (4.8175, 11.3653, 12.2616), (3.8744, 9.1494, 12.0504)),
            ("section G1", section_g1(), 10e9, 33, [1e6, 1e6], (7.3908, 18.1025, 21.2733), (5.8220, 14.3611, 21.0673))):
        for loads, expected in (([], dry), (["hydro"], wet)):
            scene = elastic(young, level, force)
            scene["stages"][1]["shake"]["loads"] = loads
            result = case.run(mesh, scene)
            t, u = shake(result, "crest")
            case.check(f"{what}, {'wet' if loads else 'dry'}: three frequencies [Hz]", peaks(t, u[:, 0], 3), expected, relative=2e-3)
            energy = result.stage_summary("shake")["energy"]
            case.check("... energy balance over the energy", energy["balance"] / (energy["kinetic"] + energy["strain"]), 0.0, absolute=1e-11)
    case.check("section G1: mass along x [kg]", result.stage_summary("shake")["added_mass"]["hydro"]["mass_x"], 6.3446e5, relative=1e-5)


def dam_on_rock():
    """A trapezoid on a box of rock, one body."""
    parts = [rectangle(-60, -60, 160, 60, 32, 12, group="rock"), quad_patch((0, 0), (40, 0), (5, 50), (0, 50), 8, 10, group="dam")]
    vertices = np.concatenate([part.vertices for part in parts])
    _, first, same = np.unique(np.round(vertices, 6), axis=0, return_index=True, return_inverse=True)
    blocks = same.ravel()[np.concatenate([parts[0].blocks, parts[1].blocks + len(parts[0].vertices)])]
    mesh = BlockMesh(vertices[first], blocks, np.repeat([0, 1], [len(part.blocks) for part in parts]), ["rock", "dam"], [0, 0], {}, {})
    mesh.face_sets = {name: face_set_on(mesh, a, b) for name, a, b in (("bottom", (-60, -60), (100, -60)), ("left", (-60, -60), (-60, 0)),
                                                                       ("right", (100, -60), (100, 0)), ("upstream", (0, 0), (0, 50)))}  # fmt: skip
    mesh.points = {"crest": vertex_at(mesh, 0, 50)}
    return mesh


def on_rock(rock, loads, duration=2.0):
    material = {"density": 2600, "young": rock, "poisson": 0.2}
    return {
        "strain": "small", "relaxation": {"history_every": 4},
        "materials": {"rock": material, "dam": material | {"density": 2400, "young": 20e9, "velocity": [0.1, 0.0]}},
        "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}}, "supports": {side: {"fix": "xy", "boundary": "quiet"} for side in ("bottom", "left", "right")},
        "loads": {"hydro": {"type": "added_mass", "faces": "upstream", "level": 48}},
        "stages": [{"shake": {"type": "dynamic", "loads": loads, "duration": duration, "dt_factor": 0.5}}],
    }  # fmt: skip


def on_ground(case):
    """VS13: a dam on rock whose outer faces let waves out: complex mode of the dam, from its decay."""
    for rock, loads, expected in ((20e9, [], (5.4281, 0.0795)), (20e9, ["hydro"], (4.4724, 0.0834)), (60e9, [], (6.4075, 0.0362)), (60e9, ["hydro"], (5.2769, 0.0410))):
        result = case.run(dam_on_rock(), on_rock(rock, loads))
        t, u = shake(result, "crest")
        late = t > 0.15
        mode = min(poles(t[late], u[late, 0], 10, 0.02), key=lambda s: abs(hertz(s) - expected[0]))
        case.check(f"dam on rock of {rock / 1e9:.0f} GPa, {'wet' if loads else 'dry'}: frequency [Hz]", abs(mode) / (2 * np.pi), expected[0], relative=2e-3)
        case.check("... damping ratio", -mode.real / abs(mode), expected[1], absolute=5e-4)
        energy = result.stage_summary("shake")["energy"]
        case.check("... energy balance over what went out", energy["balance"] / energy["radiated"], 0.0, absolute=1e-11)


# ---- a wet block that is shaken

def quake(scale):
    """Rows of an earthquake of 12 s, t, x, y: five sines in a bell, closed so that velocity and displacement end at zero."""
    t = np.round(np.arange(0, 12.005, 0.01), 10)
    bell = np.sin(np.pi * t / 12)**2
    sines = zip((0.10, 0.14, 0.12, 0.08, 0.05), (0.8, 1.7, 2.9, 4.3, 6.1), (0.0, 1.1, 2.3, 0.7, 4.0), strict=True)
    a = bell * G * sum(A * np.sin(2 * np.pi * f * t + p) for A, f, p in sines)
    c = np.linalg.solve(np.column_stack([ends(t, bell), ends(t, bell * t)]), ends(t, a))
    a = scale * (a - bell * (c[0] + c[1] * t))
    return "".join(f"{x:.2f}, {y:.12e}, 0\n" for x, y in zip(t, a, strict=True))


def ends(t, a):
    """Velocity and displacement at the end of a piecewise linear acceleration."""
    h = np.diff(t)
    v = np.concatenate([[0.0], np.cumsum(h * (a[1:] + a[:-1]) / 2)])
    return np.array([v[-1], (v[:-1] * h + h * h * (2 * a[:-1] + a[1:]) / 6).sum()])


SHAKEN = {
    "strain": "small", "relaxation": {"history_every": 200},
    "materials": {"dam": {"density": 2400, "rigid": True}, "base": {"density": 2400, "rigid": True}},
    "joints": {"default": {"k_n": 50e9, "k_s": 20e9, "friction": 25, "damping": 2e-4}},
    "supports": {"base": {"fix": "xy", "motion": "quake.csv", "quantity": "acceleration"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": HEIGHT},
              "hydro": {"type": "added_mass", "faces": "upstream", "level": HEIGHT}},
    "stages": [{"full": {"loads": ["weight", "water"]}},
               {"shake": {"type": "dynamic", "loads": ["weight", "water", "hydro"], "duration": 12.5, "dt_factor": 0.1}}],
}  # fmt: skip


def shaken(case, scale, *changes, n=40, ranks=1):
    folder = case.prepare(block(40.0, HEIGHT, n), changed(SHAKEN, *changes))
    (folder / "quake.csv").write_text(quake(scale))
    return case.again(folder, ranks=ranks)


def slipped(result):
    """Final slip of the heel downstream [m]."""
    moved = [result.probe("shake", p)[0] - result.probe("full", p)[0] for p in ("heel", "foot")]
    return moved[0] - moved[1]


def earthquake(case):
    """VS10: slip downstream; what comes of leaving the water out."""
    dry = [SHAKEN["stages"][0], {"shake": SHAKEN["stages"][1]["shake"] | {"loads": ["weight", "water"]}}]
    for scale, expected in ((1.0, 4.08), (1.5, 38.17)):
        result = shaken(case, scale)
        case.check(f"wet block, record x {scale}: slip [mm]", 1e3 * slipped(result), expected, relative=0.05)
        energy = result.stage_summary("shake")["energy"]
        case.check("... energy balance over the work of the ground", energy["balance"] / energy["supports"], 0.0, absolute=1e-10)
    without = 1e3 * slipped(shaken(case, 1.5, ("stages", dry)))
    case.check("... without the water's inertia, rigid and plastic: 19.7 [mm]", without, 19.7, relative=0.05)
    for what, changes in (("large strain", [("strain", "large")]), ("large strain, contacts found again", [("strain", "large"), ("contact", {"connectivity": "variable"})])):
        case.check(f"wet block, record x 1.5, {what}: slip [mm]", 1e3 * slipped(shaken(case, 1.5, *changes)), 38.17, relative=0.05)


def moved(case, mesh, text, scene, ranks=1):
    folder = case.prepare(mesh, scene)
    (folder / "move.csv").write_text(text)
    return case.again(folder, ranks=ranks)


def push(t):
    """Velocity [m/s] of a base that goes 0.05 m."""
    return "".join(f"{a:.9g}, {0.1 * np.sin(np.pi * a)**2:.17g}, {0.04 * np.sin(np.pi * a)**2:.17g}\n" for a in t)


def on_moving_base(level=100, **keys):
    scene = elastic(30e9, level, [0, 0])
    scene["supports"]["bottom"]["motion"] = "move.csv"
    scene["stages"] = [{"shake": scene["stages"][1]["shake"] | {"duration": 0.6, "loads": ["hydro"]} | keys}]
    return scene


def held(case):
    """Supports that move hold wet vertices: they have to move the water there too."""
    text = push(np.linspace(0, 1, 501))
    result = moved(case, battered(), text, on_moving_base())
    energy = result.stage_summary("shake")["energy"]
    case.check("battered dam on a base that moves: energy balance over the work of the base", energy["balance"] / energy["supports"], 0.0, absolute=1e-10)
    scene = changed(on_moving_base(level=80, dt_factor=1e-4), ("supports.bottom.target", "dam"))  # nothing sets the step
    s = moved(case, battered(), text, scene).stage_summary("shake")
    energy = s["energy"]
    case.check("every vertex held and moved: work of the support less that of the water [J]", energy["supports"] - energy["kinetic"], 0.0, absolute=1e-6 * energy["kinetic"])
    case.check("... kinetic energy of the water over all", s["kinetic_water"] / energy["kinetic"], 1.0, relative=1e-12)
    sine, cosine = 20 / np.hypot(100, 20), 100 / np.hypot(100, 20)
    v = np.array([0.1, 0.04]) * np.sin(np.pi * 0.6)**2
    normal = v @ [-cosine, sine]
    case.check("... which is [J]", energy["kinetic"], 0.5 * 7 / 12 * RHO * 80**2 / cosine * normal**2, relative=1e-3)


def static_stages(case):
    """Static stages may list it; ground that lets waves out asks for the same forces before and after, with or without it."""
    mesh = dam_on_rock()
    scene = on_rock(20e9, [], duration=0.02)
    scene["relaxation"] = {"tolerance": 1e-6}
    scene["materials"]["dam"].pop("velocity")
    scene["loads"]["water"] = {"type": "reservoir", "faces": "upstream", "level": 48}
    sums = set()
    for before, during in ((["water", "hydro"], ["water", "hydro"]), (["water"], ["hydro", "water"])):
        stages = [{"still": {"loads": before}}, {"shake": scene["stages"][0]["shake"] | {"loads": during}}, {"after": {"loads": before}}]
        result = case.run(mesh, changed(scene, ("stages", stages)))
        told = [line for line in result.stdout.splitlines() if "added_mass" in line]
        case.check(f"static stages with {', '.join(before)}: exit code, warnings", [result.exit_code, len(told)], [0, int("hydro" in before)])
        sums.add(result.stage_summary("still")["checksum"])
    case.check("... checksums of the static stage with it and without", len(sums), 1)


def ranks(case):
    text = push(np.linspace(0, 1, 501))
    large = changed(on_moving_base(duration=0.02), ("strain", "large"))
    for what, mesh in (("", battered()), (", triangles", split_triangles(battered()))):
        results = [moved(case, mesh, text, large, ranks=n) for n in case.ranks(1, 2, 3, 4)]
        case.check(f"elastic dam on a base that moves, large strain{what}: checksums on 1 to 4 ranks", len({r.stage_summary("shake")["checksum"] for r in results}), 1)
        energy = results[-1].stage_summary("shake")["energy"]
        case.check("... energy balance over the work of the base", energy["balance"] / energy["supports"], 0.0, absolute=1e-8)
    short = [SHAKEN["stages"][0], {"shake": SHAKEN["stages"][1]["shake"] | {"duration": 0.2}}]
    parted = join([block(40.0, HEIGHT, 4), renamed(rectangle(60, -5, 5, 5, 2, 2, group="base", rigid=True), {}, {})])
    sums = set()
    for n in case.ranks(1, 2, 3, 4):
        folder = case.prepare(parted, changed(SHAKEN, ("stages", short)))
        (folder / "quake.csv").write_text(quake(1.0))
        sums.add(case.again(folder, ranks=n).stage_summary("shake")["checksum"])
    case.check("rigid block: checksums on 1 to 4 ranks", len(sums), 1)


def restart(case):
    """From each checkpoint of a run with two stages after the shaking."""
    stages = [SHAKEN["stages"][0], {"shake": SHAKEN["stages"][1]["shake"] | {"duration": 0.4, "dt_factor": 0.5}}, {"after": {"loads": ["weight", "water"]}}]
    folder = case.prepare(block(40.0, HEIGHT, 8), changed(SHAKEN, ("stages", stages), ("checkpoint", {"every": 400, "keep": 100})))
    (folder / "quake.csv").write_text(quake(1.5))
    whole = case.again(folder)
    case.again(folder, "-output", "kept")
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    same = []
    for number, file in enumerate(files[-6:]):
        again = case.again(folder, "-restart", file, ranks=2 if number % 3 == 0 else 1)
        same += [again.stage_summary(s)["checksum"] == whole.stage_summary(s)["checksum"] for s in ("shake", "after")]
    case.check("restart in the middle, on 1 and 2 ranks: same bits", [len(files) > 3, all(same)], [True, True])
