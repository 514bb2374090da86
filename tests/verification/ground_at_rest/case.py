"""Ground under stress before anything is built: k0 times its weight sideways, reset behind it, a dam's lift on it; blocks that yield; ranks, restart."""

import numpy as np
from driver import changed, checksums
from quoin_tools.mesh.meshing import join, rectangle, renamed, split_triangles

WHAT = "ground at rest: sideways k0 times the weight above, in blocks of each kind; what is built on it; yielding by k0; ranks, restarts"
SOURCE = "k0 rho g depth by hand; first yield by the Mohr-Coulomb strength"
BY = "by hand"

WEIGHT = 2600 * 9.81
ROCK = {"density": 2600, "young": 20e9, "poisson": 0.25, "k0": 1.5, "surface": 0}
HELD = {"bottom": {"fix": "y"}, "left": {"fix": "x"}, "right": {"fix": "x"}}


def ground(triangles=False):
    mesh = rectangle(0, -10, 20, 10, 8, 5, group="rock")
    return split_triangles(mesh) if triangles else mesh


def scene(strain="small", **rock):
    return {"strain": strain, "materials": {"rock": ROCK | rock}, "supports": HELD, "loads": {"weight": {"type": "self_weight"}},
            "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9},
            "stages": [{"rock": {"loads": ["weight"]}}, {"after": {"loads": ["weight"], "displacements": "reset"}}]}  # fmt: skip


def stresses(result, stage, n_nodes=4):
    """Mean stress of each block [Pa], its depth [m], its area [m2]."""
    blocks, mesh = result.mesh.blocks[:, :n_nodes], result.mesh
    s = np.nanmean(result.stage(stage).gauss_stress.reshape(len(blocks), -1, 3), axis=1)
    p = mesh.vertices[blocks]
    area = 0.5 * np.abs(np.sum(p[..., 0] * np.roll(p[..., 1], -1, axis=1) - p[..., 1] * np.roll(p[..., 0], -1, axis=1), axis=1))
    return s, -p[..., 1].mean(axis=1), area


def run(case):
    rests(case)
    yields(case)
    built_on(case)


def rests(case):
    """Rows of rectangles have the stress of their centre; triangles have it over a row."""
    for k0 in (0.2, 1.5):
        for strain in ("small", "large"):
            for name, more in (("full", {}), ("bending", {"element": "bending"}), ("law", {"law": "mohr_coulomb", "cohesion": 5e6, "friction": 40}),
                               ("law that cracks", {"law": "damage", "tension": 5e6, "fracture_energy": 1e5})):  # fmt: skip
                result = case.run(ground(), scene(strain, k0=k0, **more))
                s, depth, _ = stresses(result, "after")
                case.check(f"k0 {k0}, {strain}, {name}: s_x, s_y over the weight above", np.stack([s[:, 0], s[:, 1]]) / (-WEIGHT * depth), np.stack([k0 + 0 * depth, 1 + 0 * depth]), absolute=1e-4)
                case.check("... displacements, reset [m]", result.stage("after").displacement, 0, absolute=1e-12)
    result = case.run(ground(True), scene())
    s, depth, area = stresses(result, "after", 3)
    case.check("triangles: force sideways of all of the ground [N]", np.sum(s[:, 0] * area) / 20, -1.5 * WEIGHT * 50, relative=1e-9)
    newton = case.run(ground(), changed(scene(), ("relaxation", {"method": "preconditioned", "tolerance": 1e-9})))
    s, depth, _ = stresses(newton, "after")
    case.check("by Newton's method: s_x over the weight above", s[:, 0] / (-WEIGHT * depth), 1.5, absolute=1e-6)


def yields(case):
    """Sideways 4 times the weight: by hand s_x may be at most N s_y + 2 c sqrt(N), N = tan(45 + phi/2)^2 = 3 for 30 degrees, so rock yields below 2 c sqrt(N) / (4 - 3) / weight."""
    cohesion = 0.3 * 6 * WEIGHT / np.sqrt(12)
    result = case.run(ground(), scene(k0=4, law="mohr_coulomb", cohesion=cohesion, friction=30, tension=0))
    s, depth, _ = stresses(result, "after")
    bears = -3 * WEIGHT * depth - 2 * cohesion * np.sqrt(3)
    case.check("k0 of 4 in rock with a friction of 30 degrees: s_x over the strength", s[:, 0] / np.maximum(bears, -4 * WEIGHT * depth), 1.0, absolute=2e-3)
    case.check("... blocks have yielded where by hand they do", bool(np.array_equal(result.stage("after").plastic_strain > 0, bears > -4 * WEIGHT * depth)), True)


def built_on(case):
    """A lift on reset ground moves it as if it were without stress; same bits on ranks, restart in each stage."""
    mesh = join([ground(), renamed(rectangle(8, 0, 4, 4, 2, 2, group="dam"), {})])
    full = scene("large")
    full["materials"]["dam"] = {"density": 2400, "young": 20e9, "poisson": 0.2}
    full["joints"] = {"default": {"k_n": 1e11, "k_s": 1e11, "law": "elastic"}}
    full["stages"] = [{"rock": {"loads": ["weight"]}}, {"dam": {"loads": ["weight"], "displacements": "reset", "build": ["dam"]}}]
    folder = case.prepare(mesh, changed(full, ("checkpoint", {"every": 300, "keep": 100})))
    first = case.again(folder)
    other = case.run(mesh, changed(full, ("materials.rock", {k: v for k, v in ROCK.items() if k not in ("k0", "surface")})))
    moved, as_before = (r.stage("dam").displacement for r in (first, other))
    case.check("a lift on it: settles as on ground without k0 [m]", moved, as_before, absolute=2e-4 * np.abs(as_before).max())
    case.again(folder, "-output", "kept")
    for ranks in case.ranks(2, 3, 4):
        case.check(f"checksums on {ranks} ranks", checksums(case.run(mesh, full, ranks=ranks)), checksums(first))
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    for i, at in enumerate((len(kept) // 3, len(kept) - 1)):
        case.check(f"restart from checkpoint {at} of {len(kept)}: checksums", checksums(case.again(folder, "-restart", kept[at], ranks=1 + i)), checksums(first))
