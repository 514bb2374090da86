"""Periods and shapes of small free vibrations: stages of type modes, without water and with."""

import h5py
import numpy as np
from driver import changed, load
from quoin_tools.mesh.meshing import join, rectangle, renamed, split_triangles

WHAT = "modes: rigid blocks, elastic dams, columns, stones, free bodies, open joints, bodies that lean under their weight; what runs beside them keeps its bits"
SOURCE = "rigid bodies on joints by hand; chains of masses and springs in closed form; independent finite elements of elastic dams; free vibrations in time"
BY = "by hand; independent finite elements of this project; Quoin itself in time"

BODIES = load("added_mass")  # its meshes, and frequencies of what swings in time
G = 9.81


LONG = ("in_time",)  # parts that the short form leaves out


def run(case):
    dams(case)
    rigid_block(case)
    in_time(case)
    shear_column(case)
    stones(case)
    anchored(case)
    floating(case)
    open_base(case)
    leaning(case)
    untouched(case)
    what_is_told(case)
    ranks(case)


def modes_of(result, stage):
    return result.stage_summary(stage)["modes"]


def hertz(result, stage, n=None):
    return np.array([mode["f"] for mode in modes_of(result, stage)["list"]][:n])


def by_hand(mass, stiffness):
    """Frequencies [Hz] and shapes (columns, mass-normalised), the slowest first."""
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares, vectors = np.linalg.eigh(root @ stiffness @ root.T)
    return np.sqrt(np.maximum(squares, 0)) / (2 * np.pi), root.T @ vectors


# ---- elastic dams, against independent finite elements

def swinging(young, level, *stages):
    return changed(BODIES.elastic(young, level, [1e6, 1e6]), ("stages", list(stages)))


def dams(case):
    """VS12: dry, and wet, where the reference has the water as a matrix of each face, ours its lumped sum at vertices."""
    for what, mesh, young, level, dry, wet in (
            ("triangle", BODIES.triangle(16), 30e9, 100, (4.9159, 11.1635, 12.9404), (3.5386, 8.1289, 12.6064)),
            ("battered dam", BODIES.battered(), 30e9, 100, (4.8175, 11.3653, 12.2616), (3.8744, 9.1494, 12.0504)),
            ("section G1", BODIES.section_g1(), 10e9, 33, (7.3908, 18.1025, 21.2733), (5.8220, 14.3611, 21.0673))):
        for strain in ("small", "large"):
            result = case.run(mesh, changed(swinging(young, level, {"dry": {"type": "modes"}}, {"wet": {"type": "modes", "loads": ["hydro"], "count": 3}}), ("strain", strain)))
            case.check(f"{what}, {strain} strain, dry: three frequencies [Hz]", hertz(result, "dry", 3), dry, relative=2e-5)
            case.check("... wet", hertz(result, "wet"), wet, relative=1e-3)
    facts = [modes_of(result, stage) for stage in ("dry", "wet")]
    foot = result.stage_summary("wet")["added_mass"]["hydro"]["mass_x"] + facts[0]["mass_x"] - facts[1]["mass_x"]
    case.check("section G1: part of the water's mass along x that the fixed foot holds", 0 < foot / 6.3446e5 < 0.04, True)
    every = case.run(BODIES.triangle(2), swinging(30e9, 100, {"all": {"type": "modes", "count": 1000, "loads": ["hydro"]}}))
    facts = modes_of(every, "all")
    case.check("small triangle: modes found, of those there are; parts of the mass in all of them", [len(facts["list"]), facts["sum_x"], facts["sum_y"]],
               [every.summary["n_dofs"] - 2 * 3, 1, 1], absolute=1e-9)
    above = hertz(every, "all")
    limited = case.run(BODIES.triangle(2), swinging(30e9, 100, *({f"up_to_{n}": {"type": "modes", "loads": ["hydro"], "up_to": float(0.5 * (above[n - 1] + above[n]))}} for n in (1, 5)),
                                                    {"two": {"type": "modes", "loads": ["hydro"], "up_to": float(above[5]), "count": 2}}, {"none": {"type": "modes", "up_to": 0.1}}))
    case.check("... up_to, up_to and count: how many", [len(modes_of(limited, s)["list"]) for s in ("up_to_1", "up_to_5", "two", "none")], [1, 5, 2, 0], absolute=0)


# ---- rigid bodies by hand

RIGID = {
    "strain": "small", "materials": {"dam": {"density": 2400, "rigid": True}, "base": {"density": 2400, "rigid": True}},
    "joints": {"default": {"law": "elastic", "k_n": 10e9, "k_s": 3e9}}, "supports": {"base": {"fix": "xy"}},
    "loads": {"hydro": {"type": "added_mass", "faces": "upstream", "level": BODIES.HEIGHT}},
    "stages": [{"dry": {"type": "modes"}}, {"wet": {"type": "modes", "loads": ["hydro"]}}],
}  # fmt: skip


def rigid_block(case):
    """VS11, and upstream faces that lean: the water couples all three degrees of freedom."""
    for lean, rule in ((0, "westergaard"), (20, "westergaard"), (20, "zangar")):
        result = case.run(BODIES.block(BODIES.WIDTH, BODIES.HEIGHT, 40, lean), changed(RIGID, ("loads.hydro.rule", rule)))
        for stage, of_water in (("dry", None), ("wet", rule)):
            mass, water, stiffness = BODIES.at_rest(lean, of_water)
            f, shapes = by_hand(mass + water, stiffness)
            what = f"rigid block, {of_water or 'dry'}" + (f", face leans by {lean} degrees" if lean else "")
            case.check(f"{what}: three frequencies [Hz]", hertz(result, stage), f, relative=2e-6)
            pull = shapes.T @ (mass + water)[:, :2]
            found = np.array([[mode["mass_x"], mode["mass_y"]] for mode in modes_of(result, stage)["list"]])
            case.check("... effective masses over the mass", found / mass[0, 0], pull**2 / mass[0, 0], absolute=1e-6)
        if not lean:
            case.check("... VS11, dry and wet [Hz]", np.concatenate([hertz(result, "dry"), hertz(result, "wet")]),
                       (16.8005, 59.3136, 63.6216, 15.0001, 55.0047, 59.3136), relative=1e-5)


def wall(n, width=2.0, height=1.5):
    base = rectangle(0, -1, width, 1, 1, 1, group="base", rigid=True)
    return join([base, *(renamed(rectangle(0, i * height, width, height, 1, 1, group="dam", rigid=True), {}, {}) for i in range(n))])


def stones(case):
    """A column of rigid stones on elastic joints: masses and springs assembled by hand, all modes, shapes too."""
    n, width, height, k_n, k_s = 6, 2.0, 1.5, 10e9, 3e9
    m, K = 2400 * width * height, np.zeros((3 * n, 3 * n))
    for i in range(n):
        B = np.zeros((3, 3 * n))  # opening, sliding, turning of the joint below stone i
        for stone, sign, arm in ((i, 1, -height / 2), (i - 1, -1, height / 2)):
            if stone >= 0:
                B[:, 3 * stone:3 * stone + 3] += sign * np.array([[0, 1, 0], [1, 0, -arm], [0, 0, 1]])
        K += B.T @ np.diag([k_n * width, k_s * width, k_n * width**3 / 12]) @ B
    M = np.diag(np.tile([m, m, m * (width**2 + height**2) / 12], n))
    f, shapes = by_hand(M, K)
    for strain in ("small", "large"):
        result = case.run(wall(n), changed(RIGID, ("strain", strain), ("loads", {}), ("stages", [{"all": {"type": "modes", "count": 3 * n}}])))
        case.check(f"column of {n} rigid stones, {strain} strain: all frequencies [Hz]", hertz(result, "all"), f, relative=1e-8)
    pull = shapes.T @ M @ np.tile(np.eye(3)[:, :2], (n, 1))
    found = np.array([[mode["mass_x"], mode["mass_y"]] for mode in modes_of(result, "all")["list"]])
    case.check("... effective masses over the mass", found / (n * m), pull**2 / (n * m), absolute=1e-8)
    corners = result.mesh.vertices
    stone = np.floor(result.mesh.centres()[:, 1] / height).astype(int)
    worst = 0.0
    for mode in range(3 * n):
        expected = np.zeros((len(corners), 2))
        for block, i in enumerate(stone):
            x, y, turn = shapes[3 * i:3 * i + 3, mode] if i >= 0 else (0, 0, 0)
            for v in result.mesh.blocks[block]:
                arm = corners[v] - [width / 2, (i + 0.5) * height]
                expected[v] = x - turn * arm[1], y + turn * arm[0]
        largest = abs(expected).max()
        first = expected.ravel()[np.argmax(abs(expected.ravel()) > (1 - 1e-6) * largest)]
        worst = max(worst, abs(result.stage("all").modes[mode] - expected / first).max())
    case.check("... shapes, the largest displacement 1 and positive", worst, 0.0, absolute=1e-6)


def anchored(case):
    """A rigid stone on its joint with bars to the base: an anchor is a spring along its line, at its head."""
    width, height, k_n, k_s = 2.0, 1.5, 10e9, 3e9
    m = 2400 * width * height
    joint = np.diag([k_s * width, k_n * width, k_n * width**3 / 12])
    below = np.array([[1, 0, height / 2], [0, 1, 0], [0, 0, 1]])  # sliding, opening, turning of the joint, of the centre's motion
    mass = np.diag([m, m, m * (width**2 + height**2) / 12])
    steel = {"area": 0.05, "young": 200e9, "compression": True}
    upright, leaning = ({"head": [x, 1.0], "root": [1.0, -0.5]} for x in (1.0, 1.7))
    for what, ends in (("none", []), ("one in the middle", [upright]), ("one that leans", [leaning]), ("both", [upright, leaning])):
        K = below.T @ joint @ below
        for end in ends:
            head, root = (np.array(end[name]) for name in ("head", "root"))
            along = (head - root) / np.linalg.norm(head - root)
            arm = head - [width / 2, height / 2]
            pull = np.array([*along, arm[0] * along[1] - arm[1] * along[0]])
            K += steel["area"] * steel["young"] / np.linalg.norm(head - root) * np.outer(pull, pull)
        f, _ = by_hand(mass, K)
        for strain in ("small", "large"):
            scene = changed(RIGID, ("strain", strain), ("loads", {"weight": {"type": "self_weight"}}),
                            ("stages", [{"under": {"loads": ["weight"]}}, {"rest": {"loads": []}}, {"all": {"type": "modes", "count": 3}}]),
                            ("anchors", {f"a{i}": steel | end for i, end in enumerate(ends)}))
            result = case.run(wall(1), scene)
            case.check(f"rigid stone, {strain} strain, anchors: {what}: three frequencies [Hz]", hertz(result, "all"), f, relative=1e-8)
    two = case.run(wall(1), scene, ranks=2)
    case.check("... on 2 ranks", hertz(two, "all"), hertz(result, "all"), relative=1e-12)


# ---- in closed form

def shear_column(case):
    """40 m high, c = 1000 m/s: f = c/4H, 3c/4H; upright motion is held. Blocks are a chain of masses and springs."""
    rho, c, height = 2000.0, 1000.0, 40.0
    exact = np.array([1, 3, 5]) * c / (4 * height)
    scene = {
        "strain": "small", "materials": {"body": {"density": rho, "young": 2.5 * rho * c**2, "poisson": 0.25}},
        "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}}, "loads": {},
        "supports": {"upright": {"fix": "y", "target": "body"}, "foot": {"fix": "xy", "target": "bottom"}}, "stages": [{"modes": {"type": "modes", "count": 3}}],
    }  # fmt: skip
    for what, cut in (("quadrilaterals", False), ("triangles", True)):
        errors = []
        for n in (10, 20, 40):
            mesh = rectangle(0, 0, 0.5, height, 1, n)
            f = hertz(case.run(split_triangles(mesh) if cut else mesh, scene), "modes")
            errors.append(abs(f / exact - 1))
            if not cut:
                chain = c * n / (np.pi * height) * np.sin(np.array([1, 3, 5]) * np.pi / (4 * n))
                case.check(f"shear column of {n} {what}: three frequencies of the chain [Hz]", f, chain, relative=1e-9)
        case.check(f"shear column of 40 {what}: three frequencies [Hz]", f, exact, relative=7e-3)
        case.check("... order of convergence of the first", np.log2(errors[1][0] / errors[2][0]), 2.0, absolute=0.05)


def floating(case):
    """Bodies that nothing holds: three motions each without stiffness, which have all the mass."""
    body, other = rectangle(0, 0, 4, 2, 8, 4, group="dam"), rectangle(10, 0, 3, 3, 6, 6, group="dam")
    for what, mesh, n in (("a body", body, 1), ("two bodies", join([body, renamed(other, {}, {})]), 2)):
        for strain in ("small", "large"):
            scene = {
                "strain": strain, "relaxation": {"allow_floating": True}, "materials": {"dam": {"density": 2400, "young": 20e9, "poisson": 0.2}},
                "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}}, "stages": [{"modes": {"type": "modes", "count": 3 * n + 2}}],
            }  # fmt: skip
            result = case.run(mesh, scene)
            f, facts = hertz(result, "modes"), modes_of(result, "modes")
            case.check(f"{what} that floats, {strain} strain: frequencies that are 0", [int(sum(f == 0)), f[3 * n] > 100], [3 * n, True], absolute=0)
            rigid = [sum(mode[f"mass_{x}"] for mode in facts["list"][:3 * n]) / facts[f"mass_{x}"] for x in "xy"]
            case.check("... their mass, along x and y, over all", rigid, 1.0, absolute=1e-9)


# ---- as in time

def in_time(case):
    """What swings in time has the frequencies of the modes: a rigid block, section G1 with water."""
    for loads in ([], ["hydro"]):
        scene = changed(BODIES.ELASTIC, ("stages", [{"modes": {"type": "modes", "loads": loads}}, {"shake": BODIES.swing(loads=loads)}]))
        result = case.run(BODIES.block(BODIES.WIDTH, BODIES.HEIGHT, 40), scene)
        t, u = BODIES.shake(result)
        case.check(f"rigid block, {'wet' if loads else 'dry'}, against its motion in time: frequencies [Hz]", hertz(result, "modes"),
                   BODIES.hertz(np.array(BODIES.poles(t, u.sum(axis=1), 6, 0.003))), relative=1e-4)
    scene = changed(BODIES.elastic(10e9, 33, [1e6, 1e6]))
    scene["stages"].insert(1, {"modes": {"type": "modes", "loads": ["hydro"], "count": 3}})
    for what, mesh in (("quadrilaterals", BODIES.section_g1()), ("triangles", split_triangles(BODIES.section_g1()))):
        result = case.run(mesh, scene)
        t, u = BODIES.shake(result, "crest")
        case.check(f"section G1, wet, {what}, against its motion in time: frequencies [Hz]", hertz(result, "modes"), BODIES.peaks(t, u[:, 0], 3), relative=1e-3)


# ---- joints as they are

def open_base(case):
    """A rigid block that a force at its top has opened over a part of its base: what is closed carries."""
    width, height, n, k_n, k_s = 4.0, 6.0, 40, 1e10, 4e9
    m = 2400 * width * height
    weight, push = m * G, 0.35 * m * G * width / height
    closed = 3 * (width / 2 - push * height / weight)
    arm, level = width / 2 - closed / 2, height / 2  # of the middle of what is closed from the mass centre
    B = np.array([[0, 1, arm], [1, 0, level], [0, 0, 1]])
    stiffness = B.T @ np.diag([k_n * closed, k_s * closed, k_n * closed**3 / 12]) @ B
    f, _ = by_hand(np.diag([m, m, m * (width**2 + height**2) / 12]), stiffness)
    for models in (("tptm", 1e-5), ("r3pt", 5e-2)):
        scene = changed(RIGID, ("joints.default", {"k_n": k_n, "k_s": k_s, "friction": 80, "stress_model": models[0]}), ("relaxation", {"tolerance": 1e-10}),
                        ("loads", {"weight": {"type": "self_weight"}, "push": {"type": "point_force", "point": "top_left", "value": [push, 0]}}),
                        ("stages", [{"whole": {"type": "modes"}}, {"stands": {"loads": ["weight", "push"]}}, {"open": {"type": "modes"}}]))  # fmt: skip
        result = case.run(standing(width, height, n), scene)
        facts = modes_of(result, "open")
        case.check(f"block on a base that is open over {width - closed:.1f} of {width:.0f} m, {models[0]}: frequencies [Hz]", hertz(result, "open"), f, relative=models[1])
        case.check("... contacts open in part or whole", facts["open"], np.ceil((width - closed) / width * n), absolute=1)
        if models[0] == "tptm":
            case.check("... and before, about the undeformed state: of the whole joint [Hz]", hertz(result, "whole"), whole_joint(width, height, k_n, k_s), relative=1e-6)
            result = case.run(on_a_slope(width, height), changed(scene, ("stages", [{"whole": {"type": "modes"}}])))
            case.check("... on a slope that other faces make up, where rounding opens no contact: the same [Hz]", hertz(result, "whole"), whole_joint(width, height, k_n, k_s), relative=1e-6)
            case.check("... and contacts that are open, or slip", [modes_of(result, "whole")[key] for key in ("open", "slipping")], [0, 0])
    # a low block, whose weaker end slips
    height = 2.0
    push = 0.3 * 2400 * width * height * G
    slides = changed(scene, ("joints.default", {"k_n": k_n, "k_s": k_s, "friction": 20}), ("loads.push.value", [push, 0]))
    result = case.run(standing(width, height, n), slides)
    facts = modes_of(result, "open")
    case.check("low block, whose weaker end slips: frequencies of what sticks [Hz]", hertz(result, "open"), whole_joint(width, height, k_n, k_s), relative=1e-5)
    case.check("... contacts that slip, and that are open", [3 < facts["slipping"] < n, facts["open"]], [True, 0])


def whole_joint(width, height, k_n, k_s):
    m = 2400 * width * height
    B = np.array([[0, 1, 0], [1, 0, height / 2], [0, 0, 1]])
    return by_hand(np.diag([m, m, m * (width**2 + height**2) / 12]), B.T @ np.diag([k_n * width, k_s * width, k_n * width**3 / 12]) @ B)[0]


def standing(width, height, n):
    base = rectangle(0, -1, width, 1, n, 1, group="base", rigid=True)
    return join([renamed(base, {}, {}), rectangle(0, 0, width, height, n, 1, group="dam", rigid=True)])


def on_a_slope(width, height):
    """The block in 15 faces on a base in 7, both turned by 0.12."""
    mesh = join([renamed(rectangle(-1, -1, width + 2, 1, 7, 1, group="base", rigid=True), {}, {}), rectangle(0, 0, width, height, 15, 1, group="dam", rigid=True)])
    mesh.vertices = mesh.vertices @ np.array([[np.cos(0.12), np.sin(0.12)], [-np.sin(0.12), np.cos(0.12)]])
    return mesh


def leaning(case):
    """A rigid block under its weight in large strain: as it turns, its weight takes W h/2 from the stiffness of its base; too much, and it falls."""
    width, height, k_s = 0.5, 10.0, 5e8  # so slender that it sinks by little
    m = 2400 * width * height
    mass = np.diag([m, m, m * (width**2 + height**2) / 12])
    for k_n, stable in ((1e8, True), (5e7, False)):
        turns = k_n * width**3 / 12 - m * G * height / 2
        B = np.array([[0, 1, 0], [1, 0, height / 2]])
        stiffness = B.T @ np.diag([k_n * width, k_s * width]) @ B + np.diag([0, 0, turns])
        squares = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
        for strain in ("small", "large"):
            scene = changed(RIGID, ("strain", strain), ("joints.default", {"law": "elastic", "k_n": k_n, "k_s": k_s}), ("relaxation", {"tolerance": 1e-9, "method": "explicit"}),
                            ("loads", {"weight": {"type": "self_weight"}}), ("stages", [{"stands": {"loads": ["weight"]}}, {"modes": {"type": "modes"}}]))  # fmt: skip
            result = case.run(standing(width, height, 8), scene)
            found = np.array([mode["omega2"] for mode in modes_of(result, "modes")["list"]])
            what = f"block of 10 m on a soft joint ({k_n / 1e6:.0f} MPa/m), {strain} strain"
            if strain == "large":
                case.check(f"{what}: squares of omega with what its weight takes [1/s2]", found, squares, relative=1e-2)
                case.check("... motions that grow", [result.stage_summary("modes")["modes"]["list"][0]["f"] is None, "grow" in result.stage_summary("modes")["evidence"]], [not stable] * 2)
            else:
                without = by_hand(mass, stiffness + np.diag([0, 0, m * G * height / 2]))[0]
                case.check(f"{what}: frequencies without it [Hz]", hertz(result, "modes"), without, relative=1e-6)


# ---- beside other stages

def untouched(case):
    """A run with stages of modes between its others has the bits of a run without."""
    stages = [{"stands": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}}, {"shake": {"type": "dynamic", "loads": ["weight", "push"], "duration": 0.05}},
              {"on": {"type": "dynamic", "loads": ["weight", "push"], "duration": 0.05}}, {"after": {"loads": ["weight"]}}]  # fmt: skip
    between = [{"m_0": {"type": "modes"}}]
    for i, stage in enumerate(stages):
        between += [stage, {f"m_{i + 1}": {"type": "modes", "loads": ["hydro"]}}]
    material = {"density": 2400, "young": 5e9, "poisson": 0.2}
    for strain, connectivity in (("small", "fixed"), ("large", "fixed"), ("large", "variable")):
        scene = changed(RIGID, ("strain", strain), ("materials.dam", material), ("joints.default", {"k_n": 1e9, "k_s": 4e8, "friction": 20}), ("contact", {"connectivity": connectivity}),
                        ("loads", {"weight": {"type": "self_weight"}, "push": {"type": "traction", "faces": "left", "value": [3e4, 0]},
                                   "hydro": {"type": "added_mass", "faces": "left", "level": 6.0}}))  # fmt: skip
        mesh = join([renamed(rectangle(-1, -1, 6, 1, 10, 1, group="base", rigid=True), {}, {}), rectangle(0, 0, 4, 6, 4, 6, group="dam")])
        runs = [case.run(mesh, changed(scene, ("stages", which))) for which in (stages, between)]
        sums = [[result.stage_summary(next(iter(stage)))["checksum"] for stage in stages] for result in runs]
        case.check(f"{strain} strain, {connectivity} connectivity: stages between stages of modes have the bits of a run without", sums[1] == sums[0], True)
        last = runs[1].stage_summary("m_3")
        case.check("... and a stage of modes those of the stage before", [runs[1].stage_summary(f"m_{i + 1}")["checksum"] for i in range(len(stages))] == sums[0], True)
        with h5py.File(runs[1].path) as file:
            held = np.array_equal(file["stages/m_3/displacement"], file["stages/shake/displacement"]) and np.array_equal(file["stages/m_3/contacts/force"], file["stages/shake/contacts/force"])
        case.check("... its displacements and forces too; no mode is missing", [held, last["modes"]["missed"]], [True, 0])
    folder = case.prepare(mesh, changed(scene, ("stages", between), ("checkpoint", {"every": 100000, "keep": 100})))
    case.again(folder)
    case.again(folder, "-output", "kept")
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    again = [case.again(folder, "-restart", file) for file in files[1:-1]]
    same = [[run.stage_summary(next(iter(stage)))["checksum"] for stage in stages] == sums[0] for run in again]
    case.check("restart from the ends of all stages: same bits", [len(same) > 8, all(same)], [True, True])


def what_is_told(case):
    for what, change, words in (("a group that can move has no mass", ("materials.dam.density", 0), "has no mass"), ("all is held", ("supports.all", {"target": "dam", "fix": "xy"}), "hold everything")):
        refused = case.run(wall(1), changed(RIGID, ("loads", {}), ("stages", [{"swing": {"type": "modes"}}]), change))
        case.check(f"{what}: refused in one line", [refused.exit_code, refused.stderr.count("\n"), "stages.swing" in refused.stderr and words in refused.stderr], [2, 1, True])
    rock = BODIES.on_rock(20e9, ["hydro"])
    result = case.run(BODIES.dam_on_rock(), changed(rock, ("stages", [{"modes": {"type": "modes", "loads": ["hydro"]}}])))
    case.check("dam on rock with quiet boundaries: they are said to hold; f1 [Hz] below that of a fixed base", ["let waves out are held" in result.stdout, hertz(result, "modes")[0] < 5.8905], [True, True])
    lines = [line.split() for line in result.stdout.splitlines() if line.startswith("     1  ")]
    case.check("... the terminal has the first frequency", float(lines[0][1]), hertz(result, "modes")[0], relative=1e-4)


def ranks(case):
    """The same modes to rounding, and the bits of what runs beside them."""
    stages = [{"stands": {"loads": ["weight"]}}, {"modes": {"type": "modes", "loads": ["hydro"]}}, {"after": {"loads": []}}]
    material = {"density": 2400, "young": 5e9, "poisson": 0.2}
    mesh = join([renamed(rectangle(-1, -1, 6, 1, 10, 1, group="base", rigid=True), {}, {}), rectangle(0, 0, 4, 6, 4, 6, group="dam"),
                 renamed(rectangle(0, 6, 4, 1, 1, 1, group="cap", rigid=True), {}, {})])  # fmt: skip
    for what, body, many in (("quadrilaterals", mesh, (1, 2, 3, 4)), ("triangles", split_triangles(mesh), (1, 2))):
        scene = changed(RIGID, ("materials.dam", material), ("materials.cap", {"density": 2400}), ("joints.default", {"k_n": 1e9, "k_s": 4e8, "friction": 30}),
                        ("loads", {"weight": {"type": "self_weight"}, "hydro": {"type": "added_mass", "faces": "left", "level": 6.0}}), ("stages", stages))  # fmt: skip
        runs = [case.run(body, scene, ranks=n) for n in case.ranks(*many)]
        f = hertz(runs[0], "modes")
        case.check(f"{what}, 1 to {many[-1]} ranks: frequencies over those of one rank", [hertz(r, "modes") / f for r in runs], 1.0, absolute=1e-9)
        case.check("... shapes", [abs(r.stage("modes").modes - runs[0].stage("modes").modes).max() for r in runs], 0.0, absolute=1e-6)
        case.check("... checksums of all stages", len({tuple(r.stage_summary(s)["checksum"] for s in ("stands", "modes", "after")) for r in runs}), 1)
