"""From continuum to blocks on one mesh: `macroblocks: false` makes each block of a group a body of its own, with joints between."""

import numpy as np
from driver import changed
from quoin_tools.mesh.dam import G1, dam_mesh
from quoin_tools.mesh.meshing import rectangle, separated

WHAT = "continuum and blocks on one mesh: macroblocks: false"
SOURCE = "u = p h/E + n p/k for n joints across the column; joints of 10 k_n add a tenth; the dam as one body"
BY = "by hand; Quoin itself, one body"

COLUMN = {
    "relaxation": {"tolerance": 1e-10, "velocity_tolerance": 1e-10},
    "materials": {"body": {"density": 0, "young": 1e9, "poisson": 0.0}},
    "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}},
    "strain": "small",
    "supports": {"bottom": {"fix": "xy"}},
    "loads": {"press": {"type": "traction", "faces": "top", "value": [0, -1e5]}},
    "stages": [{"press": {"loads": ["press"]}}],
}
DAM = {
    "strain": "small",
    "relaxation": {"method": "preconditioned", "tolerance": 1e-8, "groups": ["all"]},
    "materials": {name: {"density": 2400, "young": 10e9, "poisson": 0.2} for name in ("dam", "rock")},
    "joints": {"base": {"law": "elastic", "k_n": 10e9, "k_s": 3e9}},
    "supports": {"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "y"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]},
              "water": {"type": "reservoir", "faces": "upstream", "level": 33.0}},
    "stages": [{"hp": {"loads": ["water"]}}, {"sw": {"loads": ["weight"]}}],
}


def run(case):
    column(case)
    guilhofrei(case)


def column(case):
    """Of 2 by 4 blocks, pressed by 0.1 MPa: three joints cross it."""
    mesh = rectangle(0, 0, 1, 2, 2, 4)
    mesh.points = {"corner": mesh.points["top_left"]}
    whole = case.run(mesh, COLUMN)
    case.check("column of 8 blocks, one body: u = p h/E [m]", whole.probe("press", "corner")[1], -2e-4, relative=1e-7)
    apart = changed(COLUMN, ("materials.body.macroblocks", False))
    folder = case.prepare(mesh, apart)
    result = case.again(folder)
    case.check("... each its own: u = p h/E + 3 p/k [m]", result.probe("press", "corner")[1], -5e-4, relative=1e-7)
    case.check("... macroblocks, contacts", [result.summary["n_macroblocks"], result.summary["n_contacts"]], [8, 10])
    expected = separated(mesh, ["body"])
    case.check("... vertices and blocks as the tools number them", [np.array_equal(result.mesh.vertices, expected.vertices),
               np.array_equal(result.mesh.blocks, expected.blocks)], [True, True])  # fmt: skip
    checksum = result.stage_summary("press")["checksum"]  # before its folder is written over
    two = case.again(folder, ranks=2)
    case.check("... same bits on 2 ranks", two.stage_summary("press")["checksum"], checksum)
    rigid = changed(apart, ("materials.body", {"density": 0, "rigid": True, "macroblocks": False}))
    case.check("... rigid ones: u = 3 p/k [m]", case.run(mesh, rigid).probe("press", "corner")[1], -3e-4, relative=1e-7)


def guilhofrei(case):
    """The dam of G1 with 24 columns as 793 bodies, its row of joints from the command line."""
    mesh = dam_mesh(G1, 24)
    folder = case.prepare(mesh, DAM)
    stages = ("sw", "hp")

    def crest(options=()):
        result = case.again(folder, *options)
        return np.array([1e3 * result.probe(name, "crest_upstream")[0] for name in stages]), result

    whole = crest()[0]
    rows = {}
    for k in ("1e12", "1e13"):
        options = ("-materials_dam_macroblocks", "false", "-joints_dam+dam_law", "elastic",
                   "-joints_dam+dam_k_n", k, "-joints_dam+dam_k_s", k)  # fmt: skip
        rows[k], result = crest(options)
        case.check(f"Guilhofrei, joints of {k} Pa/m: macroblocks", result.summary["n_macroblocks"], 793)
        case.check("... crest u_x, sw and hp, and those of the dam as one body [mm]", rows[k], whole, relative=0.01 if k == "1e12" else 0.001)
    case.check("-ksp_monitor acts on the solver of preconditioned relaxation", "KSP Residual norm" in crest(("-ksp_monitor",))[1].stdout, True)
    case.check("ten times stiffer joints: a tenth of the difference", (rows["1e13"] - whole) / (rows["1e12"] - whole), 0.1, relative=0.03)
