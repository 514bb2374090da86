"""Writes the matrix of the sheet's first page: each judged case and base, block model over gravity method over the limit."""

import numpy as np

from quoin_tools.assess import guidelines
from quoin_tools.assess.assessment import block_of_joint, cell
from quoin_tools.assess.judgement import friction_of
from quoin_tools.assess.strength import factors, lies_on
from quoin_tools.base.language import N_, _, ngettext
from quoin_tools.base.results import NO_SHEAR
from quoin_tools.show.hypertext import esc, small, soft, table, verdict_class

CASES = 10  # of the table with one line each on the first page
MOST = 3  # bases on the first page; all of them are in the annex
COLUMNS = ((N_("N [kN]"), "N", None, 1e-3, 0), (N_("T [kN]"), "T", None, 1e-3, 0), (N_("M [kN m]"), "M", None, 1e-3, 0), (N_("sliding, peak strength"), "peak", "sliding_peak", 1, 2), (N_("sliding, residual strength"), "residual", "sliding_residual", 1, 2),
           (N_("sliding, no cohesion"), "friction_only", "friction_only", 1, 2), (N_("sliding, partial factors"), "partial", "sliding_partial", 1, 2), (N_("overturning: 2 e / L"), "middle", "middle", 1, 3),
           (N_("stress at the heel [kPa]"), "heel", "tension", 1e-3, 0), (N_("stress at the toe [kPa]"), "toe", None, 1e-3, 0),
           (N_("largest compression [kPa]"), "compression", "strength", 1e-3, 0), (N_("crack / L"), "crack", "crack", 1, 3),
           (N_("uplift [kN]"), "uplift", None, 1e-3, 0), (N_("material"), "local", "local_factor", 1, 2))  # fmt: skip
FACTORS = ("peak", "residual", "friction_only", "partial")  # of sliding
ALWAYS = ("N", "T", "M", "peak", "residual", "middle", "heel", "toe", "compression", "crack", "uplift")
NOTE = N_("Two rows a base: the block model with the loads of the scene; the gravity method, with the uplift of the options where a rule is named beside it. Under them the limits, which the less favourable number "
          "is held against (the annex has them with their sources). e: distance of the resultant from the middle; L: length of the base; stress by the straight line, tension positive.")  # fmt: skip


def of_block(found, facts):
    """Numbers of the block model by the names of COLUMNS."""
    block = found.block
    if not block:
        return {}
    L, groups = found.base.length, (facts.get("safety") or {}).values()
    local = min((group["value"] for group in groups if group["value"] is not None), default=None)
    return {key: block.get(key) for key in ("N", "T", "M", "peak", "residual", "compression", "uplift")} | {"friction_only": friction_of(block, found.strength)} | at_ends(found, block["start"], block["end"]) | {
        "middle": 2 * abs(block["M"] / block["N"]) / L if block["N"] > 0 else np.inf, "crack": block["crack"] / L, "local": local}  # fmt: skip


def at_ends(found, start, end):
    """Turns numbers of the ends of a base to numbers of its heel, where the water stands, and of its toe."""
    return dict(zip(("heel", "toe") if found.heel == "start" else ("toe", "heel"), (start, end)))


def of_hand(found):
    hand, L = found.governing, found.base.length
    values = {"N": hand.N, "T": hand.T, "M": hand.M, "middle": 2 * abs(hand.eccentricity) / L if hand.N > 0 else np.inf,
              "compression": hand.compression, "uplift": hand.uplift} | at_ends(found, *hand.linear)  # fmt: skip
    return values | (factors(hand, found.strength) | {"crack": hand.crack / L} if hand.crack is not None else {"crack": 1.0})


def words(value, scale, digits, key):
    if key in FACTORS and value is not None and value > NO_SHEAR:
        return "∞"
    return cell(None if value is None else value * scale, digits)


def severity(found):
    """Ranks a base by its distance from failure: failed limits first, then the least factor."""
    least = [x for x in (of_hand(found).get("peak"), (found.block or {}).get("peak")) if x is not None]
    refused = found.governing.crack is None
    return -sum(limit.verdict == guidelines.FAIL for limit in found.limits) - refused, min(least, default=np.inf), -of_hand(found)["middle"]


def judged_bases(case, found):
    """Returns the assessments of judged stages; all of the last stage where these have no base."""
    mine = [a for a in found if a.stage in case.conditions]
    return mine or [a for a in found if a.stage == case.results.stages[-1]]


def governing(case, found):
    """Returns the base nearest to failure; None without any."""
    return min(judged_bases(case, found), key=severity, default=None)


def case_name(found):
    """A stage and the condition that it is judged as, once where it has its name."""
    return f"{found.stage} ({_(found.condition)})" if found.condition and found.condition != found.stage else found.stage


def base_rows(found, facts, shown):
    limits = {limit.quantity: limit for limit in found.limits}
    method = _("gravity, {0}", found.water.rule) if found.with_uplift else _("gravity")
    name = case_name(found)
    rows = []
    for row, (who, values) in enumerate(((_("block model"), of_block(found, facts)), (method, of_hand(found)))):
        rows.append([name if row == 0 else "", found.name if row == 0 else "", who, *(words(values.get(key), scale, digits, key) for _, key, _, scale, digits in shown)])
    if limits:
        judged = [limits.get(quantity) for _, _, quantity, _, _ in shown]
        word = guidelines.overall(found.limits, found.complete)
        rows.append([(_(word), verdict_class(word)), "", _("limit"), *("" if j is None else (f"{_(j.verdict)}, {j.printed(j.value)} {j.bound}" if j.quantity == "sliding_partial" else f"{_(j.verdict)}, {j.bound}", verdict_class(j.verdict)) for j in judged)])
    return rows


def untaken(case, found):
    """Returns (stage, joint, its facts) of joints in judged stages that the gravity method has not taken, alone or within a path: lines, and joints with a path through them."""
    rows = []
    for stage in case.conditions:
        paths = [a.path for a in found if a.stage == stage and (a.kind not in ("path", "way") or a.strength.get("friction") is not None)]  # a way without strength says nothing of sliding
        for name, facts in case.results.stage_summary(stage)["joints"].items() if stage in case.results.stages else ():
            lines = [[(facts[at]["x"], facts[at]["y"]) for at in ("start", "end")]] if facts["line"] else [way.ends for way in case.sliding_paths.get(name, ())]
            if not all(any(all(lies_on(path, end) for end in ends) for path in paths) for ends in lines):
                rows.append((stage, name, facts))
    return sorted(rows, key=lambda row: np.inf if row[2]["sliding_factor_peak"] is None else row[2]["sliding_factor_peak"])


def untaken_rows(case, rows, shown):
    """Rows of the matrix for joints with numbers of the block model alone."""
    found = []
    for stage, name, facts in rows[:MOST]:
        values = {"peak": facts["sliding_factor_peak"], "residual": facts["sliding_factor_residual"], "crack": facts["open_length"] / facts["length"]}
        if facts["line"]:
            block = block_of_joint(facts, facts["chord"])
            values = {key: block.get(key) for key in ("N", "T", "M", "peak", "residual", "compression")} | {
                "middle": 2 * abs(block["M"] / block["N"]) / facts["chord"] if block["N"] > 0 else None, "crack": block["crack"] / facts["chord"]}  # fmt: skip
        found.append([(_("{0}: not judged", stage), "open"), name, _("block model alone"), *(words(values.get(key), scale, digits, key) for _, key, _, scale, digits in shown)])
    return found


def of_cases(case, found):
    """The least safe base of each judged case, in the order of the run."""
    stages = dict.fromkeys(a.stage for a in found if a.condition)
    return [min((a for a in found if a.stage == stage), key=severity) for stage in stages]


def is_crowded(case, found):
    """Tells whether there are more judged cases than the page has room for with a matrix each."""
    return len(of_cases(case, found)) > MOST


LINE = ((N_("N [kN]"), "N", None), (N_("T [kN]"), "T", None), (N_("M [kN m]"), "M", None), (N_("uplift [kN]"), "uplift", None), (N_("sliding factor"), "peak", "sliding_peak"), (N_("overturning: 2 e / L"), "middle", "middle"),
        (N_("stress at the heel [kPa]"), "heel", "tension"), (N_("stress at the toe [kPa]"), "toe", None), (N_("largest compression [kPa]"), "compression", "strength"), (N_("crack / L"), "crack", "crack"))  # fmt: skip
OF_LINE_NOTE = N_("One row a case: its least safe base by the gravity method; the sliding factor is the less favourable one of both methods. Coloured where a limit is held against the number.")


def overview(case, found):
    """HTML of a row for each judged case."""
    formats, rows = {key: (scale, digits) for _, key, _, scale, digits in COLUMNS}, []
    cases = of_cases(case, found)
    worst = sorted(cases, key=severity)[:CASES]
    for a in [a for a in cases if any(a is other for other in worst)]:
        hand, limits = of_hand(a), {limit.quantity: limit for limit in a.limits}
        hand["peak"] = min((x for x in (hand.get("peak"), (a.block or {}).get("peak")) if x is not None), default=None)
        verdict, run = guidelines.overall(a.limits, a.complete) if a.limits else "-", case.results.stage_summary(a.stage)["verdict"]
        cells = []
        for __, key, quantity in LINE:
            text, limit = words(hand.get(key), *formats[key], key), limits.get(quantity)
            cells.append((text, verdict_class(limit.verdict)) if limit and limit.verdict in (guidelines.PASS, guidelines.MET, guidelines.FAIL) else text)
        rows.append((case_name(a), a.name, (_(run), "pass" if run in ("converged", "completed") else "fail"), *cells, (_(verdict), verdict_class(verdict)) if a.limits else verdict))
    return ("<div class='matrix'>" + table((_("case"), _("base"), _("the run"), *(_(title) for title, *rest in LINE), _("limits")), rows, range(3, 3 + len(LINE)))
            + (small(_("{0} more cases are in the annex: these are the least safe.", len(cases) - CASES)) if len(cases) > CASES else "") + small(_(OF_LINE_NOTE)) + "</div>")  # fmt: skip


def matrix(case, found):
    """HTML of the matrix; the worst bases where there are more than the page has room for."""
    mine = judged_bases(case, found)
    if not mine:
        return soft(_("No base is a line that the gravity method can take: there is no number to judge."))
    worst = sorted(mine, key=severity)[: 1 if is_crowded(case, found) else MOST]
    kept = [a for a in mine if any(a is other for other in worst)]
    held = {limit.quantity for a in kept for limit in a.limits}
    shown = [column for column in COLUMNS if column[1] in ALWAYS or column[2] in held]
    rows = [row for a in kept for row in base_rows(a, case.results.stage_summary(a.stage), shown)]
    alone = untaken(case, found)
    rows += untaken_rows(case, alone, shown)
    left = []
    if len(mine) > len(kept):
        left.append(ngettext("{0} more base is in the annex: this one is the least safe.", "{0} more bases are in the annex: this one is the least safe.", len(mine) - len(kept)) if len(kept) == 1 else
                    ngettext("{0} more base is in the annex: these {1} are the least safe.", "{0} more bases are in the annex: these {1} are the least safe.", len(mine) - len(kept), len(kept)))
    if len(alone) > MOST:
        left.append(ngettext("{0} more joint has numbers of the block model alone.", "{0} more joints have numbers of the block model alone.", len(alone) - MOST))
    return ("<div class='matrix'>" + table((_("case"), _("base"), "", *(_(title) for title, *rest in shown)), rows, range(3, 3 + len(shown)))
            + f"<p><small>{esc(' '.join(left))}</small> <small>{esc(_(NOTE))}</small></p></div>")  # fmt: skip
