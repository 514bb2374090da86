"""The step that `dt_factor: auto` takes in small strain against the fastest vibration of an independent stiffness matrix: never beyond the bound, and near it.

Distorted blocks, quadrilaterals and triangles, some much smaller and stiffer than the rest, held along their base or free, alone or on a joint; a run at that step keeps its energy."""

import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import closed_rings
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "step of dt_factor auto in small strain: bound from weighted row sums against the fastest vibration, distorted and graded meshes, joints, held and free"
SOURCE = "eigenvalues of stiffness and lumped masses assembled in Python (2 x 2 Gauss points, plane strain)"
BY = "independent eigenvalues of this project"

YOUNG, POISSON, DENSITY = 10e9, 0.2, 2400.0
FACTOR = 0.9  # of the bound that auto takes
SCENE = {
    "strain": "small",
    "materials": {name: {"density": DENSITY, "young": YOUNG, "poisson": POISSON, "element": "full"} for name in ("body",)},
    "joints": {"default": {"law": "elastic", "k_n": 20e9, "k_s": 8e9}},
    "supports": {"bottom": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight"}},
    "stages": [{"swing": {"type": "dynamic", "loads": ["weight"], "duration": 0.5, "dt_factor": "auto"}}],
}  # fmt: skip


def block(nx, ny, height, seed, triangles=False, grading=1.0):
    """nx by ny blocks 4 m wide, inner vertices moved by up to a fifth of a block; grading: each row is so many times as high as the one below."""
    mesh = rectangle(0, 0, 4.0, height, nx, ny)
    rows = np.concatenate([[0.0], np.cumsum(grading ** np.arange(ny))])
    y = np.round(mesh.vertices[:, 1] / height * ny).astype(int)
    mesh.vertices[:, 1] = height * rows[y] / rows[-1]
    rng = np.random.default_rng(seed)
    inside = (y > 0) & (y < ny) & (mesh.vertices[:, 0] > 1e-9) & (mesh.vertices[:, 0] < 4 - 1e-9)
    least = height * min(np.diff(rows)) / rows[-1]
    mesh.vertices[inside] += 0.2 * min(4.0 / nx, least) * rng.uniform(-1, 1, (inside.sum(), 2))
    if triangles:
        quads, n = mesh.blocks, len(mesh.blocks)
        mesh.blocks = np.concatenate([np.column_stack([quads[:, [0, 1, 2]], np.full(n, -1)]), np.column_stack([quads[:, [0, 2, 3]], np.full(n, -1)])]).astype(np.int32)
        mesh.block_group = np.concatenate([mesh.block_group, mesh.block_group]).astype(np.int32)
        mesh.face_sets = {name: np.column_stack([np.where(rows[:, 1] < 2, rows[:, 0], rows[:, 0] + n), np.where(rows[:, 1] < 2, rows[:, 1], rows[:, 1] - 1)]).astype(np.int32) for name, rows in mesh.face_sets.items()}
    return mesh


def stiffness(mesh):
    """(K, lumped masses), degrees of freedom x, y of each vertex."""
    factor = YOUNG / (1 + POISSON) / (1 - 2 * POISSON)
    D = factor * np.array([[1 - POISSON, POISSON, 0], [POISSON, 1 - POISSON, 0], [0, 0, 0.5 - POISSON]])
    K, masses = np.zeros((2 * len(mesh.vertices),) * 2), np.zeros(2 * len(mesh.vertices))
    for ring, blk in zip(closed_rings(mesh), mesh.blocks):
        n = 3 if blk[3] < 0 else 4
        X, dofs = mesh.vertices[ring[:n]], (2 * ring[:n, None] + [0, 1]).ravel()
        g = 1 / np.sqrt(3)
        points = [(0, 0)] if n == 3 else [(-g, -g), (g, -g), (g, g), (-g, g)]
        for r, s in points:
            if n == 3:
                dN, weight = np.array([[-1, -1], [1, 0], [0, 1]]), 0.5
                N = np.full(3, 1 / 3)
            else:
                signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
                dN, weight = np.column_stack([signs[:, 0] * (1 + s * signs[:, 1]), signs[:, 1] * (1 + r * signs[:, 0])]) / 4, 1.0
                N = (1 + r * signs[:, 0]) * (1 + s * signs[:, 1]) / 4
            J = X.T @ dN
            area, dX = weight * np.linalg.det(J), dN @ np.linalg.inv(J)
            B = np.zeros((3, 2 * n))
            B[0, 0::2], B[1, 1::2], B[2, 0::2], B[2, 1::2] = dX[:, 0], dX[:, 1], dX[:, 1], dX[:, 0]
            K[np.ix_(dofs, dofs)] += area * B.T @ D @ B
            masses[dofs] += DENSITY * area * np.repeat(N, 2)
    return K, masses


def longest(K, masses, held):
    """2 / omega of the fastest vibration, held degrees of freedom left out."""
    free = np.setdiff1d(np.arange(len(masses)), held)
    root = 1 / np.sqrt(masses[free])
    return 2 / np.sqrt(np.linalg.eigvalsh(root[:, None] * K[np.ix_(free, free)] * root)[-1])


def vertices_at(mesh, y):
    return np.flatnonzero(np.abs(mesh.vertices[:, 1] - y) < 1e-9)


def run(case):
    for name, mesh in (("quadrilaterals", block(6, 5, 4.0, 1)), ("triangles", block(5, 4, 4.0, 2, True)), ("rows that grow", block(6, 6, 6.0, 3, grading=1.7)), ("slender", block(2, 24, 30.0, 4)), ("one block", block(1, 1, 4.0, 5))):
        K, masses = stiffness(mesh)
        base = vertices_at(mesh, 0.0)
        limit = longest(K, masses, np.concatenate([2 * base, 2 * base + 1]))
        compare(case, name, mesh, SCENE, limit)
    joined(case)
    formulations(case)
    kept(case)


def compare(case, name, mesh, scene, limit, nearness=0.9):
    first = case.run(mesh, scene)
    stage = first.stage_summary("swing")
    step = stage["dt_initial"] if "dt_initial" in stage else stage["dt"]
    case.check(f"{name}: the bound is below the fastest vibration's, and near it", nearness < step / (FACTOR * limit) <= 1 + 1e-9, True)
    case.report("... bound over 2 / omega", step / (FACTOR * limit), 1.0)
    case.check("... energy kept", abs(stage["energy"]["balance"]) < 1e-9, True)
    if len(mesh.blocks) > 1:
        case.check("... the same step and bits on 2 ranks", case.run(mesh, scene, ranks=2).stage_summary("swing")["checksum"], stage["checksum"])


def joined(case):
    """Two blocks on a joint: springs at its ends as the elastic joint has them, so the bound is looked at from above only."""
    upper = rectangle(0, 4.0, 4.0, 1.0, 6, 2)
    mesh = join([block(6, 5, 4.0, 6), renamed(upper, {})])
    K, masses = stiffness(mesh)
    base = vertices_at(mesh, 0.0)
    pairs = vertices_at(mesh, 4.0)
    lower, over = pairs[: len(pairs) // 2], pairs[len(pairs) // 2 :]
    share = np.array([0.5, *np.ones(len(lower) - 2), 0.5]) * 4.0 / 6
    for axis, k in ((0, 8e9), (1, 20e9)):
        for a, b, length in zip(lower, over, share):
            i, j = 2 * a + axis, 2 * b + axis
            K[[i, j], [i, j]] += k * length
            K[[i, j], [j, i]] -= k * length
    compare(case, "two bodies on a joint", mesh, SCENE, longest(K, masses, np.concatenate([2 * base, 2 * base + 1])), nearness=0.75)


def formulations(case):
    """Blocks that bend or have one point have other stiffness: against the fastest of all vibrations that a stage of modes finds, by another matrix and another method."""
    mesh = block(3, 3, 4.0, 7)
    for element in ("full", "bending", "reduced"):
        scene = changed(SCENE, ("materials.body.element", element), ("stages", [{"all": {"type": "modes", "count": 2 * 3 * 4}}, *SCENE["stages"]]))
        result = case.run(mesh, scene)
        fastest = max(mode["f"] for mode in result.stage_summary("all")["modes"]["list"])
        step = result.stage_summary("swing")["dt"]
        case.check(f"{element}: below the fastest of all modes, and near it", 0.85 < step / (FACTOR / (np.pi * fastest)) <= 1 + 1e-6, True)
        case.report("... bound over 2 / omega", step / (FACTOR / (np.pi * fastest)), 1.0)


def kept(case):
    """Scenes whose bounds have no weights keep theirs: rigid blocks beside, large strain, damping by stiffness."""
    mesh = block(6, 6, 6.0, 3, grading=1.7)
    K, masses = stiffness(mesh)
    base = vertices_at(mesh, 0.0)
    limit = longest(K, masses, np.concatenate([2 * base, 2 * base + 1]))
    for name, scene in (("large strain", SCENE | {"strain": "large"}), ("beta", changed(SCENE, ("stages", [{"swing": SCENE["stages"][0]["swing"] | {"beta": 1e-5}}])))):
        stage = case.run(mesh, scene).stage_summary("swing")
        case.check(f"{name}: a step within the bound", stage["dt"] <= FACTOR * limit * (1 + 1e-9), True)
