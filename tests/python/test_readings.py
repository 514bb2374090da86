"""Readings of a dam: tables read and looked over, refusals; water, season and time from data whose parameters are known."""

import datetime
from collections import Counter

import numpy as np
import openpyxl
import pandas as pd
import pytest
import yaml
from quoin_tools.mesh import blockmesh
from quoin_tools.readings import sensors, table
from quoin_tools.readings.sensors import ReadingsError

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
    assert found.say("pendulum.crest", -1e-3) == "-1 mm" and found.say("level", 20.0) == "20 m"
    assert found.lines.tolist() == [2, 3, 4] and not found.findings


@pytest.mark.parametrize(("quantity", "unit", "more", "written", "si"), [
    ("level", "ft above sea", {"datum": 100.0}, 400.0, 400 * 0.3048 - 100), ("level", "cm", {}, 250.0, 2.5), ("air temperature", "degF", {}, 212.0, 100.0),
    ("air temperature", "K", {}, 273.15, 0.0), ("displacement", "in", {}, 1.0, 0.0254), ("pressure", "bar", {}, 2.0, 2e5), ("joint opening", "um", {"sign": -1}, 5.0, -5e-6),
    ("discharge", "l/min", {}, 60.0, 1e-3), ("discharge", "l/s", {"width": 10.0}, 1.0, 1e-4), ("piezometric head", "m above sea", {"datum": 10.0}, 12.0, 2.0),
])  # fmt: skip
def test_units_there_and_back(quantity, unit, more, written, si):
    sensor = sensors.sensor_of("x", "x", {"quantity": quantity, "unit": unit, **more})
    assert sensor.si(written) == pytest.approx(si, abs=1e-12)
    assert sensor.shown(si) == pytest.approx(abs(sensor.scale[0]) ** -1 * (si if "datum" in more else si - sensor.scale[1]), abs=1e-9)


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


def test_decimal_commas_and_times_with_a_zone(tmp_path):
    text = "date;level;air;crest\n2020-03-28T12:00+01:00;470,5;5;1,0\n2020-03-30T12:00+02:00;471;6;1,5\n2020-03-31T12:00+02:00;472;7;\n"
    found = table.read(put(tmp_path, text, decimal="comma"))
    assert found.data.index.hour.tolist() == [11, 10, 10] and found.data["level"].iloc[0] == 20.5
    assert [one.kind for one in found.findings] == ["time zone"] and found.left_out["pendulum.crest"]["empty"] == 1
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
    "constant column": (SMALL.replace("471", "470").replace("472", "470"), SENSORS, {}, "column level: all 3 readings are 20 m: expected readings that change"),
    "no reading": (SMALL.replace("1.0\n", "\n").replace("1.5\n", "nan\n").replace("1.25\n", "-\n"), SENSORS, {}, "column crest: no reading"),
    "date": (SMALL.replace("2020-01-02", "2020-01-32"), SENSORS, {}, "line 3, column date: '2020-01-32': expected an ISO date"),
    "two formats": (SMALL.replace("2020-01-02", "02/01/2020"), SENSORS, {}, "line 3, column date: '02/01/2020': expected an ISO date"),
    "month first": (SMALL.replace("2020-01-0", "01/13/202"), SENSORS, {"dates": {"column": "date", "format": "day first"}}, "line 2, column date: '01/13/2021': expected a date such as 31/03/2024"),
    "serial": (SMALL, SENSORS, {"dates": {"column": "date", "format": "excel"}}, "line 2, column date: '2020-01-01': expected a serial number"),
    "zone in some lines": (SMALL.replace("2020-01-02", "2020-01-02T10:00Z"), SENSORS, {}, "line 3, column date: '2020-01-02T10:00Z': expected a time zone in all lines or in none"),
    "mixed zones": (SMALL.replace("-01-02", "-01-02T10:00+05:00").replace("-01-01", "-01-01T10:00Z").replace("-01-03", "-01-03T10:00Z"), SENSORS, {}, "line 3, column date: '2020-01-02T10:00+05:00': time zones of +0 h and +5 h are mixed"),
    "decimal comma": (SMALL.replace("1.5", '"1,5"'), SENSORS, {}, "line 3, column crest: '1,5': expected a decimal point, or `decimal: comma`"),
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
