"""Finds a parameter that drifts: which one, from when, how fast, by the joint readings of all instruments.

    found = search(posterior)      found.alarm, found.named() {parameter: probability}, found.start [day], found.rate

A parameter that drifts has the normal score z + rate * max(t - start, 0) after a start. To first order an instrument then reads more by the derivative of its
surface times that. For each parameter and each start of a grid this column is fitted by generalized least squares beside all that may be unknown without drift: z
itself (with its prior), zero and rate of an instrument. The gain in chi-square says how sure it is; the chance of such a gain without drift is told for all the
parameters and starts together (Bonferroni). Which parameter it is, is another question: a gain that is sure may be explained by several. The probability of each, given
that one of them drifts, is the likelihood of its column summed over starts, all alike likely beforehand, and rates (RATE).
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from quoin_tools.readings.surfaces import YEAR

STEP = 0.02  # of a normal score, for derivatives
EVERY = YEAR / 12  # [day] between starts that are tried
LEAST = 0.25 * YEAR  # [day] of readings after a start
CHANCE = 1e-4  # of an alarm without drift, below which there is one
LIKELY = 3.84  # gain below the best at which a start is still likely (95 %)
RATE = 1.0  # [prior deviations a year] prior deviation of a rate, by which parameters are told apart; an alarm does not depend on it
NAMED = 0.95  # probability of the parameters that are named, together


@dataclass
class Drift:
    """name: the likeliest parameter; start, first, last [day]: its best start, and between which it is likely; rate [normal scores a year]; chance: of the largest gain of all without drift; probability: {name: that it is this parameter which drifts};
    starts [day], gains (parameters, starts): all that were tried."""

    name: str
    start: float
    first: float
    last: float
    rate: float
    deviation: float
    gain: float
    chance: float
    probability: dict
    starts: np.ndarray
    gains: np.ndarray

    @property
    def alarm(self):
        return self.chance < CHANCE

    def least(self):
        """Returns the gain from which there is an alarm."""
        return float(scipy.stats.chi2.isf(CHANCE / self.gains.size, 1))

    def named(self):
        """Returns {parameter: probability} of the fewest that together are likely enough, the likeliest first."""
        ranked = sorted(self.probability.items(), key=lambda item: -item[1])
        before = np.cumsum([0.0, *(share for _name, share in ranked)])
        return {name: share for (name, share), sum_ in zip(ranked, before) if sum_ < NAMED}


class Whitened:
    """The readings of all instruments less the model at the posterior's mean, and derivatives by z, each row with variance 1 and independent."""

    def __init__(self, posterior):
        z = posterior.mean()
        d = len(z)
        rest, slopes, own, self.roots, self.slopes, self.times = [], [], [], [], [], []
        for k, channel in enumerate(posterior.channels):
            spread, tau = posterior.spread(k)
            spread, tau = float(np.sqrt((spread**2).mean())), float(np.exp(np.log(tau).mean()))
            cover = spread**2 * np.exp(-np.abs(channel.time[:, None] - channel.time[None, :]) / tau)
            known = channel.weight > 0
            cover += (channel.own[:, known] / channel.weight[known]) @ channel.own[:, known].T
            root = np.linalg.cholesky(cover + channel.accuracy**2 * np.eye(len(channel.time)))
            c = channel.surface.coefficients(np.vstack([z, z + STEP * np.eye(d), z - STEP * np.eye(d)]))
            slope = channel.base @ ((c[1 : d + 1] - c[d + 1 :]) / (2 * STEP)).T  # (n, d)
            white = scipy.linalg.solve_triangular(root, np.column_stack([channel.value - channel.base @ c[0], slope, channel.own[:, ~known]]), lower=True)
            rest.append(white[:, 0])
            slopes.append(white[:, 1 : d + 1])
            own.append(white[:, d + 1 :])
            self.roots.append(root)
            self.slopes.append(slope)
            self.times.append(channel.time)
        prior = np.column_stack([np.eye(d), np.zeros((d, sum(one.shape[1] for one in own)))])
        basis = np.vstack([np.column_stack([np.vstack(slopes), scipy.linalg.block_diag(*own)]), prior])
        self.q = np.linalg.qr(basis)[0]
        self.prior_rows = d
        self.rest = self.free_of_basis(np.r_[np.concatenate(rest), -z])  # the prior pulls z to zero

    def free_of_basis(self, columns):
        return columns - self.q @ (self.q.T @ columns)

    def columns(self, parameter, starts):
        """Returns (rows, starts), columns of a drift of 1 a year from each start [day], without what is unknown anyway."""
        parts = [scipy.linalg.solve_triangular(root, slope[:, parameter, None] * np.maximum(time[:, None] - starts, 0) / YEAR, lower=True) for root, slope, time in zip(self.roots, self.slopes, self.times, strict=True)]
        return self.free_of_basis(np.vstack([*parts, np.zeros((self.prior_rows, len(starts)))]))


def until(posterior, day):
    """Returns the posterior with the readings before a day alone, for a look back; its samples and model errors stay."""
    channels = []
    for channel in posterior.channels:
        kept = channel.time < day
        channels.append(replace(channel, time=channel.time[kept], state=channel.state[kept], value=channel.value[kept], own=channel.own[kept], base=channel.base[kept]))
    return replace(posterior, channels=channels)


def search(posterior):
    """Returns the Drift of the likeliest parameter. The samples of the posterior say where the surfaces are taken as straight, and how large model errors are."""
    white = Whitened(posterior)
    first, last = min(time.min() for time in white.times), max(time.max() for time in white.times)
    starts = np.arange(first, last - LEAST, EVERY)
    d = len(posterior.channels[0].surface.box.centre)  # without the delay of the season
    gains, rates = np.zeros((2, d, len(starts)))
    evidence = np.zeros((d, len(starts)))
    for p in range(d):
        columns = white.columns(p, starts)
        size = (columns**2).sum(axis=0)
        seen = size > 1e-6  # else the readings do not see this parameter
        rates[p, seen] = (columns.T @ white.rest)[seen] / size[seen]
        gains[p] = rates[p] ** 2 * size
        evidence[p] = 0.5 * (gains[p] * RATE**2 * size / (1 + RATE**2 * size) - np.log1p(RATE**2 * size))  # logarithm, over none
    shares = np.exp(evidence - evidence.max()).sum(axis=1)
    p = int(shares.argmax())
    s = int(gains[p].argmax())
    likely = starts[gains[p] > gains[p, s] - LIKELY]
    chance = min(1.0, scipy.stats.chi2.sf(gains.max(), 1) * gains.size)
    deviation = abs(rates[p, s]) / np.sqrt(gains[p, s]) if gains[p, s] > 0 else np.inf
    probability = dict(zip(posterior.names[:d], (shares / shares.sum()).tolist()))
    return Drift(posterior.names[p], float(starts[s]), float(likely.min()), float(likely.max()), float(rates[p, s]), float(deviation), float(gains[p, s]), float(chance), probability, starts, gains)
