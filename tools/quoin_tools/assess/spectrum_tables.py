"""The tables of an earthquake by a design spectrum, for the terminal and for the sheet."""

from quoin_tools.assess import guidelines
from quoin_tools.assess.assessment import cell
from quoin_tools.assess.by_spectrum import LEFT_OUT, WAYS
from quoin_tools.base.language import N_, _
from quoin_tools.base.record import STANDARD
from quoin_tools.base.results import sliding

NAMED = 3  # planes in the line of page 1
COLUMNS = (N_("plane"), N_("level [m]"), N_("by"), N_("T of the earthquake [kN]"), N_("M [kN m]"), N_("N [kN]"), N_("least sliding factor"), N_("largest tension at an end [kPa]"), N_("crack [m]"), N_("limits"))


def facts_of(study):
    """Rows (words, number) of the spectrum, of the first mode with its water and rock, and of all modes."""
    spectrum, first, modes = study.spectrum, study.first, study.modes
    rows = [(_("spectrum"), spectrum.title), (_("stage to which it is added"), study.stage), (_("acceleration of the ground [g]"), cell(spectrum.ground / STANDARD, 3)),
            (_("damping of the dam [%]"), cell(100 * spectrum.damping, 1))]  # fmt: skip
    if spectrum.ground_vertical:
        rows.append((_("vertical acceleration of the ground [g]"), cell(spectrum.ground_vertical / STANDARD, 3)))
    if first:
        rock = float(spectrum.dam.get("rock_period", 1.0))
        rows += [(_("first mode, period of the empty dam [s]"), cell(first.period / rock / first.lengthening, 3)), (_("... longer by the water, R_r"), cell(first.lengthening, 3)),
                 (_("... longer by the rock, R_f (given)"), cell(rock, 3)), (_("... period with both [s]"), cell(first.period, 3)), (_("... damping that the water adds [%]"), cell(100 * first.water_damping, 2)),
                 (_("... damping in all [%]"), cell(100 * first.damping, 2)), (_("... S_a [g]"), cell(study.acceleration / STANDARD, 3))]  # fmt: skip
        if study.reservoir:
            rows.append((_("... wave reflection of the reservoir's bottom"), cell(study.reservoir.reflection, 2)))
    if modes:
        rows += [(_("modes found in stage {0}", study.stage_of_modes), str(len(modes["list"]))), (_("... their part of the mass along x [%]"), cell(100 * modes["sum_x"], 1)),
                 (_("... their part of the mass along y [%]"), cell(100 * modes["sum_y"], 1))]  # fmt: skip
    return rows


def verdict_of(row):
    """One word for the limits of a plane; "-" where none has a number."""
    return _(guidelines.overall(row.limits)) if row.limits else "-"


def failed(study):
    """Words about each limit that a plane breaks under the spectrum, by each way, with its number and its bound."""
    return [_("{0} by a spectrum ({1}) on {2}", limit.words, _(row.way), row.plane) + f": {limit.printed(limit.value)}, {limit.bound}" for row, limit in study.judged if limit.verdict == guidelines.FAIL]


def rows_of(study):
    return [(row.plane, cell(row.level, 2), _(row.way), cell(row.T / 1e3, 0), cell(row.M / 1e3, 0), cell(row.N / 1e3, 0), sliding(row.factor, 2) if row.stands else _("no equilibrium"),
             cell(row.tension / 1e3, 0), cell(row.crack, 2), verdict_of(row)) for row in study.rows]  # fmt: skip


def left_out(study, with_record=False):
    """One sentence for each way that was taken: what it leaves out."""
    ways = list(dict.fromkeys(row.way for row in study.rows)) + (["record"] if with_record else [])
    return [_(LEFT_OUT[way]) for way in ways]


def line(study):
    """The worst plane of each way, in one line; what is missing where there is none."""
    parts = []
    for way in WAYS:
        rows = [row for row in study.rows if row.way == way]
        fallen = [row.plane for row in rows if not row.stands]
        known = [row for row in rows if row.stands and row.factor is not None]
        if fallen:
            named = fallen[:NAMED] + ([_("{0} more", len(fallen) - NAMED)] if len(fallen) > NAMED else [])
            parts.append(_("{0}: no equilibrium at the peak on {1}", _(way), ", ".join(named)))
        elif known:
            worst = min(known, key=lambda row: row.factor)
            parts.append(_("{0}: least sliding factor {1} on {2}", _(way), sliding(worst.factor, 2), worst.plane))
        elif rows:
            parts.append(_("{0}: equilibrium on all planes", _(way)))
    return "; ".join(parts) if parts else " ".join(study.why)


READ = N_("T, M, N are the largest of the earthquake alone, without signs; factor, tension and crack are those with the state at rest, the worst of all signs. No equilibrium: the peak of a moment would open the plane all through; it is no collapse yet.")
