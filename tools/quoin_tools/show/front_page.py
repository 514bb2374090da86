"""Writes page 1 of the sheet: verdict, the dam drawn, the run, the cases, the matrix of cases and bases, room to sign."""

import datetime

import quoin_tools
from quoin_tools.assess import combinations, guidelines, lifts
from quoin_tools.assess.assessment import account_complaints, cell
from quoin_tools.assess.base_water import dry_stretches
from quoin_tools.base.results import condensed_words, trials_of
from quoin_tools.show import matrix, section
from quoin_tools.show.annex import changed_by, without_result
from quoin_tools.show.hypertext import esc, notes, picture, table, verdict_class

NAMED = 5  # judged stages that the verdict has by name
HEAD = 4  # lines that the head of the rows of cases and their note take
CASES, FAILURES = 6, 3  # rows of the table of cases; failed limits, joints named in the verdict
ROOM, OF_CASE, OF_BASE, OF_ALONE, OF_LINE = 145, 7, 15, 5, 5  # [mm] on the page for drawing and rows; height of a case, a base, a joint without the gravity method, a case in one line
FEWEST, WANTED, LEAST, MOST = 2, 75, 60, 120  # cases; [mm] height of the drawing: for which cases that are not judged make room, that it keeps, at most
WIDE = 107  # [mm] of the drawing
SIGNATURES = "<table class='sign'><tbody>" + "".join(f"<tr><th>{who}</th><th class='d'>Date</th></tr><tr><td></td><td></td></tr>" for who in ("Prepared by", "Checked by")) + "</tbody></table>"


def title_of(case):
    return case.results.summary["title"] or case.results.summary["model"]


def heading(case):
    return f"<h1>{esc(title_of(case))}</h1><p class='soft'>Safety of a masonry dam: block model and gravity method</p>"


def account_boxes(case):
    """A box above all others for each stage in time whose energy account is out, judged or not."""
    return "".join(f'<div class="verdict fail"><b>Energy account out: stage {esc(s["name"])}</b><br><span>{esc(" ".join(sentences))}</span></div>'
                   for s in case.results.summary["stages"] if "balance" in s["energy"] and (sentences := account_complaints(s)))


def listed(names):
    """The first names, and how many more there are."""
    return "; ".join(names[:FAILURES]) + (f"; {len(names) - FAILURES} more" if len(names) > FAILURES else "")


def weak_lifts(case, found, swept):
    """Words about the worst lift of each judged stage whose sliding factor is below the limit of its base."""
    weak = []
    for stage, (sections, _) in swept.items():
        limit = max((j.limit for a in found if a.stage == stage for j in a.limits if j.quantity == "sliding_peak" and j.limit is not None), default=None)
        worst = lifts.worst(sections)
        if limit is not None and worst and worst.factor is not None and worst.factor < limit * (1 - guidelines.ROUNDING):
            weak.append(f"sliding factor {worst.factor:.2f} of the lift at {worst.level:.2f} m in stage {stage}")
    return weak


def lifted(swept):
    """Lifts of unknown strength that find no equilibrium without tension: nothing says that they hold."""
    return [f"{lift.level:.2f} m ({stage})" for stage, (sections, _) in swept.items() for lift in sections if lift.hand.crack is None and lift.factor is None]


def verdict_box(case, found, remarks, swept):
    """Writes the verdict of the limits in one word and one sentence. remarks: number of caveats; swept: lifts of the judged stages."""
    o = case.options
    if not o.guideline:
        names = ", ".join(guidelines.read())
        return f'<div class="verdict open"><b>Not judged</b><br><span>No guideline was named (--guideline: {esc(names)}).</span></div>'
    judged = [a for a in found if a.condition]
    named = set(case.conditions)
    there = {(a.stage, a.name) for a in judged}
    refused = [name for name in o.paths if any((stage, name) not in there for stage in named)]
    collapsed = [s["name"] for s in case.results.summary["stages"] if s["name"] in named and s["verdict"] == "collapsed"]
    missing = not judged or not named <= {a.stage for a in judged} or bool(refused) or bool(without_result(case) and not o.conditions)
    rows = [limit for a in judged for limit in a.limits]
    weak, loose = weak_lifts(case, found, swept), lifted(swept)
    alone = [f"{name} ({stage})" for stage, name, _ in matrix.untaken(case, found)]
    word = "FAIL" if weak or collapsed else guidelines.overall(rows, not missing and not alone and not loose and all(a.complete for a in judged))
    failed = [f"{limit.text} in stage {a.stage} on {a.name}" for a in judged for limit in a.limits if limit.verdict == guidelines.FAIL] + weak
    stages = list(dict.fromkeys(f"{a.stage} as {a.condition}" for a in judged))
    sentences = [f"{guidelines.read()[o.guideline]['title']}.", f"Judged: {', '.join(stages) or 'no stage'}." if len(stages) <= NAMED else f"Judged: {len(stages)} cases, in the table below."]
    if named_so := combinations.taken_from_names(case):
        sentences.append(f"Taken from the names of stages: {', '.join(f'{stage} as {condition}' for stage, condition in named_so.items())}; --condition says another one.")
    if caution := guidelines.read()[o.guideline].get("caution"):
        sentences.append(caution)
    if collapsed:
        sentences.append(f"Collapsed: {', '.join(collapsed)}.")
    if failed:
        sentences.append("Limits that fail: " + listed(failed) + ".")
    if refused:
        sentences.append(f"No numbers for path {', '.join(refused)}.")
    if alone:
        sentences.append(f"Not judged, because the gravity method does not take them: joint{'s' * (len(alone) > 1)} {listed(alone)}; --path names a way through them.")
    dry = [stage for stage in case.results.stages if stage in named and dry_stretches(case.results.stage_summary(stage))]
    if dry:
        sentences.append(f"Open joints without water in stage{'s' * (len(dry) > 1)} {listed(dry)}: see the reservations.")
    if loose:
        sentences.append(f"No equilibrium without tension in lifts whose strength is unknown: {listed(loose)}.")
    open_ones = sum(limit.verdict == guidelines.OPEN for limit in rows)
    if open_ones:
        sentences.append(f"Limits not judged for want of a number: {open_ones}.")
    if any(limit.check for limit in rows):
        sentences.append("Limits marked “check” were written from memory and must be held against the document.")
    if remarks:
        sentences.append(f"Reservations: {remarks}, under Evidence.")
    return f'<div class="verdict {verdict_class(word)}"><b>{esc(word)}</b><br><span>{esc(" ".join(sentences))}</span></div>'


def unfinished_note(case):
    """Lists stages without a result or not run: they may be decisive."""
    names, not_run = without_result(case), case.results.summary.get("not_run", [])
    sentences = [f"Not run, because the stage from which they start has failed: {', '.join(not_run)}."] if not_run else []
    names = [name for name in names if name not in not_run]
    return notes(sentences + [f"No result of stage{'s' * (len(names) != 1)} {', '.join(names)}: the run was refused, stopped or broke off before, or goes "
                  "on. The sheet knows nothing of it."] * bool(names)) if names or sentences else ""  # fmt: skip


def facts(case):
    summary = case.results.summary
    o = case.options
    return [("Model", summary["model"]), ("Scene", case.scene.path if not summary["scene"] else summary["scene"]),
            ("Program", f"Quoin {summary['quoin']}, {summary['ranks']} rank{'s' * (summary['ranks'] != 1)}; "
                        f"sheet by quoin_tools {quoin_tools.__version__}"),
            ("Model size", f"{summary['n_blocks']} blocks in {summary['n_macroblocks']} bodies, {summary['n_contacts']} contacts, "
                           f"{summary['n_dofs']} degrees of freedom"),
            *([("Condensed", condensed_words(summary))] if summary.get("condensed") else []),
            ("Slice", f"{summary['thickness']:g} m thick; forces are those of the slice"),
            ("Guideline", o.guideline or "none"), ("Uplift in the gravity method", (o.uplift + ("" if o.drain is not None else ", drain as in the scene")) if o.uplift else "as in the scene"),
            ("State checksum", f"{summary['stages'][-1]['checksum']} (stage {summary['stages'][-1]['name']})"),
            ("Sheet written", datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"))]  # fmt: skip


def trial_words(found):
    """Describes the result of trials in a line."""
    stable, failing = (cell(found.get(end), 3) for end in ("stable", "failing"))
    factors = [cell(found.get(f"safety_factor_{end}"), 3) for end in ("stable", "failing")]
    return f"{changed_by(found)}: {stable} stands, " + (f"{failing} fails" if failing != "-" else "no trial fails") + (
        f"; factor {factors[0]} to {factors[1]}" if factors[0] != "-" else "")  # fmt: skip


def case_rows(case):
    rows, judged = [], combinations.judged_as(case)
    for s in case.results.summary["stages"]:
        keys, trials = case.scene.stages.get(s["name"], {}), trials_of(s)
        kind = str(keys.get("type", "static")).replace("_", " ")
        good = s["verdict"] in ("converged", "completed")
        rows.append((s["name"] + (f" (from {s['from']})" if "from" in s else ""), kind, ", ".join(keys.get("loads") or ()), (judged[s["name"]], "word") if s["name"] in judged else "-",
                     (s["verdict"], "pass" if good else "fail"), trial_words(trials) if trials else ""))  # fmt: skip
    return rows + [(name, str(case.scene.stages[name].get("type", "static")).replace("_", " "), ", ".join(case.scene.stages[name].get("loads") or ()), "-", ("no result", "fail"), "")
                   for name in without_result(case)]  # fmt: skip


def cases(case, most):
    """Returns the judged stages, then stages of trials and the others as far as there is room, in the order of the run."""
    rows = case_rows(case)
    kept = sorted(sorted(range(len(rows)), key=lambda k: (rows[k][3] == "-", not rows[k][5]))[:most])
    more = f"<p><small>{len(rows) - most} more are in the annex.</small></p>" if len(rows) > most else ""
    _, missing = combinations.of_cases(case)
    more += f"<p><small>Load combinations of the guideline without a case: {esc(', '.join(one['name'] for one in missing))}.</small></p>" if missing else ""
    if not kept:
        return more.replace(f"{len(rows)} more are in the annex.", "Cases with their loads are in the annex.")
    columns = 6 if any(rows[k][5] for k in kept) else 5
    return "<h2>Cases</h2>" + table(("case", "kind", "loads at its end", "judged as", "the run", "found by trials")[:columns], [rows[k][:columns] for k in kept]) + more


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
    caption = f"Stage {stage}. Forces of the slice; red arrows at bases: resultants by the gravity method; dashed: its crack."
    return picture(section.section_svg(case, stage, mine, height and (WIDE, height)).encode("utf-8"), "svg+xml", caption)


def front_page(case, found, caveats, stage, swept):
    """stage: the one that is drawn; swept: lifts and levels left out of the stages that are judged."""
    most, height = rooms(case, found)
    return (heading(case) + account_boxes(case) + verdict_box(case, found, caveats.judged, swept) + unfinished_note(case)
            + f"<div class='top'>{drawing(case, found, stage, height)}<div>{table(('', ''), facts(case))}{SIGNATURES}</div></div>" + cases(case, most)
            + "<h2>Cases and bases</h2>" + (matrix.overview(case, found) if matrix.is_crowded(case, found) else "") + matrix.matrix(case, found))  # fmt: skip
