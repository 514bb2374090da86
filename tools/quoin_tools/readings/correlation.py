"""How far the coefficients of a least-squares fit scatter whose residuals are correlated in time.

The covariance of the noise is taken as s0^2 I + s1^2 exp(-|days| / tau): what an instrument adds to each reading, and what lasts. Days are those between the readings, so
they may come by hand first and automatically later. s0, s1 and tau are found by moments: the sums of products of residuals that lie some readings apart are fitted to those that such noise leaves behind when the same unknowns are fitted to it. Otherwise what the fit takes away would make
the noise look smaller and shorter than it is. Standard errors by Newey and West (HAC) were tried: of 95 % intervals of a trend they hold 61 to 95 %.
"""

from dataclasses import dataclass

import numpy as np
import scipy

LASTING = (0.2, 0.4, 0.6, 0.7, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99, 0.995)  # exp(-days / tau) at the median distance of readings, tried
LAGS = 14  # from 0 to an eighth of the readings, in steps that grow


@dataclass(frozen=True)
class Noise:
    """deviation: of one reading [unit of the residuals]; lasting: share of its variance that lasts; correlation: of the lasting part at the median distance of readings;
    effective: number of independent readings that tell as much of the unknowns."""

    deviation: float
    lasting: float
    correlation: float
    effective: float


def times_correlation(columns, steps):
    """Returns the product of the correlation matrix with columns (n, p). steps (n - 1,): correlation from each reading to the next; that of two readings is the product between them."""
    if not steps.any():
        return columns
    bands = np.array([np.ones(len(columns)), np.r_[-steps, 0.0]])
    down = scipy.linalg.solve_banded((1, 0), bands, columns)
    up = scipy.linalg.solve_banded((1, 0), np.array([bands[0], np.r_[-steps[::-1], 0.0]]), columns[::-1])[::-1]
    return down + up - columns


def products(one, other, lags):
    """Returns the sums over i and columns of one[i + lag] other[i]."""
    return np.array([np.einsum("ij,ij->", one[lag:], other[: len(other) - lag]) for lag in lags])


def left_behind(q, time, tau, lags):
    """Returns the expected sums of products of the residuals of noise of variance 1 and correlation exp(-|days| / tau), 0: none, after a fit of the orthonormal columns q, and q' C q."""
    n, steps = len(q), np.exp(-np.diff(time) / tau) if tau else np.zeros(len(q) - 1)
    spread = times_correlation(q, steps)
    inner = q.T @ spread
    own = np.array([np.exp((time[: n - lag] - time[lag:]) / tau).sum() if tau else n * (lag == 0) for lag in lags])
    return own - products(q, spread, lags) - products(spread, q, lags) + products(q @ inner, q, lags), inner


def covariance(matrix, residuals, time):
    """Returns (covariance of the coefficients of a least-squares fit, its Noise). matrix: (n, p) in the order of time, of full rank; residuals: (n,); time [day]: (n,), rising."""
    n, p = matrix.shape
    q, triangle = np.linalg.qr(matrix)
    lags = np.r_[0, np.unique(np.round(np.geomspace(1, max(n / 8, 2), LAGS)).astype(int))]
    lags = lags[lags < n - 1]
    weights = 1 / np.sqrt(n - lags)
    found = products(residuals[:, None], residuals[:, None], lags) * weights
    size, usual = max(abs(found).max(), 1e-300), np.median(np.diff(time))
    short, _ = left_behind(q, time, 0.0, lags)
    best = None
    for r in LASTING:
        long, inner = left_behind(q, time, -usual / np.log(r), lags)
        parts, miss = scipy.optimize.nnls(np.column_stack([short, long]) * weights[:, None], found / size)
        if best is None or miss < best[0]:
            best = miss, parts * size, r, inner
    _, (own, lasting), r, inner = best
    total = max(own + lasting, 1e-300)
    middle = own * np.eye(p) + lasting * inner
    back = np.linalg.inv(triangle)
    effective = n * p / max(np.trace(middle) / total, p)
    return back @ middle @ back.T, Noise(float(np.sqrt(total)), float(lasting / total), r if lasting > 0 else 0.0, float(effective))
