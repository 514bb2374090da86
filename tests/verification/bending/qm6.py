"""An independent linear solution of the dam of Fig. 6 with quadrilaterals of incompatible modes: QM6, the modes of Wilson with
Taylor's correction (gradients of 1 - xi^2, 1 - eta^2 by the Jacobian at the centre, times its determinant over the present one)."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

E, NU, RHO, WATER, G, K_N, K_S, B, H = 30e9, 0.2, 2400.0, 1000.0, 9.81, 30e9, 10e9, 80.0, 100.0
LAME, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
D = np.array([[LAME + 2 * MU, LAME, 0], [LAME, LAME + 2 * MU, 0], [0, 0, MU]])
CORNER = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)


def strain_matrix(gradients):
    matrix = np.zeros((3, 2 * len(gradients)))
    matrix[0, 0::2] = matrix[2, 1::2] = gradients[:, 0]
    matrix[1, 1::2] = matrix[2, 0::2] = gradients[:, 1]
    return matrix


def shape_slopes(point):
    return 0.25 * CORNER * (1 + CORNER[:, ::-1] * np.asarray(point)[::-1])


def quadrilateral(X, incompatible=True):
    """Stiffness [N/m] and areas of the four vertices [m2]."""
    K, coupling, inner, areas = np.zeros((8, 8)), np.zeros((8, 4)), np.zeros((4, 4)), np.zeros(4)
    centre = shape_slopes((0, 0)).T @ X
    for point in CORNER / np.sqrt(3):
        slopes = shape_slopes(point)
        jacobian = slopes.T @ X
        area = np.linalg.det(jacobian)
        compatible = strain_matrix(slopes @ np.linalg.inv(jacobian).T)
        modes = strain_matrix(np.diag(-2 * point) @ np.linalg.inv(centre).T * (np.linalg.det(centre) / area))
        K += compatible.T @ D @ compatible * area
        coupling += compatible.T @ D @ modes * area
        inner += modes.T @ D @ modes * area
        areas += 0.25 * np.prod(1 + CORNER * point, axis=1) * area
    return (K - coupling @ np.linalg.solve(inner, coupling.T) if incompatible else K), areas


def triangle(X):
    edges = X[[1, 2, 0]] - X[[2, 0, 1]]
    area = 0.5 * np.linalg.det(np.array([X[1] - X[0], X[2] - X[0]]))
    matrix = strain_matrix(np.column_stack([edges[:, 1], -edges[:, 0]]) / (2 * area))
    return matrix.T @ D @ matrix * area, np.full(3, area / 3)


def dam(n, incompatible=True):
    """Normal stress of the joint at heel and toe [MPa], horizontal displacement of the crest [mm]; n by n blocks."""
    number = {(i, j): j * (n + 1) + i for j in range(n) for i in range(n + 1)} | {(i, n): n * (n + 1) for i in range(n + 1)}
    X = np.array([(B * (1 - j / n) * i / n, H * j / n) for j in range(n) for i in range(n + 1)] + [(0, H)])
    load, entries = np.zeros(2 * len(X)), []

    def add(vertices, K):
        dofs = np.column_stack([2 * np.array(vertices), 2 * np.array(vertices) + 1]).ravel()
        entries.append((np.repeat(dofs, len(dofs)), np.tile(dofs, len(dofs)), K.ravel()))

    for j in range(n):
        for i in range(n):
            ring = [number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]][: 4 if j < n - 1 else 3]
            K, areas = quadrilateral(X[ring], incompatible) if j < n - 1 else triangle(X[ring])
            add(ring, K)
            load[2 * np.array(ring) + 1] -= RHO * G * areas
        low, high = number[0, j], number[0, j + 1]
        p = WATER * G * (H - X[[low, high], 1])
        load[[2 * low, 2 * high]] += H / n / 6 * np.array([[2, 1], [1, 2]]) @ p
        line = B / n / 6 * np.array([[2, 1], [1, 2]])  # of an elastic joint, stress linear along a segment
        add([number[j, 0], number[j + 1, 0]], np.kron(line, np.diag([K_S, K_N])))
    rows, columns, values = map(np.concatenate, zip(*entries))
    u = spsolve(coo_matrix((values, (rows, columns))).tocsc(), load)
    return np.array([K_N * u[1] * 1e-6, K_N * u[2 * n + 1] * 1e-6, u[2 * number[0, n]] * 1e3])
