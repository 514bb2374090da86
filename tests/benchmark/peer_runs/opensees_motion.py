"""OpenSees on a shaken section of dam and rock: quad (2 x 2 points, small strain), lumped masses at nodes, UniformExcitation.

The bottom of the rock moves by the record along x, its sides are on rollers. The joint is zeroLength, k_n and k_s times a node's
share of the base, along and across it: stress model pt of the solver under test is the same joint. Newmark's average acceleration,
algorithm Linear with -factorOnce: the model is linear and the step constant, so that one factor serves all steps. Damping acts on
the masses alone, relative to the ground. Seconds are of the steps, without building the model and without the factor."""

import numpy as np
import openseespy.opensees as ops
from fig6_dam import Clock, arguments, report
from quoin_tools.base.record import read as read_record
from quoin_tools.mesh.blockmesh import areas, face_ends, read

OPTIONS = (("--mesh", {"required": True}), ("--record", {"required": True}), ("--duration", {"type": float, "required": True}),
           ("--dt", {"type": float, "default": 0.005}), ("--system", {"default": "UmfPack"}), ("--alpha", {"type": float, "default": 1.0}),
           ("--young", {"type": float, "default": 10e9}), ("--poisson", {"type": float, "default": 0.2}),
           ("--k-n", {"type": float, "default": 10e9}), ("--k-s", {"type": float, "default": 3e9}),
           ("--density", {"type": float, "nargs": 2, "default": (2400.0, 2500.0), "help": "of dam and rock"}))  # fmt: skip


def lumped(mesh, density):
    """Masses of nodes: shape functions integrated with 2 x 2 points, which is exact."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    rho = np.array(density)[mesh.block_group]
    masses = np.zeros(len(mesh.vertices))
    for point in corners / np.sqrt(3):
        one = 1 + corners * point
        gradient = np.array([corners[:, 0] * one[:, 1], corners[:, 1] * one[:, 0]]) / 4
        np.add.at(masses, mesh.blocks, rho[:, None] * np.linalg.det(gradient @ mesh.vertices[mesh.blocks])[:, None] * one.prod(axis=1) / 4)
    assert np.isclose(masses.sum(), (rho * areas(mesh)).sum())
    return masses


def joint(mesh):
    """Pairs of nodes that face each other across the base, their shares of its length, and its direction."""
    dam = mesh.group_names.index("dam")
    faces = mesh.face_sets["base"]
    upper = face_ends(mesh, faces[mesh.block_group[faces[:, 0]] == dam])
    lower = np.unique(face_ends(mesh, faces[mesh.block_group[faces[:, 0]] != dam]))
    share = {}
    for a, b in upper:
        for node in (a, b):
            share[node] = share.get(node, 0.0) + np.linalg.norm(mesh.vertices[b] - mesh.vertices[a]) / 2
    for node, length in share.items():
        other = lower[np.argmin(np.linalg.norm(mesh.vertices[lower] - mesh.vertices[node], axis=1))]
        assert np.allclose(mesh.vertices[other], mesh.vertices[node])
        yield int(other), int(node), length
    ends = mesh.vertices[list(share)]
    joint.along = ends[ends[:, 0].argmax()] - ends[ends[:, 0].argmin()]


def build(mesh, options):
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    for i, xy in enumerate(mesh.vertices.tolist(), 1):
        ops.node(i, *xy)
    ops.nDMaterial("ElasticIsotropic", 1, options.young, options.poisson)
    for i, row in enumerate((mesh.blocks + 1).tolist(), 1):
        ops.element("quad", i, *row, 1.0, "PlaneStrain", 1)
    for i, mass in enumerate(lumped(mesh, options.density).tolist(), 1):
        ops.mass(i, mass, mass)
    pairs = list(joint(mesh))
    x, y = (joint.along / np.linalg.norm(joint.along)).tolist()
    for k, (lower, upper, share) in enumerate(pairs):
        material = 2 + 2 * k
        ops.uniaxialMaterial("Elastic", material, options.k_s * share)
        ops.uniaxialMaterial("Elastic", material + 1, options.k_n * share)
        ops.element("zeroLength", len(mesh.blocks) + 1 + k, lower + 1, upper + 1, "-mat", material, material + 1, "-dir", 1, 2,
                    "-orient", x, y, 0.0, -y, x, 0.0)  # fmt: skip
    bottom = set(np.unique(face_ends(mesh, mesh.face_sets["rock_bottom"])).tolist())
    for node in bottom | set(np.unique(face_ends(mesh, mesh.face_sets["rock_sides"])).tolist()):
        ops.fix(node + 1, int(node in bottom), 1)
    ops.region(1, "-nodeOnlyRange", 1, len(mesh.vertices), "-rayleigh", options.alpha, 0.0, 0.0, 0.0)


def shake(options):
    record = read_record(options.record)
    ops.timeSeries("Path", 1, "-time", *record.t.tolist(), "-values", *record.a.tolist())
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system(options.system)
    ops.integrator("Newmark", 0.5, 0.25)
    ops.algorithm("Linear", "-factorOnce")
    ops.analysis("Transient")


def main():
    options = arguments(*OPTIONS)
    mesh = read(options.mesh)
    build(mesh, options)
    shake(options)
    crest, rock = mesh.points["crest_upstream"] + 1, mesh.points["rock_heel"] + 1
    steps = round(options.duration / options.dt)
    found = np.zeros(steps + 1)
    first = Clock()
    if ops.analyze(1, options.dt):
        raise SystemExit("OpenSees: the analysis failed")
    first = first.read()
    clock = Clock()
    for i in range(2, steps + 1):
        if ops.analyze(1, options.dt):
            raise SystemExit("OpenSees: the analysis failed")
        found[i] = ops.nodeDisp(crest, 1) - ops.nodeDisp(rock, 1)
    cost = clock.read()
    report(crest=float(np.abs(found).max()), steps=steps, factor_s=first["cpu_s"], **cost)


if __name__ == "__main__":
    main()
