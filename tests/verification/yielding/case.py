"""Blocks that yield at the Mohr-Coulomb strength: closed forms of one block (M02), loading in steps, unloading, ranks, restart.

The return of a point is tested by itself, in tests/unit/blocks/test_laws.c, against an oracle and published numbers (M01)."""

import numpy as np
from driver import changed, check_restarts, checksums
from quoin_tools.mesh.meshing import face_set_on, graded, join, rectangle, renamed, split_triangles, structured
from quoin_tools.mesh.stacks import quad_patch

WHAT = "blocks that yield: held and free block (M02), thick ring and footing (M03), history over stages, unloading, energy, blocks that move far, ranks, restarts"
SOURCE = "Mohr-Coulomb with tension cut-off in plane strain: 2 c cos/(1 - sin), edge return by hand, numbers of another program"
BY = "by hand; a program apart, not named there; Prandtl"

E, NU = 20e9, 0.2
HELD = {"young": E, "poisson": NU, "density": 0, "law": "mohr_coulomb", "cohesion": 0.2e6, "friction": 30, "tension": 0}
FREE = {"young": E, "poisson": NU, "density": 24, "law": "mohr_coulomb", "cohesion": 1e6, "friction": 45, "dilation": 15, "tension": 0.5e6}
ELEMENTS = ("bending", "full", "reduced", "triangles")


def block(element, n=2):
    """A unit square; its inner vertex is off the centre, so that blocks are distorted."""
    mesh = rectangle(0, 0, 1, 1, n, n, group="block")
    inner = np.all((mesh.vertices > 1e-9) & (mesh.vertices < 1 - 1e-9), axis=1)
    mesh.vertices[inner] += (0.06, -0.04)
    return split_triangles(mesh) if element == "triangles" else mesh


def of(material, element):
    return {"block": material if element in ("bending", "triangles") else material | {"element": element}}


def run(case):
    held(case)
    free(case)
    collapses(case)
    sheared(case)
    lifts(case)
    ring(case)
    swinging(case)
    footing(case)
    ranks_and_restart(case)
    refused(case)
    told(case)
    thrown(case)


# ---- sides held: the load decides


def compressed(material, element, pressures, **more):
    loads = {f"p{i}": {"type": "traction", "faces": "top", "value": [0, -p]} for i, p in enumerate(pressures)}
    return {"strain": "small", "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 100}, "materials": of(material, element),
            "supports": {"bottom": {"fix": "y"}, "left": {"fix": "x"}, "right": {"fix": "x"}}, "loads": loads,
            "stages": [{f"s{i}": {"loads": [f"p{i}"] if p else []}} for i, p in enumerate(pressures)]} | more  # fmt: skip


def along_y(stage):
    return stage.displacement[:, 1].min()


def held(case):
    """M02: below yield; on the edge; unloaded, which is elastic, from a plastic strain that stays; twice as far."""
    M, side = E * (1 - NU) / (1 + NU) / (1 - 2 * NU), NU / (1 - NU)
    steps = [2.77e6, 10.27713e6, 1e6, 20.27713e6]
    back = -5e-4 + (steps[1] - steps[2]) / M, -3.19477e6 + side * (steps[1] - steps[2])
    along = [-2.77e6 / M, -5e-4, back[0], -1e-3]
    for element in ELEMENTS:
        result = case.run(block(element), compressed(HELD, element, steps))
        stages = [result.stage(f"s{i}") for i in range(4)]
        case.check(f"sides held, {element}: e_y below yield, on the edge, unloaded, farther",
                   [along_y(s) for s in stages], along, relative=1e-4)
        for i, (sx, name) in enumerate(((-side * 2.77e6, "below yield"), (-3.19477e6, "on the edge"), (back[1], "unloaded"), (-6.52810e6, "farther"))):
            points = stages[i].gauss_stress.reshape(-1, 3)
            points = points[~np.isnan(points[:, 0])]
            case.check(f"... {name}: s_x, s_y at all points [Pa]", points[:, :2], [[sx, -steps[i]]], absolute=100)
    turned = case.run(block("bending"), changed(compressed(HELD, "bending", steps[1:2]), ("strain", "large")))
    case.check("sides held, large strain: e_y", along_y(turned.stage("s0")), -5e-4, relative=1e-3)
    newton = case.run(block("bending"), compressed(HELD, "bending", steps, relaxation={"tolerance": 1e-9, "velocity_tolerance": 1e-9, "method": "preconditioned"}))
    case.check("... by Newton's method: e_y", [along_y(newton.stage(f"s{i}")) for i in range(4)], along, relative=1e-4)
    case.check("... all of it", [s["method"] for s in newton.summary["stages"]], ["preconditioned"] * 4)


# ---- sides free: the top moves


def pressed(case, element, strain="small", ranks=1):
    """Top pressed down to e_y = -6e-4 in 0.1 s, which is slow: 1500 times the time a wave takes."""
    scene = {"strain": strain, "materials": of(FREE, element), "stages": [{"press": {"type": "dynamic", "loads": [], "duration": 0.1, "alpha": 1000}}],
             "supports": {"bottom": {"fix": "y"}, "left": {"fix": "x"}, "top": {"fix": "y", "motion": "way.csv", "quantity": "velocity"}},
             "relaxation": {"history_every": 20}}  # fmt: skip
    folder = case.prepare(block(element), scene)
    (folder / "way.csv").write_text("0, 0, 0\n0.02, 0, -6.6666666666666667e-3\n0.1, 0, -6.6666666666666667e-3\n")
    return case.again(folder, ranks=ranks)


def free(case):
    """M02: 2 c cos/(1 - sin) along y, whatever the dilation; e_x by it. The energy account closes."""
    for element in ELEMENTS:
        result = pressed(case, element)
        stage = result.stage("press")
        points = stage.gauss_stress.reshape(-1, 3)
        case.check(f"sides free, {element}: s_y [Pa]", points[~np.isnan(points[:, 0]), 1], -4.82843e6, relative=5e-4)
        ey, ex = result.history["top_right_uy_m"], result.history["top_right_ux_m"]
        case.check("... e_x at e_y = -3e-4, -6e-4", np.interp([3e-4, 6e-4], -ey, ex), [1.73832e-4, 6.83351e-4], relative=1e-3)
        energy = result.stage_summary("press")["energy"]
        case.check("... balance of the account over the work of the support", energy["balance"] / energy["supports"], 0, absolute=1e-5)
    large = pressed(case, "bending", "large").stage("press")
    case.check("sides free, large strain: s_y [Pa]", large.gauss_stress[..., 1], -4.82843e6, relative=3e-3)


def collapses(case):
    """A free block bears 2 c cos/(1 - sin) and no more."""
    strength = 4.82843e6
    for part, verdict in ((0.999, "converged"), (1.001, None)):
        scene = compressed(FREE, "bending", [part * strength], supports={"bottom": {"fix": "y"}, "left": {"fix": "x"}})
        result = case.run(block("bending"), scene, "-relaxation_max_cycles", "20000")
        found = result.stage_summary("s0")["verdict"]
        if verdict:
            case.check(f"sides free under {part} of the strength", found, verdict)
        else:
            case.check(f"... under {part} of it: no equilibrium", found in ("collapsed", "undecided", "diverged"), True)


def lifts(case):
    """Two lifts of rock with held sides, by hand: a block stiffens from M to E as it yields (edge return with dilation 0), and strain counts from when it is placed."""
    weight, n = 60e3 * 9.81, 8
    side, yields = (1 - NU) / (1 + NU) / (1 - 2 * NU) * E, 2.77128e6
    def strain(s):
        return min(s, yields) / side + max(s - yields, 0) / E
    mesh = rectangle(0, 0, 1, 8, 1, 2 * n, group="low")
    mesh.group_names, mesh.group_rigid = ["low", "high"], np.zeros(2, dtype=np.int32)
    mesh.block_group[mesh.vertices[mesh.blocks[:, :4]][..., 1].mean(axis=1) > 4] = 1
    rock = HELD | {"density": 60e3}
    scene = {"strain": "small", "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 300}, "materials": {"low": rock, "high": rock},
             "supports": {"bottom": {"fix": "y"}, "left": {"fix": "x"}, "right": {"fix": "x"}}, "loads": {"weight": {"type": "self_weight"}},
             "stages": [{"one": {"loads": ["weight"]}}, {"two": {"loads": ["weight"], "build": ["high"], "displacements": "reset"}}]}  # fmt: skip
    for method in ("explicit", "preconditioned"):
        result = case.run(mesh, changed(scene, ("relaxation.method", method)))
        top = [result.stage(name).displacement[np.abs(mesh.vertices[:, 1] - y) < 1e-9, 1].mean() for name, y in (("one", 4), ("two", 4), ("two", 8))]
        t = 4 / n
        z = t * (np.arange(2 * n) + 0.5)
        first = t * sum(strain(weight * (4 - y)) for y in z[:n])
        low = t * sum(strain(weight * (8 - y)) for y in z[:n]) - first
        high = t * sum(strain(weight * (8 - y)) for y in z[n:])
        case.check(f"lifts, {method}: settlement of the first, then of it and of the second since placing [m]", top, [-first, -low, -low - high], relative=1e-4)
        yielded = [result.stage(name).plastic_strain[rows] > 0 for name, rows in (("one", slice(n)), ("two", slice(None)))]
        case.check("... blocks have yielded where by hand they do", [row.tolist() for row in yielded], [(weight * (4 - z[:n]) > yields).tolist(), (weight * (8 - z) > yields).tolist()])


def sheared(case):
    """A block that stands on its bottom, pushed along its top: what it cannot bear is no equilibrium, however far it flows. A step that is long is reported."""
    def on_top(part, load, **relax):
        scene = compressed(FREE | {"density": 24}, "bending", [0] * part, supports={"bottom": {"fix": "xy"}}, relaxation=relax)
        loads = {f"p{i}": {"type": "traction", "faces": "top", "value": [x * (i + 1) / part for x in load]} for i in range(part)}
        return case.run(block("bending", 4), changed(scene, ("loads", loads), ("stages", [{f"s{i}": {"loads": [f"p{i}"]}} for i in range(part)])))
    far = on_top(1, (1.4e6, -1.7e6), max_cycles=10000)
    case.check("pushed along its top, beyond what it bears: no equilibrium", far.stage_summary("s0")["verdict"] == "converged", False)
    stages, steps, one = on_top(8, (0.4e6, -0.375e6)), *(on_top(1, (0.4e6, -0.375e6), method="preconditioned", increments=n) for n in (32, 1))
    case.check("... half of that in 8 stages: reported that one is too long", "stage s5: its load is applied in one step, and yielding depends on the path" in stages.stderr, True)
    case.check("... in 32 increments: not reported", "what yields depends on the way" in steps.stderr, False)
    reached = [r.summary["stages"][-1]["probes"]["top_right"]["u_x"] for r in (one, stages, steps)]
    case.check("... it does depend: displacement in 1, 8, 32 steps falls, by 3 to 6 % in all", [bool(reached[0] > reached[1] > reached[2]), bool(0.03 < reached[0] / reached[2] - 1 < 0.06)], [True] * 2)


# ---- thick ring


def quarter_ring(nr, nt, a=1.5, b=15.0):
    """Rows of blocks around a hole, as wide as they are far; a load for each outer face: pressure stays normal to it."""
    r, t = a * (b / a) ** np.linspace(0, 1, nr + 1)[:, None], np.linspace(np.pi / 2, 0, nt + 1)
    xy = np.stack([r * np.cos(t), r * np.sin(t)], axis=-1)
    mesh = structured(xy, group="rock")
    faces, loads = mesh.face_sets, {}
    mesh.face_sets = {"x0": faces["left"], "y0": faces["right"]} | {f"o{k}": row[None] for k, row in enumerate(faces["top"])}
    for k in range(nt):
        along = xy[-1, k + 1] - xy[-1, k]
        inwards = np.array([along[1], -along[0]]) / np.hypot(*along)
        loads[f"o{k}"] = {"type": "traction", "faces": f"o{k}", "value": (5e6 * inwards).tolist()}
    return mesh, loads


def pressed_ring(case, n, dilation):
    """Inward displacement of wall and outer face [mm], radius to which blocks have yielded [m]."""
    mesh, loads = quarter_ring(n, 6 * n // 10)
    rock = {"density": 0, "young": 10e9, "poisson": 0.25, "law": "mohr_coulomb", "cohesion": 0.8e6, "friction": 35, "dilation": dilation}
    result = case.run(mesh, {"strain": "small", "materials": {"rock": rock}, "supports": {"x0": {"fix": "x"}, "y0": {"fix": "y"}}, "loads": loads,
                             "stages": [{"press": {"loads": list(loads)}}]})  # fmt: skip
    stage, far = result.stage("press"), np.hypot(*mesh.vertices.T)
    inwards = -1e3 * np.sum(stage.displacement * mesh.vertices, axis=1) / far
    centres = np.hypot(*mesh.vertices[mesh.blocks].mean(axis=1).T)
    return inwards[far < 1.5 + 1e-9].mean(), inwards[far > 15 - 1e-9].mean(), centres[stage.plastic_strain > 0].max()


def ring(case):
    """M03: hole of 1.5 m in rock to 15 m under 5 MPa from outside, three meshes; numbers of a radial equation."""
    wall = []
    for n in (10, 20, 40):
        u, outer, radius = pressed_ring(case, n, 0)
        wall.append(u)
        case.check(f"ring, {n} blocks along the radius: outer displacement [mm]", outer, 4.8746, relative=0.02)
        case.check("... plastic radius, to the centre of a block [m]", radius, 2.0501, absolute=2.0501 * (10 ** (1 / n) - 1))
    case.check("... displacement of the wall with 40 blocks [mm]", wall[-1], 1.8710, relative=0.02)
    case.check("... its error falls at least as the size of the blocks: two halvings", bool((1.8710 - wall[2]) < (1.8710 - wall[0]) / 4), True)
    for dilation, expected in ((10, 1.9936), (35, 2.9129)):
        case.check(f"... dilation {dilation}: wall [mm]", pressed_ring(case, 40, dilation)[0], expected, relative=0.02)


def swinging(case):
    """A mesh on which cycles swing about the equilibrium of a flow without dilation: they say so, and which key decides it."""
    mesh, loads = quarter_ring(80, 48)
    rock = {"density": 0, "young": 10e9, "poisson": 0.25, "law": "mohr_coulomb", "cohesion": 0.8e6, "friction": 35, "dilation": 0}
    folder = case.prepare(mesh, {"strain": "small", "materials": {"rock": rock}, "supports": {"x0": {"fix": "x"}, "y0": {"fix": "y"}}, "loads": loads,
                                 "relaxation": {"max_cycles": 10000}, "stages": [{"press": {"loads": list(loads)}}]})  # fmt: skip
    cycles, newton = case.again(folder), case.again(folder, "-relaxation_method", "preconditioned")
    said = ["dilation 0 below friction 35 degrees" in cycles.stderr, "try relaxation.method: preconditioned" in cycles.summary["stages"][0]["evidence"]]
    case.check("ring of 3840 blocks, dilation 0, 10000 cycles: verdict; a warning and the evidence name the key", [cycles.summary["stages"][0]["verdict"], *said], ["undecided", True, True])
    far = np.hypot(*mesh.vertices.T)
    wall = -1e3 * np.sum(newton.stage("press").displacement * mesh.vertices, axis=1)[far < 1.5 + 1e-9].mean() / 1.5
    case.check("... by Newton's method: wall [mm]", wall, 1.8710, relative=0.01)
    falls = case.again(folder, "-relaxation_max_cycles", "1500", "-materials_rock_dilation", "35")
    case.check("... with dilation as friction, too few cycles", "it falls: raise max_cycles" in falls.summary["stages"][0]["evidence"] and "swing" not in falls.stderr, True)


# ---- strip footing


# friction [degree]: its bearing capacity over cohesion, the way of the footing [m], how far the soil goes beside it and down [m], seconds, damping [1/s]
FOOTINGS = {0: (5.1416, 0.08, 9, 5, 3, 2), 20: (14.835, 0.15, 9, 5, 3, 1), 30: (30.140, 0.4, 11, 6, 6, 0.5)}


def pressed_footing(case, n, friction, way, far, deep, seconds, alpha):
    """Reaction over cohesion and width of half a rough footing of 2 m, n blocks wide, on weightless soil that flows as its friction says; balance over work."""
    x = np.concatenate([np.linspace(0, 1, n + 1), 1 + graded(1 / n, far, int(3.2 * n))[1:]])
    mesh = structured(np.stack(np.meshgrid(x, -graded(1 / n, deep, int(2.2 * n))[::-1]), axis=-1), group="soil")
    mesh.face_sets["footing"] = face_set_on(mesh, (0, 0), (1, 0))
    soil = {"density": 2000, "young": 1e8, "poisson": 0.3, "law": "mohr_coulomb", "cohesion": 1e5, "friction": friction, "dilation": friction}
    scene = {"strain": "small", "materials": {"soil": soil}, "relaxation": {"history_every": 100},
             "supports": {"bottom": {"fix": "xy"}, "left": {"fix": "x"}, "right": {"fix": "x"}, "footing": {"fix": "xy", "motion": "way.csv", "quantity": "velocity"}},
             "stages": [{"press": {"type": "dynamic", "loads": [], "duration": seconds, "alpha": alpha, "dt_factor": 0.5}}]}  # fmt: skip
    folder = case.prepare(mesh, scene)
    begins, v = seconds / 6, way / (seconds * 11 / 12)
    (folder / "way.csv").write_text(f"0, 0, 0\n{begins!r}, 0, {-v!r}\n{seconds}, 0, {-v!r}\n")
    result = case.again(folder)
    energy = result.stage_summary("press")["energy"]
    return abs(result.history["footing_fy_N"][-1]) / 1e5, energy["balance"] / energy["supports"]


def footing(case):
    """M03: Prandtl's bearing capacities. Three meshes come down to each from above, to first order in the size of the blocks:
    the soil yields to half a block beside the footing, which is as if the footing were wider by that."""
    for friction, (capacity, *how) in FOOTINGS.items():
        sizes = np.array((4, 8) if case.short and friction != 20 else (4, 8, 16))  # 16 blocks take nine tenths of the time
        found, balance = np.array([pressed_footing(case, n, friction, *how) for n in sizes]).T
        error = found / capacity - 1
        case.check(f"footing, friction {friction}: errors with {', '.join(map(str, sizes))} blocks against what half a block is", error, 0.5 / sizes, absolute=0.025)
        case.check("... order of convergence", np.log2(error[:-1] / error[1:]), 1.0, absolute=0.35)
        if 16 in sizes:
            case.check("... of a footing half a block wider, 16 blocks: bearing capacity over cohesion", found[-1] / (1 + 0.5 / 16), capacity, relative=0.015)
        case.check("... balance of the account over the work of the support", balance, 0, absolute=1e-4)


# ---- ranks, restart


def wall():
    """A wall on its ground, all of it yielding: static stages, by trials, in time."""
    mesh = join([renamed(rectangle(-2, -2, 8, 2, 8, 3, group="ground"), {"bottom": "bottom"}),
                 renamed(quad_patch((0, 0), (4, 0), (3, 5), (0, 5), 6, 6, group="block"), {"upstream": "left"}, {})])  # fmt: skip
    weak = {"density": 2400, "young": 1e9, "poisson": 0.2, "law": "mohr_coulomb", "cohesion": 2.5e4, "friction": 35, "tension": 1e4}
    return mesh, {
        "strain": "large", "materials": {"ground": weak | {"element": "full", "dilation": 35}, "block": weak},
        "joints": {"default": {"k_n": 2e9, "k_s": 1e9, "friction": 50, "cohesion": 1e5, "tension": 1e5}},
        "supports": {"bottom": {"fix": "xy"}}, "relaxation": {"max_cycles": 20000},
        "loads": {"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "upstream", "level": 3.8}},
        "stages": [{"own": {"loads": ["weight"]}}, {"full": {"loads": ["weight", "water"]}}, {"empty": {"loads": ["weight"]}},
                   {"shaken": {"type": "dynamic", "loads": ["weight", "water"], "duration": 0.05}}, {"after": {"loads": ["weight"]}}]}  # fmt: skip


def ranks_and_restart(case):
    """The same bits on 1 to 4 ranks, and from checkpoints within stages that yield."""
    mesh, scene = wall()
    folder = case.prepare(mesh, changed(scene, ("checkpoint", {"every": 300, "keep": 1000})))
    first = case.again(folder)
    case.check("all stages end well", [s["verdict"] for s in first.summary["stages"]], ["converged"] * 3 + ["completed", "converged"])
    elastic = case.run(mesh, changed(scene, ("materials.ground", {"density": 2400, "young": 1e9, "poisson": 0.2}),
                                     ("materials.block", {"density": 2400, "young": 1e9, "poisson": 0.2, "element": "bending"})))  # fmt: skip
    gone, all_back = (np.abs(r.stage("empty").displacement - r.stage("own").displacement).max() for r in (first, elastic))
    case.check("it has yielded: emptied, more is left of what the water has moved than of elastic blocks", bool(gone > 5 * all_back), True)
    for ranks in case.ranks(2, 3, 4):
        case.check(f"checksums on {ranks} ranks", checksums(case.run(mesh, scene, ranks=ranks)), checksums(first))
    check_restarts(case, folder, first)


def refused(case):
    """Bodies that never deform by themselves have no use for a law."""
    for keys in ({"rigid": True}, {"condensed": True}):
        scene = changed(compressed(HELD, "bending", [1e6]), ("materials.block", HELD | {"tension": 1e4} | keys))
        result = case.run(block("bending"), scene)
        line = f"materials.block.law: mohr_coulomb is for blocks that deform by themselves, and these are {next(iter(keys))}: expected elastic"
        case.check(f"{next(iter(keys))} blocks with a law: refused in one line", [result.exit_code, result.stderr.count("\n"), line in result.stderr], [2, 1, True])


def told(case):
    """Stages in which the law has no part say so."""
    mesh, scene = wall()
    stages = [{"own": {"loads": ["weight"]}}, {"swings": {"type": "modes"}}, {"weaker": {"type": "strength_reduction", "loads": ["weight"], "bracket": 0.5}}]
    result = case.run(mesh, changed(scene, ("stages", stages), ("relaxation.max_cycles", 3000)))
    for line in ("stages.weaker: it weakens joints; blocks of group block keep the strengths of their law",
                 "stages.swings: its modes take blocks of group block as elastic and whole"):  # fmt: skip
        case.check(f"reported: {line}", line in result.stderr, True)


# ---- blocks that move far


def thrown(case):
    """A block thrown onto a rigid floor, of which its blocks know before or only as they meet it: they yield, or crack, alike. Falling from above they do so later."""
    cracks = {"density": 2400, "young": 1e9, "poisson": NU, "law": "damage", "tension": 1e5, "fracture_energy": 100}
    yields = {"density": 2400, "young": 1e9, "poisson": NU, "law": "mohr_coulomb", "cohesion": 2e5, "friction": 30, "tension": 1e5}
    for name, material, triangles in (("yields", yields, False), ("cracks", cracks, True)):
        lost, sides, first = [], rectangle(0.013, 0, 1, 1, 4, 4, group="block"), None
        body = split_triangles(sides) if triangles else sides
        for gap, connectivity, duration in ((0, "fixed", 0.01), (0, "variable", 0.01), (0.03, "variable", 0.02)):
            body.vertices[:, 1] += gap
            mesh = join([renamed(rectangle(-2, -1, 6, 1, 3, 1, group="floor", rigid=True), {}), renamed(body, {})])
            scene = {"strain": "large", "contact": {"connectivity": connectivity, "tolerance": 0.005}, "joints": {"default": {"k_n": 1e10, "k_s": 3e9, "friction": 30}},
                     "materials": {"block": material | {"velocity": [0, -3]}, "floor": {"density": 2400}}, "supports": {"floor": {"fix": "xy"}}, "checkpoint": {"every": 100, "keep": 1000},
                     "loads": {}, "relaxation": {"allow_floating": True}, "stages": [{"meets": {"type": "dynamic", "loads": [], "duration": duration, "dt_factor": 0.3}}]}  # fmt: skip
            folder = case.prepare(mesh, scene)
            first = case.again(folder)
            lost.append(first.stage_summary("meets")["laws"]["block"]["lost"])
        case.check(f"thrown onto a floor, {name}: energy lost where contacts are found, at once and later, over that where they are known", np.array(lost[1:]) / lost[0], 1, absolute=2e-3)
        made = first.stage_summary("meets")
        case.check("... contacts are made in flight", bool(made["verifications"] > 2 and lost[0] > 100), True)
        case.check("... the same on 2 ranks", checksums(case.again(folder, ranks=2)), checksums(first))
        kept = sorted((folder / "out" / "checkpoints").iterdir())
        again = case.again(folder, "-restart", kept[len(kept) // 2])
        case.check(f"... from checkpoint {len(kept) // 2} of {len(kept)}", checksums(again), checksums(first))
