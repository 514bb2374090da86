"""Bayesian updating of the parameters of the block model by the readings, on checked surfaces (surfaces.py).

    reading = model(level, day; z) + zero + rate * time + model error + instrument error

z: normal scores of the variables, prior standard normal within the box of the surface;
the last of them is the delay of the season behind the yearly wave of the air. Zero and rate only where an instrument has no zero of its own (displacement, joint
opening): unknown, flat prior, integrated exactly. Model error: standard deviation s (half-Cauchy prior, scale of the accuracy), correlation
exp(-|days| / tau). The surface errs alike wherever the state is alike, so its error does not fade as readings become many: a polynomial of level and season whose
coefficients have the size of its error on held-out runs. Instrument error: independent, of the stated accuracy. s and tau of each instrument lie on a grid, fine enough
that a band is as wide as with the true ones (steps of 1.8 in s made it 12 % wrong), and tau begins where readings no longer tell it from independent errors: more values
below would be a prior for such errors. The sum over the grid is exact, and what remains, the posterior of z alone, is sampled by emcee (moves by differential evolution).
"""

import copy
from dataclasses import dataclass

import numpy as np
import scipy

from quoin_tools.readings.sensors import ReadingsError
from quoin_tools.readings.surfaces import DELAY, YEAR, Box, Surface

MOST = 400  # readings of an instrument that are used; more are thinned evenly: days beside each other say little new
TAUS, SHORTEST, LONGEST_TAU = 7, 1 / 3, 600.0  # how many; over the usual distance of readings; [day]
SPREADS = np.geomspace(0.1, 40, 21)  # of the model error, over the accuracy of the instrument
UNLIKELY = 30.0  # logarithm below the likeliest at which a place on the grid is left out
HAS_ZERO = ("piezometric head", "pressure", "discharge")  # quantities whose zero is known: no constant, no rate is taken off
WALKERS, BURN, CHUNK, LONGEST = 48, 300, 500, 8000
ENOUGH = 1000  # effective samples
LENGTHS = 50  # of its correlation time that a chain has at least, or that time is not known
CHANCE = 1e-4  # of an instrument and the others in a right model that are as far apart: below, they contradict each other
FIRM, LOOSE, TIED = 0.5, 0.9, 0.8  # posterior over prior deviation: below, the readings decide; above, the prior does. Correlation of a pair that trades off


@dataclass
class Channel:
    """The readings of an instrument beside the model. time [day] from a common start, base (n, J) of the surface at the states, own (n, m): zero and rate, and the
    error of the surface; weight (m,) 1 over their prior variance, 0 where nothing is known."""

    name: str
    accuracy: float
    time: np.ndarray
    state: np.ndarray
    value: np.ndarray
    surface: Surface
    own: np.ndarray
    weight: np.ndarray
    free: bool
    base: np.ndarray
    taus: np.ndarray  # [day] on the grid
    vectors: list  # of the correlation of each tau
    roots: np.ndarray  # (taus, n) its eigenvalues

    @classmethod
    def of(cls, name, accuracy, time, state, value, surface, free, like=None):
        """free: the instrument has no zero of its own. like: a channel with the same times, whose decompositions are taken. Where the surface is one of logarithms, so are value and
        accuracy (over the median reading) of the channel."""
        if not accuracy or not accuracy > 0:
            raise ReadingsError(f"sensors.{name}.accuracy: missing: expected the standard deviation of a reading; the posterior depends on it")
        if surface.log and not (value > 0).all():
            raise ReadingsError(f"sensors.{name}: {(value <= 0).sum()} readings are not above 0: expected a discharge, whose logarithm is taken; exclude them, or the instrument")
        if surface.log:
            accuracy, value = accuracy / np.median(value), np.log(value)
        if like is not None and np.array_equal(like.time, time):
            taus, vectors, roots = like.taus, like.vectors, like.roots
        else:
            taus, lag = taus_of(time), np.abs(time[:, None] - time[None, :])
            pairs = [scipy.linalg.eigh(np.exp(-lag / tau), driver="evd") for tau in taus]
            vectors, roots = [pair[1] for pair in pairs], np.maximum(np.array([pair[0] for pair in pairs]), 0)
        return cls(name, accuracy, time, state, value, surface, *own_columns(surface, free, time, state), free, surface.states.of(state), taus, vectors, roots)

    def weights(self, t, s):
        """Returns (n,), one over the variance along the vectors of tau t with spread s."""
        return 1 / ((SPREADS[s] * self.accuracy) ** 2 * self.roots[t] + self.accuracy**2)

    def forms(self):
        """Returns what the likelihood needs of each (tau, spread): constant (g,), y P y (g,), base P y (J, g), base P base (J, g J). P: the inverse of the covariance without zero and rate."""
        constant, yy, by, bb = [], [], [], []
        for t, vectors in enumerate(self.vectors):
            y, base, own = (vectors.T @ one for one in (self.value, self.base, self.own))
            for s, spread in enumerate(SPREADS):
                w = self.weights(t, s)
                parts = np.column_stack([y, base])
                gram = parts.T @ (w[:, None] * parts)
                log = np.log(w).sum()
                if own.shape[1]:
                    inner, cross = own.T @ (w[:, None] * own) + np.diag(self.weight), own.T @ (w[:, None] * parts)
                    gram = gram - cross.T @ np.linalg.solve(inner, cross)
                    log -= np.linalg.slogdet(inner)[1]
                constant.append(0.5 * log + np.log(spread / (1 + spread**2)))
                yy.append(gram[0, 0])
                by.append(gram[1:, 0])
                bb.append(gram[1:, 1:])
        j = len(by[0])
        return np.array(constant), np.array(yy), np.array(by).T.copy(), np.array(bb).transpose(1, 0, 2).reshape(j, -1).copy()


def taus_of(time):
    """Returns the times [day] over which a model error may last, for readings at these times."""
    usual = np.median(np.diff(time)) if len(time) > 1 else 1.0
    return np.geomspace(np.clip(SHORTEST * usual, 0.1, 0.5 * LONGEST_TAU), LONGEST_TAU, TAUS)


def own_columns(surface, free, time, state):
    """Returns (columns (n, m), weight (m,)) of what a channel has beside the model: zero and rate per year where its zero is not known; the error of its surface."""
    x, angle = 2 * (state[:, 0] - surface.states.low) / (surface.states.high - surface.states.low) - 1, 2 * np.pi * state[:, 1] / YEAR
    own = [np.ones_like(time), time / YEAR] if free else []
    error = [np.ones_like(x), x, x**2, np.cos(angle), np.sin(angle)] if surface.error > 0 else []
    return np.array([*own, *error]).reshape(-1, len(time)).T, np.array([0.0] * len(own) + [len(error) / surface.error**2 for _column in error])


def log_sum(grid):
    """Returns (n,) the logarithm of the sum of exponentials of each row."""
    top = grid.max(axis=1)
    return top + np.log(np.exp(grid - top[:, None]).sum(axis=1))


class Likelihood:
    """Log-likelihood of normal scores: the sum over instruments of the sum over their model errors."""

    def __init__(self, channels, box):
        self.channels, self.box = channels, box
        self.forms = [channel.forms() for channel in channels]
        self.places = [np.arange(len(forms[0])) for forms in self.forms]

    def near(self, normal):
        """Leaves out the places on the grids that are unlikely at all these normal scores (n, d), where the samples will lie: most are, and cost time."""
        for k, (constant, yy, by, bb) in enumerate(self.forms):
            found = self.grid(k, normal)
            kept = (found > found.max(axis=1, keepdims=True) - UNLIKELY).any(axis=0)
            self.places[k] = self.places[k][kept]
            self.forms[k] = constant[kept], yy[kept], by[:, kept].copy(), bb.reshape(len(by), -1, len(by))[:, kept].reshape(len(by), -1).copy()

    def grid(self, k, normal):
        """Returns (n, g): of channel k with each of its model errors."""
        constant, yy, by, bb = self.forms[k]
        c = self.channels[k].surface.coefficients(normal)
        square = np.einsum("wgj,wj->wg", (c @ bb).reshape(len(c), -1, c.shape[1]), c)
        return constant - 0.5 * (yy - 2 * c @ by + square)

    def __call__(self, normal):
        """Returns (n,) log-posterior; minus infinity outside the box."""
        normal = np.atleast_2d(normal)
        inside = self.box.holds(normal)
        found = np.full(len(normal), -np.inf)
        if inside.any():
            z = normal[inside]
            found[inside] = sum(log_sum(self.grid(k, z)) for k in range(len(self.channels))) - 0.5 * (z**2).sum(axis=1)
        return found

    def without(self, k):
        """Returns the likelihood of all channels but k."""
        other = copy.copy(self)
        other.channels, other.forms, other.places = ([one for j, one in enumerate(row) if j != k] for row in (self.channels, self.forms, self.places))
        return other

    def errors(self, normal, random):
        """Draws (n, channels) places on the grid of model errors, given the normal scores."""
        drawn = [self.grid(k, normal) for k in range(len(self.channels))]
        return np.column_stack([places[np.argmax(one + random.gumbel(size=one.shape), axis=1)] for places, one in zip(self.places, drawn, strict=True)])


@dataclass
class Posterior:
    """normal (n, d): samples; errors (n, channels): places on the grids; r_hat, effective (d,)."""

    names: list
    channels: list
    box: Box
    normal: np.ndarray
    errors: np.ndarray
    r_hat: np.ndarray
    effective: np.ndarray
    steps: int

    def spread(self, k):
        """Returns samples of (s [as the values of the channel], tau [day]) of channel k."""
        t, s = np.divmod(self.errors[:, k], len(SPREADS))
        return SPREADS[s] * self.channels[k].accuracy, self.channels[k].taus[t]

    def mean(self):
        return self.normal.mean(axis=0)

    def predicted(self, k, time, state, most=300):
        """Returns (mean, standard deviation) of readings of channel k (logarithms, where its surface is one of them) at other times and states: over samples of z, model error, zero and rate; a reading near another one knows its model error."""
        channel = self.channels[k]
        pick = np.linspace(0, len(self.normal) - 1, min(most, len(self.normal))).astype(int)
        places, new, own = self.errors[pick, k], channel.surface.states.of(state), own_columns(channel.surface, channel.free, time, state)[0]
        mean, variance = np.zeros((len(pick), len(time))), np.zeros((len(pick), len(time)))
        for place in np.unique(places):
            mine = places == place
            t, s = divmod(int(place), len(SPREADS))
            w, vectors = channel.weights(t, s), channel.vectors[t]
            size = (SPREADS[s] * channel.accuracy) ** 2
            near = size * np.exp(-np.abs(time[:, None] - channel.time[None, :]) / channel.taus[t]) @ vectors  # (new, n)
            c = channel.surface.coefficients(self.normal[pick][mine]).T  # (J, samples)
            rest, basis = vectors.T @ (channel.value[:, None] - channel.base @ c), vectors.T @ channel.own
            spread = size + channel.accuracy**2 - (near**2 * w).sum(axis=1)
            found = new @ c + near @ (w[:, None] * rest)
            if own.shape[1]:
                inner = basis.T @ (w[:, None] * basis) + np.diag(channel.weight)
                beta = np.linalg.solve(inner, basis.T @ (w[:, None] * rest))
                further = own - near @ (w[:, None] * basis)
                found = found + further @ beta
                spread = spread + (further * np.linalg.solve(inner, further.T).T).sum(axis=1)
            mean[mine], variance[mine] = found.T, spread
        return mean.mean(axis=0), np.sqrt(variance.mean(axis=0) + mean.var(axis=0))

    def rate(self, k):
        """Returns (mean, standard deviation) of the rate [SI a year] of channel k that neither level nor season explains; None where its zero is known."""
        channel = self.channels[k]
        if not channel.free:
            return None
        mean, deviation = self.own(k)
        return float(mean[1]), float(deviation[1])

    def own(self, k, most=300):
        """Returns (mean, standard deviation) of what channel k has beside the model, zero and rate first, each (m,)."""
        channel, pick = self.channels[k], np.linspace(0, len(self.normal) - 1, min(most, len(self.normal))).astype(int)
        means, covers = [], []
        for z, place in zip(self.normal[pick], self.errors[pick, k], strict=True):
            t, s = divmod(int(place), len(SPREADS))
            w, vectors = channel.weights(t, s), channel.vectors[t]
            basis = vectors.T @ channel.own
            inner = np.linalg.inv(basis.T @ (w[:, None] * basis) + np.diag(channel.weight))
            rest = vectors.T @ (channel.value - channel.base @ channel.surface.coefficients(z)[0])
            means.append(inner @ (basis.T @ (w * rest)))
            covers.append(np.diag(inner))
        return np.mean(means, axis=0), np.sqrt(np.mean(covers, axis=0) + np.var(means, axis=0))


def sample(names, channels, box, seed=1, enough=ENOUGH, longest=LONGEST):
    """Samples the posterior until each variable has enough effective samples, or the longest chain is reached."""
    import emcee

    unknowns, there = len(names) + sum(2 * channel.free for channel in channels), sum(len(channel.value) for channel in channels)
    if not channels or there <= unknowns:
        raise ReadingsError(f"{there} readings of {len(channels)} instruments for {unknowns} unknowns: expected more")
    likelihood, random = Likelihood(channels, box), np.random.default_rng(seed)
    d, walkers = len(names), max(WALKERS, 4 * len(names))
    low, high = (scipy.special.ndtr(end) for end in (box.centre - box.half, box.centre + box.half))
    first = scipy.special.ndtri(low + (high - low) * random.random((4000, d)))
    value = likelihood(first)
    best = first[np.argmax(value)]
    centre, root = about_peak(likelihood, box, best)
    start = np.clip(centre + random.standard_normal((walkers, d)) @ root.T, box.centre - 0.99 * box.half, box.centre + 0.99 * box.half)
    likelihood.near(start)
    moves = [(emcee.moves.DEMove(), 0.7), (emcee.moves.DEMove(gamma0=1.0), 0.1), (emcee.moves.StretchMove(), 0.2)]  # the snooker move of emcee 3.1.6 leaves tails too short
    sampler = emcee.EnsembleSampler(walkers, d, likelihood, moves=moves, vectorize=True)
    at = sampler.run_mcmc(emcee.State(start, random_state=np.random.RandomState(seed).get_state()), BURN)  # noqa: NPY002 (what emcee takes)
    sampler.reset()
    while True:
        at = sampler.run_mcmc(at, CHUNK)
        chain = sampler.get_chain()
        length = np.array([emcee.autocorr.integrated_time(chain[:, :, k : k + 1], tol=0)[0] for k in range(d)])
        effective = chain.shape[0] * walkers / length
        if (effective.min() >= enough and chain.shape[0] >= LENGTHS * length.max()) or chain.shape[0] >= longest:
            break
    flat = chain.reshape(-1, d)
    flat = flat[np.linspace(0, len(flat) - 1, min(len(flat), 4000)).astype(int)]
    return Posterior(list(names), channels, box, flat, likelihood.errors(flat, random), r_hat(chain), effective, chain.shape[0])


def about_peak(likelihood, box, start):
    """Returns (the peak of the posterior near a start, a root of its covariance there), from differences of the log-likelihood."""
    d, step = len(start), 1e-3

    def gradient(points):
        """Returns (n, d)."""
        ends = points[:, None, None, :] + np.array([step, -step])[:, None, None] * np.eye(d)  # n, side, d, d
        value = likelihood(np.clip(ends, box.centre - box.half, box.centre + box.half).reshape(-1, d)).reshape(len(points), 2, d)
        return (value[:, 0] - value[:, 1]) / (2 * step)

    def both(z):
        return -float(likelihood(z)[0]), -gradient(z[None])[0]

    bounds = list(zip(box.centre - box.half, box.centre + box.half))
    peak = scipy.optimize.minimize(both, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 200}).x
    slopes = gradient(np.vstack([peak + step * np.eye(d), peak - step * np.eye(d)]))
    curved = -(slopes[:d] - slopes[d:]) / (2 * step)
    values, vectors = np.linalg.eigh(0.5 * (curved + curved.T))
    return peak, vectors / np.sqrt(np.maximum(values, 1.0))  # the prior alone curves by 1


def contradictions(posterior):
    """Returns {instrument: the peak (d,) that all others have without it}, where these others like the peak of all less, against their own, than they do by CHANCE in a right model.

    There twice the logarithm of that ratio is at most a chi-square number of d. A box that ends earlier makes it smaller."""
    likelihood, count, found = Likelihood(posterior.channels, posterior.box), len(posterior.channels), {}
    peak = about_peak(likelihood, posterior.box, posterior.mean())[0]
    most = scipy.stats.chi2.isf(CHANCE / count, len(posterior.names)) if count else 0.0
    for k in range(count if count > 1 else 0):
        less = likelihood.without(k)
        other = about_peak(less, posterior.box, peak)[0]
        if 2 * float(less(other)[0] - less(peak)[0]) > most:
            found[posterior.channels[k].name] = other
    return found


def r_hat(chain):
    """Returns (d,) of Gelman and Rubin, each walker cut into halves; near 1 where all tell the same."""
    half = chain.shape[0] // 2
    parts = np.concatenate([chain[:half], chain[half : 2 * half]], axis=1)
    within, between = parts.var(axis=0, ddof=1).mean(axis=0), parts.mean(axis=0).var(axis=0, ddof=1)
    return np.sqrt((half - 1) / half + between / within)


# ---- what the readings say of each variable ----------------------------------------------------------------


def summary(posterior, variables):
    """Returns rows (name, prior mean, deviation; posterior mean, deviation, 2.5 %, 97.5 %; posterior over prior deviation of the normal score; effective samples, R-hat)."""
    d = len(variables.each)
    scores = posterior.normal[:, :d]
    after = np.array(variables.values(scores), dtype=float)
    before, rows = [one.spread() for one in variables.each], []
    if len(posterior.names) > d:  # the delay of the season [day]
        after, before = np.column_stack([after, DELAY * posterior.normal[:, d]]), [*before, (0.0, DELAY)]
    ratios = np.column_stack([scores @ variables.root.T, posterior.normal[:, d:]]).std(axis=0)
    for k, name in enumerate(posterior.names):
        low, high = np.quantile(after[:, k], [0.025, 0.975])
        rows.append({"name": name, "prior_mean": before[k][0], "prior_sd": before[k][1], "mean": after[:, k].mean(), "sd": after[:, k].std(), "low": low, "high": high,
                     "ratio": float(ratios[k]), "effective": float(posterior.effective[k]), "r_hat": float(posterior.r_hat[k])})  # fmt: skip
    return rows


def correlations(posterior, variables):
    """Returns (d, d) of the normal scores of the variables."""
    d = len(variables.each)
    return np.corrcoef(np.column_stack([posterior.normal[:, :d] @ variables.root.T, posterior.normal[:, d:]]).T).reshape(len(posterior.names), -1)


def identified(rows, correlation):
    """Says in sentences what the readings do not tell: (sentence with places {0}.., arguments)."""
    said = []
    for row in rows:
        if row["ratio"] > LOOSE:
            said.append(("{0}: the prior alone gave {1:.0f} % of its spread: these readings say nothing of it.", row["name"], 100 * min(row["ratio"], 1.0)))
        elif row["ratio"] > FIRM:
            said.append(("{0}: its spread is {1:.0f} % of that of the prior: these readings say little of it.", row["name"], 100 * row["ratio"]))
    for i, j in zip(*np.triu_indices(len(rows), 1)):
        if abs(correlation[i, j]) > TIED:
            said.append(("{0} and {1} trade off (correlation {2:+.2f}): what these readings tell is a combination of them, each alone is less sure.", rows[i]["name"], rows[j]["name"], correlation[i, j]))
    return said
