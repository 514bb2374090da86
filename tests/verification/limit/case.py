"""Limit analysis (quoin limit) against closed forms and independent programmes, and beside the simulation of the same scenes.

Block on a slope, dam in lifts, arch under a force, pier under a beam: where sliding is confined the associative bound is above what blocks bear.
Forces of the programme are held against equilibrium and strength, and units must not matter: the trap that gave "optimal" answers wrong by a factor of eight."""

import math
import os
import re
from dataclasses import replace
from pathlib import Path

import assemblies as p
import numpy as np
from driver import changed
from quoin_tools.limit import LimitError
from quoin_tools.limit.bounds import bound
from quoin_tools.limit.program import velocities
from quoin_tools.limit.water import of_run as water_of
from quoin_tools.mesh.meshing import join, quad_patch, renamed
from quoin_tools.show import limit, limit_picture

WHAT = "limit analysis: slope, dam in lifts, arch, pier, ceiling; beside trials of the solver; scaling, duality, mechanism; anchors, crushing, uplift"
SOURCE = "statics (L01, L02, L05); independent linear programmes and explicit rigid blocks (L03, L04)"
BY = "by hand; independent linear programmes and rigid blocks of this project"


def run(case):
    os.environ["QUOIN_SOLVER"] = str(Path(case.quoin).resolve())
    closed_forms(case)
    thin(case)
    units(case)
    mechanism(case)
    kinds(case)
    extras(case)
    bars(case)
    flowing(case)
    built(case)
    settled(case)
    contradicted(case)
    simulated(case)


def of(made, **options):
    mesh, keys = made
    return bound(mesh, p.scene_of(keys), "push", **options)


def closed_forms(case):
    for height, exact in ((2, math.tan(math.radians(math.degrees(math.atan(0.5)) - 10))), (3, math.tan(math.atan(0.5) - math.radians(10))),
                          (6, 2 / 6 - math.tan(math.radians(10)))):  # fmt: skip
        if height == 6:  # it turns about its lower corner
            exact = (1 - 3 * math.tan(math.radians(10))) / (3 + math.tan(math.radians(10)))
        case.check(f"L01 block 2 x {height} m on 10 degrees: load factor", of(p.slope(height)).value, exact, relative=1e-9)
    for friction, cohesion, exact in ((0.75, 0, 1.29375), (0.5, 0, 0.8625), (2, 0, 2.5875), (0.5, 1e5, 1.244763)):
        case.check(f"L02 dam in lifts, tan(phi) {friction:g}, c {cohesion:g} Pa", of(p.dam(friction, cohesion)).value, exact, relative=1e-6)
    for n, friction, exact in ((12, 0.6, 150.676), (24, 0.6, 150.394), (48, 0.6, 150.252), (24, 0.35, 138.519), (24, 0.3, 120.959)):
        case.check(f"L03 arch, {n} stones, tan(phi) {friction:g} [kN]", of(p.arch(n, friction)).value, exact, relative=1e-5)
    for thickness, exact in ((0.6, 101.476), (0.5, 65.072), (0.4, 38.539)):
        case.check(f"L03 arch, {thickness:g} m thick [kN]", of(p.arch(24, 0.6, thickness)).value, exact, relative=2e-5)
    pier = of(p.pier())
    case.check("L04 pier: associative [kN]", pier.value, 115.98, relative=1e-4)
    confined = of(p.ceiling())
    case.check("L05 block under a ceiling: associative", confined.value, math.inf)
    case.check("... says what joints pressed by 100 MPa bear: 0.5 (2 N - W), N = 200 MN", [note for note in confined.notes if note.endswith("the limit is: 4999.5.")], confined.notes)


def thin(case):
    """Layers thinner than contact.tolerance: bodies do not meet through them. Lengths of joints and what slides on the mortar, by hand."""
    for beds, length in (((1,), 4), ((1, 1), 8), ((2,), 6)):
        for tolerance in (1e-4, 0.005):
            mesh, keys = p.mortared(beds)
            said = bound(mesh, p.scene_of(keys | {"contact": {"tolerance": tolerance}}), "push")
            case.check(f"L06 bed of 4 mm in {beds[0]} layers, {len(beds)} blocks, tolerance {1e3 * tolerance:g} mm: load factor", said.value, 0.364, relative=1e-6)
            case.check("... length of joints [m]", float(said.parts.contacts.length.sum()), length, relative=1e-9)
    mesh, keys = p.pier()  # a model 1:100: joints of 5 mm at most, as long as the tolerance
    model = bound(replace(mesh, vertices=0.01 * mesh.vertices), p.scene_of(changed(keys, ("loads.dead.value", [0, -15.0]), ("loads.push.value", [0.1, 0]))), "push")
    case.check("L04 pier as a model 1:100, tolerance 5 mm: associative [kN]", model.value, 115.98, relative=1e-4)
    for digits in (3, 2):  # 7 faces on 15 of a base that rises 1:10, gaps and overlaps of up to 4 mm
        rock, dam = quad_patch((-24, -20), (48, -20), (48, 4.8), (-24, -2.4), 15, 2, "ground", True), quad_patch((0, 0), (24, 2.4), (6, 30), (0, 30), 7, 4, "block", True)
        rock.points, dam.points, keys = {}, {}, p.slope(3)[1]
        rising = join([renamed(rock, {}), renamed(dam, {})])
        rising = replace(rising, vertices=np.round(rising.vertices, digits), face_sets={}, points={})
        said = bound(rising, p.scene_of(changed(keys, ("joints.default.friction", math.degrees(math.atan(0.9))))), "push")
        case.check(f"L07 dam on rock that rises 1:10, rounded to {10.0 ** (3 - digits):g} mm: it slides at tan(phi + beta)", said.value, (0.9 + 0.1) / (1 - 0.09), relative=5e-3)
        case.check("... length of its joint [m]", float(said.parts.contacts.length.sum()), math.hypot(24, 2.4), relative=5e-4)
    leaning = of(p.mortared((1,), tilt=0.04))  # meets at one corner: it falls over by its weight
    case.check("L06 block that stands on a corner, 1.1 degrees open, bears nothing", leaning.value, None)


def units(case):
    """Weights from a feather to a mountain, lengths in any unit: the same factor."""
    mesh, keys = p.dam(0.75)
    for density in (1e-6, 1.0, 1e9):
        water = changed(keys, ("materials.block.density", 2300 * density), ("loads.push.density", 1000 * density))
        case.check(f"dam with densities times {density:g}", bound(mesh, p.scene_of(water), "push").value, 1.29375, relative=1e-8)
    for size in (1e-3, 1e3):
        small = replace(mesh, vertices=size * mesh.vertices)
        said = bound(small, p.scene_of(changed(keys, ("loads.push.level", 40.0 * size), ("contact", {"tolerance": 0.005 * size}), ("joints.default.cohesion", 1e-9))), "push")
        case.check(f"dam with lengths times {size:g}, joints as wide as contact.tolerance says", said.value, 1.29375, relative=1e-8)
        case.check("... says that runs take cohesion away", said.notes, ["Cohesion and tensile strength are taken as if joints kept them when they fail, runs take them away: default."])
    mesh, keys = p.arch(24, 0.3)
    heavy = changed(keys, ("materials.block.density", 2200e6), ("loads.push.value", [0, -1e9]))
    case.check("arch a million times as heavy", bound(mesh, p.scene_of(heavy), "push").value, 120.959, relative=1e-5)


def mechanism(case):
    """Hinges of the arch; power of the loads equals what cohesion takes; nothing is pressed where faces part."""
    answer = of(p.arch(24, 0.6))
    hinges = [place for place, what in limit_picture.states(answer) if what == "hinge"]
    case.check("arch: four hinges", len(hinges), 4)
    angles = sorted(math.degrees(math.atan2(x, y + 4.5)) for x, y in hinges)
    half = math.degrees(math.asin(6 / 7.5))
    # both springings, the load, and the ninth face from the other springing
    case.check("... at both springings, at the load, nine faces from the left", angles, [-half, -half + 9 * 2 * half / 24, half / 2, half], absolute=1e-6)
    live = sum(answer.loads[name] for name in answer.raised)
    total = sum(answer.loads.values()) + (answer.value - 1) * live
    power = (total * answer.limit.motion).sum()
    case.check("... power of all loads, without cohesion", power / np.abs(total * answer.limit.motion).sum(), 0.0, absolute=1e-9)
    case.check("... fastest corner", np.hypot(*velocities(answer.parts, answer.limit.motion).T).max(), 1.0, relative=1e-9)
    force, _, share = limit_picture.resultants(answer)
    case.check("... forces within the faces", [bool((force > -1e-6).all()), bool((share > -1e-9).all() and (share < 1 + 1e-9).all())], [True, True])


def kinds(case):
    """Flood and reductions of the dam of one lift against statics."""
    mesh, keys = p.dam(0.75, lifts=1)
    weight = 0.5 * 30 * 40 * 2300 * 9.81
    reduction = changed(keys, ("stages", [{"push": {"type": "strength_reduction", "loads": ["weight", "push"], "bracket": 0.01}}]))
    answer = bound(mesh, p.scene_of(reduction), "push")
    case.check("dam: least friction [degree]", answer.value, math.degrees(math.atan(0.5 * 9810 * 40**2 / weight)), relative=1e-6)
    pressed = changed(keys, ("loads.push", {"type": "pressure", "faces": keys["loads"]["push"]["faces"], "pressure": 1e5}))
    case.check("dam under a uniform pressure: load factor, it slides", bound(mesh, p.scene_of(pressed), "push").value, weight * 0.75 / (1e5 * 40), relative=1e-6)
    over = changed(pressed, ("joints.default.friction", 80))
    case.check("... it turns over about the toe", bound(mesh, p.scene_of(over), "push").value, weight * 20 / (1e5 * 40**2 / 2), relative=1e-6)
    half = changed(keys, ("loads.push.level", 30), ("joints.default.friction", 80), ("stages", [{"push": {"type": "flood", "loads": ["weight", "push"], "bracket": 0.01}}]))
    level = (weight * 20 / 9810 + 40**3 / 3) / (40**2 / 2)  # it turns about the toe, 20 m from the centre; the face ends at 40 m
    answer = bound(mesh, p.scene_of(half), "push")
    case.check("dam: level at which it turns over [m]", answer.value, level, relative=1e-6)


def extras(case):
    mesh, keys = p.dam(0.75, lifts=1)
    weight, water = 0.5 * 30 * 40 * 2300 * 9.81, 0.5 * 9810 * 40**2
    tie = {"area": 1e-3, "young": 200e9, "yield": 1e9, "head": [0.5, 20], "root": [0.5, -4]}
    anchored = changed(keys, ("anchors", {"tie": tie}))
    case.check("dam with a tie of 1000 kN in the heel", bound(mesh, p.scene_of(anchored), "push").value, 0.75 * (weight + 1e6) / water, relative=1e-6)
    case.check("... of 500 kN a metre, spaced 2 m", bound(mesh, p.scene_of(changed(anchored, ("anchors.tie.spacing", 2))), "push").value, 0.75 * (weight + 0.5e6) / water, relative=1e-6)
    # crushing: the resultant stands as near to the toe as the stress block allows
    strength = 2e6
    crushed = changed(keys, ("joints.default.friction", 80), ("joints.default.compression", strength))
    block = weight / strength  # length of the block of stress
    exact = weight * (20 - block / 2) / (water * 40 / 3)
    case.check("dam that crushes its toe", bound(mesh, p.scene_of(crushed), "push").value, exact, relative=1e-8)


def bars(case):
    """A block with one bar in grout, by hand: lifted, and pushed along the joint, where steel and dowel share an ellipse."""
    weight = 96.0  # kN
    for what, keys, force in (("bond in the ground", {"yield": 500e6, "bond_strength": 2e5}, 200), ("bond in the block", {"yield": 500e6, "bond_strength": 2e5, "head": [0, 0.6]}, 120),
                              ("yield", {"yield": 500e6, "bond_strength": 6e5}, 500), ("a plate", {"yield": 150e6, "bond_strength": 2e5, "head": [0, 0.6], "plate": True}, 150),
                              ("a plate, bond in the ground", {"yield": 500e6, "bond_strength": 2e5, "head": [0, 0.6], "plate": True}, 200),
                              ("breaking", {"yield": 500e6, "breaking_force": 90e3}, 90), ("spaced 2 m", {"yield": 500e6, "spacing": 2}, 250)):  # fmt: skip
        case.check(f"block lifted off a bar, {what} [kN]", of(p.barred((0, 1), **keys)).value, weight + force, relative=1e-9)
    case.check("... pressed down: no bar is needed", of(p.barred((0, -1), **{"yield": 500e6})).value, math.inf)
    for T, V in ((200.0, 150.0), (500.0, 60.0)):
        found = of(p.barred((1, 0), **{"yield": T * 1e6, "dowel_stiffness": 1e8, "dowel_strength": V * 1e3})).value
        case.check(f"block pushed off a bar of {T:g} kN and its dowel of {V:g} kN [kN]", found, 0.5 * weight + math.hypot(0.5 * T, V), relative=1e-8)
    foundation = {"yield": 500e6, "dowel_foundation": 2e9}
    inertia, section = 1e-6 / (4 * math.pi), math.pi / 32 * math.sqrt(4e-3 / math.pi) ** 3  # of a round bar, area squared over 4 pi
    V = 500e6 * section * (2e9 / (4 * 200e9 * inertia)) ** 0.25 / (math.exp(-math.pi / 4) * math.sin(math.pi / 4)) / 1e3
    case.check("... a dowel on its foundation", of(p.barred((1, 0), **foundation)).value, 0.5 * weight + math.hypot(250, V), relative=1e-8)
    case.check("... and without strength: reported", [line for line in of(p.barred((1, 0), **{"yield": 2e8, "dowel_stiffness": 1e8})).notes if "Dowels" in line], ["Dowels without strength keep joints from sliding whatever comes: bar."])
    for what, direction, exact, keys in (("lifted", (0, 1), weight + 200, {"yield": 500e6, "bond_strength": 2e5}),
                                         ("pushed, where sliding does not stretch the bar", (1, 0), 0.5 * weight + 150, {"yield": 500e6, "dowel_stiffness": 1e8, "dowel_strength": 150e3})):  # fmt: skip
        mesh, scene = p.barred(direction, **keys)
        stage = scene["stages"][0]["push"] | {"start": 0.5 * exact, "step": 0.3 * exact, "limit": 2 * exact, "bracket": 5e-3 * exact}
        for method in ("explicit", "preconditioned"):
            result = case.run(mesh, changed(scene, ("strain", "small"), ("relaxation", {**scene.get("relaxation", {}), "method": method}), ("stages", [{"push": stage}])))
            found = result.stage_summary("push")["load_factor"]
            case.check(f"the block with the bar {what}, {method}: the run stands at [kN]", found["stable"], exact, relative=1e-2)
            case.check("... not beyond the bound", limit.main([str(result.folder)]), 0)


def flowing(case):
    """A weir on a joint in which water flows: pressures of its run, by hand and as an uplift load; alone it is refused."""
    mesh, keys = p.weir()
    weight, water, uplift = 6 * 8 * 2400 * 9.81, 9810 * 8**2 / 2, 9810 * 8 * 6 / 2
    exact = 0.5 * (weight - uplift) / water
    result = case.run(mesh, keys)
    found = result.stage_summary("push")["load_factor"]
    case.check("weir on water that flows: the run stands at", found["stable"], exact, relative=4e-3)
    _, scene, results = limit.inputs(str(result.folder))
    pressing = water_of(results, "push")
    answer = bound(mesh, scene, "push", water=pressing)
    case.check("... the bound with the pressures of the run", answer.value, exact, relative=1e-6)
    case.check("... says which these are", answer.notes[-1].startswith("Water in joints presses as in the run in its last stable trial"), True)
    case.check("... water in the joint raised too, alone", bound(mesh, scene, "full", ["up"], water=water_of(results, "full")).value, (weight - water / 0.5) / uplift, relative=1e-6)
    flood = replace(scene, stages={"push": {"type": "flood", "loads": ["weight", "push", "up", "down"]}})
    rises = math.sqrt(exact * 8**2 + (math.sqrt(exact) * 8 - 8) ** 2)
    for _ in range(50):  # above the crest a trapezium presses
        rises = math.sqrt(exact * 8**2 + (rises - 8) ** 2)
    case.check("... as a flood, with the same pressures [m]", bound(mesh, flood, "push", water=pressing).value, rises, relative=1e-5)
    rule = changed(keys, ("loads.up", {"type": "uplift", "faces": "base", "level": 8, "tailwater": 0}), ("stages", [{"push": {"type": "load_factor", "raises": ["push"], "loads": ["weight", "push", "up"]}}]))
    case.check("... as with an uplift load", bound(mesh, p.scene_of(rule), "push").value, answer.value, relative=1e-6)
    case.check("... the command", limit.main([str(result.folder)]), 0)
    try:
        bound(mesh, scene, "push")
        said = ""
    except LimitError as error:
        said = str(error)
    case.check("... without a run", said, "loads.up: water that flows in joints presses as a run finds it: run it first, then quoin limit on the folder of the run")


def built(case):
    """A dam in lifts, two of which a later stage builds: what stands before is what a mesh without them is."""
    mesh, keys = p.dam(0.75, lifts=4)
    lifts = np.flatnonzero(np.array(mesh.group_names)[mesh.block_group] == "block")
    mesh.group_names, mesh.group_rigid = [*mesh.group_names, "later"], np.array([*mesh.group_rigid, 1], dtype=np.int32)
    mesh.block_group[lifts[2:]] = 2
    mesh.points["top"] = int(mesh.blocks[lifts[-1], 2])
    stages = [{"half": {"loads": ["weight", "low"]}}, {"push": p.RAISED[0]["push"] | {"loads": ["weight", "push"], "build": ["later"]}}]
    whole = changed(keys, ("materials.later", {"density": 2300, "rigid": True}), ("loads.weight", {"type": "self_weight", "groups": ["block", "later"]}),
                    ("loads.low", keys["loads"]["push"] | {"level": 20}), ("supports.top", {"fix": "y"}), ("stages", stages))  # fmt: skip
    weight, water = 0.5 * (30 + 15) * 20 * 2300 * 9.81, 9810 * 20**2 / 2
    answer = bound(mesh, p.scene_of(whole), "half", ["low"])
    case.check("half a dam, the rest not built yet: bodies, rock included", answer.parts.n, 3)
    case.check("... slides on its base at", answer.value, 0.75 * weight / water, relative=1e-9)
    del whole["supports"]["top"]
    case.check("... all of it built", bound(mesh, p.scene_of(whole), "push").value, 1.29375, relative=1e-9)


def settled(case):
    """A scene as the solver understands it: units, and keys of the command line."""
    mesh, keys = p.dam(0.75)
    folder = case.prepare(mesh, {"model": "model.h5"} | changed(keys, ("materials.block.density", "2.3 t/m3"), ("joints.default.k_n", "100 GPa/m")))
    before = os.getcwd()
    os.chdir(folder)
    try:
        mesh, scene, _ = limit.inputs("scene.yaml", ["-loads_push_level", "42"])
    finally:
        os.chdir(before)
    bar, bonded = p.barred((0, 1), **{"yield": 500e6, "bond_strength": 2e5})
    mesh_of_bar, scene_of_bar, _ = limit.inputs(str(case.prepare(bar, {"model": "model.h5"} | bonded) / "scene.yaml"))
    case.check("a scene whose setup reports a bar in grout [kN]", bound(mesh_of_bar, scene_of_bar, "push").value, 296, relative=1e-9)
    tip = (42 - 32) ** 2 - (42 - 40) ** 2  # the top lift of 8 m under water 2 m above its crest
    case.check("a scene with units, and a key of the command line", bound(mesh, scene, "push").value, 1.29375 * 8**2 / tip, relative=1e-9)


def contradicted(case):
    """A run of stronger joints than those of its scene stands beyond the bound, and the command says so."""
    mesh, keys = p.slope(3)
    result = case.run(mesh, keys | {"stages": [{"push": keys["stages"][0]["push"] | {"start": 0.1, "step": 0.05, "limit": 1, "bracket": 1e-3}}]})
    case.check("a run that is as it says", limit.main([str(result.folder)]), 0)
    echo = Path(result.folder) / "scene_echo.yaml"
    weaker = re.sub(r"friction: [0-9.e+]+", "friction: 25", echo.read_text(encoding="utf-8"))
    echo.write_text(weaker, encoding="utf-8")
    case.check("... and one whose joints bear more than the scene says", limit.main([str(result.folder)]), limit.CONTRADICTION)


def simulated(case):
    """Trials of the solver beside the programme: inside, and near where sliding is free. Forces stand in corners (pt), as those of rigid hinges."""
    for name, made in (("L01 sliding", p.slope(3)), ("L01 turning", p.slope(6)), ("L02 dam", p.dam(0.75)), ("L03 arch", p.arch(24, 0.6))):
        mesh, keys = made[0], changed(made[1], ("joints.default.stress_model", "pt"))
        exact = of(made).value
        stage = keys["stages"][0]["push"] | {"start": 0.5 * exact, "step": 0.25 * exact, "limit": 2 * exact, "bracket": 2e-3 * exact}
        result = case.run(mesh, keys | {"stages": [{"push": stage}]})
        found = result.stage_summary("push")["load_factor"]
        case.check(f"{name}: the run stands below the bound, and not far", 0.985 < found["stable"] / exact < 1.001, True)
        case.check("... as the command says", limit.main([str(result.folder)]), 0)
    mesh, keys = p.ceiling()
    stage = keys["stages"][0]["push"] | {"start": 0.25, "step": 0.1, "limit": 2, "bracket": 1e-3}
    found = case.run(mesh, keys | {"stages": [{"push": stage}]}).stage_summary("push")["load_factor"]
    case.check("L05 block under a ceiling: the run stands at", found["stable"], 0.5, relative=5e-3)
    mesh, keys = p.pier()
    keys = changed(keys, ("joints.default.stress_model", "pt"))
    found = case.run(mesh, keys).stage_summary("push")["load_factor"]
    case.check("L04 pier: the run stands at [kN]", found["stable"], 108.5, relative=1.5e-2)
    case.check("... which is far below the associative bound", found["failing"] < 0.96 * 115.98, True)
