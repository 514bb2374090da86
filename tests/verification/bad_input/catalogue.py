#!/usr/bin/env python3
"""The catalogue of bad input: every wrong scene and block mesh of the tests, the message it gets and the exit code.

    tests/verification/bad_input/catalogue.py --quoin build/quoin                      check docs/generated/bad_input.md on 1 rank
    tests/verification/bad_input/catalogue.py --quoin build/quoin --ranks 1 2          on 1 and 2
    tests/verification/bad_input/catalogue.py --quoin build/quoin --write              write it, tried on 1 and 2 ranks

A fault stands here or in scene_faults.py and nowhere else, and its message in the document alone. With --refusals, the program of
refusals.c, one process for each number of ranks runs them all, in seconds; without, the program itself is started for each.

Scenes: one fault each in the good scene of tests/unit/scene/test_read.c, and texts made to do harm. Water in joints: one fault each in
a scene whose joints do not bear it out. Meshes: one fault each in a good block mesh, in its content or in the file. Exit code 1 when a
run does not end with exit code 2 and one line on stderr, when ranks do not agree on that line, or when the document says another one."""

import argparse
import ast
import contextlib
import difflib
import io
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from unittest.mock import patch

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import assemblies
from bad_input.case import GOOD, pushed, without_key
from bad_input.scene_faults import SCENE_FAULTS
from driver import ENVIRONMENT, ROOT, changed, dump, write
from quoin_tools.front.main import main as quoin_command
from quoin_tools.mesh.meshing import face_set_on, join, rectangle
from quoin_tools.mesh.stacks import two_bodies

DOCUMENT = ROOT / "docs" / "generated" / "bad_input.md"
UNIT = ROOT / "tests" / "unit" / "scene"
LIMIT = "Limit analysis"  # section of what quoin limit refuses


def c_strings(text):
    """Neighbouring string literals of C as one string."""
    return "".join(ast.literal_eval(part) for part in re.findall(r'"(?:[^"\\]|\\.)*"', text))


def good_scene():
    text = (UNIT / "test_read.c").read_text(encoding="utf-8")
    return c_strings(re.sub(r"//[^\n]*", "", re.search(r"good\[\] = (.*?);", text, re.DOTALL)[1]))


def scene_faults():
    """(what, scene text, options) of each fault in scene_faults.py."""
    good = good_scene()
    for before, after, *options in SCENE_FAULTS:
        assert before in good, before
        what = options[0] if options else f"{before} → {after}" if after else f"without {before}"
        yield what, good.replace(before, after, 1), " ".join(options).split()


def good_mesh():
    """Rock, dam and ground, each of two blocks, with the sets that the good scene names."""
    parts = [rectangle(0, i, 2, 1, nx=2, group=name) for i, name in enumerate(("ground", "rock", "dam"))]
    for part in parts:
        part.face_sets, part.points = {}, {}
    mesh = join(parts)
    mesh.face_sets = {"base": face_set_on(mesh, (0, 2), (2, 2)), "upstream": face_set_on(mesh, (0, 2), (0, 3)),
                      "sides": face_set_on(mesh, (0, 0), (0, 2)), "both": face_set_on(mesh, (2, 2), (2, 3))}  # fmt: skip
    mesh.points = {"tip": len(mesh.vertices) - 1, "both": 0}
    return mesh


def put(name, value):
    def change(file):
        del file[name]
        file[name] = value
    return change


def entry(name, at, value):
    def change(file):
        file[name][at] = value
    return change


def without(name):
    def change(file):
        del file[name]
    return change


def attribute(name, value):
    def change(file):
        file.attrs[name] = value
    return change


def link(name, target):
    def change(file):
        del file[name]
        file[name] = target
    return change


def move(group, dx, dy):
    def change(file):
        rows = np.unique(file["blocks"][()][file["block_group"][()] == group])
        file["vertices"][rows] = file["vertices"][rows] + [dx, dy]
    return change


def swap(file):
    file["blocks"][2] = file["blocks"][2][::-1]


def unwritten(file):
    del file["vertices"]
    file.create_dataset("vertices", (18, 2), "f8")


def mesh_faults():
    """(what, change of the HDF5 file) of each fault of a mesh."""
    return [
        ("version 9", attribute("version", 9)),
        ("version is text", attribute("version", np.bytes_("one"))),
        ("format of another program", attribute("format", np.bytes_("other-mesh"))),
        ("format of variable length", attribute("format", "quoin-mesh")),
        *((f"without /{name}", without(name)) for name in ("vertices", "blocks", "block_group", "groups", "groups/name", "groups/rigid")),
        ("vertices in single precision", put("vertices", np.zeros((18, 2), "f4"))),
        ("vertices with three coordinates", put("vertices", np.zeros((18, 3)))),
        ("vertices without a value", put("vertices", h5py.Empty("f8"))),
        ("vertices declared, never written", unwritten),
        ("blocks of 64 bits", put("blocks", np.zeros((6, 4), "i8"))),
        ("blocks without a sign", put("blocks", np.zeros((6, 4), "u4"))),
        ("blocks of five vertices", put("blocks", np.zeros((6, 5), "i4"))),
        ("no blocks", put("blocks", np.zeros((0, 4), "i4"))),
        ("fewer groups than blocks", put("block_group", np.zeros(5, "i4"))),
        ("rigid for one group too many", put("groups/rigid", np.zeros(4, "i4"))),
        ("names of 32 bytes", put("groups/name", np.array([b"ground", b"rock", b"dam"], "S32"))),
        ("group name with a path separator", entry("groups/name", 0, b"../ground")),
        ("group name with a line feed", entry("groups/name", 0, b"gro\nund")),
        ("empty group name", entry("groups/name", 0, b"")),
        ("two groups of one name", entry("groups/name", 0, b"rock")),
        ("rigid is 2", entry("groups/rigid", 0, 2)),
        ("vertices is a soft link", link("vertices", h5py.SoftLink("/blocks"))),
        ("vertices is a link to itself", link("vertices", h5py.SoftLink("/vertices"))),
        ("vertices in another file", link("vertices", h5py.ExternalLink("elsewhere.h5", "/vertices"))),
        ("vertices is a group", lambda file: (file.__delitem__("vertices"), file.create_group("vertices"))),
        ("2^40 vertices", lambda file: (file.__delitem__("vertices"), file.create_dataset("vertices", (1 << 40, 2), "f8", chunks=(1024, 2)))),
        ("2^31 blocks", lambda file: (file.__delitem__("blocks"), file.create_dataset("blocks", (1 << 31, 4), "i4", chunks=(1024, 4)))),
        ("2^20 vertices, of which one chunk is written", lambda file: (file.__delitem__("vertices"), file.create_dataset("vertices", (1 << 20, 2), "f8", chunks=(16, 2)).__setitem__(0, 1))),
        ("coordinate not a number", entry("vertices", 3, [np.nan, 0])),
        ("coordinate infinite", entry("vertices", 3, [np.inf, 0])),
        ("coordinate 1e300 m", entry("vertices", 3, [1e300, 0])),
        ("vertex 1000 of a block", entry("blocks", (1, 2), 1000)),
        ("vertex -2 of a block", entry("blocks", (1, 2), -2)),
        ("-1 in the first column", entry("blocks", (1, 0), -1)),
        ("vertex repeated", entry("blocks", 1, [1, 2, 2, 4])),
        ("group 7 of a block", entry("block_group", 1, 7)),
        ("clockwise block", swap),
        ("block without area", entry("vertices", 3, [0, 0])),
        ("block not convex", entry("vertices", 0, [0.9, 0.9])),
        ("vertex that no block uses", put("vertices", np.vstack([good_mesh().vertices, [9, 9]]))),
        ("bodies that overlap", move(2, 0, -0.25)),
        ("face set with a block too many", entry("face_sets/base", 0, [6, 0])),
        ("face set with a fifth face", entry("face_sets/base", 0, [4, 4])),
        ("face set with an inner face", entry("face_sets/base", 0, [4, 1])),
        ("face listed twice", lambda file: entry("face_sets/base", 1, file["face_sets/base"][0])(file)),
        ("face set of another shape", put("face_sets/base", np.zeros((2, 3), "i4"))),
        ("face set with a name that is none", lambda file: file.__setitem__("face_sets/a b", np.zeros((0, 2), "i4"))),
        ("point of a vertex that is not there", entry("points/tip", 0, 99)),
        ("point of two vertices", put("points/tip", np.zeros(2, "i4"))),
        ("point with a name that is none", lambda file: file.__setitem__("points/1st", np.zeros(1, "i4"))),
    ]


def text_faults():
    """(what, bytes) of scenes that are wrong as a text, whatever their keys."""
    good, laugh = good_scene(), "".join(f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]\n" for a, b in zip("abcdefghijk", "bcdefghijkl"))
    texts = [
        ("no text", ""), ("a comment alone", "# a dam\n"), ("a list", "- a\n- b\n"), ("one word", "dam\n"),
        ("aliases of aliases: 9^12 values", "a: &a [x]\n" + laugh + good), ("an alias of itself", "a: &a {b: *a}\n" + good),
        ("an alias of nothing", good + "output: *elsewhere\n"), ("a merge key", good.replace("{density: 2400", "{<<: {density: 1}, density: 2400")),
        ("100000 brackets in each other", good + "plane: " + "[" * 100000 + "]" * 100000 + "\n"),
        ("1000000 brackets, none closed", good + "plane: " + "[" * 1000000), ("50000 keys below each other", good + "plane: " + "{a: " * 50000),
        ("a list of 300000 names", good.replace("groups: [dam]", "groups: [" + "dam," * 300000 + "dam]")),
        ("100000 stages", good + "".join(f"  - s{i}: {{loads: [weight]}}\n" for i in range(100000))),
        ("a title of 10 MB", good.replace("title: Wall", "title: " + "W" * 10**7)), ("a number of 5 MB", good.replace("2400", "1" + "0" * 5 * 10**6)),
        ("a name of 10 MB", good + "? " + "W" * 10**7 + "\n: 1\n"), ("a scene of 17 MB", good + "# " + "W" * 17 * 10**6 + "\n"),
        ("title that colours a terminal", good.replace("title: Wall", 'title: "\\e[31mWall"')),
        ("title of two lines", good.replace("title: Wall", 'title: "Wall\\nquoin: done"')),
        ("title with a C1 control character", good.replace("title: Wall", 'title: "\\x9b31mWall"')),
        ("name that colours a terminal", good + '"\\e[31mred": 1\n'), ("a number with a zero byte behind it", good.replace("2400", '"2400\\0kg"')),
        ("output folder with a line feed", good + 'output: "o\\nut"\n'), ("%YAML 9.9", "%YAML 9.9\n---\n" + good),
        ("tags of Python objects", good.replace("gravity: 9.81", "gravity: !!python/object/apply:os.system [ls]")),
    ]
    coded = [("a zero byte", good.encode() + b"# \0\n"), ("Latin-1", good.replace("Wall", "Staumäuerchen").encode("latin-1")),
             ("UTF-8 that is too long", good.encode().replace(b"Wall", b"W\xc0\xafll")), ("UTF-16 without a mark", good.encode("utf-16-le"))]
    return [(what, text.encode()) for what, text in texts] + coded


def file_faults():
    """(what, function of the bytes of a good file -> bytes, or None for no file)."""
    return [("no such file", lambda data: None), ("not an HDF5 file", lambda data: b"vertices: none"), ("an empty file", lambda data: b""),
            ("cut off in the middle", lambda data: data[:len(data) // 2]), ("cut off after the header", lambda data: data[:96])]  # fmt: skip


def motion_faults():
    """(what, content or None for no file) of a file of support motion."""
    return [("no such file", None), ("an empty file", b""), ("one row", b"0, 0, 0\n"), ("a row of two numbers", b"0, 0, 0\n1, 0\n"),
            ("times that go back", b"0, 0, 0\n1, 0, 0\n0.5, 0, 0\n"), ("a time twice", b"0, 0, 0\n0, 0, 0\n"),
            ("a time three times", b"0, 0, 0\n1, 0, 0\n1, 1, 0\n1, 2, 0\n2, 0, 0\n"), ("two lines of names", b"t, x, y\ns, m/s, m/s\n0, 0, 0\n1, 0, 0\n"),
            ("a fourth column", b"0, 0, 0, 0\n1, 0, 0, 0\n"),
            ("a velocity that is not a number", b"0, 0, 0\n1, nan, 0\n"), ("an infinite time", b"0, 0, 0\ninf, 0, 0\n"),
            ("a velocity of 1e400", b"0, 0, 0\n1, 1e400, 0\n"), ("a way of 1e400 m", b"0, 0, 0\n1e200, 1e200, 0\n2e200, 0, 0\n"), ("rows with semicolons", b"0; 0; 0\n1; 0; 0\n"),
            ("a row that ends with a comma", b"0, 0, 0,\n1, 0, 0,\n"), ("a zero byte", b"0, 0, 0\n1, 0\0, 0\n"), ("one component", b"0, 0\n1, 0\n"),
            ("a word behind a number", b"0, 0, 0\n1, 2m, 0\n"), ("bytes", bytes(range(256)))]  # fmt: skip


PEER = "PEER NGA STRONG MOTION DATABASE RECORD\nHere, 1/1/2026\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS=      4, DT=   .0100 SEC\n"


def record_faults():
    """(what, file, its content or None, keys of the motion besides it)."""
    values, rows = ".1E-01 .2E-01\n.1E-01 0.\n", "0, 0\n1, 1\n2, -1\n3, 0\n"
    at2 = [("fewer values than NPTS says", PEER + ".1 .2 .3\n"), ("more values than NPTS says", PEER + values + ".1\n"),
           ("DT 0", PEER.replace(".0100", "0.") + values), ("DT in minutes", PEER.replace("SEC", "MIN") + values), ("no DT", PEER.replace("DT", "D") + values), ("DT that is no number", PEER.replace(".0100", "nan") + values),
           ("NPTS 1.5", PEER.replace("     4", "1.5") + values), ("NPTS 0", PEER.replace("     4", "0") + values), ("NPTS that is a word", PEER.replace("     4", "four") + values),
           ("a value that is no number", PEER + values.replace(".2E-01", "NaN")), ("text where a number should be", PEER + values.replace(".2E-01", "end")),
           ("two values grown together", PEER + values.replace(" .2", "-.2")), ("units that are not known", PEER.replace("OF G", "OF FURLONGS") + values),
           ("displacements", PEER.replace("OF G", "OF CM") + values), ("velocities", PEER.replace("OF G", "OF CM/S") + values),
           ("no units", PEER.replace("UNITS", "units").replace("IN units OF G", "") + values), ("no head", values), ("an empty file", "")]  # fmt: skip
    yield from ((f"AT2: {what}", "motion.AT2", content, "direction: x") for what, content in at2)
    yield "AT2 without direction", "motion.AT2", PEER + values, "scale: 1"
    yield "one component without direction", "motion.csv", rows, "scale: 1"
    yield "two components with a direction", "motion.csv", "0, 0, 0\n1, 1, 0\n", "direction: x"
    yield "four columns", "motion.csv", "0, 0, 0, 0\n1, 1, 0, 0\n", "direction: x"
    yield "rows of two and of three numbers", "motion.txt", "0 0\n1 1 1\n2 0\n", "direction: x"
    yield "no such file", "motion.csv", None, "direction: x"
    yield "baseline of three rows", "motion.csv", "0, 0\n1, 1\n2, 0\n", "direction: x, baseline: linear"
    yield "pga of rest", "motion.csv", "0, 0\n1, 0\n", "direction: x, pga: 2"
    yield "scaled beyond numbers", "motion.csv", "0, 0\n1, 1e300\n2, 0\n", "direction: x, scale: 1e300"


def water_mesh():
    """A dam of four blocks on rock of four, 4 m long, and a wall that stands apart."""
    rock, dam = rectangle(0, 0, 4, 1, nx=4, group="rock"), rectangle(0, 1, 4, 1, nx=4, group="dam")
    parts = [rock, dam, rectangle(9, 0, 1, 1, group="dam")]
    for part in parts:
        part.face_sets, part.points = {}, {}
    mesh = join(parts)
    mesh.face_sets = {"base": face_set_on(mesh, (0, 1), (4, 1)), "up": face_set_on(mesh, (0, 1), (0, 2)), "down": face_set_on(mesh, (4, 1), (4, 2)),
                      "left": face_set_on(mesh, (0, 0), (0, 2)), "apart": face_set_on(mesh, (9, 0), (9, 1)),
                      "bottom": face_set_on(mesh, (0, 0), (4, 0)), "foot": face_set_on(mesh, (9, 0), (10, 0))}  # fmt: skip
    return mesh


WATER = """\
model: model.h5
gravity: 9.81
materials: {rock: {density: 0, young: 20e9, poisson: 0.2}, dam: {density: 2400, young: 10e9, poisson: 0.2}}
joints:
  default: {k_n: 10e9, k_s: 3e9, law: elastic}
  base: {aperture: 2e-4, aperture_residual: 2e-5}
supports: {bottom: {fix: xy}, foot: {fix: xy}}
loads:
  weight: {type: self_weight}
  reservoir: {type: head, faces: up, level: 5}
  tail: {type: head, faces: down, level: 2}
  drain: {type: drain, joint: base, distance: 1.5}
stages:
  - own: {loads: [weight]}
  - full: {loads: [weight, reservoir, tail, drain]}
"""


def water_faults():
    """(what, scene) of each fault that shows on the joints of the mesh, though the keys are right."""
    held = ("base: {aperture: 2e-4, aperture_residual: 2e-5}", "base: {}", "type: head", "type: reservoir", "type: head", "type: tailwater",
            "level: 5", "level: 2", "level: 2}\n  drain", "level: 1.5}\n  drain")  # fmt: skip
    drain = "drain: {type: drain, joint: base, distance: 1.5}"
    changes = [
        ("gravity: 9.81", "gravity: 0"), ("aperture: 2e-4, aperture_residual: 2e-5", "flow: false"), ("aperture: 2e-4", "aperture: 1.5"),
        ("aperture_residual: 2e-5", "aperture_residual: 1.5"), ("distance: 1.5", "distance: 4.5"), ("joint: base", "joint: apart"),
        ("joint: base, distance: 1.5", "from: [1, 0.2], to: [3, 0.2]"), ("distance: 1.5", "distance: 0"), ("distance: 1.5", "distance: 4, conductance: 1e-6"),
        (drain, "drain: {type: curtain, from: [1, 3], to: [1, 5], width: 1, factor: 0.1}"),
        ("faces: up, level: 5", "faces: apart, level: 5"), ("faces: up, level: 5", "faces: base, level: 5"),
        (drain, "drain: {type: head, faces: left, level: 4}"),
        (drain, "drain: {type: uplift, faces: base, level: 5}"),
        (drain, "drain: {type: inflow, faces: apart, discharge: 1e-5}"),
        ("[weight, reservoir, tail, drain]", "[weight, drain], joints: {base: {flow: false}}"),
        ("distance: 1.5}\nstages", "distance: 1.5, conductance: 0}\n  rain: {type: inflow, faces: up, discharge: 1e-5}\nstages",
         "reservoir, tail, drain]", "rain, drain]"),
        ("loads: [weight, reservoir, tail, drain]}", "loads: [weight, reservoir]}\n  - quake: {type: dynamic, loads: [weight, reservoir, tail]}"),
        ("  - full: {", "  - full: {type: transient, duration: 10, ", "gravity: 9.81", "gravity: 9.81\nflow: {bulk_modulus: inf}"),
        ("gravity: 9.81", "gravity: 9.81\nflow: {dynamic: undrained}"),
        ("distance: 1.5", "distance: 1.5, heel: end"),
        (*held, drain, "drain: {type: uplift, faces: base, level: 2, tailwater: 1.5, heel: end}"),
        (*held, "type: reservoir", "type: tailwater", "type: tailwater, faces: down, level: 1.5", "type: reservoir, faces: down, level: 2", "up, level: 2", "up, level: 1.5",
         drain, "drain: {type: uplift, faces: base, level: 2, tailwater: 1.5, heel: start}"),
        (*held, "level: 1.5", "level: 2", drain, "drain: {type: uplift, faces: base, level: 2}", "loads: [weight, reservoir, tail, drain]}",
         "loads: [weight, reservoir, drain]}\n  - turned: {loads: [weight, tail, drain]}"),
    ]  # fmt: skip
    for change in changes:
        scene = WATER
        for before, after in zip(change[::2], change[1::2]):
            assert before in scene, before
            scene = scene.replace(before, after, 1)
        yield ", ".join(f"{before} → {after}" for before, after in zip(change[::2], change[1::2])), scene


def model_faults():
    """(what, scene, options) of each fault that shows on two bodies, one on the other."""
    def wet(*keys):
        """Water in the joint between them."""
        load = {"type": "uplift", "faces": "joint", "level": 5} | dict(keys)
        return changed(GOOD, ("loads.wet", load), ("stages", [{"weight": {"loads": ["weight", "wet"]}}]))

    return [
        ("missing material", without_key(GOOD, "materials.upper"), ()),
        ("load that does not exist", changed(GOOD, ("stages", [{"weight": {"loads": ["water"]}}])), ()),
        ("body held in x only floats", changed(GOOD, ("supports.bottom.fix", "x")), ()),
        ("quiet boundary that is no face set", changed(GOOD, ("supports.bottom", {"fix": "xy", "target": "lower", "boundary": "quiet"})), ()),
        ("quiet boundary of a rigid body", changed(GOOD, ("supports.bottom.boundary", "quiet"), ("materials.lower", {"density": 2400, "rigid": True})), ()),
        ("quiet boundary and other loads in time", changed(GOOD, ("supports.bottom.boundary", "quiet"), ("stages", [{"rest": {"loads": ["weight"]}}, {"shake": {"type": "dynamic", "loads": [], "duration": 1}}])), ()),
        ("quiet boundary and loads that nothing has stood under", changed(GOOD, ("supports.bottom.boundary", "quiet"), ("stages", [{"shake": {"type": "dynamic", "loads": ["weight"], "duration": 1}}])), ()),
        ("a stage in time in which nothing moves", changed(GOOD, ("supports.top", {"target": "upper", "fix": "xy"}), ("supports.lower", {"fix": "xy"}), ("stages", [{"shake": {"type": "dynamic", "loads": ["weight"], "duration": 1}}])), ()),
        ("waves and a support that is moved", changed(GOOD, ("supports.bottom", {"fix": "xy", "boundary": "quiet", "motion": "motion.csv"}), ("supports.top", {"target": "upper", "fix": "x", "motion": "motion.csv"})), ()),
        ("a wave that comes in through a boundary that holds", changed(GOOD, ("supports.bottom.input", "incident")), ()),
        ("support of nothing", changed(GOOD, ("supports.cellar", {"fix": "xy"})), ()),
        ("uplift on a set that is no joint", wet(("faces", "left")), ()),
        ("drain outside the base", wet(("rule", "npb"), ("drain", 3)), ()),
        ("unknown rule", wet(("rule", "icold")), ()),
        ("reduction that starts above the friction there is", pushed(50), ()),
        ("modes of what is condensed", changed(GOOD, ("materials.upper.condensed", True), ("stages", [{"weight": {"loads": ["weight"]}}, {"swing": {"type": "modes"}}])), ()),
        ("water that moves, and nothing else does", changed(GOOD, ("loads.hydro", {"type": "added_mass", "faces": "left", "level": 1}), ("stages", [{"weight": {"loads": ["weight", "hydro"]}}])), ()),
        ("water that moves below the faces", changed(GOOD, ("loads.hydro", {"type": "added_mass", "faces": "left", "level": -1}), ("stages", [{"shake": {"type": "dynamic", "loads": ["weight", "hydro"], "duration": 1}}])), ()),
        ("bad value of an option", GOOD, ("-gravity", "much")),
    ]  # fmt: skip


def limit_faults():
    """(what, mesh, scene, words) that quoin limit refuses, and the solver does not."""
    slope, barred, weir = assemblies.slope(3), assemblies.barred((0, 1)), assemblies.weir()
    pulled = {"type": "anchor_force", "anchors": ["bar"], "loads": ["weight"], "start": 1, "step": 0.1, "bracket": 0.1}
    tendon = {"head": [0, 1.5], "root": [0, -1], "area": 1e-3, "young": 200e9, "yield": 500e6, "prestress": 1e5}
    one = rectangle(0, 0, 1, 1, group="block", rigid=True)
    for what, (mesh, keys), changes, words in (
        ("water flows in joints, and no run has found its pressures", weir, [], []),
        ("--stage nothing", slope, [], ["--stage", "nothing"]),
        ("--raises wind", slope, [], ["--raises", "wind"]),
        ("a static stage of weight alone", slope, [("stages", [{"own": {"loads": ["weight"]}}])], []),
        ("--stage shake, of type dynamic", slope, [("stages", [{"own": {"loads": ["weight"]}}, {"shake": {"type": "dynamic", "duration": 1, "loads": ["weight"]}}])], ["--stage", "shake"]),
        ("a stage of type modes alone", slope, [("stages", [{"swing": {"type": "modes"}}])], []),
        ("--stage pull, of type anchor_force", barred, [("anchors.bar", tendon), ("stages", [{"pull": pulled}])], ["--stage", "pull"]),
        ("supports that hold all groups", slope, [("supports.block", {"fix": "xy"})], []),
        ("no supports, and allow_floating", slope, [("supports", {}), ("relaxation.allow_floating", True)], []),
        ("loads that are raised act on what is held", slope, [("loads.push.groups", ["ground"])], []),
        ("a mesh of one body", (one, slope[1]), [("materials", {"block": {"density": 2000, "rigid": True}}), ("supports", {"block": {"fix": "xy"}})], []),
    ):
        yield what, mesh, changed(keys, *changes), words


def limit_message(quoin, place, words):
    """As message_of, of quoin limit in this process: starting one for each takes longer than all of them."""
    said, before = io.StringIO(), os.getcwd()
    os.chdir(place)
    try:
        with patch.dict(os.environ, QUOIN_SOLVER=quoin), contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            code = quoin_command(words)
    finally:
        os.chdir(before)
    lines = said.getvalue().splitlines()
    if code != 2 or len(lines) != 1 or not lines[0].startswith("quoin limit: ") or "a fault of the program" in lines[0]:
        raise ValueError(f"{place.name}: exit code {code}, stderr {said.getvalue()[:400]!r}")
    return lines[0].removeprefix("quoin limit: ")


def messages():
    """{what: message} of the document, both as they stand in its cells."""
    rows = re.findall(r"^\| (`.*`) \| `(.*)` \| 2 \|$", DOCUMENT.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {what: message.replace("\\|", "|") for what, message in rows}


def prepare(folder):
    """A folder for each entry; (section, what, folder, options)."""
    entries = []

    def new(section, what, scene, options=()):
        place = folder / f"{len(entries):03d}"
        place.mkdir()
        (place / "scene.yaml").write_bytes(scene)
        entries.append((section, what, place, list(options)))
        return place / "model.h5"

    for what, scene, options in scene_faults():
        write(str(new("Scenes", what, scene.encode(), options)), good_mesh())
    for what, scene in text_faults():
        write(str(new("Scenes as texts", what, scene)), good_mesh())
    for what, scene in water_faults():
        write(str(new("Water in joints", what, scene.encode())), water_mesh())
    for what, change in mesh_faults():
        path = new("Block meshes", what, good_scene().encode())
        write(str(path), good_mesh())
        with h5py.File(path, "r+") as file:
            change(file)
    for what, change in file_faults():
        path = new("Files", what, good_scene().encode())
        write(str(path), good_mesh())
        data = change(path.read_bytes())
        path.unlink()
        if data is not None:
            path.write_bytes(data)
    for what, data in motion_faults():
        path = new("Files of support motion", what, good_scene().encode(), ["-supports_foot_motion", "motion.csv"])
        write(str(path), good_mesh())
        if data is not None:
            path.with_name("motion.csv").write_bytes(data)
    for what, name, text, keys in record_faults():
        path = new("Motions", what, f"motions: {{quake: {{file: {name}, {keys}}}}}\n{good_scene()}".encode(), ["-supports_foot_motion", "quake"])
        write(str(path), good_mesh())
        if text is not None:
            path.with_name(name).write_text(text, encoding="ascii")
    for what, scene, options in model_faults():
        path = new("Models", what, dump(scene).encode(), options)
        write(str(path), two_bodies())
        path.with_name("motion.csv").write_text("0, 0, 0\n1, 0, 0\n", encoding="ascii")
    for what, mesh, scene, words in limit_faults():
        write(str(new(LIMIT, what, dump({"model": "model.h5"} | scene).encode(), ["limit", "scene.yaml", *words])), mesh)
    return entries


def only_line(place, ranks, code, stderr):
    """What a run has said on stderr; ValueError when it is not one line and exit code 2."""
    # doubts of the scene come before; a line of Open MPI's event library may come behind
    lines = [line for line in stderr.splitlines() if not line.startswith(("quoin: warning: ", "[warn] Epoll"))]
    if code != 2 or len(lines) != 1 or not lines[0].startswith("quoin: error: ") or (place / "out").exists():
        raise ValueError(f"{place.name} on {ranks} ranks: exit code {code}, stderr {stderr[:400]!r}")
    return lines[0].removeprefix("quoin: error: ")


def started(ranks):
    return [] if ranks == 1 else ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"]


def run_each(quoin, entries, ranks):
    """(exit code, stderr) of each entry, by a start of the program for each."""
    def run(entry):
        _, _, place, options = entry
        done = subprocess.run([*started(ranks), quoin, "-options_file", "scene.yaml", *options], cwd=place, capture_output=True, text=True,
                              errors="replace", env=ENVIRONMENT | dict(os.environ), timeout=120)  # fmt: skip
        return done.returncode, done.stderr

    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(run, entries))


def run_together(refusals, entries, ranks):
    """As run_each, in one process of refusals.c; where that ends early, what follows has exit code None."""
    with tempfile.NamedTemporaryFile("w", suffix=".list", encoding="utf-8") as names:
        names.write("".join(" ".join([str(place), *options]) + "\n" for _, _, place, options in entries))
        names.flush()
        done = subprocess.run([*started(ranks), *refusals.split(), names.name], capture_output=True, text=True, errors="replace",
                              env=ENVIRONMENT | dict(os.environ), timeout=600)  # fmt: skip
    found = [(None, done.stderr[-1000:])] * len(entries)
    for i, (_, _, place, _) in enumerate(entries):
        said = re.search(rf"^refusals: {re.escape(str(place))}\n(.*?)^refusals: exit code (\d+)$", done.stderr, re.DOTALL | re.MULTILINE)
        if said:
            found[i] = int(said[2]), said[1]
    if done.returncode and found[-1][0] is not None:  # all are refused, and valgrind or a sanitizer has more to say
        found[-1] = done.returncode, done.stderr[-1000:]
    return found


def cell(text):
    return "`" + re.sub(r"\s*\n\s*", " ⏎ ", text.strip()).replace("|", "\\|").replace("`", "'").replace("\t", "⇥") + "`"


def document(entries, messages):
    lines = ["# Bad input and what is said about it", "",
             f"Written by `tests/verification/bad_input/catalogue.py`: {len(entries)} wrong scenes, block meshes and files, each tried on 1 and 2",
             "ranks. Each ends with exit code 2, nothing is written, and stderr holds one line, `quoin: error: ` and the text below, besides warnings.",
             "Scenes: the change made to a good scene, or the words added to the command line. What `quoin limit` refuses begins with",
             "`quoin limit: ` instead."]  # fmt: skip
    section = None
    for (name, what, _, _), message in zip(entries, messages):
        if name != section:
            section = name
            lines += ["", f"## {name}", "", "| what is wrong | message | exit code |", "|---|---|---|"]
        lines.append(f"| {cell(what)} | {cell(message)} | 2 |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quoin", type=Path, default=ROOT / "build" / "quoin")
    parser.add_argument("--refusals", metavar="COMMAND", help="the program of refusals.c, which runs all in one process")
    parser.add_argument("--write", action="store_true", help="write docs/generated/bad_input.md, tried on 1 and 2 ranks")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1])
    arguments = parser.parse_args()
    quoin = str(arguments.quoin.resolve())
    with tempfile.TemporaryDirectory() as folder:
        entries = prepare(Path(folder))
        solved = [entry for entry in entries if entry[0] != LIMIT]
        found = {ranks: run_together(arguments.refusals, solved, ranks) if arguments.refusals else run_each(quoin, solved, ranks)
                 for ranks in ((1, 2) if arguments.write else arguments.ranks)}  # fmt: skip
        messages, faults = [], []
        for i, (section, what, place, options) in enumerate(entries):
            try:
                said = {limit_message(quoin, place, options)} if section == LIMIT else {only_line(place, ranks, *runs[i]) for ranks, runs in found.items()}
                if len(said) > 1:
                    raise ValueError(f"ranks differ: {said}")
                messages.append(said.pop())
            except ValueError as error:
                faults.append(f"{what}: {error}")
    if not faults and arguments.write:
        DOCUMENT.write_text(document(entries, messages), encoding="utf-8")
    elif not faults and (expected := DOCUMENT.read_text(encoding="utf-8")) != document(entries, messages):
        faults += difflib.unified_diff(expected.splitlines(), document(entries, messages).splitlines(), str(DOCUMENT), "now", "", "", 0, "")
        faults.append(f"{DOCUMENT}: does not say what the solver says; write it again with --write")
    print("\n".join(faults) if faults else f"{len(entries)} entries, all refused in one line")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
