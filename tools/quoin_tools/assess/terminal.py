"""Prints the tables of the gravity method in the terminal: quoin report --terminal FOLDER."""

import sys

from quoin_tools.assess import base_water, by_spectrum, design_spectrum, lifts, spectrum_tables
from quoin_tools.assess.assessment import ERRORS, assess, beside, cell, lines, load_case
from quoin_tools.assess.assessment_options import options_from, parser
from quoin_tools.base.flow import condition_rows, facts_of
from quoin_tools.base.terminal import table


def text_of(found):
    """A table for the terminal."""
    rows = [(r.quantity + (f" [{r.unit}]" if r.unit else ""), cell(r.block, r.digits), cell(r.hand, r.digits),
             cell(r.difference, r.digits, "+"), cell(r.with_uplift, r.digits)) for r in lines(found)]  # fmt: skip
    out = ["", f"Stage {found.stage}, {found.kind} {found.name}: ({found.base.start[0]:.2f}, {found.base.start[1]:.2f}) to "
               f"({found.base.end[0]:.2f}, {found.base.end[1]:.2f}) m, length {found.base.length:.3f} m"]  # fmt: skip
    shown = 5 if found.with_uplift else 4
    header = ["quantity", "block model", "gravity", "difference", "with uplift"]
    out += table(header[:shown], [row[:shown] for row in rows])
    out += [f"  {j.words}: {j.printed(j.value)}, limit {j.bound}: {j.verdict} ({j.source})"
            for j in found.limits]  # fmt: skip
    return out + [f"  {note}" for note in found.notes]


def water_text(case, stage, found):
    """The water in the joints of a stage for the terminal; nothing where none flows."""
    facts = case.results.stage_summary(stage)
    if not facts_of(facts):
        return []
    rows = [(a.name, *row) for a in found if a.stage == stage and a.computed is not None for row in beside(a)]
    out = ["", f"Stage {stage}: water in joints, {facts_of(facts)['state']}"]
    out += table(["leaves the joints (negative: enters) by", "m2/s", "litres per minute and metre"], condition_rows(facts))
    out += table(["base", *base_water.BESIDE], rows) if rows else []
    return out + [f"  {line}" for line in base_water.remarks(case.results, stage)]


def spectrum_text(case, found):
    """The earthquake of --spectrum for the terminal; nothing without."""
    if not case.options.spectrum:
        return []
    stage = by_spectrum.state_at_rest(case)
    swept = lifts.sweep(case, stage, lifts.feet(case, [a for a in found if a.stage == stage]))[0] if stage else []
    study = by_spectrum.study(case, design_spectrum.read(case.options.spectrum), found, swept)
    out = ["", *table(["earthquake by a spectrum", ""], spectrum_tables.facts_of(study)), *(f"  {line}" for line in study.why)]
    if not study.rows:
        return out
    return [*out, "", *table(list(spectrum_tables.COLUMNS), spectrum_tables.rows_of(study)), *(f"  {line}" for line in [*spectrum_tables.failed(study), spectrum_tables.READ, *spectrum_tables.left_out(study)])]


def gathered(complaints):
    """Returns lines (stages, text) about what could not be assessed; a text that holds for several stages stands once."""
    stages = {}
    for stage, sentences in complaints.items():
        for line in sentences:
            stages.setdefault(line, []).append(stage)
    return [("Stage" + "s" * (len(names) > 1) + " " + ", ".join(names), line) for line, names in stages.items()]


def main(arguments=None):
    given = parser("report --terminal", "The gravity method beside the block model, in the terminal.").parse_args(arguments)
    try:
        case = load_case(given.folder, options_from(given))
        found, complaints = assess(case)
        by_design = spectrum_text(case, found)
    except ERRORS as error:
        print(f"report: {error}", file=sys.stderr)
        return 2
    for assessment in found:
        print("\n".join(text_of(assessment)))
    for line in (line for stage in case.results.stages for line in water_text(case, stage, found)):
        print(line)
    print("\n".join(by_design), end="\n" if by_design else "")
    for stages, line in gathered(complaints):
        print(f"  {stages}: {line}")
    return 0
