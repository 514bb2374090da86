"""Deformable bodies that slide, rock and land on each other, cut by the partition; and bodies left out of verification."""

import json

import numpy as np
from driver import changed
from quoin_tools.base.results import VERTEX_FACE
from quoin_tools.mesh.meshing import join, rectangle, renamed
from quoin_tools.mesh.stacks import column

WHAT = "bodies cut by the ranks choose the same faces; what is not upgradeable stays as it is"
SOURCE = "the run on one rank; the run with fixed connectivity"
BY = "Quoin itself, one rank and fixed connectivity"

SCENE = {
    "contact": {"connectivity": "variable", "tolerance": 0.01},
    "relaxation": {"allow_floating": True},
    "materials": {"base": {"density": 2400, "young": 2e8, "poisson": 0.2},
                  "block": {"density": 2400, "young": 5e7, "poisson": 0.2, "velocity": [3.0, -0.5], "spin": -2.0}},
    "joints": {"default": {"k_n": 1e9, "k_s": 1e9, "friction": 30, "damping": 1e-4}},
    "supports": {"bottom": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight"}},
    "stages": [{f"s{i}": {"type": "dynamic", "loads": ["weight"], "duration": 0.05, "dt_factor": 0.3}} for i in range(6)],
}


def turned(mesh, degrees, at):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    mesh.vertices = mesh.vertices @ np.array([[c, s], [-s, c]]) + np.array(at)
    return renamed(mesh, {})


def rocking():
    """Two blocks of several elements, one sliding over a step on its corner, one landing on a corner."""
    return join([renamed(rectangle(0, -1, 3, 1, 6, 2, "base"), {"bottom": "bottom"}),
                 renamed(rectangle(3, -1, 2, 0.9, 4, 2, "base"), {"bottom": "bottom"}),
                 turned(rectangle(0, 0, 1, 1, 4, 4, "block"), 8, (2.2, 0.0005)),
                 turned(rectangle(0, 0, 1, 0.6, 3, 2, "block"), -20, (0.5, 0.4))])


def checksums(result):
    return " ".join(stage["checksum"] for stage in result.summary["stages"])


def run(case):
    folder = case.prepare(rocking(), SCENE)
    result = case.again(folder)
    one = checksums(result)
    standing = [int((result.stage(name).contacts.klass == VERTEX_FACE).sum()) for name in result.stages]
    case.check("rocking: corners stand on faces", max(standing) > 0, True)
    others = {checksums(case.again(folder, "-partition", cut, ranks=ranks))
              for ranks, cut in ((2, "stripes"), (3, "stripes"), (4, "stripes"), (3, "metis"))}
    case.check("rocking: bits of 6 stages on 2, 3, 4 ranks, bodies cut", json.dumps(sorted(others)), json.dumps([one]))
    not_upgradeable(case)


def not_upgradeable(case):
    """A sheared column: contacts that are not verified are those of fixed connectivity, open or not."""
    scene = {"materials": {"base": {"density": 0}, "block": {"density": 2400}},
             "relaxation": {"tolerance": 1e-10, "velocity_tolerance": 1e-10},
             "joints": {"default": {"k_n": 1e9, "k_s": 3e8, "friction": 60}},
             "supports": {"bottom": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight"}, "push": {"type": "traction", "faces": "right", "value": [-5e3, 0]}},
             "stages": [{"rest": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"]}}]}
    variable = changed(scene, ("contact", {"connectivity": "variable", "tolerance": 1e-6}),
                       *((f"materials.{name}", scene["materials"][name] | {"upgradeable": False}) for name in ("base", "block")))
    fixed = case.run(column(4), scene)
    expected = fixed.stage().contacts
    case.check("column: a joint opens beyond the tolerance", bool(expected.opening.max() > 1e-5), True)
    runs = [case.run(column(4), variable, ranks=ranks) for ranks in case.ranks(1, 3)]
    kept = runs[0].stage().contacts
    case.check("column: verified", runs[0].stage_summary("push")["verifications"] > 10, True)
    case.check("column: opening [m]", kept.opening, expected.opening, absolute=1e-10)
    case.check("column: sliding, elastic [m]", kept.sliding - kept.slip, expected.sliding - expected.slip, absolute=1e-10)
    case.check("column: bits on 3 ranks", checksums(runs[1]), checksums(runs[0]))
