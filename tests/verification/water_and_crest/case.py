"""Overflow, tailwater, waves and a load on the crest: forces and moments by hand, and those of the gravity method and of limit analysis.

A trapezium whose faces both lean by 1 to 4, so each force on a face has a vertical part of a quarter of the horizontal one."""

import math

import numpy as np
from driver import changed
from quoin_tools.assess import section_cut
from quoin_tools.assess.scene_loads import SceneLoads
from quoin_tools.base import scene as scenes
from quoin_tools.limit.bounds import bound
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, split_triangles

WHAT = "overflow (velocity head, crest), tailwater pushed away, waves by Molitor and Sainflou, a load on the crest: forces, moments, floods, load factors, energy, both strains, ranks, refusals"
SOURCE = "statics; Molitor 2 rho g h^2 at 3 h/8 above the water; Sainflou's resultants R and M of the whole diagram less the water at rest"
BY = "by hand; formulas of Molitor and of Sainflou"

G, H, LEAN, B, THICK, PHI = 9.81, 12.0, 0.25, 9.0, 2.0, 20.0
OVER, HEAD, LEFT, TAIL, PART, STILL, WAVE, WAVELENGTH = 14.0, 0.3, 0.6, 5.0, 0.6, 8.5, 1.2, 25.0
AT, LEVER, FORCE = 5.2, 1.5, (20e3, -50e3)
WATER = 1000 * G * THICK


def mesh(rigid=True, triangles=False, n=6, columns=3):
    dam = quad_patch((0, 0), (B, 0), (6, H), (3, H), columns, n, group="dam")
    dam = split_triangles(dam) if triangles else dam
    found = join([renamed(rectangle(-2, -2, 13, 2, 1, 1, group="base", rigid=True), {}),
                  renamed(dam, {"up": "left", "crest": "top", "down": "right", "foot": "bottom"})])  # fmt: skip
    found.group_rigid[found.group_names.index("dam")] = rigid
    found.face_sets["wet"] = np.concatenate([found.face_sets["up"], found.face_sets["crest"]])
    return found


def scene(*stages, **more):
    loads = {
        "weight": {"type": "self_weight", "groups": ["dam"]},
        "over": {"type": "overflow", "faces": "up", "crest": "crest", "level": OVER, "velocity_head": HEAD, "crest_pressure": LEFT},
        "tail": {"type": "tailwater", "faces": "down", "level": TAIL, "effective": PART, "bottom": 0},
        "water": {"type": "reservoir", "faces": "up", "level": STILL},
        "wave": {"type": "wave", "faces": "up", "level": STILL, "height": WAVE},
        "storm": {"type": "wave", "faces": "up", "level": STILL, "wind": "90 km/h", "fetch": "8 km"},
        "swell": {"type": "wave", "faces": "up", "level": STILL, "height": WAVE, "formula": "sainflou", "length": WAVELENGTH, "bottom": 0},
        "bridge": {"type": "crest_load", "faces": "crest", "value": list(FORCE), "at": AT, "lever": LEVER},
    }
    return {
        "thickness": THICK, "strain": "small", "relaxation": {"tolerance": 1e-8, "velocity_tolerance": 1e-8, "method": "explicit", "ramp": 100},
        "materials": {"dam": {"density": 2400, "young": 1e11, "poisson": 0.2}, "base": {"density": 0, "rigid": True}},
        "joints": {"default": {"k_n": 1e10, "k_s": 1e10, "law": "elastic"}}, "supports": {"base": {"fix": "xy"}}, "loads": loads, "stages": list(stages),
    } | more  # fmt: skip


def at_face(force, height, downstream=False):
    """(X, Y, M about the origin) of a horizontal force on a face, with the vertical part that its lean brings."""
    x, y = (B - LEAN * height, -LEAN * force) if downstream else (LEAN * height, -LEAN * force)
    push = -force if downstream else force
    return np.array([push, y, x * y - height * push])


def still(level):
    return at_face(WATER * level**2 / 2, level / 3)


def molitor(height, level=STILL):
    return at_face(2 * WATER * height**2, level + 3 * height / 8)


def sainflou(height, level=STILL):
    """Whole diagram, a triangle from the ground to the crest of the wave, less the water at rest."""
    k = 2 * math.pi / WAVELENGTH
    rise, foot = math.pi * height**2 / WAVELENGTH / math.tanh(k * level), WATER * (level + height / math.cosh(k * level))
    force = (level + height + rise) * foot / 2 - WATER * level**2 / 2
    return at_face(force, ((level + height + rise) ** 2 * foot / 6 - WATER * level**3 / 6) / force)


def over(level, head):
    """Above the crest the upstream face ends, and with it the triangle."""
    depth = level - head
    face = WATER * (depth * H - H**2 / 2)
    crest = LEFT * WATER * (level - H) * 3.0 if level > H else 0.0
    return at_face(face, WATER * (depth * H**2 / 2 - H**3 / 3) / face) - np.array([0, crest, 4.5 * crest])


def by_hand():
    whole, high = 2400 * G * THICK * H * 6.0, 0.032 * math.sqrt(90 * 8) + 0.763 - 0.271 * 8**0.25
    x, y = THICK * np.array(FORCE)
    return {"weight": np.array([0, -whole, -whole * 4.5]), "over": over(OVER, HEAD), "tail": at_face(WATER * 3.0**2 / 2, 1.0, downstream=True),
            "water": still(STILL), "wave": molitor(WAVE), "storm": molitor(high), "swell": sainflou(WAVE), "bridge": np.array([x, y, AT * y - (H + LEVER) * x])}  # fmt: skip


STAGES = {"flooded": ["weight", "over", "tail"], "waving": ["weight", "water", "wave"], "stormy": ["weight", "water", "storm"],
          "standing": ["weight", "water", "swell", "tail"], "used": ["weight", "bridge"]}  # fmt: skip


def resultants(result, stage):
    """(X, Y, M) that the base joint bears, from its openings."""
    now, k_n = result.stage(stage), 1e10
    x, opening = now.contacts.point[..., 0].ravel(), now.contacts.opening.ravel()
    slope, middle = np.polyfit(x - B / 2, opening, 1)
    n, m = -k_n * middle * B * THICK, -k_n * slope * B**3 / 12 * THICK
    return np.array([-result.stage_summary(stage)["reaction"]["x"], -n, -(n * B / 2 + m)])


def run(case):
    hand = by_hand()
    size = np.abs(sum(hand[name] for name in STAGES["flooded"]))
    stages = [{name: {"loads": loads}} for name, loads in STAGES.items()]
    at_rest(case, hand, size, stages)
    floods(case, hand, size)
    factors(case, hand, size)
    in_time(case)
    refused(case, stages)


def at_rest(case, hand, size, stages):
    for what, one in (("rigid", mesh()), ("one face", mesh(n=1, columns=1)), ("deformable", mesh(rigid=False, n=4)), ("triangles", mesh(rigid=False, triangles=True, n=4))):
        result = case.run(one, scene(*stages))
        for stage, names in STAGES.items():
            wanted = sum(hand[name] for name in names)
            if what in ("rigid", "one face"):
                case.check(f"{what}, {stage}: X, Y, M at the base [N, N m]", resultants(result, stage) / size, wanted / size, absolute=2e-6)
            reaction = result.stage_summary(stage)["reaction"]
            case.check(f"{what}, {stage}: reactions [N]", np.array([-reaction["x"], -reaction["y"]]) / size[:2], wanted[:2] / size[:2], absolute=1e-6)
        used = scenes.read(result.folder + "/scene_echo.yaml")
        for stage in STAGES if what != "triangles" else ():
            forces, left_out = section_cut.stage_forces(one, used, stage, pressed=result.stage(stage).loads)
            for name in STAGES[stage][1:]:
                case.check(f"... gravity method, {stage}, {name}: X, Y, M [N, N m]", forces[name] / size, hand[name] / size, absolute=1e-12)
            case.check("... knows all loads", left_out, [])
    for ranks in (3,):
        result = case.run(mesh(rigid=False, n=3), scene(stages[0], stages[-1]), ranks=ranks)
        for stage in ("flooded", "used"):
            wanted = sum(hand[name] for name in STAGES[stage])
            case.check(f"{ranks} ranks, {stage}: reactions [N]", [-result.stage_summary(stage)["reaction"][x] for x in "xy"], wanted[:2], absolute=1e-6 * size[0])
    large = case.run(mesh(rigid=False), scene(*stages, strain="large"))
    for stage, names in STAGES.items():
        case.check(f"large strain, {stage}: reactions [N]", [-large.stage_summary(stage)["reaction"][x] for x in "xy"], sum(hand[name] for name in names)[:2], absolute=2e-4 * size[0])
    not_met(case, stages)


def on_faces(places):
    """Force [N] on the upstream face of straight lines between places (elevation [m], pressure over the weight of the water [m]): what is above and below it is left out."""
    y, p = np.transpose(sorted(places))
    at = np.unique(np.clip([0, H, *y], 0, H))
    return WATER * np.trapezoid(np.interp(at, y, p), at)


def not_met(case, stages):
    """Loads that reach beyond their faces: reported, and by both methods what is on the faces."""
    silt = {"type": "silt", "faces": "up", "level": 13.0, "density": 950, "lateral": 0.4}
    odd = changed(scene(*stages), ("loads.wave.height", 3.0), ("loads.swell.bottom", -1.0), ("loads.tail.level", 14.0), ("loads.tail.effective", 1.0), ("loads.over.level", 12.2), ("loads.mud", silt))
    odd["loads"]["low"] = {"type": "tailwater", "faces": "down", "level": -1.0}
    odd["stages"].append({"buried": {"loads": ["weight", "mud", "low"]}})
    result = case.run(mesh(), odd, ranks=2)
    told = ["wave: its pressure reaches up to 12.5 m, the faces of up to 12 m: what is above them is left out", "swell: its pressure reaches down to -1 m, the faces of up to 0 m: what is below them is left out",
            "tail: its surface is at 14 m, the faces of down end at 12 m: what is above them is left out", "mud: its surface is at 13 m, the faces of up end at 12 m: what is above them is left out",
            "low: its surface is at -1 m, the faces of down begin at 0 m: it presses nowhere",
            "over: at the dam its surface is at 11.9 m, below the top of the faces of up at 12 m: no water runs over them, and none has a velocity_head"]  # fmt: skip
    case.check("pressures that reach beyond their faces are reported", [f"quoin: warning: loads.{line}\n" in result.stderr for line in told], [True] * len(told))
    case.check("... and nothing else, once", result.stderr.count("\n"), len(told))
    k = 2 * math.pi / WAVELENGTH
    d, below, rise = STILL + 1, WAVE / math.cosh(k * (STILL + 1)), math.pi * WAVE**2 / WAVELENGTH / math.tanh(k * (STILL + 1))
    tail = -on_faces([(-1, 15), (14, 0)])
    hand = {"wave": on_faces([(12.5, 0), (8.875, 7.2), (7.5, 0)]), "tail": tail, "mud": 0.4 * 0.95 * on_faces([(13, 0), (-1, 14)]), "low": 0.0, "over": on_faces([(11.9, 0), (-1, 12.9)]),
            "swell": on_faces([(STILL + WAVE + rise, 0), (STILL, (below + d) * (WAVE + rise) / (d + WAVE + rise)), (-1, below)])}  # fmt: skip
    used = scenes.read(result.folder + "/scene_echo.yaml")
    for stage, names in (*STAGES.items(), ("buried", ["weight", "mud", "low"])):
        if not {*names} & {*hand}:
            continue
        forces, _ = section_cut.stage_forces(mesh(), used, stage, pressed=result.stage(stage).loads)
        wanted = sum(hand.get(name, forces[name][0]) for name in names)
        case.check(f"... {stage}: what is on the faces, X of the block model and of the gravity method [N]", [-result.stage_summary(stage)["reaction"]["x"], sum(f[0] for f in forces.values())],
                   [wanted, wanted], relative=1e-5)  # fmt: skip


def floods(case, hand, size):
    """A wave rises with its water, a tailwater stays: also one as high as the reservoir."""
    loads = ["weight", "over", "tail", "wave"]
    keys = changed(scene({"first": {"loads": ["weight"]}}, {"flood": {"type": "flood", "loads": loads, "step": 0.5, "limit": 9.5}}),
                   ("loads.over.velocity_head", 0), ("loads.over.level", STILL), ("loads.tail.level", STILL))  # fmt: skip
    result = case.run(mesh(), keys)
    trials = result.stage_summary("flood")["flood"]["trials"]
    case.check("flood: levels of the waters [m]", [[t["waters"][name]["level"] for name in ("over", "tail", "wave")] for t in trials], [[8.5 + i / 2, 8.5, 8.5 + i / 2] for i in range(3)], absolute=1e-12)
    tail = at_face(WATER * (PART * STILL) ** 2 / 2, PART * STILL / 3, downstream=True)
    for t in trials:
        wanted = hand["weight"] + still(t["value"]) + molitor(WAVE, t["value"]) + tail
        case.check(f"... at {t['value']:g} m: N and T [N]", np.array([t["joints"]["default"][x] for x in "NT"]) / size[0], [-wanted[1] / size[0], wanted[0] / size[0]], absolute=1e-6)
    used = scenes.of_run(result.folder, result.summary)
    case.check("... gravity method at the last level: X, Y, M [N, N m]", section_cut.total(section_cut.stage_forces(mesh(), used, "flood", pressed=result.stage("flood").loads)[0]) / size, wanted / size, absolute=1e-12)
    named = case.run(mesh(), changed(keys, ("stages", [{"first": {"loads": ["weight"]}}, {"flood": {"type": "flood", "loads": loads, "step": 0.5, "limit": 9, "rises": ["tail"]}}])))
    last = named.stage_summary("flood")["flood"]["trials"][-1]
    case.check("the tailwater is named: it rises alone [m]", [last["waters"][name]["level"] for name in ("over", "tail", "wave")], [STILL, 9.0, STILL], absolute=1e-12)
    wanted = hand["weight"] + still(STILL) + molitor(WAVE) + at_face(WATER * (PART * 9) ** 2 / 2, PART * 3, downstream=True)
    case.check("... N and T [N]", np.array([last["joints"]["default"][x] for x in "NT"]) / size[0], [-wanted[1] / size[0], wanted[0] / size[0]], absolute=1e-6)
    weak = changed(keys, ("joints.default", {"k_n": 1e10, "k_s": 1e10, "friction": PHI}), ("stages", [{"flood": {"type": "flood", "loads": loads, "step": 0.5, "limit": 16}}]))
    result = case.run(mesh(n=1, columns=1), weak)
    found = result.stage_summary("flood")["flood"]
    low, high, asked = STILL, 16.0, None  # over the crest the wave is not whole: the sums of the gravity method, which are those by hand above
    while high - low > 1e-9:
        middle = (low + high) / 2
        loads_there = {name: load | ({"level": middle} if name in ("over", "wave") else {}) for name, load in used.loads.items()}
        made = scenes.Scene("", "", thickness=THICK, materials=weak["materials"], loads=loads_there, stages={"flood": {"loads": loads}})
        asked = asked or SceneLoads(mesh(n=1, columns=1), made)
        x, y, _ = section_cut.total(section_cut.stage_forces(asked.mesh, made, "flood", pressed=asked.of(made, "flood").table)[0])
        low, high = (middle, high) if x <= -y * math.tan(math.radians(PHI)) else (low, middle)
    case.check("a flood that slides the dam: stable below, fails above the level of T = N tan(phi) [m]", [found["stable"] <= low, low <= found["failing"], found["failing"] - found["stable"] <= 0.5 + 1e-9], [True] * 3)
    answer = bound(mesh(n=1, columns=1), scenes.of_run(result.folder, result.summary), "flood")
    case.check("... by limit analysis [m]", answer.value, low, absolute=1e-5)
    case.check("... which raises", sorted(answer.raised), ["over", "wave"])


def factors(case, hand, size):
    raised = ["over", "wave", "bridge"]
    factor = {"pushed": {"type": "load_factor", "loads": ["weight", "tail", *raised], "raises": raised, "start": 1, "step": 1, "limit": 2}}
    result = case.run(mesh(), scene({"first": {"loads": ["weight"]}}, factor))
    wanted = hand["weight"] + hand["tail"] + 2 * sum(hand[name] for name in raised)
    case.check("a load factor of 2: X, Y, M [N, N m]", resultants(result, "pushed") / size, wanted / size, absolute=1e-5)
    used = scenes.of_run(result.folder, result.summary)
    case.check("... gravity method", section_cut.total(section_cut.stage_forces(mesh(), used, "pushed", pressed=result.stage("pushed").loads)[0]) / size, wanted / size, absolute=1e-12)
    one, weak = mesh(n=1, columns=1), changed(scene({"first": {"loads": ["weight"]}}, changed(factor, ("pushed.start", 0.1), ("pushed.step", 0.05))), ("joints.default", {"k_n": 1e10, "k_s": 1e10, "friction": PHI}))
    live, dead, friction = sum(hand[name] for name in raised), hand["weight"] + hand["tail"], math.tan(math.radians(PHI))
    slides = -(dead[0] + friction * dead[1]) / (live[0] + friction * live[1])
    about = [f[2] - B * f[1] for f in (dead, live)]  # about the toe
    made = case.run(one, weak)
    exact, found = min(slides, -about[0] / about[1]), made.stage_summary("pushed")["load_factor"]
    case.check("limit analysis: the factor by hand", bound(one, scenes.of_run(made.folder, made.summary), "pushed").value, exact, relative=1e-7)
    case.check("... between the trials", [bool(found["stable"] <= exact <= found["failing"]), found["failing"] - found["stable"] <= 0.05 + 1e-9], [True, True])


def in_time(case):
    """Loads that follow the faces work on them: the account of the energy has it."""
    soft = changed(scene({"first": {"loads": ["weight"]}}, {"hit": {"type": "dynamic", "loads": ["weight", "over", "tail", "wave", "bridge"], "duration": 0.2}}),
                   ("materials.dam.young", 2e7), ("strain", "large"), ("joints.default.k_n", 1e9), ("joints.default.k_s", 1e9))  # fmt: skip
    result = case.run(mesh(rigid=False, n=3), soft)
    now = (result.history["stage"] == "hit") & np.isfinite(result.history["balance_J"])
    moved = sum(np.ptp(result.history[name][now]) for name in ("kinetic_J", "strain_J", "joints_J"))
    case.check("a blow of all of them on a soft dam: it moves [J]", bool(moved > 1e4), True)
    case.check("... balance of the account over what was moved", result.history["balance_J"][now] / moved, 0.0, absolute=1e-7)


def refused(case, stages):
    flood = [{"flood": {"type": "flood", "loads": ["weight", "over", "wave"], "step": 1, "limit": 15}}]
    for changes, words in (
        ((("loads.over.faces", "wet"),), "loads.over.crest: faces of crest are in wet too: expected none"),
        ((("loads.over.crest", "side"),), "loads.over: the mesh has no face set 'side'"),
        ((("loads.over", {"type": "overflow", "faces": "up", "level": OVER, "crest_pressure": 1}),), "loads.over.crest_pressure: there is no crest: give loads.over.crest"),
        ((("loads.tail.bottom", TAIL),), "loads.tail.bottom: 5 is not below the level 5 [m]"),
        ((("loads.storm.height", 1.0),), "loads.storm.height: a wave needs its height [m], or wind [m/s] and fetch [m], one of them"),
        ((("loads.wave.wind", 20),), "loads.wave.fetch: missing: wind and fetch belong together"),
        ((("loads.wave.length", 20),), "loads.wave.length: it is for formula: sainflou"),
        ((("loads.swell.height", 4.0),), "loads.swell.height: a wave of 4 m breaks: of this length it is 3.452 m high at most in 8.5 m of water"),
        ((("loads.bridge.at", 6.0),), "loads.bridge.at: 0 faces of crest are at 6 m: expected one, where the load is left of their right end"),
        ((("loads.wave.value", [1, 1]),), "loads.wave.value: does not belong to a load of type wave"),
        ((("stages", flood), ("loads.over.level", STILL)), "loads.over rises, but its velocity_head is that of one level: leave it out"),
        ((("stages", flood), ("loads.over.velocity_head", 0)), "loads.wave is a wave at the level 8.5 m, which no water of this stage has"),
        ((("stages", changed(flood[0], ("flood.rises", ["wave"]))), ), "stages.flood.rises: 'wave' is a wave: it rises with the water that has its level"),
    ):  # fmt: skip
        result = case.run(mesh(), changed(scene(*stages), *changes), ranks=1)
        case.check(f"refused: {words}", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])
