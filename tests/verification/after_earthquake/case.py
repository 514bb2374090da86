"""After the earthquake: a dam at rest, shaken on its joint, and at rest again, with the friction that is left and the uplift of a cracked base.

By hand: the sliding factor tan(phi) (W - U)/T of a triangle on a plane; angles of friction at which it slides."""

import math

import numpy as np
from driver import changed
from driver import load as other_case
from quoin_tools.assess import newmark
from quoin_tools.base import record
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "after the earthquake: static stages behind a shaken one keep its slip; factors with residual friction and full uplift"
SOURCE = "statics of a plane (VS16): 1.9200; 1.1085 with 30 degrees; 1.1200 and 0.6466 with full uplift"
BY = "by hand"

quake = other_case("added_mass").quake
G, BASE, LEVEL = 9.81, 40.0, 50.0
WEIGHT, THRUST, UPLIFT = BASE * LEVEL / 2 * 2400 * G, 9810 * LEVEL**2 / 2, 9810 * LEVEL * BASE / 2
LEFT_30 = {"default": {"friction": 30}}  # of 45 degrees

SCENE = {
    "strain": "small", "relaxation": {"tolerance": 1e-9, "history_every": 200},
    "materials": {"dam": {"density": 2400, "rigid": True}, "base": {"density": 2400, "rigid": True}},
    "joints": {"default": {"k_n": 50e9, "k_s": 20e9, "friction": 45, "damping": 2e-4}},
    "supports": {"base": {"fix": "xy", "motion": "quake.csv", "quantity": "acceleration"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": {"type": "reservoir", "faces": "upstream", "level": LEVEL},
              "hydro": {"type": "added_mass", "faces": "upstream", "level": LEVEL},
              "uplift": {"type": "uplift", "faces": "bottom", "level": LEVEL, "tailwater": 0, "rule": "linear"}},
}  # fmt: skip
REST, WET = ["weight", "water"], ["weight", "water", "uplift"]
SHAKE = {"type": "dynamic", "loads": [*REST, "hydro"], "duration": 12.5, "dt_factor": 0.1}


def triangle():
    dam = BlockMesh(np.array([[0.0, 0], [BASE, 0], [0, LEVEL]]), np.array([[0, 1, 2, -1]]), np.zeros(1), ["dam"], [True])
    dam.face_sets = {"bottom": np.array([[0, 0]]), "upstream": np.array([[0, 2]])}  # a triangle's faces are those between its vertices
    dam.points = {"heel": 0}
    return join([renamed(rectangle(-BASE, -10, 3 * BASE, 10, group="base", rigid=True), {}, {"foot": "bottom_left"}), dam])


def reduction(loads, start):
    return {"type": "strength_reduction", "loads": loads, "start": start, "step": 1, "bracket": 0.01}


def stages(*rows):
    return ("stages", list(rows))


def played(case, *changes, scale=1.5, ranks=1):
    folder = case.prepare(triangle(), changed(SCENE, *changes))
    (folder / "quake.csv").write_text(quake(scale))
    return case.again(folder, ranks=ranks)


def factors(result, stage):
    """The factors between which it begins to slide, with regard to its friction of 45 or 30 degrees."""
    found = result.stage_summary(stage)["strength_reduction"]
    return [found["safety_factor_stable"], found["safety_factor_failing"]]


def slip(result, stage):
    """[m] Slip of the contacts at the end of a stage; what is elastic left out."""
    return result.stage(stage).contacts.slip


def run(case):
    before(case)
    shaken(case)
    uplifted(case)
    ranks(case)


def before(case):
    """At rest, before anything has happened."""
    result = played(case, stages({"full": {"loads": REST}}, {"less": reduction(REST, 45)}))
    case.check("before: factor", factors(result, "less"), [WEIGHT / THRUST] * 2, relative=1e-3)


def shaken(case):
    """The slip of the shaking stays; 30 degrees of friction are left."""
    after = {"loads": REST, "joints": LEFT_30}
    result = played(case, stages({"full": {"loads": REST}}, {"shake": SHAKE}, {"after": after}, {"less": reduction(REST, 30)}))
    moved = [result.probe(s, "heel")[0] - result.probe(s, "foot")[0] for s in ("full", "shake", "after")]
    case.check("record x 1.5: the dam slides downstream [m], as its contacts do", moved[1] - moved[0], abs(slip(result, "shake")).mean(), relative=0.01)
    total = WEIGHT + G * 7 / 12 * 1000 * LEVEL**2  # with the water that moves with it
    rows = np.array([[float(x) for x in row.split(",")] for row in quake(1.5).splitlines()])
    block = newmark.slide(record.Record("", rows[:, 0], rows[:, 1]), newmark.yielding((WEIGHT - THRUST) / total, (WEIGHT + THRUST) / total))[0]
    case.check("... a rigid and plastic block, k_y 0.298, by [m]", moved[1] - moved[0], block.final, relative=0.1)
    case.check("after it, friction 30: stands", result.stage_summary("after")["verdict"], "converged")
    case.check("... the slip stays: it changes by [m]", abs(slip(result, "after") - slip(result, "shake")).max(), 0.0, absolute=1e-6)
    case.check("... the dam moves by what swings no more [m]", moved[2] - moved[1], 0.0, absolute=1e-4)
    case.check("... factor of the joint", result.stage_summary("after")["joints"]["default"]["sliding_factor_peak"], math.tan(math.radians(30)) * WEIGHT / THRUST, relative=1e-4)
    case.check("... factor by reduction", factors(result, "less"), [math.tan(math.radians(30)) * WEIGHT / THRUST] * 2, relative=1e-3)


def uplifted(case):
    """Full uplift in the cracked base: 45 degrees bear it, 30 do not."""
    shake = stages({"full": {"loads": REST}}, {"shake": SHAKE}, {"after": {"loads": WET}}, {"less": reduction(WET, 45)})
    result = played(case, shake)
    wanted = (WEIGHT - UPLIFT) / THRUST
    case.check("full uplift, friction 45: stands", result.stage_summary("after")["verdict"], "converged")
    case.check("... uplift [kN]", result.stage_summary("after")["joints"]["default"]["N"] / 1e3, (WEIGHT - UPLIFT) / 1e3, relative=1e-5)
    case.check("... factor by reduction", factors(result, "less"), [wanted] * 2, relative=1e-3)
    lost = played(case, stages({"full": {"loads": REST}}, {"shake": SHAKE}, {"after": {"loads": WET, "joints": LEFT_30}}))
    case.check("full uplift, friction 30, factor 0.6466: verdict", lost.stage_summary("after")["verdict"], "collapsed")


def ranks(case):
    rows = stages({"full": {"loads": REST}}, {"shake": SHAKE | {"duration": 2.0}}, {"after": {"loads": REST, "joints": LEFT_30}})
    results = [played(case, rows, scale=20, ranks=n) for n in (1, 2)]
    sums = [[r.stage_summary(s)["checksum"] for s in ("full", "shake", "after")] for r in results]
    case.check("checksums on 1 and 2 ranks", sums[0] == sums[1], True)
