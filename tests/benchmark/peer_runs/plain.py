"""The independent solver: finite elements in numpy, one sparse Cholesky factor by CHOLMOD, and Newton for the joint.

Q4 with 2 x 2 points, T3, small strain; the joint is integrated with 32 points a segment, between which opening and slip
are linear. Nothing here comes from the solver under test. The seconds are analysis, factor and one solve of the elastic
problem, assembled already: the honest bar. With --friction the base is condensed (its flexibility takes as many solves as
it has degrees of freedom) and Newton's method runs on it, in --steps of the load; those seconds are no bar, the state is
the reference."""

import ctypes

import numpy as np
from fig6_dam import FRICTION, K_N, K_S, POISSON, YOUNG, Clock, Dam, arguments, gauss_points, report
from scipy.sparse import coo_matrix, tril

POINTS = 32  # of a segment of the joint
PLANE_STRAIN = YOUNG / ((1 + POISSON) * (1 - 2 * POISSON)) * np.array(
    [[1 - POISSON, POISSON, 0], [POISSON, 1 - POISSON, 0], [0, 0, 0.5 - POISSON]])  # fmt: skip


class Sparse(ctypes.Structure):
    """cholmod_sparse of CHOLMOD 3."""

    _fields_ = [*((name, ctypes.c_size_t) for name in ("nrow", "ncol", "nzmax")),
                *((name, ctypes.c_void_p) for name in ("p", "i", "nz", "x", "z")),
                *((name, ctypes.c_int) for name in ("stype", "itype", "xtype", "dtype", "sorted", "packed"))]  # fmt: skip


class Dense(ctypes.Structure):
    """cholmod_dense."""

    _fields_ = [*((name, ctypes.c_size_t) for name in ("nrow", "ncol", "nzmax", "d")), ("x", ctypes.c_void_p),
                ("z", ctypes.c_void_p), ("xtype", ctypes.c_int), ("dtype", ctypes.c_int)]  # fmt: skip


class Cholesky:
    """Supernodal factor of the lower half (scipy csc, sorted) of a symmetric positive definite matrix."""

    def __init__(self, lower):
        self.cholmod = ctypes.CDLL("libcholmod.so.3")
        for name in ("cholmod_analyze", "cholmod_solve"):
            getattr(self.cholmod, name).restype = ctypes.c_void_p
        self.common = ctypes.create_string_buffer(16384)  # larger than cholmod_common
        self.cholmod.cholmod_start(self.common)
        self.sparse = Sparse(*lower.shape, lower.nnz, lower.indptr.ctypes.data, lower.indices.ctypes.data, None,
                             lower.data.ctypes.data, None, -1, 0, 1, 0, 1, 1)  # fmt: skip
        self.factor = ctypes.c_void_p(self.cholmod.cholmod_analyze(ctypes.byref(self.sparse), self.common))
        if not self.cholmod.cholmod_factorize(ctypes.byref(self.sparse), self.factor, self.common):
            raise RuntimeError("CHOLMOD: the factorisation failed")

    def solve(self, right):
        """Solutions in the shape of right: (n) or (n, k)."""
        right = np.asfortranarray(right)
        columns = right.shape[1] if right.ndim == 2 else 1
        dense = Dense(len(right), columns, right.size, len(right), right.ctypes.data, None, 1, 0)
        answer = ctypes.c_void_p(self.cholmod.cholmod_solve(0, self.factor, ctypes.byref(dense), self.common))
        values = ctypes.cast(ctypes.cast(answer, ctypes.POINTER(Dense)).contents.x, ctypes.POINTER(ctypes.c_double))
        values = np.ctypeslib.as_array(values, (right.size,)).copy()
        self.cholmod.cholmod_free_dense(ctypes.byref(answer), self.common)
        return values.reshape(right.shape, order="F")


def strain_matrix(gradient):
    """B (elements, 3, 2 k) of the gradients (elements, 2, k) of the shape functions."""
    b = np.zeros((len(gradient), 3, 2 * gradient.shape[2]))
    b[:, 0, 0::2] = b[:, 2, 1::2] = gradient[:, 0]
    b[:, 1, 1::2] = b[:, 2, 0::2] = gradient[:, 1]
    return b


def element_matrices(dam):
    """Pairs (nodes of each element, stiffness matrices)."""
    quads = np.zeros((len(dam.quads), 8, 8))
    for _, _, local in gauss_points():
        jacobian = local @ dam.xy[dam.quads]
        b = strain_matrix(np.linalg.solve(jacobian, np.broadcast_to(local, (len(jacobian), 2, 4))))
        quads += np.linalg.det(jacobian)[:, None, None] * (b.transpose(0, 2, 1) @ (PLANE_STRAIN @ b))
    local = np.array([[-1.0, 1, 0], [-1, 0, 1]])
    jacobian = local @ dam.xy[dam.triangles]
    b = strain_matrix(np.linalg.solve(jacobian, np.broadcast_to(local, (len(jacobian), 2, 3))))
    triangles = np.linalg.det(jacobian)[:, None, None] / 2 * (b.transpose(0, 2, 1) @ (PLANE_STRAIN @ b))
    # the joint is two nodes of the base against the ground; its length integrates N N^T exactly
    segments = np.column_stack([dam.base[:-1], dam.base[1:]])
    mass = np.kron([[2, 1], [1, 2]], np.diag([K_S, K_N])) / 6 * np.diff(dam.xy[dam.base, 0])[:, None, None]
    return (dam.quads, quads), (dam.triangles, triangles), (segments, mass)


def assemble(dam):
    """Lower half of the stiffness with the elastic joint; degree of freedom 2 node + direction."""
    rows, columns, values = [], [], []
    for nodes, matrices in element_matrices(dam):
        dofs = (2 * nodes[:, :, None] + [0, 1]).reshape(len(nodes), -1)
        rows.append(np.repeat(dofs, dofs.shape[1], axis=1).ravel())
        columns.append(np.tile(dofs, dofs.shape[1]).ravel())
        values.append(matrices.ravel())
    size = 2 * len(dam.xy)
    whole = coo_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(size, size))
    lower = tril(whole.tocsc(), format="csc")
    lower.sort_indices()
    return lower


class Joint:
    """Coulomb joint without tension on a rigid line: forces of u (2 base nodes) on its degrees of freedom, and tangent."""

    def __init__(self, dam):
        xi = (np.arange(POINTS) + 0.5) / POINTS
        self.shape, self.weight = np.array([1 - xi, xi]), np.diff(dam.xy[dam.base, 0])[:, None] / POINTS
        self.slip = np.zeros((dam.n, POINTS))  # plastic part [m]

    def evaluate(self, u):
        """(force (2 b), tangent (2 b, 2 b), slip) of displacements u (2 b)."""
        u = u.reshape(-1, 2)
        u_s, u_n = (u[:-1, k, None] * self.shape[0] + u[1:, k, None] * self.shape[1] for k in (0, 1))
        sigma, trial = np.minimum(K_N * u_n, 0), K_S * (u_s - self.slip)
        limit = -FRICTION * sigma
        tau, sliding, closed = np.clip(trial, -limit, limit), np.abs(trial) >= limit, u_n < 0
        # d tau / d u_s, d tau / d u_n, d sigma / d u_n
        slopes = (np.where(sliding, 0, K_S), np.where(sliding & closed, -FRICTION * K_N * np.sign(trial), 0),
                  np.where(closed, K_N, 0))
        force, tangent = np.zeros_like(u), np.zeros((len(u), 2, len(u), 2))
        i = np.arange(len(u) - 1)
        for a in (0, 1):
            for k, stress in enumerate((tau, sigma)):
                np.add.at(force[:, k], i + a, (self.weight * self.shape[a] * stress).sum(axis=1))
            for b in (0, 1):
                for k, m, slope in ((0, 0, slopes[0]), (0, 1, slopes[1]), (1, 1, slopes[2])):
                    tangent[i + a, k, i + b, m] += (self.weight * self.shape[a] * self.shape[b] * slope).sum(axis=1)
        return force.ravel(), tangent.reshape(u.size, u.size), u_s - tau / K_S


def frictional(dam, factor, steps):
    """Displacements (nodes, 2) with the frictional joint, the load in equal steps; iterations.

    K0: stiffness with the elastic joint, K_j: the joint's part of it, F: K0^-1 on the base. Then
    u_b = share u_b0 + F (K_j u_b - force(u_b))."""
    joint, base = Joint(dam), np.arange(2 * len(dam.base))  # the base comes first
    load = dam.loads.ravel()
    unit = np.zeros((len(load), len(base)), order="F")
    unit[base, base] = 1
    flexibility, start = factor.solve(unit)[base], factor.solve(load)[base]
    elastic = np.zeros((len(base), len(base)))
    for nodes, matrix in zip(*element_matrices(dam)[2]):
        dofs = (2 * nodes[:, None] + [0, 1]).ravel()
        elastic[np.ix_(dofs, dofs)] += matrix
    def wrong(u, share):
        return u - share * start - flexibility @ (elastic @ u - joint.evaluate(u)[0])

    u, iterations = start / steps, 0
    for share in np.arange(1, steps + 1) / steps:
        error = wrong(u, share)
        while np.abs(error).max() > 1e-11 * np.abs(start).max():
            if iterations == 100 * steps:
                raise RuntimeError("the joint's iteration does not end")
            change = np.linalg.solve(np.eye(len(base)) - flexibility @ (elastic - joint.evaluate(u)[1]), error)
            u, iterations = u - change, iterations + 1
            error = wrong(u, share)
        joint.slip = joint.evaluate(u)[2]
    correction = np.zeros_like(load)
    correction[base] = elastic @ u - joint.evaluate(u)[0]
    return factor.solve(load + correction).reshape(-1, 2), iterations


def main():
    options = arguments(("--steps", {"type": int, "default": 1, "help": "of the load, with friction"}))
    dam = Dam(options.n)
    lower = assemble(dam)
    clock = Clock()
    factor = Cholesky(lower)
    u = factor.solve(dam.loads.ravel()).reshape(-1, 2)
    cost, iterations = clock.read(), 1
    if options.friction:
        u, iterations = frictional(dam, factor, options.steps)
    report(crest=u[dam.crest, 0], toe=dam.toe_stress(u[dam.base, 1]), corner=K_N * u[dam.base[-1], 1], iterations=iterations, **cost)


if __name__ == "__main__":
    main()
