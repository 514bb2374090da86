"""Solves linear programmes with Clarabel or HiGHS and checks each solution.

    done = solved(Standard(cost, matrix, right, equal))       None: no solver ends with a solution that holds
    done.x, done.dual

Clarabel is an interior-point method, many times as fast as HiGHS (scipy) on hundreds of stones; small programmes are a matter of milliseconds, and HiGHS ends in a corner, exact to the last digit. Where one of
both fails, or its solution does not hold, the other solves again. Python without Clarabel has HiGHS alone.

Blocks that are wedged hold themselves with forces of any size. Then the optimum is no bounded set of forces, the mechanisms have no inside, and an interior-point method ends nowhere; `wedged` finds the inequalities
that such forces satisfy by any amount, at no cost. Without them the least cost is the same: a solution and enough of those forces satisfies them too.
"""

import math
import pickle
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy

from quoin_tools.base.language import N_, _

try:
    import clarabel
except ImportError:  # a Python without the package, such as Debian's
    clarabel = None

ALLOWED = 1e-6  # of the largest entry of the data, about 1: error allowed in checks
SMALL, MANY = 1500, 5000  # rows: of fewer HiGHS solves as fast; of more it takes minutes over what Clarabel cannot
SHARP = {"primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9}
WAYS = (SHARP | {"presolve": True}, SHARP | {"presolve": False}, {"presolve": True}, {"presolve": False})  # of HiGHS, which has called programmes unbounded that have an end
CLOSE = 1e-12  # tolerance of Clarabel; with 1e-10 a wedged dam whose forces are thousands of times its loads was said to fall 0.4 mm below the level at which it does
SECONDS = (0.1, 1.9, 1500) if clarabel else (2.0, 2.7, 1500)  # of a programme of so many joints, last, on a core of 2026; and its power
WEDGE_SECONDS, MOST_WEDGES = (1.1, 2.5, 1500), 50000  # the same of the search for wedges; rows of the largest programme that is searched for them: with 100 000 it would take ten minutes
SMOOTH, OWN = 1e-12, 1e-8  # that Clarabel adds to the diagonal of its systems; its own leaves 1e-7 of an error where forces are a thousand times the loads, but ends where the other does not
ROUNDS, SLACK, SURE = 20, 1e-3, 1e-6  # programmes that look for wedges; slack of an inequality that each asks for, with forces of at most 1; what has more is wedged
LONGER, ERROR = 200, 1e-3  # iterations of such a programme; error of its directions, over SURE
ROUGH = 1e-10  # both of these, for such directions; the first with cones, which make 1e-12 too much to ask
STOP, PATIENCE = threading.Event(), 5  # s for a solver to see it
BLINK = 0.2  # s
APART = "import pickle, sys, scipy.optimize; pickle.dump(scipy.optimize.linprog(*pickle.load(sys.stdin.buffer)), sys.stdout.buffer)"
SOLVED, UNBOUNDED, INFEASIBLE, OPEN = "solved", "unbounded", "infeasible", "open"


@dataclass
class Standard:
    """Least cost @ x of all x for which matrix @ x = right in the first `equal` rows and matrix @ x <= right in the others. The last rows, three for each cone: of the rests s = right - matrix @ x the first is no
    less than the length of the other two. Entries of about 1: solvers take tolerances as they are."""

    cost: np.ndarray
    matrix: "scipy.sparse.csc_matrix"
    right: np.ndarray
    equal: int
    cones: tuple = ()  # for each: (d, 2) unit vectors along which the other two are held against the first, where a solver takes no cones

    @property
    def plain(self):
        """Number of rows that belong to no cone."""
        return len(self.right) - 3 * len(self.cones)

    def tangents(self):
        """Returns the matrix that makes of the rows of this programme those of a linear one, with tangent planes in place of cones, from outside."""
        rows, columns, values, at = [], [], [], self.plain
        for k, ways in enumerate(self.cones):
            rows.append(at + np.arange(len(ways)).repeat(3))
            columns.append(np.tile(self.plain + 3 * k + np.arange(3), len(ways)))
            values.append(np.column_stack([np.ones(len(ways)), -ways]).ravel())
            at += len(ways)
        plain = np.arange(self.plain)
        return scipy.sparse.csr_matrix((np.concatenate([np.ones(self.plain), *values]), (np.concatenate([plain, *rows]), np.concatenate([plain, *columns]))), (at, len(self.right)))

    def lagrangian(self, done):
        """Returns cost @ x + dual @ (matrix @ x - right): of a solution its value; of a programme near by its value too, in first order."""
        return float(self.cost @ done.x + done.dual @ (self.matrix @ done.x - self.right))


@dataclass
class Solution:
    status: str
    by: str = ""  # solver
    x: np.ndarray | None = None
    dual: np.ndarray | None = None  # of each row: by how much the value falls for more of `right`
    value: float = 0.0
    residual: float = 0.0  # largest error of a row
    dual_residual: float = 0.0  # largest error of cost + dual @ matrix = 0, dual >= 0
    gap: float = 0.0  # between the value and that of the dual, and what errors make of both, relative
    why: str = ""  # why it is not solved
    wedged: np.ndarray | None = None  # rows that forces of any size satisfy: x need not
    checked: bool = False


def seconds(joints, like=SECONDS):
    """Returns about how long one programme takes, or as WEDGE_SECONDS the search for wedges."""
    at_once, power, few = like
    return at_once * (joints / few) ** power


def solved(asked, level=None):
    """Returns the first solution; None: there is none."""
    return next((done for done in answers(asked, level) if done.status == SOLVED), None)


def answers(asked, level=None, limited=None):
    """Yields the answers of the solvers, one after the other, each checked. level: value of which it matters only whether that of the solution is above it. limited: whether each force is (None: not
    known): then no row is wedged, and 1e-10 will do for Clarabel. Where forces are known to be without limit HiGHS does not try many rows."""
    highs = [lambda way=way: by_tangents(asked, partial(by_highs, way=way), level) for way in WAYS]
    fast = [lambda: by_clarabel(asked, smooth=OWN), lambda: by_clarabel(asked)] if clarabel else []
    few = len(asked.right) < SMALL and not asked.cones
    if clarabel and not limited:
        fast.insert(0 if WEDGES.known(asked) else 2, lambda: by_wedges(asked, level))
    if clarabel and asked.cones:
        fast.append(lambda: by_tangents(asked, by_clarabel, level))
    if clarabel and limited is not False and len(asked.right) >= SMALL:
        fast.insert(0 if limited else len(fast), lambda: by_clarabel(asked, ROUGH))
    if few:
        order = [*highs[:1], *fast, *highs[1:]]
    else:
        order = [*fast, *highs] if not clarabel or limited is not False or len(asked.right) < MANY else fast
    for solve in order:
        done = in_thread(solve)
        if done:
            yield done if done.checked else checked(asked, done, level)


def in_thread(solve):
    """Returns solve(). Signals are answered meanwhile, which a library that computes would hold up."""
    found, ended = [], threading.Event()

    def work():
        try:
            found.append(solve())
        except BaseException as error:  # raised again where it is waited for
            found.append(error)
        ended.set()

    threading.Thread(target=work, daemon=True).start()
    try:
        ended.wait()
    except BaseException:
        STOP.set()
        try:
            ended.wait(PATIENCE)
        finally:
            STOP.clear()
        raise
    if isinstance(found[0], BaseException):
        raise found[0]
    return found[0]


def by_tangents(asked, solve, level):
    """Returns the solution of solve(programme), checked, with tangent planes in place of cones."""
    tangents = asked.tangents()
    cut = Standard(asked.cost, (tangents @ asked.matrix).tocsc(), tangents @ asked.right, asked.equal) if asked.cones else asked
    done = checked(cut, solve(cut), level)
    if asked.cones and done.dual is not None:
        done.dual = tangents.T @ done.dual
    return done


def by_highs(asked, way):
    k = asked.equal
    arguments = (asked.cost, asked.matrix[k:], asked.right[k:], asked.matrix[:k], asked.right[:k], (None, None), "highs", None, way)
    done = scipy.optimize.linprog(*arguments) if len(asked.right) < SMALL or not sys.executable else apart(arguments)
    status = {0: SOLVED, 2: INFEASIBLE, 3: UNBOUNDED}.get(done.status, OPEN)
    dual = -np.concatenate([done.eqlin.marginals, done.ineqlin.marginals]) if status == SOLVED else None
    return Solution(status, "HiGHS", done.x, dual)


def apart(arguments):
    """Returns linprog(*arguments) from a process of its own, which can be stopped: HiGHS cannot."""
    with tempfile.TemporaryFile() as asked:
        pickle.dump(arguments, asked)
        asked.seek(0)
        with subprocess.Popen([sys.executable, "-c", APART], stdin=asked, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
            while True:
                try:
                    said = child.communicate(timeout=BLINK)[0]
                    break
                except subprocess.TimeoutExpired:
                    if STOP.is_set():
                        child.kill()
                except BaseException:
                    child.kill()
                    raise
    return pickle.loads(said) if child.returncode == 0 else scipy.optimize.OptimizeResult(status=4, x=None)  # noqa: S301 - a process of our own


def by_clarabel(asked, close=None, smooth=SMOOTH, rounds=100):
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.max_iter, settings.direct_solve_method = False, rounds, "qdldl"  # three times as fast here as faer, and the same digits on any number of threads
    settings.static_regularization_constant = smooth
    for tolerance in ("tol_gap_abs", "tol_gap_rel", "tol_feas"):
        setattr(settings, tolerance, close or (ROUGH if asked.cones else CLOSE))
    k = asked.equal
    cones = [clarabel.ZeroConeT(k), clarabel.NonnegativeConeT(asked.plain - k), *(clarabel.SecondOrderConeT(3) for _cone in asked.cones)]
    solver = clarabel.DefaultSolver(scipy.sparse.csc_matrix((len(asked.cost),) * 2), asked.cost, asked.matrix, asked.right, cones, settings)
    solver.set_termination_callback(lambda _: STOP.is_set())
    done = solver.solve()
    status = {"Solved": SOLVED, "PrimalInfeasible": INFEASIBLE, "DualInfeasible": UNBOUNDED}.get(str(done.status), OPEN)
    if (asked.cones or close) and status == OPEN and not STOP.is_set():  # where cones touch, or forces of 200 MN hold a load of 1, the last digits are out of reach: the check tells what the point is worth
        status = SOLVED
    return Solution(status, "Clarabel", np.array(done.x), np.array(done.z))


# ---- wedges ------------------------------------------------------------------------------------------------


@dataclass
class Wedges:
    """The wedged rows of one matrix, which programmes of a search share. watch: is called before they are looked for."""

    matrix: "scipy.sparse.csc_matrix | None" = None
    rows: np.ndarray | None = None
    watch: Callable[[], None] | None = None

    def known(self, asked):
        one, other = self.matrix, asked.matrix
        return one is not None and one.shape == other.shape and all(np.array_equal(getattr(one, part), getattr(other, part)) for part in ("indptr", "indices", "data"))

    def of(self, asked):
        if self.known(asked):
            return self.rows
        if self.watch:
            self.watch()
        rows = wedged(asked)
        if not STOP.is_set():
            self.matrix, self.rows = asked.matrix, rows
        return rows


WEDGES = Wedges()


def by_wedges(asked, level):
    """Returns Clarabel's solution of the programme without its wedged rows; None: there are none, it is not solved, or the search for them would take long."""
    if len(asked.right) > MOST_WEDGES:
        return None
    rows = WEDGES.of(asked)
    if not rows.any():
        return None
    less = Standard(asked.cost, asked.matrix[~rows], asked.right[~rows], asked.equal, asked.cones)
    done = checked(less, by_clarabel(less), level)
    if done.status != SOLVED:
        return None
    dual = np.zeros(len(rows))
    dual[~rows], done.dual, done.wedged = done.dual, dual, rows
    return done


def wedged(asked):
    """Tells of each row whether x may run off, at no cost, so that its inequality holds by any amount. Each round looks for such directions, at most 1 in any unknown, that satisfy as many rows as can be by SLACK;
    then the next round is free of these rows, since a large enough part of this direction satisfies them again. The dual of a wedged row is nothing in every mechanism. A direction need not be the best one: the rows
    that it satisfies are wedged where its errors are small. An unknown that costs stays what it is: all of them cost something and none of them gives any back."""
    rows = scipy.sparse.csr_matrix(asked.matrix[:, asked.cost == 0])
    k, n, left = asked.equal, rows.shape[1], np.arange(asked.equal, asked.plain)
    left, answer = left[np.diff(rows.indptr)[left] > 0], np.zeros(len(asked.right), dtype=bool)
    still, round_, one = rows[:k].tocsc(), rows[asked.plain :], scipy.sparse.eye(n)
    for _round in range(ROUNDS):
        slack = scipy.sparse.eye(len(left))
        matrix = scipy.sparse.bmat([[still, None], [rows[left], slack], [None, slack], [None, -slack], [one, None], [-one, None], [round_, None]]).tocsc()
        right = np.concatenate([np.zeros(k + len(left)), np.full(len(left), SLACK), np.zeros(len(left)), np.ones(2 * n), np.zeros(round_.shape[0])])
        directions = Standard(np.repeat([0.0, -1.0 / len(left)], [n, len(left)]), matrix, right, k, asked.cones)
        for smooth in (ROUGH, OWN):
            x = by_clarabel(directions, ROUGH, smooth, LONGER).x[:n]
            holds = -(rows[left] @ x)
            if np.abs(still @ x).max() <= ERROR * SURE and holds.min() >= -ERROR * SURE:
                break
        else:
            break
        free = holds > SURE
        if not free.any():
            break
        answer[left[free]], left = True, left[~free]
        if not len(left):
            break
    return answer


def beyond_cones(asked, rows):
    """Returns by how much the last rows leave their cones, at the first of the three rows of each."""
    three = rows[asked.plain :].reshape(-1, 3)
    found = np.zeros_like(three)
    found[:, 0] = np.maximum(np.hypot(three[:, 1], three[:, 2]) - three[:, 0], 0.0)
    return found.ravel()


def checked(asked, done, level=None):
    """Fills in value and errors of a solution. One that does not hold (badly scaled units once gave a factor of eight) is none."""
    done.checked = True
    if done.status != SOLVED:
        done.why = _("{0} finds no end of it", done.by)
        return done
    k, error, slope, least = asked.equal, asked.matrix @ done.x - asked.right, asked.cost + asked.matrix.T @ done.dual, np.minimum(done.dual, 0.0)
    outside, below = beyond_cones(asked, -error), beyond_cones(asked, done.dual)
    error[k:], least[:k] = np.maximum(error[k:], 0.0), 0.0
    error[asked.plain :], least[asked.plain :] = outside, -below
    if done.wedged is not None:
        error[done.wedged] = 0.0
    done.value = float(asked.cost @ done.x)
    done.residual, done.dual_residual = float(np.abs(error).max()), float(max(np.abs(slope).max(), -least.min()))
    unsure = abs(done.value + asked.right @ done.dual) + np.abs(slope) @ np.abs(done.x) + np.abs(error) @ np.abs(done.dual)  # errors of the mechanism matter as forces are large
    done.gap = float(unsure / max(abs(done.value), 1.0))
    within = ALLOWED if level is None else math.inf if abs(done.value - level) > 2 * unsure else min(ALLOWED, level)
    for why, value, most in ((N_("equilibrium or strengths are missed by {0:.1e} (of the heaviest load, or of the multiplier)"), done.residual, ALLOWED),
                             (N_("the mechanism is missed by {0:.1e} (of the heaviest load, or of the multiplier)"), done.dual_residual, ALLOWED),
                             (N_("the value is uncertain by {0:.1e} (of the heaviest load, or of the multiplier)"), done.gap, within)):  # fmt: skip
        if not value <= most:
            done.status, done.why = OPEN, _(why, value)
            break
    return done
