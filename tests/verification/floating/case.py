"""Blocks that float in still water: pressure follows the faces as they move, in dynamic stages too."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import rectangle

WHAT = "heave and roll of a floating block, in time"
SOURCE = "heave w^2 = rho_w g b / m; small roll w^2 = rho_w g V GM / I, GM = b^3/12/V - BG; energy as that of springs"
BY = "closed forms of ship hydrostatics, by hand"

B, H, RHO, WATER, G = 2.0, 1.0, 600.0, 1000.0, 9.81
DRAUGHT = RHO / WATER * H
MASS = RHO * B * H
SCENE = {
    "contact": {"connectivity": "fixed"},
    "relaxation": {"allow_floating": True, "history_every": 50},
    "materials": {"block": {"density": RHO, "rigid": True}},
    "joints": {"default": {"k_n": 1e8, "k_s": 1e8, "friction": 30}},
    "loads": {"weight": {"type": "self_weight"}, "sea": {"type": "reservoir", "faces": "wet", "level": 0.0}},
}


def stage(duration):
    return "stages", [{"float": {"type": "dynamic", "loads": ["weight", "sea"], "duration": duration, "dt_factor": 0.5}}]


def block(nx=1, ny=1):
    """At its draught; wet: all faces but the deck."""
    mesh = rectangle(-B / 2, -DRAUGHT, B, H, nx=nx, ny=ny, group="block")
    sets, points = mesh.face_sets, mesh.points
    mesh.face_sets = {"wet": np.concatenate([sets[side] for side in ("bottom", "left", "right")])}
    mesh.points = {"keel": points["bottom_left"], "right": points["bottom_right"]}
    return mesh


def run(case):
    heave(case)
    roll(case)
    deformable(case)


def heave(case):
    """Pushed down at v: u = -v/w sin(w t)."""
    w, v = np.sqrt(WATER * G * B / MASS), 0.4
    scene = changed(SCENE, ("materials.block.velocity", [0.0, -v]), stage(float(2.5 * np.pi / w)))
    result = case.run(block(), scene)
    time = result.history["time_s"]
    u = -v / w * np.sin(w * time)
    case.check("heave of a rigid block [m]", result.history["keel_uy_m"], u, absolute=1e-4 * v / w)
    energy = result.stage_summary("float")["energy"]
    case.check("work of weight and water: -1/2 rho_w g b u^2 [J]", energy["outside"], -0.5 * WATER * G * B * u[-1] ** 2, relative=1e-3)
    case.check("balance over the energy at the start", energy["balance"] / (0.5 * MASS * v**2), 0.0, absolute=1e-12)
    dead = changed(scene, ("strain", "small"))
    moved = case.run(block(), dead).probe("float", "keel")[1]
    case.check("small strain: the water stays as it was, the block goes on at v [m]", moved, -v * time[-1], relative=1e-6)


def roll(case):
    """Spun slowly: theta = spin/w sin(w t); the centre of the water's plane, of buoyancy and of mass are on one line."""
    volume, centre, buoyancy = B * DRAUGHT, -DRAUGHT + H / 2, -DRAUGHT / 2
    metacentre = B**3 / 12 / volume - (centre - buoyancy)
    w = np.sqrt(WATER * G * volume * metacentre / (MASS * (B**2 + H**2) / 12))
    spin = 0.01
    scene = changed(SCENE, ("materials.block.spin", spin), stage(float(1.75 * np.pi / w)))
    result = case.run(block(), scene)
    theta = (result.history["right_uy_m"] - result.history["keel_uy_m"]) / B
    case.check("roll of a rigid block [rad]", theta, spin / w * np.sin(w * result.history["time_s"]), absolute=2e-4 * spin / w)


def deformable(case):
    """The same heave of a stiff block of 4 x 3 parts, cut by ranks: its wet faces have vertices of others."""
    w, v = np.sqrt(WATER * G * B / MASS), 0.4
    scene = changed(SCENE, ("materials.block", {"density": RHO, "young": 1e9, "poisson": 0.2, "velocity": [0.0, -v]}),
                    stage(float(0.5 * np.pi / w)))
    folder = case.prepare(block(4, 3), scene)
    result = case.again(folder)
    checksum = result.stage_summary("float")["checksum"]
    case.check("heave of a deformable block after a quarter of its period [m]", result.probe("float", "keel")[1], -v / w, relative=1e-3)
    for ranks in case.ranks(2, 3):
        case.check(f"same bits on {ranks} ranks", case.again(folder, ranks=ranks).stage_summary("float")["checksum"], checksum)
