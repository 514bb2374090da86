"""Writes the sheet: one self-contained HTML page (and PDF) about a run, with the gravity method and a guideline's limits.

    quoin report FOLDER [--guideline usace] [--uplift npb] [--pdf] ...

writes FOLDER/report.html; --help lists all options, docs/safety.md explains them. Everything taken from files is escaped, and nothing
is loaded from elsewhere.
"""

import os
import sys

from quoin_tools.assess import by_spectrum, design_spectrum, guidelines, lifts
from quoin_tools.assess.assessment import ERRORS, assess, load_case
from quoin_tools.assess.assessment_options import OptionError, options_from, parser
from quoin_tools.base import language, shared, sheet_units, terminal
from quoin_tools.base.command import words_of
from quoin_tools.base.files import write_file
from quoin_tools.base.language import N_, _
from quoin_tools.ensemble import what_if
from quoin_tools.ensemble.variables import EnsembleError
from quoin_tools.show import annex, browser, main_part, matrix, plots, verify, what_if_part
from quoin_tools.show.anchors_part import anchors_part
from quoin_tools.show.caveats import Caveats
from quoin_tools.show.ensemble_part import ensemble_part
from quoin_tools.show.front_page import drawing, front_page, title_of
from quoin_tools.show.hypertext import esc, file_picture, head, without_full
from quoin_tools.show.lifts_part import lifts_part
from quoin_tools.show.limit_part import limit_part
from quoin_tools.show.materials_part import laws_part
from quoin_tools.show.shaken_part import shaken_part
from quoin_tools.show.shaking import Shaken
from quoin_tools.show.spectrum_part import spectrum_part

FIGURES, FURTHER = "<!-- figures -->", "<!-- further figures -->"  # places of the pictures: drawing them takes longer than all else
STYLE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "page", "sheet.css")
OTHERS = ("quoin report --terminal FOLDER: only the tables of the gravity method, in the terminal. quoin report --verify SHEET FOLDER: whether a sheet is unchanged "
          "and about these files.")  # fmt: skip


def style(case):
    """The style sheet; every page of the PDF carries the checksum of the state (hexadecimal figures only, whatever the file says)."""
    state = "".join(c for c in str(case.results.summary["stages"][-1]["checksum"]) if c in "0123456789abcdef")
    with open(STYLE, encoding="utf-8") as file:
        text = file.read().replace("STATE", state)
    for words in (N_("page "), N_(" of "), N_("Quoin, state ")):
        text = text.replace(f'"{words}', f'"{_(words)}')
    return text


def main_pages(case, found, caveats, stage, swept, dams, study):
    """The first four pages, without pictures. stage: the one that they are about."""
    return (f"<div class='first'>{front_page(case, found, caveats, stage, swept, dams, study)}</div>" + main_part.loads_part(case, stage)
            + lifts_part(case, stage, *swept.get(stage, ([], [])), main_part.ROWS)
            + FIGURES + main_part.mechanism_part(case) + main_part.evidence_part(case, caveats))  # fmt: skip


def further_lifts(case, drawn, swept):
    """Lifts of the other cases, and all of them where the main part has only some."""
    return "".join(lifts_part(case, stage, *answer, len(answer[0])) for stage, answer in swept.items() if stage != drawn or len(answer[0]) > main_part.ROWS)


def annex_pages(case, found, caveats, drawn, swept, shaken, ensemble, study, dams):
    """All else, without pictures. drawn: the stage of page 1."""
    other = [stage for stage in case.results.stages if stage in case.conditions and stage != drawn]
    sections = head(_("Section and loads")) + "".join(drawing(case, found, stage) for stage in other) if other else ""
    return "".join((
        caveats.annex(), what_if_part.what_if_part(*dams) if dams else "", annex.limits_part(case, found, swept), annex.combinations_part(case), sections, annex.stages_part(case), annex.inputs_part(case, drawn, main_part.ROWS),
        annex.assessments_part(case, found, caveats), further_lifts(case, drawn, swept), annex.water_part(case, found), anchors_part(case, found), annex.trials_part(case), limit_part(case),
        ensemble_part(ensemble), annex.modes_part(case), spectrum_part(study, shaken), shaken_part(case, shaken), laws_part(case), annex.local_part(case), annex.displacements_part(case),
        annex.effort_part(case, main_part.ROWS), FURTHER))  # fmt: skip


def page(case, shaken, ensemble=None, spectrum=None, items=()):
    """Returns the page without its pictures, and the names of those that the main part shows, the most wanted first."""
    found, complaints = assess(case)
    caveats, governing = Caveats(case, found, complaints), matrix.governing(case, found)
    dams = what_if_part.dams(case, found, items) if items else None
    stage = governing.stage if governing else case.results.stages[-1]
    swept = {name: lifts.sweep(case, name, lifts.feet(case, [a for a in found if a.stage == name])) for name in case.conditions if name in case.results.stages}
    study = by_spectrum.study(case, spectrum, found, swept.get(by_spectrum.state_at_rest(case), ([], []))[0]) if spectrum else None
    body = main_pages(case, found, caveats, stage, swept, dams, study) + "<div class='annex'>" + head(_("Annex"), 1) + annex_pages(case, found, caveats, stage, swept, shaken, ensemble, study, dams) + "</div>"
    return (f'<!DOCTYPE html><html lang="{language.current.name if language.current else language.ENGLISH}"><head><meta charset="utf-8"><title>{esc(title_of(case))}</title>'
            f'<meta name="viewport" content="width=device-width"><style>{style(case)}</style></head><body>{body}</body></html>\n'), main_part.wanted(stage, governing.name if governing else "")  # fmt: skip


def illustrated(text, wanted, pictures):
    """Returns a page with its pictures: those that are wanted in the main part, the others in the annex."""
    first = main_part.chosen(pictures, wanted)
    captions = [(path, main_part.caption_of(path)) for path in pictures if path not in first]
    further = "".join(file_picture(path, caption) for path, caption in captions if caption)
    return text.replace(FIGURES, main_part.figures(first)).replace(FURTHER, head(_("Further figures")) + further if further else "")


def write(folder, options, with_pdf=False, with_xlsx=False, ensemble=None, speaks=language.ENGLISH, jobs=0, units=None):
    """Returns the paths of the written files, and the texts that the catalogue lacks. jobs: dams of what_if that run at a time, 0: none is run; units: of sheet_units.SYSTEMS, None: those of the guideline."""
    case = load_case(folder, options)
    spectrum = design_spectrum.read(options.spectrum) if options.spectrum else None
    units = units or (guidelines.of(options) or {}).get("units", sheet_units.SI)
    with language.spoken(speaks) as spoken, sheet_units.shown(units):
        with terminal.doing("runs the dams of what_if"):
            items = what_if.run(folder, case.scene, case.mesh_path, jobs) if jobs else []
        shaken = Shaken(case.results, options.ky)
        with terminal.doing("assesses and draws the run"), plots.drawing(case.results, shaken=shaken) as pictures:
            full = illustrated(*page(case, shaken, ensemble, spectrum, items), pictures())
            text = verify.signed(without_full(full))
        path = os.path.join(folder, "report.html")
        write_file(path, text)
        written = [path]
        if with_xlsx:
            from quoin_tools.show import spreadsheet

            written.append(os.path.join(folder, "report.xlsx"))
            spreadsheet.write(written[-1], full, spoken.decimal if spoken else spreadsheet.POINT)
    if with_pdf:
        written.append(os.path.join(folder, "report.pdf"))
        with terminal.doing("prints the sheet"):
            browser.pdf(path, os.path.abspath(written[-1]), os.path.basename(case.scene.path), case.scene.text)
    return written, spoken.missing if spoken else []


def main(arguments=None):
    options = parser("report", "Writes one self-contained HTML sheet about a run, FOLDER/report.html.", OTHERS)
    options.add_argument("--pdf", action="store_true", help="also FOLDER/report.pdf, printed by headless Chromium")
    options.add_argument("--xlsx", action="store_true", help="also FOLDER/report.xlsx: its tables, a tab for each chapter")
    options.add_argument("--language", choices=language.languages(), default=language.ENGLISH, help="of the sheet and its pictures (en)")
    options.add_argument("--units", choices=list(sheet_units.SYSTEMS), help="of the sheet and its pictures: us has ft, kip, psi, pcf (si, or what the guideline's file says)")
    options.add_argument("--ensemble", metavar="FOLDER", help="a page about an ensemble (quoin ensemble): probability of failure, what it hangs on")
    options.add_argument("--what-if", type=int, default=shared.processors(), metavar="JOBS", help="how many dams of the scene's what_if run at a time (all cores); 0: none is run")
    given = options.parse_args(arguments)
    try:
        if given.what_if < 0:
            raise OptionError(f"--what-if {given.what_if}: expected 0 (none is run) or more")
        written, missing = write(given.folder, options_from(given), given.pdf, given.xlsx, given.ensemble, given.language, given.what_if, given.units)
    except browser.BrowserError as error:
        print(f"report: report.html is written, report.pdf is not: {error}", file=sys.stderr)
        return 3
    except (*ERRORS, EnsembleError, OSError) as error:
        print(f"report: {words_of(error)}", file=sys.stderr)
        return 2
    print("\n".join(written))
    if missing:
        print(f"report: {len(missing)} texts have no words in this language and stay English, as '{missing[0]}'", file=sys.stderr)
    return 0
