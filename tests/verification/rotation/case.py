# ranks: 2
"""A deformable bar in free flight turns by 90 degrees (V26)."""

import numpy as np
from quoin_tools.meshing import join, rectangle, renamed

WHAT = "a deformable block turns by 90 degrees in free flight: no false stress, momentum kept (V26)"
SOURCE = "stress <= 2 rho w^2 L^2 / 8 (a bar, twice for the sudden spin); angular momentum I w; mass centre v t"

RHO, E, SIDE, HEIGHT, SPIN, V = 2400.0, 1e9, 1.0, 0.125, 10.0, np.array([1.5, -0.5])


def run(case):
    duration = np.pi / 2 / SPIN
    block = rectangle(0, 5, SIDE, HEIGHT, 16, 2, group="block")
    mesh = join([renamed(rectangle(-1, -1, 3, 1, group="base", rigid=True), {}), renamed(block, {}, {"mark": "top_right"})])
    scene = {
        "relaxation": {"allow_floating": True},
        "materials": {"block": {"density": RHO, "young": E, "poisson": 0.0, "spin": SPIN, "velocity": V.tolist()},
                      "base": {"density": RHO}},
        "joints": {"default": {"k_n": 1e9, "k_s": 1e9, "friction": 30}},
        "supports": {"base": {"fix": "xy"}},
        "loads": {"none": {"type": "point_force", "point": "mark", "value": [0, 0]}},
        "stages": [{"turn": {"type": "dynamic", "loads": ["none"], "duration": duration, "dt_factor": 0.2, "frames": 40}}],
    }
    results = [case.run(mesh, scene, ranks=ranks) for ranks in (1, 2)]
    result = results[0]
    frames = [result.stage(name) for name in [*result.frames("turn"), "turn"]]
    mine = result.mesh.block_group == result.mesh.group_names.index("block")
    static = RHO * SPIN**2 * SIDE**2 / 8  # at the middle of a bar that has spun for long
    stress = np.array([f.s1[mine].max() for f in frames])
    case.check("largest stress, twice that of steady spin: it spins all of a sudden [Pa]", stress.max(), 2 * static, relative=0.05)
    case.check("... its mean over time, that of steady spin [Pa]", stress[1:].mean(), static, relative=0.1)

    nodes = np.unique(result.mesh.blocks[mine])
    X = result.mesh.vertices[nodes]
    share = np.zeros(len(nodes))  # lumped masses: a quarter of every square
    for ring in result.mesh.blocks[mine]:
        share[np.searchsorted(nodes, ring)] += RHO * (SIDE / 16)**2 / 4
    end = X + frames[-1].displacement[nodes]
    centre = (share @ end) / share.sum()
    case.check("mass centre [m]", centre - (share @ X) / share.sum(), V * duration, absolute=1e-9)
    # angle of the best rotation from the first to the last shape
    a, b = X - (share @ X) / share.sum(), end - centre
    turned = np.arctan2(share @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), share @ (a * b).sum(axis=1))
    case.check("angle [rad]", turned, np.pi / 2, relative=1e-3)
    # momentum from the displacements between the last frames
    t = [f.time for f in frames]
    momentum = []
    for i in (0, len(frames) - 2):
        u, w = frames[i].displacement[nodes], frames[i + 1].displacement[nodes]
        middle, velocity = X + (u + w) / 2, (w - u) / (t[i + 1] - t[i])
        r = middle - (share @ middle) / share.sum()
        momentum.append(share @ (r[:, 0] * velocity[:, 1] - r[:, 1] * velocity[:, 0]))
    case.check("angular momentum, last over first", momentum[1] / momentum[0], 1.0, absolute=1e-3)
    case.check("same bits on 2 ranks", results[1].stage_summary("turn")["checksum"], result.stage_summary("turn")["checksum"])
