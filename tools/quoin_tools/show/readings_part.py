"""Writes what readings say: readings.json, a CSV for each sensor, pictures, and readings.html, one page with all of it. Numbers stand in the unit of the table."""

import io
import json
import math
import os
from functools import partial

import numpy as np
import scipy

import quoin_tools
from quoin_tools.base.files import write_file
from quoin_tools.base.shared import shared
from quoin_tools.base.terminal import doing
from quoin_tools.readings import statistics
from quoin_tools.show import readings_pictures
from quoin_tools.show.hypertext import esc, file_picture, head, notes, small, soft, table

STYLE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "page", "sheet.css")
MOST = 60  # findings in the page
FORMS = 8  # of the fit in the table of cross-validation, the best ones
DOUBTFUL, CHANCE = 0.85, 0.01  # share of a held-out year inside the 95 % band; chance of as few, below which it is doubtful
INFLUENTIAL = 5  # readings in the table of influence
HEADER = ("sensor", "readings", "explained [%]", "scatter", "RMSE, held out", "inside 95 % [%]", "drift", "95 % interval", "rate per year at the end", "95 % interval")


def facts(readings, answer):
    """Returns the numbers of a sensor, in its unit, as readings.json has them."""
    sensor, fit = readings.sensors[answer.name], answer.final
    found, influence = readings_pictures.banded(readings, answer), statistics.influence(answer)
    drift, judged = statistics.drift(answer), statistics.judgement(answer)
    size = lambda value: abs(float(sensor.shown(value, True)))  # noqa: E731
    beyond = found["residual"].abs() > found["band 99%"]
    top = influence.nlargest(INFLUENTIAL, "cook")
    return {
        "quantity": sensor.quantity, "unit": sensor.unit_of(), "unit of differences": sensor.unit_of(True), "readings": len(answer.data), "from": f"{fit.start:%Y-%m-%d}", "to": f"{fit.end:%Y-%m-%d}",
        "left_out": {reason: count for reason, count in {**readings.left_out[answer.name], **answer.left_out}.items() if count}, "notes": answer.notes + doubts(judged), "fit": fit.choice.words(),
        "cross_validation": [{"fit": choice.words(), "rmse": size(score)} for choice, score in answer.scores.items()],
        "explained": statistics.explained(answer), "scatter": size(fit.noise.deviation), "lasting_share": fit.noise.lasting, "correlation": fit.noise.correlation, "independent_readings": fit.noise.effective,
        "drift": drift and dict(zip(("change", "rate_at_end_per_year"), (span(sensor, *one) for one in drift))),
        "held_out": judged and {"readings": judged["readings"], "rmse": size(judged["rmse"]), "mean_error": float(sensor.shown(judged["mean"], True)),
                                "inside_95": judged["inside"][0.95], "inside_99": judged["inside"][0.99], "levels_not_seen": judged["unseen"]},
        "alerts": [{"line": int(readings.lines[date]), "date": str(date), "residual": float(found["residual"][date])} for date in found.index[beyond]],
        "influence": [{"line": int(readings.lines[date]), "date": str(date), "reading": float(found["reading"][date]), "cook": float(row["cook"]), "leverage": float(row["leverage"])} for date, row in top.iterrows()],
    }  # fmt: skip


def doubts(judged):
    """Returns what a held-out year makes doubtful. judged: statistics.judgement."""
    if judged is None:
        return []
    seen = [f"{judged['unseen']} of {judged['readings']} readings of the held-out year stand at levels that the fit has not seen: it may be wrong there"] if judged["unseen"] else []
    share = judged["inside"][0.95]
    few = share < DOUBTFUL and scipy.stats.binom.cdf(round(share * judged["readings"]), judged["readings"], 0.95) < CHANCE
    return seen + ([f"{share:.0%} of the held-out year lies inside the 95 % band: the noise lasts longer, or the dam has changed; trust no interval of this sensor"] if few else [])


def span(sensor, value, low, high):
    """Returns a change with its interval in the unit of the sensor."""
    low, high = sorted(float(one) for one in sensor.shown([low, high], True))
    return {"value": float(sensor.shown(value, True)), "low": low, "high": high, "differs_from_0": low > 0 or high < 0}


def rows(said):
    """Returns the table of all sensors, HEADER above it. said: {sensor: facts}."""
    return [row(name, one) for name, one in said.items()]


def row(name, one):
    unit, drift, held = one["unit of differences"], one["drift"], one["held_out"]
    digits = 3 - math.floor(math.log10(max(one["scatter"], 1e-300)))  # a thousandth of the scatter is nothing
    said = lambda value: f"{round(value, digits) + 0.0:+.3g}"  # noqa: E731
    change = lambda part: (f"{said(part['value'])} {unit}", f"{said(part['low'])} to {said(part['high'])}" + ("" if part["differs_from_0"] else " (none)"))  # noqa: E731
    drifts = (*change(drift["change"]), *change(drift["rate_at_end_per_year"])) if drift else ("-",) * 4
    return (name, one["readings"], f"{100 * one['explained']:.1f}", f"{one['scatter']:.3g} {unit}", f"{held['rmse']:.3g} {unit}" if held else "-", f"{100 * held['inside_95']:.1f}" if held else "-", *drifts)


def write(readings, answers, folder):
    """Writes all into the folder. Returns (paths, {sensor: facts})."""
    said = {answer.name: facts(readings, answer) for answer in answers}
    os.makedirs(folder, exist_ok=True)
    written = []
    with doing("draws"):
        pictures = dict(zip(said, shared([partial(readings_pictures.draw, readings, answer, folder) for answer in answers])))
    for answer in answers:
        written.append(os.path.join(folder, f"{answer.name}.csv"))
        write_file(written[-1], csv_of(readings, answer))
        written += pictures[answer.name].values()
    found = [{"kind": one.kind, "sensor": one.sensor, "column": one.column, "lines": [one.first, one.last], "readings": one.count, "value": one.value, "expected": one.expected, "used": one.used} for one in readings.findings]
    data = {"quoin": quoin_tools.__version__, "file": readings.plan.file, "findings": found, "sensors": said}
    written.append(os.path.join(folder, "readings.json"))
    write_file(written[-1], json.dumps(data, indent=1, allow_nan=False) + "\n")
    written.append(os.path.join(folder, "readings.html"))
    write_file(written[-1], page(readings, said, pictures))
    return written, said


def csv_of(readings, answer):
    """A row for each reading of a sensor, units in the head; of readings that are not used the fit is empty."""
    sensor, name = readings.sensors[answer.name], answer.name
    found = readings_pictures.banded(readings, answer).drop(columns=["reading", "constant"])
    unit, difference = sensor.unit_of(), sensor.unit_of(True)
    whole = readings.data.loc[readings.data[name].notna(), [name]].apply(sensor.shown)
    data = whole.assign(line=readings.lines, used=np.where(readings.used[name].loc[whole.index], "yes", "no"))[["line", name, "used"]].join(found).join(statistics.influence(answer))
    data.columns = ["line", f"{name} [{unit}]", "used", *(f"{column.replace('%', ' %')} [{unit if column == 'fit' else difference}]" for column in found), "Cook's distance [-]", "leverage [-]"]
    text = io.StringIO()
    data.to_csv(text, float_format="%.9g", lineterminator="\n")
    return text.getvalue()


# ---- the page --------------------------------------------------------------------------------------------------

def page(readings, said, pictures):
    with open(STYLE, encoding="utf-8") as file:
        style = file.read()
    title = f"Readings: {readings.file}"
    body = head(title, 1) + soft(f"Quoin {quoin_tools.__version__}. Numbers stand in the unit of the table, displacements positive along their direction.")
    body += findings_part(readings) + head("Drift and the held-out year") + table(HEADER, rows(said), range(1, len(HEADER)))
    body += small("Drift: what time alone has changed from the first to the last reading, with water and season taken away; (none): the interval holds 0. "
                  "Explained: share of the variance of the readings that the fit to all takes (R2). Scatter: deviation of a reading from the fit. Held out: the last twelve months, or the year of statistics.held_out, which the fit has not seen; its band should hold 95 %.")  # fmt: skip
    for name, one in said.items():
        body += sensor_part(name, one, pictures[name])
    return f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{esc(title)}</title><meta name="viewport" content="width=device-width"><style>{style}</style></head><body>{body}</body></html>\n'


def findings_part(readings):
    found = [(one.kind, one.column, f"{one.first}" if one.first == one.last else f"{one.first} to {one.last}", one.count, one.value, one.expected, "yes" if one.used else "no") for one in readings.findings]
    more = small(f"{len(found) - MOST} more are in readings.json.") if len(found) > MOST else ""
    return head("Findings") + (table(("finding", "column", "lines", "readings", "value", "expected", "used"), found[:MOST], (3,)) + more if found else soft("Nothing odd was found in the table."))


def sensor_part(name, one, pictures):
    unit = one["unit of differences"]
    text = f"{one['fit']}. {one['readings']} readings from {one['from']} to {one['to']}, which tell as much as {one['independent_readings']:.0f} independent ones"
    text += f" ({one['lasting_share']:.0%} of the variance of the noise lasts, with a correlation of {one['correlation']:g} from one reading to the next)." if one["lasting_share"] > 0 else "."
    out = ", ".join(f"{count} {reason}" for reason, count in one["left_out"].items())
    body = head(name) + f"<p>{esc(text)}</p>" + notes(one["notes"]) + (soft(f"Left out: {out}.") if out else "")
    body += "".join(file_picture(path, readings_pictures.CAPTIONS[kind]) for kind, path in pictures.items())
    scores = [(score["fit"], f"{score['rmse']:.4g}") for score in sorted(one["cross_validation"], key=lambda score: score["rmse"])[:FORMS]]
    body += head("Cross-validation by years", 3) + table(("fit", f"RMSE of years left out [{unit}]"), scores, (1,)) if scores else ""
    top = [(row["line"], row["date"][:10], f"{row['reading']:.5g}", f"{row['cook']:.3g}", f"{row['leverage']:.3g}") for row in one["influence"]]
    return body + head("Readings with most influence on the fit", 3) + table(("line", "date", f"reading [{one['unit']}]", "Cook's distance [-]", "leverage [-]"), top, (0, 2, 3, 4))
