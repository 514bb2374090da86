"""Writes the part of the sheet about what_if: the dam as it is and with each item, a row each, the worst first; and one line about it for page 1."""

import math
from dataclasses import dataclass, field

from quoin_tools.assess import guidelines
from quoin_tools.assess.assessment import ERRORS, Case, assess, cell, load_case
from quoin_tools.assess.danger_level import danger_level
from quoin_tools.base.language import N_, _, ngettext
from quoin_tools.base.results import trials_of
from quoin_tools.ensemble.what_if import LOST, Item
from quoin_tools.show import matrix
from quoin_tools.show.hypertext import head, notes, small, table, verdict_class
from quoin_tools.show.limit_part import limit_level

DEFAULT = "joints.default."  # before a key
SAME = 1e-9  # numbers of two dams that differ by less of themselves are the same
NOTE = N_("Each row is a run of its own, by the scene with the changes of what_if: of its judged cases the base with the least sliding factor. The change is that against the least factor of the same cases as they are. This factor is the less favourable one of block model and gravity method; e, L and crack are those of the gravity method. "
          "Fails from: the least level of the water at which gravity method, limit analysis or a stage of trials finds no safety left. The dam fails where a judged stage collapses, where the gravity method finds no equilibrium, or where a sliding factor is below 1.")  # fmt: skip


@dataclass
class Dam:
    """One row. item None: the dam as it is. why: why there are no numbers."""

    item: Item | None
    stage: str = ""
    base: str = ""
    sliding: float | None = None
    middle: float | None = None  # 2 e / L
    crack: float | None = None  # over L
    broken: float | None = None  # [m]
    fails_from: float | None = None  # [m]
    fails: list = field(default_factory=list)
    undecided: list = field(default_factory=list)
    limits: str = ""
    why: str = ""
    factors: dict = field(default_factory=dict)  # (stage, base) to the sliding factor of each judged base

    def numbers(self):
        return self.sliding, self.middle, self.crack, self.broken, self.fails_from

    def severity(self):
        return not self.fails, len(self.factors) if self.fails else bool(self.why), math.inf if self.sliding is None else self.sliding, -(self.middle or 0.0)


def least_factor(found):
    """Returns the less favourable sliding factor of a base; 0 where the gravity method finds no equilibrium, None where nothing resists by a law."""
    if found.governing.crack is None:
        return 0.0
    return min((x for x in (matrix.of_hand(found).get("peak"), (found.block or {}).get("peak")) if x is not None), default=None)


def weakest(case, found):
    """Returns the judged base with the least sliding factor, of several the one nearest to overturning; None without a base."""
    def rank(one):
        factor = least_factor(one)
        return math.inf if factor is None else factor, -matrix.of_hand(one)["middle"]

    return min(matrix.judged_bases(case, found), key=rank, default=None)


def dam_of(case: Case, found, item=None):
    """Returns the row of a run."""
    base = weakest(case, found)
    if base is None:
        return Dam(item, why=_("no base is a line that the gravity method can take"))
    hand, danger = matrix.of_hand(base), danger_level(case, found)
    sliding, judged_now = least_factor(base), [a for a in found if a.condition]
    limits = [limit for a in judged_now for limit in a.limits]
    factors = {(one.stage, one.name): least_factor(one) for one in matrix.judged_bases(case, found)}
    dam = Dam(item, matrix.case_name(base), base.name, sliding, hand["middle"], hand["crack"], limits=guidelines.overall(limits, all(a.complete for a in judged_now)) if limits else "", factors=factors)
    if danger and danger.base:
        trials = trials_of(case.results.stage_summary(danger.stage)) or {}
        levels = [danger.fails, limit_level(case, danger.stage) if trials else None, trials.get("failing")]
        dam.broken, dam.fails_from = danger.broken, min((level for level in levels if level is not None and math.isfinite(level)), default=None)
    judged = {s["name"]: s["verdict"] for s in case.results.summary["stages"] if s["name"] in case.conditions}
    dam.fails = [_("stage {0} collapses", name) for name, verdict in judged.items() if verdict == "collapsed"]
    dam.fails += [_("no equilibrium in stage {0}", a.stage) for a in judged_now if a.governing.crack is None][:1]
    dam.fails += [_("slides in stage {0}", base.stage)] if sliding is not None and sliding < 1.0 and not dam.fails else []
    dam.undecided = [name for name, verdict in judged.items() if verdict not in ("converged", "completed", "collapsed")]
    dam.undecided += [name for name in case.conditions if name not in judged and not dam.fails]
    return dam


def dams(case, found, items):
    """Returns the row of the dam as it is, and those of the items, the worst first."""
    rows = []
    for item in items:
        if item.why:
            rows.append(Dam(item, why=item.why))
            continue
        try:
            other = load_case(item.folder, case.options)
            rows.append(dam_of(other, assess(other)[0], item))
        except ERRORS as error:
            rows.append(Dam(item, fails=[_("it does not stand at its start")], why=" ".join(str(error).split())))
    return dam_of(case, found), sorted(rows, key=Dam.severity)


def outcome(dam):
    """Returns (words, class of the cell) about whether a dam stands."""
    if dam.fails:
        return _("fails: {0}", "; ".join(dam.fails)), "fail"
    if dam.item and dam.item.why:
        return _("cannot be run: {0}", dam.why), "open"
    if dam.undecided or dam.sliding is None and dam.why:
        return _("undecided: {0}", ", ".join(dam.undecided) or dam.why), "open"
    return _("stands"), "pass"


def as_before(as_it_is, row):
    """Returns the least sliding factor of the dam as it is in the cases that the run of an item has too: where the usual case collapses, those behind it were
    not run. None without one."""
    return min((factor for key, factor in as_it_is.factors.items() if key in row.factors and factor is not None), default=None)


def change(now, was, part=False):
    """A difference as text; part: in percent of what it was."""
    if now is None or was is None or not (math.isfinite(now) and math.isfinite(was)) or (part and was == 0):
        return "-"
    return cell(100 * (now / was - 1), 1, "+") if part else cell(now - was, 2, "+")


def line(as_it_is, rows):
    """Words for page 1: how many fail, and the worst of them."""
    worst, failing = rows[0], sum(bool(row.fails) for row in rows)
    parts = [ngettext("{0} of {1} items fails", "{0} of {1} items fail", failing, len(rows)), _("worst: {0}, {1}", worst.item.name, outcome(worst)[0])]
    if worst.sliding is not None:
        parts.append(_("sliding factor {0} ({1} as it is)", cell(worst.sliding, 2), cell(as_before(as_it_is, worst), 2)))
    if worst.crack is not None:
        parts.append(_("crack {0} of the base ({1})", cell(worst.crack, 3), cell(as_it_is.crack, 3)))
    if worst.fails_from is not None:
        parts.append(_("fails from {0} m ({1} m)", cell(worst.fails_from, 2), cell(as_it_is.fails_from, 2)))
    refused = [row.item.name for row in rows[1:] if row.item.why]
    return "; ".join(parts + ([_("cannot be run: {0}", ", ".join(refused))] if refused else []))


def changes_words(item):
    of_default = {(path.removeprefix(DEFAULT), was, now) for path, was, now in item.changes if path.startswith(DEFAULT)}
    own = [change for change in item.changes if change[0].startswith(DEFAULT) or (change[0].rpartition(".")[2], *change[1:]) not in of_default]  # without joints that have the key from there
    return "; ".join(_("{0} lost", path) if now == LOST else f"{path} {was} → {now}" for path, was, now in own)


def remarks(as_it_is, row):
    """What in an item has no effect."""
    item = row.item
    said = [_("{0}: {1} has this value already, so the change does nothing.", item.name, path) for path in item.idle]
    said += [_("{0}: stage {1} gives {2} itself, and the change does not reach it.", item.name, stage, path) for path, stage in item.kept]
    pairs = list(zip(row.numbers(), as_it_is.numbers()))
    if not row.why and not item.idle and all(a == b or (a is not None and b is not None and math.isclose(a, b, rel_tol=SAME)) for a, b in pairs):
        said.append(_("{0}: no number of this table changes.", item.name))
    gone = sorted({stage for stage, _base in as_it_is.factors.keys() - row.factors.keys()}) if row.factors else []
    said += [_("{0}: no result of {1}; the change is against {2} in the other cases as they are.", item.name, ", ".join(gone), cell(as_before(as_it_is, row), 2))] if gone else []
    return said + ([f"{item.name}: {row.why}."] if row.why else [])


def what_if_part(as_it_is, rows):
    """HTML of the table."""
    with_levels = any(row.fails_from is not None or row.broken is not None for row in [as_it_is, *rows])
    cells = []
    for row in [as_it_is, *rows]:
        name, changes = (row.item.name, (changes_words(row.item), "keys")) if row.item else (_("as it is"), "")
        levels = [cell(row.broken, 2), cell(row.fails_from, 2), change(row.fails_from, as_it_is.fails_from) if row.item else ""] if with_levels else []
        limits = [(_(row.limits), verdict_class(row.limits)) if row.limits else "-"]
        cells.append((name, changes, row.stage, row.base, cell(row.sliding, 2), change(row.sliding, as_before(as_it_is, row), part=True) if row.item else "", cell(row.middle, 3), cell(row.crack, 3), *levels, *limits, outcome(row)))
    header = (_("item"), _("changes of keys (SI)"), _("case"), _("base"), _("sliding factor"), _("change [%]"), _("overturning: 2 e / L"), _("crack / L"), *((_("a limit is broken from [m]"), _("fails from [m]"), _("change [m]")) if with_levels else ()), _("limits"), _("the dam"))
    said = [text for row in rows for text in remarks(as_it_is, row)]
    return head(_("What if")) + "<div class='matrix'>" + table(header, cells, range(4, 11 if with_levels else 8)) + small(_(NOTE)) + "</div>" + (notes(said) if said else "")
