"""Writes page 1 of the sheet: verdict, the dam drawn, the run, the cases, the matrix of cases and bases, room to sign."""

import datetime
import math

import quoin_tools
from quoin_tools.assess import (
    combinations,
    danger_level,
    guidelines,
    lifts,
    partial_factors,
    spectrum_tables,
)
from quoin_tools.assess.assessment import account_complaints, cell
from quoin_tools.assess.base_water import dry_stretches
from quoin_tools.base.language import N_, _, ngettext
from quoin_tools.base.results import condensed_words, factor_rows, trials_of
from quoin_tools.show import matrix, section, what_if_part
from quoin_tools.show.annex import changed_by, value_of, without_result
from quoin_tools.show.hypertext import box, esc, head, notes, picture, small, soft, table, verdict_class
from quoin_tools.show.limit_part import limit_level

NAMED = 5  # judged stages that the verdict has by name
HEAD = 4  # lines that the head of the rows of cases and their note take
CASES, FAILURES = 6, 3  # rows of the table of cases; failed limits, joints named in the verdict
ROOM, OF_CASE, OF_BASE, OF_ALONE, OF_LINE = 145, 7, 15, 5, 5  # [mm] on the page for drawing and rows; height of a case, a base, a joint without the gravity method, a case in one line
FEWEST, WANTED, LEAST, MOST = 2, 75, 60, 120  # cases; [mm] height of the drawing: for which cases that are not judged make room, that it keeps, at most
WIDE = 107  # [mm] of the drawing
SIGN = (N_("Prepared by"), N_("Checked by"))


def signatures():
    date = esc(_("Date"))
    return "<table class='sign'><tbody>" + "".join(f"<tr><th>{esc(_(who))}</th><th class='d'>{date}</th></tr><tr><td></td><td></td></tr>" for who in SIGN) + "</tbody></table>"


def title_of(case):
    return case.results.summary["title"] or case.results.summary["model"]


def heading(case):
    return head(title_of(case), 1) + soft(_("Safety of a masonry dam: block model and gravity method"))


def account_boxes(case):
    """A box above all others for each stage in time whose energy account is out, judged or not."""
    return "".join(box("fail", _("Energy account out: stage {0}", s["name"]), " ".join(sentences))
                   for s in case.results.summary["stages"] if "balance" in s["energy"] and (sentences := account_complaints(s)))


def listed(names):
    """The first names, and how many more there are."""
    return "; ".join(names[:FAILURES]) + ("; " + _("{0} more", len(names) - FAILURES) if len(names) > FAILURES else "")


def weak_lifts(case, swept):
    """Words about the worst lift of each judged stage whose sliding factor is below the limit, with partial factors on strengths where the guideline has them; about one of known strength
    without equilibrium, too, where the guideline has no such limit."""
    weak = []
    for stage, (found, _left_out) in swept.items():
        strong, broken = [lift for lift in found if lift.factor is not None], []
        limits = guidelines.judge(guidelines.of(case.options), case.conditions[stage], {}, case.options.given, plane="lift")
        for row in [row for row in limits if row.quantity in lifts.SLIDING and row.limit is not None and strong]:
            factored = row.quantity == "sliding_partial"
            least, lift = min(((partial_factors.of_lift(lift, row.entry) if factored else lift.factor, lift) for lift in strong), key=lambda pair: pair[0])
            if least < row.limit * (1 - guidelines.ROUNDING):
                said = _("{0}: {1:.2f} in the lift at {2:.2f} m in stage {3}", row.words, least, lift.level, stage) if factored else _("sliding factor {0:.2f} of the lift at {1:.2f} m in stage {2}", least, lift.level, stage)
                broken.append(said + without_equilibrium(lift))
        fallen = [lift for lift in strong if lift.hand.crack is None] if not broken else []
        weak += broken + [_("no equilibrium of the lift at {0:.2f} m in stage {1}", lift.level, stage) for lift in fallen[:1]]
    return weak


def without_equilibrium(lift):
    """Says why the sliding factor of a lift is 0, where it is."""
    return f" ({_('no equilibrium')})" if lift.hand.crack is None else ""


def lifted(swept):
    """Lifts of unknown strength that find no equilibrium without tension: nothing says that they hold."""
    return [_("{0:.2f} m ({1})", lift.level, stage) for stage, answer in swept.items() for lift in answer[0] if lift.hand.crack is None and lift.factor is None]


def verdict_box(case, found, remarks, swept, study=None):
    """Writes the verdict of the limits in one word and one sentence. remarks: number of caveats; swept: lifts of the judged stages; study: of a spectrum."""
    o = case.options
    if not o.guideline:
        return box("open", _("Not judged"), _("No guideline was named (--guideline: {0}).", ", ".join(guidelines.read(o.guidelines))))
    judged = [a for a in found if a.condition]
    named = set(case.conditions)
    there = {(a.stage, a.name) for a in judged}
    refused = [name for name in o.paths if any((stage, name) not in there for stage in named)]
    collapsed = [s["name"] for s in case.results.summary["stages"] if s["name"] in named and s["verdict"] == "collapsed"]
    wanting = combinations.wanting(case)
    missing = not judged or wanting or not named <= {a.stage for a in judged} or bool(refused) or bool(without_result(case) and not o.conditions)
    of_lifts = {stage: lifts.judged(case, stage, answer[0]) + partial_factors.judged(case, stage) for stage, answer in swept.items()}
    rows = [limit for a in judged for limit in a.limits] + [limit for limits in of_lifts.values() for limit in limits]
    rows += [limit for _row, limit in study.judged] if study else []
    weak, loose = weak_lifts(case, swept), lifted(swept)
    fallen = [_("no equilibrium on {0} in stage {1}", a.name, a.stage) for a in judged if a.governing.crack is None and guidelines.FAIL not in {limit.verdict for limit in a.limits}]
    alone = [f"{name} ({stage})" for stage, name, _facts in matrix.untaken(case, found)]
    word = "FAIL" if weak or fallen or collapsed else guidelines.overall(rows, not missing and not alone and not loose and not (study and study.unheld) and all(a.complete for a in judged))
    failed = [_("{0} in stage {1} on {2}", limit.words, a.stage, a.name) for a in judged for limit in a.limits if limit.verdict == guidelines.FAIL]
    failed += [_("{0} in stage {1}", limit.words, stage) for stage, limits in of_lifts.items() for limit in limits if limit.verdict == guidelines.FAIL] + weak + fallen + (spectrum_tables.failed(study) if study else [])
    stages = list(dict.fromkeys(_("{0} as {1}", a.stage, _(a.condition)) for a in judged))
    sentences = [_(guidelines.of(o)["title"]) + ".", _("Judged: {0}.", ", ".join(stages) or _("no stage")) if len(stages) <= NAMED else _("Judged: {0} cases, in the table below.", len(stages))]
    if named_so := combinations.taken_from_names(case):
        sentences.append(_("Taken from the names of stages: {0}; --condition says another one.", ", ".join(_("{0} as {1}", stage, _(condition)) for stage, condition in named_so.items())))
    if caution := guidelines.of(o).get("caution"):
        sentences.append(_(caution))
    if collapsed:
        sentences.append(_("Collapsed: {0}.", ", ".join(collapsed)))
    if failed:
        sentences.append(_("Limits that fail: {0}.", listed(failed)))
    if refused:
        sentences.append(_("No numbers for path {0}.", ", ".join(refused)))
    if alone:
        sentences.append(ngettext("Not judged, because the gravity method does not take them: joint {1}; --path names a way through them.",
                                  "Not judged, because the gravity method does not take them: joints {1}; --path names a way through them.", len(alone), listed(alone)))
    dry = [stage for stage in case.results.stages if stage in named and dry_stretches(case.results.stage_summary(stage))]
    if study and study.unheld:
        sentences.append(_("Not all is judged by the spectrum: {0}", " ".join(study.unheld)))
    if dry:
        sentences.append(ngettext("Open joints without water in stage {1}: see the reservations.", "Open joints without water in stages {1}: see the reservations.", len(dry), listed(dry)))
    if loose:
        sentences.append(_("No equilibrium without tension in lifts whose strength is unknown: {0}.", listed(loose)))
    open_ones = sum(limit.verdict == guidelines.OPEN and not limit.wanting for limit in rows)
    if wanting:
        sentences.append(ngettext("{0} load combination of the guideline has no case: it is named under Cases.", "{0} load combinations of the guideline have no case: they are named under Cases.", len(wanting)))
    if open_ones:
        sentences.append(_("Limits not judged for want of a number: {0}.", open_ones))
    if wanting := sorted({limit.wanting for limit in rows} - {""}):
        sentences.append(_("Not given, though limits depend on it: {0}.", "; ".join(f"--given {name}={'|'.join(guidelines.of(o)['inputs'][name])}" for name in wanting)))
    if unread := sum(not limit.confirmed for limit in rows):
        sentences.append(ngettext("{0} of {1} limits was not held against the document; a file of limits confirms it (--guidelines).", "{0} of {1} limits were not held against the document; a file of limits confirms them (--guidelines).", unread, len(rows)))
    if remarks:
        sentences.append(_("Reservations: {0}, under Evidence.", remarks))
    return box(verdict_class(word), _(word), " ".join(sentences))


def unfinished_note(case):
    """Lists stages without a result or not run: they may be decisive."""
    names, not_run = without_result(case), case.results.summary.get("not_run", [])
    sentences = [_("Not run, because the stage from which they start has failed: {0}.", ", ".join(not_run))] if not_run else []
    names = [name for name in names if name not in not_run]
    if names:
        sentences.append(ngettext("No result of stage {1}: the run was refused, stopped or broke off before, or goes on. The sheet knows nothing of it.",
                                  "No result of stages {1}: the run was refused, stopped or broke off before, or goes on. The sheet knows nothing of it.", len(names), ", ".join(names)))  # fmt: skip
    return notes(sentences)


def chosen_words(summary):
    return "; " + _("chosen by the program, materials.<name>.condensed fixes it") if summary.get("condensed_choice", "").startswith("condensed") else ""


def danger_words(case, found):
    """Says from which level a limit is broken and from which the dam fails, by each method that knows it, and what gives way first; "" where no water rises."""
    danger = danger_level.danger_level(case, found)
    if danger is None:
        return ""
    if not danger.base:
        return _("not known where water flows in joints, or where no base is one straight joint with friction")
    beyond = _("no limit is broken up to {0:.2f} m", danger.highest) if danger.broken is None else _(
        "from {0:.2f} m on, {1} ({2}, {3}) is broken on {4}", danger.broken, danger.missing.words, _(danger.condition), danger.missing.bound, danger.base)  # fmt: skip
    failing = danger_level.failing_below(case, found, danger)
    others = [_("limits are broken below that level in {0}, by the condition and loads of the case or in the block model: the level is that of the condition {1} by the gravity method", listed(failing), _(danger.condition))] if failing else []
    fails = [_("{0:.2f} m by the gravity method", danger.fails)] if danger.fails is not None else []
    trials = trials_of(case.results.stage_summary(danger.stage))
    if trials:
        most = limit_level(case, danger.stage)
        fails += [_("{0:.2f} m by limit analysis", most)] if most is not None and math.isfinite(most) else []
        fails += [_("{0:.2f} to {1:.2f} m by the run", trials["stable"], trials["failing"])] if None not in (trials.get("stable"), trials.get("failing")) else []
        moving = [row[0] for row in factor_rows(case.results.stage_summary(danger.stage)) if row[-1] not in ("", "-")]
        fails += [_("first {0}", ", ".join(moving[:FAILURES]))] if moving else []
    parts = [_("{0:.2f} m in stage {1}", danger.start, danger.stage), *([beyond, *others] if danger.condition else []), *([_("fails at {0}", ", ".join(fails))] if fails else [_("no failure up to {0:.2f} m", danger.highest)])]
    return "; ".join(parts)


def facts(case, found, dams, study=None):
    summary = case.results.summary
    o = case.options
    return [(_("Model"), summary["model"]), (_("Scene"), case.scene.path if not summary["scene"] else summary["scene"]),
            (_("Program"), ngettext("Quoin {1}, {0} rank; sheet by quoin_tools {2}", "Quoin {1}, {0} ranks; sheet by quoin_tools {2}", summary["ranks"], summary["quoin"], quoin_tools.__version__)),
            (_("Model size"), _("{0} blocks in {1} bodies, {2} contacts, {3} degrees of freedom", *(summary[key] for key in ("n_blocks", "n_macroblocks", "n_contacts", "n_dofs")))),
            *([(_("Condensed"), condensed_words(summary) + chosen_words(summary))] if summary.get("condensed") else []),
            (_("Slice"), _("{0:g} m thick; forces are those of the slice", summary["thickness"])),
            (_("Guideline"), o.guideline or _("none")),
            *([(_("Given for the guideline"), "; ".join(_(guidelines.of(o)["inputs"][name][choice]) for name, choice in o.given.items()))] if o.given else []),
            *([(_("Danger level of the water"), words)] if (words := danger_words(case, found)) else []),
            *([(_("What if"), what_if_part.line(*dams))] if dams else []),
            *([(_("Earthquake by a spectrum"), spectrum_tables.line(study))] if study else []),
            (_("Uplift in the gravity method"), _("as in the scene") if not o.uplift else o.uplift if o.drain is not None else _("{0}, drain as in the scene", o.uplift)),
            (_("State checksum"), _("{0} (stage {1})", summary["stages"][-1]["checksum"], summary["stages"][-1]["name"])),
            (_("Sheet written"), datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"))]  # fmt: skip


def trial_words(found):
    """Describes the result of trials in a line."""
    stable, failing = (value_of(found, found.get(end), 3) for end in ("stable", "failing"))
    factors = [cell(found.get(f"safety_factor_{end}"), 3) for end in ("stable", "failing")]
    text = _("{0}: {1} stands, {2} fails", changed_by(found), stable, failing) if failing != "-" else _("{0}: {1} stands, no trial fails", changed_by(found), stable)
    return text if factors[0] == "-" else _("{0}; factor {1} to {2}", text, *factors)


KINDS = (N_("static"), N_("dynamic"), N_("modes"), N_("flood"), N_("transient"), N_("strength reduction"), N_("load factor"), N_("anchor force"), N_("pushover"))


def kind_of(keys):
    return _(str(keys.get("type", "static")).replace("_", " "))


def case_rows(case, found):
    rows, judged = [], combinations.judged_as(case)
    for s in case.results.summary["stages"]:
        keys, trials = case.scene.stages.get(s["name"], {}), trials_of(s)
        design = s["name"] not in case.conditions and case.scene.is_design(s["name"])
        good = s["verdict"] in ("converged", "completed")
        rows.append((_("{0} (from {1})", s["name"], s["from"]) if "from" in s else s["name"], kind_of(keys), ", ".join(keys.get("loads") or ()), judged.get(s["name"], "-"),
                     (_(s["verdict"]), "pass" if good else "fail"), trial_words(trials) if trials else partial_factors.words(case, found, s["name"]) if design else ""))  # fmt: skip
    return rows + [(name, kind_of(case.scene.stages[name]), ", ".join(case.scene.stages[name].get("loads") or ()), "-", (_("no result"), "fail"), "") for name in without_result(case)]


def cases(case, found, most):
    """Returns the judged stages, then stages of trials and the others as far as there is room, in the order of the run."""
    rows = case_rows(case, found)
    kept = sorted(sorted(range(len(rows)), key=lambda k: (rows[k][3] == "-", not rows[k][5]))[:most])
    left = len(rows) - most
    more = small(_("Cases with their loads are in the annex.") if not kept else ngettext("{0} more is in the annex.", "{0} more are in the annex.", left)) if left > 0 else ""
    if not kept:
        more += "".join(small(f"{row[0]}: {row[5]}.") for row, s in zip(rows, case.results.summary["stages"]) if row[5] and trials_of(s))
    more += small(said) if left > 0 and (said := partial_factors.summary(case, found)) else ""
    wanting, excused = combinations.wanting(case), case.options.no_case
    more += small(_("Load combinations of the guideline without a case: {0}. --no-case says of one why it does not concern this dam.", ", ".join(_(one["name"]) for one in wanting))) if wanting else ""
    more += small(_("Said not to concern this dam: {0}.", "; ".join(f"{_(name)} ({why})" for name, why in excused.items()))) if excused else ""
    if not kept:
        return more
    columns = 6 if any(rows[k][5] for k in kept) else 5
    return head(_("Cases")) + table((_("case"), _("kind"), _("loads at its end"), _("judged as"), _("the run"), _("found by trials"))[:columns], [rows[k][:columns] for k in kept]) + more


def rooms(case, found):
    """Returns how many cases the page shows, and the height [mm] that they and the bases leave for the drawing."""
    if matrix.is_crowded(case, found):
        return 0, max(LEAST, min(MOST, ROOM - OF_LINE * (HEAD + min(matrix.CASES, len(matrix.of_cases(case, found)))) - OF_BASE - OF_ALONE * min(matrix.MOST, len(matrix.untaken(case, found)))))
    room = ROOM - OF_BASE * min(matrix.MOST, len(matrix.judged_bases(case, found))) - OF_ALONE * min(matrix.MOST, len(matrix.untaken(case, found)))
    most = min(CASES, len(case.scene.stages), max(FEWEST, len(case.conditions), (room - WANTED) // OF_CASE))
    return most, max(LEAST, min(MOST, room - OF_CASE * most))


def drawing(case, found, stage, height=None):
    """Draws the section with the loads of a stage. height [mm]: on page 1; none: the height of a page."""
    mine = [a for a in found if a.stage == stage]
    caption = _("Stage {0}. Forces of the slice; red arrows at bases: resultants by the gravity method; dashed: its crack.", stage)
    return picture(section.section_svg(case, stage, mine, height and (WIDE, height)).encode("utf-8"), "svg+xml", caption)


def front_page(case, found, caveats, stage, swept, dams=None, study=None):
    """stage: the one that is drawn; swept: lifts and levels left out of the stages that are judged; dams: rows of what_if_part, None: the scene asks none; study: of by_spectrum, None: no spectrum."""
    most, height = rooms(case, found)
    return (heading(case) + account_boxes(case) + verdict_box(case, found, caveats.judged, swept, study) + unfinished_note(case)
            + f"<div class='top'>{drawing(case, found, stage, height)}<div>{table(('', ''), facts(case, found, dams, study))}{signatures()}</div></div>" + cases(case, found, most)
            + head(_("Cases and bases")) + (matrix.overview(case, found) if matrix.is_crowded(case, found) else "") + matrix.matrix(case, found))  # fmt: skip
