"""Computes the results of an ensemble from its rows: a probability with its interval at each level; sensitivity. Undecided samples are an outcome: the interval counts them once as standing, once as failing."""

import itertools
import math
from dataclasses import asdict, dataclass

import numpy as np
import scipy

from quoin_tools.ensemble.intervals import clopper_pearson, of_mean, zero_bound

LEVEL = 0.95
FLATTEST = 10.0  # spread of the logarithm of a curve that still says something


@dataclass
class Probability:
    """low, high: ends of the interval that holds the probability with 95 %; undecided samples count as standing for low, as failing for high."""

    level: float | None
    n: int
    fails: int
    undecided: int
    value: float
    value_high: float  # if all undecided ones fail
    low: float
    high: float
    by: str  # which interval

    @property
    def half_width(self):
        return 0.5 * (self.high - self.low)


def counted(design, rows):
    """Returns the samples that count: those before the first missing one, up to the first at which `stop` is met; blocks whole."""
    n = 0
    while all((n, level) in rows for level in design.levels) and n < design.samples:
        n += 1
    n -= n % design.block_size()
    return met(design, rows, n) or n


def met(design, rows, n):
    """Returns the first multiple of `stop.batch` at which all intervals are as narrow as required; None: no multiple up to n."""
    if design.half_width is None:
        return None
    narrow = (m for m in range(design.batch, n + 1, design.batch) if all(of_level(design, rows, level, m).half_width <= design.half_width for level in design.levels))
    return next(narrow, None)


def enough(design, rows):
    """Tells whether `stop` is met by samples without gaps, so that it does not depend on which came first."""
    return design.half_width is not None and met(design, rows, counted(design, rows)) is not None


def probabilities(design, rows):
    n = counted(design, rows) if design.method != "sobol_indices" else 0  # its samples are not independent
    return [of_level(design, rows, level, n) for level in design.levels] if n else []


def of_level(design, rows, level, n):
    mine = [rows[i, level] for i in range(n)]
    fails, open_ones = sum(r.outcome == "fails" for r in mine), sum(r.outcome == "undecided" for r in mine)
    if design.method == "importance":
        return weighted(level, mine, fails, open_ones)
    if design.method in ("latin_hypercube", "sobol"):
        return replicated(design, level, mine, fails, open_ones)
    return plain(level, mine)


def plain(level, mine):
    """Returns the probability from independent samples."""
    n, fails, open_ones = len(mine), sum(r.outcome == "fails" for r in mine), sum(r.outcome == "undecided" for r in mine)
    low, high = clopper_pearson(fails, n, LEVEL)[0], clopper_pearson(fails + open_ones, n, LEVEL)[1]
    return Probability(level, n, fails, open_ones, fails / n, (fails + open_ones) / n, low, high, "Clopper-Pearson")


def weighted(level, mine, fails, open_ones):
    """Returns the probability from importance sampling: the mean of the weights of failing samples. Without any their spread says nothing."""
    value, low, _ = of_mean([r.weight * (r.outcome == "fails") for r in mine], LEVEL)
    most, _, high = of_mean([r.weight * (r.outcome != "stands") for r in mine], LEVEL)
    return Probability(level, len(mine), fails, open_ones, value, most, max(low, 0.0), min(high, 1.0) if fails else 1.0, "normal, of weights")


def replicated(design, level, mine, fails, open_ones):
    """Returns the probability from blocks, each of which fills the space evenly, by the spread of their means. Fewer than five, or no spread: Clopper-Pearson of all, which is on the safe side."""
    n, block = len(mine), design.block_size()
    ends = [[np.mean([r.outcome in kinds for r in mine[i : i + block]]) for i in range(0, n, block)] for kinds in (("fails",), ("fails", "undecided"))]
    wide = clopper_pearson(fails, n, LEVEL)[0], clopper_pearson(fails + open_ones, n, LEVEL)[1]
    if len(ends[0]) < 5 or not np.std(ends[0]) > 0:
        return Probability(level, n, fails, open_ones, fails / n, (fails + open_ones) / n, *wide, "Clopper-Pearson, as if independent")
    low, high = of_mean(ends[0], LEVEL)[1], of_mean(ends[1], LEVEL)[2]
    return Probability(level, n, fails, open_ones, fails / n, (fails + open_ones) / n, max(low, 0.0), min(high, 1.0), f"{len(ends[0])} blocks")


def words(p):
    """Writes one line for people."""
    if p.fails == 0 and p.undecided == 0 and p.by == "Clopper-Pearson":
        return f"none of {p.n} fails: less than {zero_bound(p.n, LEVEL):.3g} with 95 %"
    text = f"{p.value:.4g}, between {p.low:.3g} and {p.high:.3g} with 95 % ({p.fails} of {p.n} fail"
    return text + (f", {p.undecided} undecided: {p.value_high:.4g} if these fail)" if p.undecided else ")")


# ---- danger level, fragility, sensitivity --------------------------------------------------------------------------------


@dataclass
class Danger:
    """The level from which a sample fails: median and the interval of 95 % of the samples; None: beyond the levels. never, always:
    how many samples fail at no level, at all; unknown: are undecided before they fail, and left out."""

    low: float | None
    median: float | None
    high: float | None
    n: int
    never: int
    always: int
    unknown: int
    least: float
    most: float

    def words(self):
        if not self.n:
            return "no sample says"
        texts = [f"{value:.4g}" if value is not None else (f"below {self.least:g}" if self.always > part * self.n else f"above {self.most:g}") for value, part in ((self.median, 0.5), (self.low, 0.025), (self.high, 0.975))]
        return f"{texts[0]}, between {texts[1]} and {texts[2]} for 95 % of {self.n} samples" + (f"; {self.unknown} undecided are left out" if self.unknown else "")


def danger(design, rows):
    """Returns the Danger of the samples; None with fewer than two levels. Between the last level that stands and the first that fails the number of the condition is taken as
    straight; without a number it is the level that fails, no lower than the truth by more than a step."""
    levels = design.levels
    if len(levels) < 2 or design.method not in ("monte_carlo", "latin_hypercube", "sobol"):
        return None
    n, found, unknown = counted(design, rows), [], 0
    for i in range(n):
        mine = [rows[i, level] for level in levels]
        first = next((k for k, row in enumerate(mine) if row.outcome != "stands"), None)
        if first is None:
            found.append(math.inf)
        elif mine[first].outcome == "undecided":
            unknown += 1
        elif first == 0:
            found.append(-math.inf)
        else:
            found.append(crossing(design, mine[first - 1], mine[first]))
    ends = np.quantile(found, [0.025, 0.5, 0.975], method="inverted_cdf") if found else [math.inf] * 3
    low, median, high = (float(end) if math.isfinite(end) else None for end in ends)
    return Danger(low, median, high, len(found), found.count(math.inf), found.count(-math.inf), unknown, levels[0], levels[-1])


def crossing(design, stands, fails):
    """Returns the level at which the number of the condition meets its limit."""
    condition = design.condition
    if condition is None or design.response != condition.path or stands.response is None or fails.response is None:
        return fails.level
    good, bad = condition.margin(stands.response), condition.margin(fails.response)
    return fails.level if good - bad <= 0 else stands.level + (fails.level - stands.level) * min(max(good / (good - bad), 0.0), 1.0)


@dataclass
class Fragility:
    """Fits a lognormal curve to the counts of all levels: p(h) = Phi(ln(h / median) / spread), by maximum likelihood."""

    median: float
    spread: float

    def at(self, level):
        return scipy.stats.norm.cdf(np.log(np.asarray(level, dtype=float) / self.median) / self.spread)

    def level(self, p):
        return self.median * math.exp(self.spread * scipy.stats.norm.ppf(p))


def fragility(found):
    """Returns the curve for Probability rows with levels; None where fewer than two levels have both outcomes, or where counts do not rise with the level."""
    levels, n, fails = (np.array([getattr(p, name) for p in found], dtype=float) for name in ("level", "n", "fails"))
    if ((fails > 0) & (fails < n)).sum() < 2 or (levels <= 0).any():
        return None
    start = float(np.interp(0.5, np.maximum.accumulate(fails / n), levels))

    def loss(x):
        p = np.clip(scipy.stats.norm.cdf((np.log(levels) - x[0]) / math.exp(x[1])), 1e-300, 1 - 1e-16)
        return -float(fails @ np.log(p) + (n - fails) @ np.log1p(-p))

    best = scipy.optimize.minimize(loss, [math.log(start), math.log(0.1)], method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-10, "maxiter": 4000})
    return Fragility(math.exp(best.x[0]), math.exp(best.x[1])) if best.x[1] < math.log(FLATTEST) else None


def influence(design, rows):
    """Returns [(variable, rank correlation with the response, or with failure where no number is given, number of samples)] of the last level."""
    n, level = counted(design, rows), design.levels[-1]
    mine = [rows[i, level] for i in range(n)]
    graded = sum(r.response is not None for r in mine) > max(10, 0.5 * n)
    used = [r for r in mine if (r.response is not None) or not graded]
    answer = [r.response if graded else float(r.outcome == "fails") for r in used]
    if len(used) < 10 or np.ptp(answer) == 0:
        return []
    ranked = [(k, one.name) for k, one in enumerate(design.variables.each) if not one.has_words() and len({r.values[k] for r in used}) > 1]
    return [(name, float(scipy.stats.spearmanr([r.values[k] for r in used], answer).statistic), len(used)) for k, name in ranked]


def by_choice(design, rows):
    """Returns for each value of a choice, at each level, {variable, choice, and the members of a Probability}; an interval as if its samples were independent."""
    n = counted(design, rows) if design.method != "sobol_indices" else 0
    found = []
    for k, one in enumerate(design.variables.each):
        for value, level in itertools.product(one.choices, design.levels):
            mine = [r for r in (rows[i, level] for i in range(n)) if r.values[k] == one.kept(value)]
            if mine:
                found.append({"variable": one.name, "choice": value} | asdict(plain(level, mine)))
    return found


def sobol_indices(design, rows):
    """Returns [(variable, first order, total)] of the response at the last level, and how many groups were dropped because a sample gave no number (Saltelli's and Jansen's estimators)."""
    k, level = len(design.columns()), design.levels[-1]
    groups = [[rows[g * (k + 2) + m, level].response for m in range(k + 2)] for g in range(counted(design, rows) // (k + 2))]
    whole = np.array([group for group in groups if None not in group], dtype=float)
    whole = whole - whole.mean() if whole.size else whole  # or the first order would be far less sure
    if len(whole) < 2 or not np.ptp(whole) > 0:
        return [], len(groups) - len(whole)
    a, b, mixed = whole[:, 0], whole[:, 1], whole[:, 2:]
    spread = np.concatenate([a, b]).var()
    first = [float((b * (mixed[:, v] - a)).mean() / spread) for v in range(k)]
    total = [float(((a - mixed[:, v]) ** 2).mean() / 2 / spread) for v in range(k)]
    return list(zip(design.columns(), first, total)), len(groups) - len(whole)
