"""Readings of a dam: tables read and looked over, refusals; water, season and time from data whose parameters are known."""

import dataclasses
import datetime
import json
from collections import Counter

import numpy as np
import openpyxl
import pandas as pd
import pytest
import yaml
from quoin_tools.front import main
from quoin_tools.mesh import blockmesh
from quoin_tools.readings import correlation, sensors, table
from quoin_tools.readings import statistics as analysis
from quoin_tools.readings.sensors import ReadingsError
from quoin_tools.show import readings_part

DATUM, YEAR = 450.0, 365.25
WATER, SEASON, TREND = 6.0, 2.0, 0.1  # [mm] at the highest level, [mm], [mm/year]
SENSORS = {
    "level": {"quantity": "level", "unit": "m above sea", "datum": DATUM},
    "air": {"quantity": "air temperature", "unit": "degC"},
    "pendulum.crest": {"column": "crest", "quantity": "displacement", "unit": "mm", "point": [2, 33], "direction": [2, 0], "accuracy": 0.1},
}


def noise(random, n, correlation):
    """Normal numbers of deviation 1 that are correlated from one to the next."""
    found = random.standard_normal(n)
    for k in range(1, n):
        found[k] = correlation * found[k - 1] + np.sqrt(1 - correlation**2) * found[k]
    return found


def made(seed=1, n=1461, every=2, correlation=0.0, deviation=0.3, trend=TREND):
    """Dates, level [m], air [degC], and the crest [mm] whose parts are known."""
    random = np.random.default_rng(seed)
    t = np.arange(n) * every / YEAR
    level = 28 + 3 * np.cos(2 * np.pi * (t - 0.2)) + 1.5 * noise(random, n, 0.97**every)
    level = np.clip(level, 20.0, 33.0)
    air = 12 - 8 * np.cos(2 * np.pi * t) + 2.5 * noise(random, n, 0.7**every)
    crest = WATER * ((level - 20) / 13) ** 3 + SEASON * np.cos(2 * np.pi * t - 1) + trend * t + deviation * noise(random, n, correlation)
    return pd.DataFrame({"date": pd.date_range("2010-01-01", periods=n, freq=f"{every}D"), "level": level.round(2) + DATUM, "air": air.round(1), "crest": crest.round(3)})


def text_of(frame):
    return frame.assign(date=frame["date"].dt.strftime("%Y-%m-%d")).astype(object)


def put(folder, frame, sensors=SENSORS, name="readings.csv", **keys):
    """Writes readings.yaml and its table; returns the path."""
    folder.mkdir(parents=True, exist_ok=True)
    if isinstance(frame, str):
        (folder / name).write_text(frame, encoding="utf-8")
    else:
        frame.to_csv(folder / name, index=False)
    data = {"file": name, "dates": {"column": "date"}, "sensors": sensors} | keys
    (folder / "readings.yaml").write_text(yaml.safe_dump(data), encoding="utf-8")
    return str(folder / "readings.yaml")


SMALL = "date,level,air,crest\n2020-01-01,470,5,1.0\n2020-01-02,471,6,1.5\n2020-01-03,472,7,1.25\n"


# ---- the table -------------------------------------------------------------------------------------------------

def test_si(tmp_path):
    found = table.read(put(tmp_path, SMALL, SENSORS | {"pendulum.crest": SENSORS["pendulum.crest"] | {"sign": -1}}))
    assert found.data["level"].tolist() == [20, 21, 22] and found.data["air"].tolist() == [5, 6, 7]
    assert np.allclose(found.data["pendulum.crest"], [-1e-3, -1.5e-3, -1.25e-3], rtol=1e-15)
    assert found.sensors["pendulum.crest"].direction == (1, 0) and found.sensors["pendulum.crest"].accuracy == pytest.approx(1e-4)
    assert found.say("pendulum.crest", -1e-3) == "1 mm" and found.say("level", 20.0) == "470 m above sea"
    assert found.say("level", 20.0, difference=True) == "20 m" and found.sensors["pendulum.crest"].shown(-1e-3) == -1
    assert found.lines.tolist() == [2, 3, 4] and not found.findings


@pytest.mark.parametrize(("quantity", "unit", "more", "written", "si"), [
    ("level", "ft above sea", {"datum": 100.0}, 400.0, 400 * 0.3048 - 100), ("level", "cm", {}, 250.0, 2.5), ("air temperature", "degF", {}, 212.0, 100.0),
    ("air temperature", "K", {}, 273.15, 0.0), ("displacement", "in", {}, 1.0, 0.0254), ("pressure", "bar", {}, 2.0, 2e5), ("joint opening", "um", {"sign": -1}, 5.0, -5e-6),
    ("discharge", "l/min", {}, 60.0, 1e-3), ("discharge", "l/s", {"width": 10.0}, 1.0, 1e-4), ("piezometric head", "m above sea", {"datum": 10.0}, 12.0, 2.0),
])  # fmt: skip
def test_units_there_and_back(quantity, unit, more, written, si):
    sensor = sensors.sensor_of("x", "x", {"quantity": quantity, "unit": unit, **more})
    assert sensor.si(written) == pytest.approx(si, abs=1e-12)
    assert sensor.written(si) == pytest.approx(written, abs=1e-9) and sensor.shown(si) == pytest.approx(sensor.sign * written, abs=1e-9)


def test_dates_of_all_formats_agree(tmp_path):
    frame, n = made(n=200), 200
    want = table.read(put(tmp_path / "iso", text_of(frame))).data
    day_first = text_of(frame).assign(date=frame["date"].dt.strftime("%d/%m/%Y"))
    serial = text_of(frame).assign(date=(frame["date"] - pd.Timestamp("1899-12-30")).dt.days)
    for name, other in (("day first", day_first), ("excel", serial)):
        pd.testing.assert_frame_equal(table.read(put(tmp_path / name, other, dates={"column": "date", "format": name})).data, want)
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "data"
    sheet.append(["from the archive"])
    sheet.append(list(frame.columns))
    for row in frame.itertuples(index=False):
        sheet.append([row[0].to_pydatetime(), *row[1:]])
    path = put(tmp_path / "sheet", "", name="readings.xlsx", sheet="data", header=2)
    book.save(tmp_path / "sheet/readings.xlsx")
    found = table.read(path)
    pd.testing.assert_frame_equal(found.data, want)
    assert found.lines.tolist() == list(range(3, n + 3))


def test_dates_of_a_sheet(tmp_path):
    """Serial dates count from the sheet's own day 0; dates of which a program took some for its own, day and month swapped, are told."""
    frame, epoch = made(n=60), openpyxl.utils.datetime.CALENDAR_MAC_1904
    want = table.read(put(tmp_path / "iso", text_of(frame))).data
    serials = [(date - pd.Timestamp(epoch)).days for date in frame["date"]]
    mixed = [f"{date:%d/%m/%Y}" if date.day > 12 else date.to_pydatetime() for date in frame["date"]]
    for name, dates, kind in (("serials", serials, "excel"), ("mixed", mixed, "day first")):
        book = openpyxl.Workbook()
        book.epoch = epoch
        book.active.append(list(frame.columns))
        for date, row in zip(dates, frame.itertuples(index=False), strict=True):
            book.active.append([date, *row[1:]])
        path = put(tmp_path / name, "", name="readings.xlsx", dates={"column": "date", "format": kind})
        book.save(tmp_path / name / "readings.xlsx")
        found = table.read(path)
        pd.testing.assert_frame_equal(found.data, want)
        assert [one.kind for one in found.findings] == (["date"] if name == "mixed" else [])
    assert found.findings[0].value == f"{sum(isinstance(one, str) for one in mixed)} dates are texts, {sum(not isinstance(one, str) for one in mixed)} are dates of the sheet"


def test_decimal_commas_and_times_with_a_zone(tmp_path):
    text = "date;level;air;crest\n2020-03-28T12:00+01:00;470,5;−5;1,0\n2020-03-30T12:00+02:00;471;−6;1,5\n2020-03-31T12:00+02:00;472;−7;\n"
    found = table.read(put(tmp_path, text, decimal="comma"))
    assert found.data.index.hour.tolist() == [11, 10, 10] and found.data["level"].iloc[0] == 20.5
    assert [one.kind for one in found.findings] == ["time zone"] and found.left_out["pendulum.crest"]["empty"] == 1 and found.data["air"].iloc[2] == -7  # the sign of typesetters
    assert found.series("pendulum.crest").notna().all() and len(found.series("pendulum.crest")) == 2


def test_all_that_is_odd_is_told_with_its_line(tmp_path):
    frame = text_of(made())
    frame.loc[100, "crest"] = 12.0  # an outlier
    frame.loc[210:240, "crest"] /= 10.0  # a month in cm
    frame.loc[400, "crest"] *= 1000  # in um
    frame.loc[500, "level"] -= DATUM
    frame.loc[550, "level"] *= 100
    frame.loc[600:620, "air"] = frame.loc[600:620, "air"] * 1.8 + 32
    frame.loc[900:, "crest"] += 1.2  # the instrument has jumped
    frame.loc[700, "crest"] = "n/a"
    frame.loc[750:800, "crest"] = ""
    frame.loc[850, "date"] = frame.loc[849, "date"]
    path = put(tmp_path, frame)
    found = table.read(path)
    told = {(one.kind, one.column, one.first, one.last) for one in found.findings}
    assert {("outlier", "crest", 102, 102), ("no number", "crest", 702, 702), ("gap", "crest", 751, 803), ("doubled date", "level", 851, 852)} <= told
    units = {(one.column, one.first): one.expected.rpartition(" in ")[2].partition(",")[0] for one in found.findings if one.kind == "unit"}
    assert units[("crest", 402)] == "um" and units[("level", 502)] == "m" and units[("level", 552)] == "cm above sea" and units[("air", 602)] == "degF"
    month = [one for one in found.findings if one.kind == "unit" and one.expected.endswith(" cm")]
    assert month and all(212 <= one.first <= one.last <= 242 for one in month) and sum(one.count for one in month) > 25
    jump = [one for one in found.findings if one.kind == "jump"]
    assert len(jump) == 1 and abs(jump[0].first - 902) <= 2 and 0.9 < float(jump[0].value.split()[-3]) < 1.5
    assert not found.data.loc[found.used.all(axis=1)].isna().any(axis=None)
    assert found.left_out["pendulum.crest"] == Counter({"empty": 51, "no number": 1, "doubled date": 2})
    assert len(found.series("pendulum.crest")) == 1461 - 54  # told, not dropped
    without = table.read(put(tmp_path, frame, findings="exclude", exclude=[{"sensor": "level", "lines": [2, 11]}]))
    out = without.left_out["pendulum.crest"]
    assert out["unit"] > 25 and out["outlier"] >= 1 and len(without.series("pendulum.crest")) == 1461 - sum(out.values())
    assert without.left_out["level"]["by the user"] == 10 and all(not one.used for one in without.findings if one.kind in ("unit", "outlier", "excluded"))


@pytest.mark.parametrize("correlation", [0.0, 0.8])
def test_no_false_alarms(tmp_path, correlation):
    """Clean readings are not odd, with correlated noise either: of 10 series one finding at most."""
    assert sum(len(table.read(put(tmp_path, text_of(made(seed, 731, 4, correlation)))).findings) for seed in range(10)) <= 1


@pytest.mark.parametrize(("name", "wrong", "kind", "words"), [
    ("feet", lambda level: level / 0.3048, "unit", "likely written in ft above sea"), ("cm", lambda level: level * 100, "unit", "likely written in cm above sea"),
    ("gauge", lambda level: level + 12, "jump", "another `datum`"),
])  # fmt: skip
def test_many_levels_that_are_wrong(tmp_path, name, wrong, kind, words):
    """A fifth of the levels, from a line on, written otherwise: told once, from the first line to the last."""
    frame = text_of(made(2, 731, 4))
    frame.loc[580:, "level"] = wrong(frame.loc[580:, "level"])
    found = [one for one in table.read(put(tmp_path, frame)).findings if one.sensor == "level"]
    assert [(one.kind, one.first, one.last) for one in found] == [(kind, 582, 732 if kind == "unit" else 582)] and words in found[0].expected


def test_stuck_instruments_are_told(tmp_path):
    """One that reads the same for months is told, and its other readings are no outliers; a drain that is dry and a reservoir that is full are not."""
    frame = text_of(made(3, 731, 4))
    frame.loc[300:520, "crest"] = frame.loc[300, "crest"]
    frame.loc[600:640, "level"] = frame.loc[600, "level"]
    found = table.read(put(tmp_path, frame, findings="exclude"))
    still = [(one.sensor, one.first, one.last, one.used) for one in found.findings if one.kind == "stuck"]
    assert still == [("pendulum.crest", 303, 522, False), ("level", 603, 642, False)] and len(found.findings) <= 3
    assert found.left_out["pendulum.crest"]["stuck"] == 220 and found.left_out["level"] == Counter({"stuck": 40, "empty": 0, "no number": 0})
    dry = text_of(made(3, 731, 4, deviation=0.05))
    full, dry["crest"] = dry["level"].clip(upper=DATUM + 29), dry["crest"].clip(lower=2.0)
    assert (dry["crest"] == 2.0).mean() > 0.3 and (full == DATUM + 29).mean() > 0.3
    assert not table.read(put(tmp_path, dry)).findings
    assert not [one for one in table.read(put(tmp_path, dry.assign(level=full))).findings if one.sensor == "level"]


def test_whole_column_in_a_wrong_unit(tmp_path):
    frame = text_of(made(n=300))
    frame["level"] = frame["level"] * 100
    frame["air"] = frame["air"] * 1.8 + 32
    keys = {"level": SENSORS["level"] | {"expected": [465, 485]}, "air": SENSORS["air"] | {"expected": [-20, 40]}}
    found = table.read(put(tmp_path, frame, SENSORS | keys))
    units = {one.column: one for one in found.findings if one.kind == "unit" and one.count > 200}
    assert "cm above sea" in units["level"].expected and units["air"].expected.endswith("degF")


def square(folder):
    """A mesh of one block of 4 by 33 m on a rock, with the face set base."""
    vertices = np.array([[0, 0], [4, 0], [4, 33], [0, 33], [-4, -4], [8, -4], [8, 0], [-4, 0]], dtype=float)
    mesh = blockmesh.BlockMesh(vertices, [[0, 1, 2, 3], [4, 5, 6, 7]], [0, 1], ["dam", "rock"], [0, 0], {"base": [[0, 0]]}, {})
    blockmesh.write(folder / "model.h5", mesh)


def crest(**keys):
    return SENSORS | {"pendulum.crest": {key: value for key, value in (SENSORS["pendulum.crest"] | keys).items() if value is not None}}


REFUSED = {  # name: (text of the table, sensors, other keys, words of the message)
    "column of no sensor": (SMALL.replace("crest\n", "crest,toe\n", 1), SENSORS, {}, "line 1: column 'toe': expected a sensor"),
    "sensor of no column": (SMALL, crest(column="toe"), {}, "line 1: no column 'toe' for sensors.pendulum.crest"),
    "no dates": (SMALL, SENSORS, {"dates": {"column": "day"}}, "line 1: no column 'day'"),
    "column twice": (SMALL.replace("air", "level"), SENSORS, {}, "column 'level' stands there twice"),
    "constant column": (SMALL.replace("471", "470").replace("472", "470"), SENSORS, {}, "column level: all 3 readings are 470 m above sea: expected readings that change"),
    "no reading": (SMALL.replace("1.0\n", "\n").replace("1.5\n", "nan\n").replace("1.25\n", "1e308\n"), SENSORS, {}, "column crest: no reading"),
    "date": (SMALL.replace("2020-01-02", "2020-01-32"), SENSORS, {}, "line 3, column date: '2020-01-32': expected an ISO date"),
    "two formats": (SMALL.replace("2020-01-02", "02/01/2020"), SENSORS, {}, "line 3, column date: '02/01/2020': expected an ISO date"),
    "month first": (SMALL.replace("2020-01-0", "01/13/202"), SENSORS, {"dates": {"column": "date", "format": "day first"}}, "line 2, column date: '01/13/2021': expected a date such as 31/03/2024"),
    "serial": (SMALL, SENSORS, {"dates": {"column": "date", "format": "excel"}}, "line 2, column date: '2020-01-01': expected a serial number"),
    "zone in some lines": (SMALL.replace("2020-01-02", "2020-01-02T10:00Z"), SENSORS, {}, "line 3, column date: '2020-01-02T10:00Z': expected a time zone in all lines or in none"),
    "mixed zones": (SMALL.replace("-01-02", "-01-02T10:00+05:00").replace("-01-01", "-01-01T10:00Z").replace("-01-03", "-01-03T10:00Z"), SENSORS, {}, "line 3, column date: '2020-01-02T10:00+05:00': time zones of +0 h and +5 h are mixed"),
    "decimal comma": (SMALL.replace("1.5", '"1,5"'), SENSORS, {}, "line 3, column crest: '1,5': expected a decimal point, or `decimal: comma`"),
    "thousands with a point": ("date;level;air;crest\n2020-01-01;470,5;5;1.780\n", SENSORS, {"decimal": "comma"}, "line 2, column crest: '1.780': expected a decimal comma"),
    "thousands with a comma": (SMALL.replace("1.0", '"1,780.0"').replace("1.5", '"1,200.5"'), SENSORS, {}, "line 2, column crest: '1,780.0', and 1 more such cells: expected numbers"),
    "future": (SMALL.replace("2020-01-02", "2220-01-02"), SENSORS, {}, "line 3, column date: '2220-01-02' is 2220-01-02: expected a date from 1800 to today"),
    "long ago": (SMALL.replace("2020-01-02", "0202-01-02"), SENSORS, {}, "line 3, column date: '0202-01-02' is"),
    "steps of a level": (SMALL, SENSORS | {"level": SENSORS["level"] | {"steps": [3]}}, {}, "sensors.level.steps: a level has none"),
    "decimal comma without quotes": (SMALL.replace("1.5", "1,5"), SENSORS, {}, "line 3: '5' stands behind the last of 4 columns"),
    "empty": ("", SENSORS, {}, "line 1: empty"),
    "head alone": ("date,level,air,crest\n", SENSORS, {}, "no readings below line 1"),
    "negative accuracy": (SMALL, crest(accuracy=-0.1), {}, "sensors.pendulum.crest.accuracy: -0.1"),
    "accuracy of 0": (SMALL, crest(accuracy=0), {}, "sensors.pendulum.crest.accuracy: 0"),
    "unit": (SMALL, crest(unit="kPa"), {}, "sensors.pendulum.crest.unit: 'kPa': expected a unit of displacement: m, cm, mm"),
    "datum": (SMALL, SENSORS | {"level": {"quantity": "level", "unit": "m above sea"}}, {}, "sensors.level.datum: expected with a unit"),
    "direction": (SMALL, crest(direction=[0, 0]), {}, "sensors.pendulum.crest.direction: [0, 0]: expected a vector"),
    "nan": (SMALL, crest(direction=[float("nan"), 1]), {}, "sensors.pendulum.crest.direction: [nan, 1]: expected finite numbers"),
    "key": (SMALL, crest(places=3), {}, "sensors.pendulum.crest: Additional properties are not allowed"),
    "two levels": (SMALL, SENSORS | {"air": SENSORS["level"] | {"column": "air"}}, {}, "quantity level, as air: expected one sensor"),
    "line of no reading": (SMALL, SENSORS, {"exclude": [{"sensor": "level", "lines": [30, 40]}]}, "exclude: level, lines 30 to 40: no reading there"),
    "no mesh": (SMALL, SENSORS, {"model": "other.h5"}, "model: no file other.h5"),
    "point outside": (SMALL, crest(point=[2, 40]), {"model": "model.h5"}, "sensors.pendulum.crest.point: [2, 40] is 7 m outside"),
    "no direction": (SMALL, crest(direction=None), {"model": "model.h5"}, "sensors.pendulum.crest.direction: missing"),
    "joint": (SMALL, crest(quantity="joint opening", point=None, direction=None, joint="lift", position=1), {"model": "model.h5"}, "joint: 'lift': expected a face set of"),
    "beyond the joint": (SMALL, crest(quantity="joint opening", point=None, direction=None, joint="base", position=5), {"model": "model.h5"}, "position: 5 m: expected 0 to 4 m"),
    "not UTF-8": (None, SENSORS, {}, "line 2: byte 0xe9: expected a text in UTF-8"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refusals(tmp_path, name):
    text, own, keys, words = REFUSED[name]
    path = put(tmp_path, SMALL if text is None else text, own, **keys)
    if text is None:
        (tmp_path / "readings.csv").write_bytes(SMALL.encode().replace(b"2020-01-01", b"\xe9"))
    if keys.get("model") == "model.h5":
        square(tmp_path)
    with pytest.raises(ReadingsError) as error:
        table.read(path)
    assert words in str(error.value) and "\n" not in str(error.value) and str(tmp_path) in str(error.value)


def test_drains_are_those_of_the_scene(tmp_path):
    (tmp_path / "scene.yaml").write_text("loads: {row: {type: drain, joint: base}, water: {type: reservoir}}\n", encoding="utf-8")
    own = SENSORS | {"pendulum.crest": {"column": "crest", "quantity": "discharge", "unit": "l/min", "drain": "water"}}
    with pytest.raises(ReadingsError, match=r"drain: 'water': expected a load of type drain of .*scene.yaml: row$"):
        table.read(put(tmp_path, SMALL, own, scene="scene.yaml"))
    own["pendulum.crest"]["drain"] = "row"
    assert isinstance(table.read(put(tmp_path, SMALL, own, scene="scene.yaml")).data.index[0], datetime.datetime)


def test_levels_beyond_the_mesh(tmp_path):
    """Where a mesh is named, a datum that is wrong shows."""
    square(tmp_path)
    found = table.read(put(tmp_path, SMALL, SENSORS | {"level": SENSORS["level"] | {"datum": 400.0}}, model="model.h5"))
    assert [(one.kind, one.count) for one in found.findings if one.sensor == "level"] == [("unit", 3)]


# ---- statistics ------------------------------------------------------------------------------------------------

def readings_of(frame, name="pendulum.crest", **statistics):
    """Readings in SI of a table that made() has made, without a file."""
    own = {key: sensors.sensor_of(key, key, dict(keys)) for key, keys in SENSORS.items()}
    plan = sensors.Plan("readings.yaml", "readings.csv", "", 1, "", "point", "date", "iso", [], (), {}, statistics, own)
    data = pd.DataFrame({"level": frame["level"] - DATUM, "air": frame["air"], name: frame["crest"] * 1e-3}).set_index(pd.DatetimeIndex(frame["date"]))
    return table.Readings(plan, data, data.notna(), pd.Series(range(2, len(data) + 2), index=data.index), [], {name: Counter()})


def analysed(frame, **statistics):
    return analysis.analyse(readings_of(frame, **statistics), "pendulum.crest")


def true_parts(level, season_days, t):
    """Water from 27 m to a level, season at a day of the year 2010, trend after t years [mm]."""
    water = WATER * (((level - 20) / 13) ** 3 - (7 / 13) ** 3)
    return water, SEASON * np.cos(2 * np.pi * season_days / YEAR - 1), TREND * t


def test_correlation_against_a_dense_matrix():
    """At uneven days, some of them the same distance apart, none and two coincident."""
    random = np.random.default_rng(4)
    columns, time = random.standard_normal((60, 3)), np.cumsum(np.r_[np.full(20, 30.0), random.exponential(2, 20), 0.0, np.ones(19)])
    apart = np.abs(np.subtract.outer(time, time))
    for tau in (0.0, 3.0, 70.0):
        dense = np.exp(-apart / tau) if tau else np.eye(60)
        assert np.allclose(correlation.times_correlation(columns, np.exp(-np.diff(time) / tau) if tau else np.zeros(59)), dense @ columns)
        q, _ = np.linalg.qr(columns)
        left = (np.eye(60) - q @ q.T) @ dense @ (np.eye(60) - q @ q.T)
        lags = np.array([0, 1, 4, 9])
        sums, inner = correlation.left_behind(q, time, tau, lags)
        assert np.allclose(sums, [np.trace(left, lag) for lag in lags]) and np.allclose(inner, q.T @ dense @ q)


def test_fit_against_least_squares_written_apart():
    """The same numbers by numpy.linalg.lstsq, with plain powers of the level and the calendar's own angle."""
    frame = made(7, 700, 3)
    answer = analysed(frame, method="HST", time="linear")
    days = (frame["date"] - frame["date"][0]).dt.days.to_numpy()
    angle, h = 2 * np.pi * days / YEAR, frame["level"].to_numpy() - DATUM - 25
    matrix = np.column_stack([np.ones(700), h, h**2, h**3, h**4, np.sin(angle), np.cos(angle), np.sin(2 * angle), np.cos(2 * angle), days])
    y = frame["crest"].to_numpy() * 1e-3
    own = np.linalg.lstsq(matrix, y, rcond=None)[0]
    assert np.abs(answer.final.predict(answer.data)[0] - matrix @ own).max() < 1e-12
    assert analysis.drift(answer)[0][0] == pytest.approx(own[-1] * days[-1], rel=1e-9) and analysis.drift(answer)[1][0] == pytest.approx(own[-1] * YEAR, rel=1e-9)
    parts = answer.final.parts(answer.data)
    assert np.allclose(parts["season"], matrix[:, 5:9] @ own[5:9], atol=1e-12) and np.allclose(parts.sum(axis=1), matrix @ own, atol=1e-12)
    assert np.ptp(parts["water"].to_numpy() - matrix[:, 1:5] @ own[1:5]) < 1e-12
    found = analysis.influence(answer)
    worst = int(np.argmax(found["cook"].to_numpy()))
    less = np.linalg.lstsq(np.delete(matrix, worst, 0), np.delete(y, worst), rcond=None)[0]
    variance = np.sum((y - matrix @ own) ** 2) / (700 - 10)
    assert found["cook"].iloc[worst] == pytest.approx(np.sum((matrix @ (own - less)) ** 2) / (10 * variance), rel=1e-6)
    assert found["leverage"].sum() == pytest.approx(10)
    assert analysis.explained(answer) == pytest.approx(1 - np.sum((y - matrix @ own) ** 2) / np.sum((y - y.mean()) ** 2), rel=1e-9)


def test_few_readings_outside_the_band_are_chance():
    said = [readings_part.doubts({"unseen": 0, "readings": n, "inside": {0.95: out}}) for n, out in ((6, 5 / 6), (52, 47 / 52), (52, 40 / 52))]
    assert said[:2] == [[], []] and said[2][0].startswith("77% of the held-out year lies inside the 95 % band")


def by_hand_first(n):
    """Rows of n daily readings of an instrument that is read every fourth week in the first six tenths of the record, and automatically then."""
    return np.r_[0 : n * 6 // 10 : 28, n * 6 // 10 : n]


def shares_covered(seeds, n, every, lasting, rows=slice(None), **statistics):
    """How often the 95 % intervals of drift, water at 31 m and season on the 100th day hold the truth, and the share of the held-out year inside its band."""
    hits, inside = [], []
    for seed in seeds:
        answer = analysed(made(seed, n, every, lasting).iloc[rows], **statistics)
        fit, scale = answer.final, 1e3
        water, season, trend = true_parts(31.0, 100, (n - 1) * every / YEAR)
        reach = fit.times(0.95)
        at_27 = fit.water([31.0]) - fit.water([27.0])
        day = fit.season([pd.Timestamp("2010-01-01") + pd.Timedelta(days=100)])
        end = fit.time([answer.data.index[-1]])
        told = [(fit.part(name, columns), truth) for name, columns, truth in (("water", at_27, water), ("season", day, season), ("time", end, trend))]
        hits.append([abs(value[0] * scale - truth) <= reach * error[0] * scale for (value, error), truth in told])
        inside.append(analysis.judgement(answer)["inside"][0.95])
    return np.mean(hits, axis=0), float(np.mean(inside))


@pytest.mark.parametrize(("n", "every", "lasting"), [(731, 5, 0.0), (731, 5, 0.7)])
def test_intervals_hold_the_truth(n, every, lasting):
    """Of 40 series: 95 % intervals of water, season and time hold the truth at least 34 times each, 107 times together (fewer: once in 300 such tests)."""
    found, inside = shares_covered(range(100, 140), n, every, lasting, method="HST", time="linear")
    assert found.min() >= 34 / 40 and found.mean() >= 107 / 120 and 0.93 < inside < 0.97, (found, inside)


@pytest.mark.long
@pytest.mark.parametrize(("n", "every", "lasting", "rows"), [(1461, 2, 0.0, slice(None)), (1461, 2, 0.8, slice(None)), (240, 14, 0.0, slice(None)), (3650, 1, 0.9, slice(None)), (3650, 1, 0.95, by_hand_first(3650))])
def test_intervals_hold_the_truth_of_two_hundred(n, every, lasting, rows):
    """Of 200 series: between 92 and 98 % of the 95 % intervals, all parts together; each part at least 91 %."""
    found, inside = shares_covered(range(200), n, every, lasting, rows, method="HST", time="linear")
    assert 0.92 <= found.mean() <= 0.98 and found.min() >= 0.91 and 0.94 < inside < 0.96, (found, inside)


@pytest.mark.parametrize("seeds", [range(30), pytest.param(range(300), marks=pytest.mark.long)], ids=["30", "300"])
def test_drift_is_found_and_none_is_no_drift(seeds):
    """With the form of time chosen by cross-validation: a drift of 0.1 mm a year under a noise of 0.3 mm is found; without one, at most every twelfth interval is beside 0."""
    drifts = [analysis.drift(analysed(made(seed, 731, 5, 0.5), method="HST"))[0] for seed in seeds]
    assert all(low > 0 for _, low, _ in drifts)
    without = [analysis.drift(analysed(made(seed, 731, 5, 0.5, trend=0.0), method="HST"))[0] for seed in seeds]
    assert sum(not low <= 0 <= high for _, low, high in without) <= max(4, len(seeds) / 12)


def test_air_temperature_where_it_is_the_cause():
    """Displacements that follow the air by 20 days: HTT is chosen with this delay, and it predicts the held-out year better than HST."""
    frame = made(11, 2200, 1)
    air = pd.Series(frame["air"].to_numpy(), index=frame["date"])
    slow = air.copy()
    for k in range(1, len(air)):
        slow.iloc[k] = slow.iloc[k - 1] + (air.iloc[k] - slow.iloc[k - 1]) * (1 - np.exp(-1 / 20))
    level = frame["level"].to_numpy() - DATUM
    frame["crest"] = WATER * ((level - 20) / 13) ** 3 - 0.4 * slow.to_numpy() + 0.1 * np.random.default_rng(3).standard_normal(2200)
    answer = analysed(frame)
    assert answer.final.choice.method == "HTT" and answer.final.choice.delays == (20,) and answer.left_out["no air temperature before it"] == 80
    warmth = answer.final.coefficients[answer.final.places()["season"]][0]
    assert warmth * 1e3 == pytest.approx(-0.4, abs=0.01)
    frame.loc[1600:, "crest"] += 1.0  # less than a year before the held-out one: a year left out takes all of it away
    stepped = readings_of(frame)
    stepped.plan.sensors["pendulum.crest"] = dataclasses.replace(stepped.plan.sensors["pendulum.crest"], steps=(1602,))
    assert analysis.analyse(stepped, "pendulum.crest").final.choice.delays == (20,)
    frame.loc[1600:, "crest"] -= 1.0
    seasonal = analysed(frame, method="HST")
    assert analysis.judgement(answer)["rmse"] < 0.5 * analysis.judgement(seasonal)["rmse"]


def test_form_of_time():
    """A movement that dies out is told from a line; what the user chooses is taken."""
    frame = made(5, 1461, 2, trend=0.0)
    t = (frame["date"] - frame["date"][0]).dt.days.to_numpy() / YEAR
    frame["crest"] += 3 * (1 - np.exp(-t / 1.0))
    answer = analysed(frame, method="HST")
    assert (answer.final.choice.time, answer.final.choice.tau) == ("exponential", 1.0)
    change, rate = analysis.drift(answer)
    assert change[1] * 1e3 < 3 < change[2] * 1e3 and abs(rate[0]) * 1e3 < 0.01
    assert analysed(frame, method="HST", time="logarithm").final.choice.time == "logarithm"
    assert analysis.drift(analysed(frame, method="HST", time="none")) is None


def test_steps_are_no_drift(tmp_path):
    """An instrument that was reset: told as a jump with its line; with this line under `steps` the drift is what it was, and the step is found."""
    frame = text_of(made(5, 1461, 2, 0.3))
    frame.loc[700:, "crest"] += 2.0
    found = table.read(put(tmp_path, frame))
    line = next(one.first for one in found.findings if one.kind == "jump")
    wrong = analysis.drift(analysis.analyse(found, "pendulum.crest"))[0]
    own = SENSORS | {"pendulum.crest": SENSORS["pendulum.crest"] | {"steps": [702]}}
    stepped = table.read(put(tmp_path, frame, own))
    answer = analysis.analyse(stepped, "pendulum.crest")
    right, step = analysis.drift(answer)[0], answer.final.coefficients[answer.final.places()["steps"]]
    assert abs(line - 702) <= 2 and not [one for one in stepped.findings if one.kind == "jump"] and "1 step" in answer.final.choice.words()
    assert right[1] < TREND * 1460 * 2 / YEAR * 1e-3 < right[2] < wrong[1] and step == pytest.approx(2e-3, abs=0.3e-3)
    for steps, words in (([9000], "steps: 9000: expected a line with readings of the sensor before and behind it"), ([1462], "line 1462: this reading alone settles an unknown of HST"), ([1450], "")):
        own["pendulum.crest"]["steps"] = steps
        if words:
            with pytest.raises(ReadingsError, match=words):
                analysis.analyse(table.read(put(tmp_path, frame, own)), "pendulum.crest")
        else:
            assert "no year is held out: the instrument steps in it" in analysis.analyse(table.read(put(tmp_path, frame, own)), "pendulum.crest").notes


def test_levels_never_seen_are_told():
    frame = made(5, 1461, 2)
    last = frame["date"] > frame["date"].iloc[-1] - pd.Timedelta(days=365)
    frame.loc[~last, "level"] = frame.loc[~last, "level"].clip(upper=DATUM + 29)
    judged = analysis.judgement(analysed(frame, method="HST", time="linear"))
    assert judged["readings"] == last.sum() and judged["unseen"] == (frame.loc[last, "level"] > DATUM + 29).sum() > 0


def test_intervals_of_hardly_more_readings_than_unknowns():
    """11 readings for 10 unknowns: intervals of the drift, here none, hold the truth all the same."""
    data, held = made(1, 11, 130).set_index("date"), []
    for seed in range(150):
        random = np.random.default_rng(seed)
        data["level"], data["reading"] = random.uniform(20, 32, 11), 0.3 * random.standard_normal(11)
        fit = analysis.fitted(analysis.Choice("HST", "linear"), data)
        value, error = (float(one[0]) for one in fit.part("time", np.ones((1, 1))))
        held.append(abs(value) < fit.times(0.95) * error)
    assert np.mean(held) > 0.9


@pytest.mark.parametrize(("frame", "statistics", "words"), [
    (made(1, 10, 30), {}, "column crest: 10 readings with a level: expected more than 10, the unknowns of HST"),
    (made(1, 40, 2), {}, "column crest: its 40 readings span 0.21 years: expected one at least"),
    (made(1, 400, 5).assign(level=lambda frame: frame["level"].round(-1)), {}, "different levels: expected a longer record, more levels, or a smaller statistics.degree"),
    (made(1, 400, 5), {"held_out": 1999}, "statistics.held_out: 1999: expected a year of the record"),
    (made(1, 400, 5), {"held_out": 2012}, "statistics.held_out: 2012: expected the last year of the record, 2015"),
    (made(1, 300, 5), {"method": "HTT"}, "no HTT: air temperatures are more than 3 days apart"),
])  # fmt: skip
def test_what_no_fit_can_be_made_of(frame, statistics, words):
    with pytest.raises(ReadingsError) as error:
        analysed(frame, **statistics)
    assert words in str(error.value) and "\n" not in str(error.value)


# ---- the command -----------------------------------------------------------------------------------------------

def test_command(tmp_path, capsys, monkeypatch):
    """Findings first, then a table with units; page, JSON without NaN, CSV with units, pictures. A refusal is one line, and writes nothing."""
    frame = text_of(made(3, 500, 5, 0.3))
    frame.loc[100, "crest"] = 30.0
    frame.loc[200, "crest"] = ""
    put(tmp_path, frame, findings="exclude")
    monkeypatch.chdir(tmp_path)
    assert main.main(["readings", "readings.yaml", "-o", "out"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("1 finding\n  readings.csv: line 102, column crest: outlier: 30 mm; expected") and "1 not used" in said.out and not said.err
    assert "pendulum.crest: left out: 1 empty, 1 outlier" in said.out and "wrote out/readings.html" in said.out
    data = json.loads((tmp_path / "out/readings.json").read_text(), parse_constant=pytest.fail)
    one = data["sensors"]["pendulum.crest"]
    assert one["unit"] == "mm" and one["readings"] == 498 and one["drift"]["change"]["low"] < TREND * 499 * 5 / YEAR < one["drift"]["change"]["high"]
    assert one["held_out"]["rmse"] == pytest.approx(0.3, rel=0.4) and data["findings"][0]["lines"] == [102, 102]
    rows = pd.read_csv(tmp_path / "out/pendulum.crest.csv")
    assert {"pendulum.crest [mm]", "fit [mm]", "water [mm]", "season [mm]", "time [mm]", "residual [mm]", "band 99 % [mm]", "Cook's distance [-]"} <= set(rows.columns)
    assert (rows["used"] == "no").sum() == 1 and rows.loc[rows["used"] == "no", "line"].tolist() == [102]
    page = (tmp_path / "out/readings.html").read_text()
    assert page.count("<img") == 4 == len(list((tmp_path / "out").glob("*.png"))) and "nan" not in page.split("base64")[0].lower()
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    frame.loc[300, "date"] = "2014-13-01"
    put(tmp_path, frame)
    assert main.main(["readings", "readings.yaml", "-o", "out"]) == 2
    said = capsys.readouterr()
    assert not said.out and said.err.count("\n") == 1 and "line 302, column date: '2014-13-01': expected an ISO date" in said.err
    assert before == {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    frame.loc[300, "date"], frame.loc[150, "level"] = "2014-02-08", 1e14
    put(tmp_path, frame)
    assert main.main(["readings", "readings.yaml", "-o", "out"]) == 2
    said = capsys.readouterr()
    assert "line 152, column level: outlier: 1e+14 m" in said.out and said.err.count("\n") == 1 and "do not tell the 10 unknowns apart" in said.err  # the cause is there
    assert main.main(["readings", "readings.csv"]) == 2 and "readings.csv: a table: expected a file such as readings.yaml" in capsys.readouterr().err
    assert main.main(["readings", "readings.yaml", "-o", "new"]) == 2 and not (tmp_path / "new").exists()
