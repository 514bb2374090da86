"""Reads readings.yaml (docs/readings.md): the file of readings, and what each of its columns is.

    plan = read("readings.yaml")
    plan.sensors["pendulum.crest"].si(4.2)      # mm as written -> m, positive along the sensor's direction
"""

import json
import math
import os
from dataclasses import dataclass, field

import numpy as np
import shapely

from quoin_tools.base import scene
from quoin_tools.base.scene import yaml_of
from quoin_tools.mesh import blockmesh

SCHEMA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "readings.schema.json")
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "ft": 0.3048}
SEA = " above sea"  # behind a unit of length: an elevation above the sea, which `datum` turns into that of the mesh
ELEVATIONS = LENGTHS | {unit + SEA: factor for unit, factor in LENGTHS.items()}
QUANTITIES = {  # quantity: (unit in SI, {unit as written: factor}); of a temperature the pair (factor, offset)
    "level": ("m", ELEVATIONS),
    "air temperature": ("degC", {"degC": 1.0, "degF": (5 / 9, -160 / 9), "K": (1.0, -273.15)}),
    "displacement": ("m", LENGTHS),
    "pressure": ("Pa", {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "bar": 1e5, "psi": 6894.757293168}),
    "piezometric head": ("m", ELEVATIONS),
    "discharge": ("m3/s", {"m3/s": 1.0, "l/s": 1e-3, "l/min": 1e-3 / 60, "m3/h": 1 / 3600, "m3/d": 1 / 86400, "ml/min": 1e-6 / 60}),
    "joint opening": ("m", LENGTHS),
}
DRIVERS = ("level", "air temperature")  # what the others depend on
PLACES = {"displacement": ("point", "direction"), "joint opening": ("joint", "position")}  # the keys that say where; without a mesh none is required
NEAR = 1e-3  # [m] a point may lie so far outside the mesh


class ReadingsError(ValueError):
    """A file of readings, or what describes it, is wrong; the message is one line."""


@dataclass(frozen=True)
class Sensor:
    """An instrument: a column of the table. accuracy: standard deviation in SI, None where not given; expected: lowest and highest reading, in the unit as
    written; datum [m]: elevation above the sea of y = 0 of the mesh; width [m] of the dam whose water a discharge is; steps: lines from which on
    the instrument reads otherwise."""

    name: str
    column: str
    quantity: str
    unit: str
    datum: float = 0.0
    point: tuple | None = None
    direction: tuple | None = None
    joint: str = ""
    position: float | None = None
    drain: str = ""
    width: float | None = None
    sign: int = 1
    accuracy: float | None = None
    expected: tuple | None = None
    steps: tuple = ()

    @property
    def scale(self):
        """Returns (factor, offset): SI is factor times the reading plus offset, before the sign. A sign turns displacements and openings, not levels."""
        factor = QUANTITIES[self.quantity][1][self.unit]
        factor, offset = factor if isinstance(factor, tuple) else (factor, 0.0)
        return factor * self.sign / (self.width or 1.0), offset - self.datum

    @property
    def unit_si(self):
        return "m2/s" if self.width else QUANTITIES[self.quantity][0]

    def si(self, value):
        """Converts readings as written into SI, positive along the direction."""
        factor, offset = self.scale
        return factor * np.asarray(value, dtype=float) + offset

    def written(self, value, difference=False):
        """Converts SI into numbers as the table has them; difference: of two readings, as a change of temperature is."""
        factor, offset = self.scale
        return (np.asarray(value, dtype=float) - (0.0 if difference else offset)) / factor

    def shown(self, value, difference=False):
        """Converts SI into the unit of the table, positive along the direction: for pictures and results."""
        return self.sign * self.written(value, difference)

    def unit_of(self, difference=False):
        """Returns the unit of numbers as written, or of differences."""
        return self.unit.removesuffix(SEA) if difference else self.unit

    @property
    def drives(self):
        return self.quantity in DRIVERS


@dataclass
class Plan:
    """What readings.yaml says. findings: the kinds of findings that exclude a reading; exclude: {sensor: [(first line, last line)]};
    heights: lowest and highest point [m] of the mesh, where one is named."""

    path: str
    file: str
    sheet: str
    header: int
    separator: str
    decimal: str
    date_column: str
    date_format: str
    ignore: list
    findings: tuple
    exclude: dict
    statistics: dict
    sensors: dict = field(default_factory=dict)
    heights: tuple | None = None

    def one(self, quantity):
        """Returns the name of the sensor of a driving quantity, or None."""
        return next((name for name, sensor in self.sensors.items() if sensor.quantity == quantity), None)


def read(path):
    """Reads and checks readings.yaml; ReadingsError names the file, the key and what was expected."""
    import jsonschema

    if os.path.splitext(path)[1].lower() in (".csv", ".txt", ".xlsx", ".xlsm"):
        raise ReadingsError(f"{path}: a table: expected a file such as readings.yaml that names it and says what its columns are (quoin help readings)")
    data = yaml_of(path, ReadingsError)
    with open(SCHEMA, encoding="utf-8") as file:
        wrong = jsonschema.exceptions.best_match(jsonschema.Draft7Validator(json.load(file)).iter_errors(data))
    if wrong:
        raise ReadingsError(f"{path}: {'.'.join(map(str, wrong.absolute_path)) or 'the file'}: {' '.join(wrong.message.split())}")
    folder = os.path.dirname(os.path.abspath(path))
    sensors = {name: sensor_of(f"{path}: sensors.{name}", name, keys) for name, keys in data["sensors"].items()}
    for quantity in DRIVERS:
        found = [name for name, sensor in sensors.items() if sensor.quantity == quantity]
        if len(found) > 1:
            raise ReadingsError(f"{path}: sensors.{found[1]}: quantity {quantity}, as {found[0]}: expected one sensor of it")
    columns = [sensor.column for sensor in sensors.values()]
    twice = next((column for column in columns if columns.count(column) > 1), None)
    if twice:
        raise ReadingsError(f"{path}: sensors: column '{twice}' belongs to two sensors: expected one")
    exclude = {}
    for k, row in enumerate(data.get("exclude", [])):
        if row["sensor"] not in sensors or row["lines"][0] > row["lines"][1]:
            raise ReadingsError(f"{path}: exclude.{k}: {row['sensor']}, lines {row['lines']}: expected a sensor of the file, and the first line before the last")
        exclude.setdefault(row["sensor"], []).append(tuple(row["lines"]))
    told = data.get("findings", "tell")
    findings = {"tell": (), "exclude": ("unit", "outlier", "stuck")}[told] if isinstance(told, str) else tuple(told)
    dates = data["dates"]
    plan = Plan(os.fspath(path), os.path.join(folder, data["file"]), data.get("sheet", ""), data.get("header", 1), data.get("separator", ""), data.get("decimal", "point"),
                dates["column"], dates.get("format", "iso"), data.get("ignore", []), findings, exclude, data.get("statistics", {}), sensors)  # fmt: skip
    check_places(plan, data, folder)
    return plan


def sensor_of(where, name, keys):
    """Returns the sensor of the keys under its name; refuses a unit of another quantity, a datum without need, a place that does not fit."""
    units = QUANTITIES[keys["quantity"]][1]
    if keys["unit"] not in units:
        raise ReadingsError(f"{where}.unit: '{keys['unit']}': expected a unit of {keys['quantity']}: {', '.join(units)}")
    if keys["unit"].endswith(SEA) != ("datum" in keys):
        raise ReadingsError(f"{where}.datum: expected with a unit that ends in '{SEA.strip()}', and only there: the elevation above the sea [m] of y = 0 of the mesh")
    for key, quantity in (("direction", "displacement"), ("drain", "discharge"), ("width", "discharge")):
        if key in keys and keys["quantity"] != quantity:
            raise ReadingsError(f"{where}.{key}: a {keys['quantity']} has none; expected with quantity {quantity}")
    if keys.get("sign", 1) < 0 and keys["quantity"] not in PLACES:
        raise ReadingsError(f"{where}.sign: -1: expected with a displacement or a joint opening")
    if "steps" in keys and keys["quantity"] in DRIVERS:
        raise ReadingsError(f"{where}.steps: a {keys['quantity']} has none; expected with an instrument whose readings are fitted")
    for key, value in keys.items():
        if any(isinstance(number, float) and not math.isfinite(number) for number in (value if isinstance(value, list) else [value])):
            raise ReadingsError(f"{where}.{key}: {value}: expected finite numbers")
    given = {key: tuple(value) if isinstance(value, list) else value for key, value in keys.items()}
    if "direction" in given:
        length = math.hypot(*given["direction"])
        if length == 0:
            raise ReadingsError(f"{where}.direction: [0, 0]: expected a vector along which the reading is positive")
        given["direction"] = tuple(one / length for one in given["direction"])
    if "expected" in given and given["expected"][0] >= given["expected"][1]:
        raise ReadingsError(f"{where}.expected: {list(given['expected'])}: expected the lowest reading before the highest")
    sensor = Sensor(name, given.pop("column", name), **given)
    return sensor if sensor.accuracy is None else Sensor(**{**sensor.__dict__, "accuracy": abs(sensor.scale[0]) * sensor.accuracy})


# ---- places in the mesh ----------------------------------------------------------------------------------------

def check_places(plan, data, folder):
    """Refuses points that are not in the mesh, joints and drains that it or the scene does not have, where the file names a model or a scene."""
    wanted = scene.read(os.path.join(folder, data["scene"])) if "scene" in data else None
    named = data.get("model") or (wanted and wanted.model)
    path = scene.find(folder, named) if named else None
    if named and path is None:
        raise ReadingsError(f"{plan.path}: model: no file {named} here: expected the block mesh")
    mesh = blockmesh.read(path) if path else None
    plan.heights = (float(mesh.vertices[:, 1].min()), float(mesh.vertices[:, 1].max())) if mesh else None
    rings = shapely.union_all(shapely.polygons(mesh.vertices[blockmesh.closed_rings(mesh)])) if mesh else None
    for name, sensor in plan.sensors.items():
        where = f"{plan.path}: sensors.{name}"
        if wanted and sensor.drain:
            drains = [load for load, keys in wanted.loads.items() if keys.get("type") == "drain"]
            if sensor.drain not in drains:
                raise ReadingsError(f"{where}.drain: '{sensor.drain}': expected a load of type drain of {wanted.path}: {', '.join(drains) or 'it has none'}")
        if mesh is None:
            continue
        missing = [key for key in PLACES.get(sensor.quantity, ()) if getattr(sensor, key) in (None, "")]
        if missing and not (sensor.quantity == "joint opening" and sensor.joint and sensor.point):
            raise ReadingsError(f"{where}.{missing[0]}: missing: expected with a {sensor.quantity}, as the file names a mesh")
        if sensor.point and rings.distance(shapely.Point(sensor.point)) > NEAR:
            raise ReadingsError(f"{where}.point: [{sensor.point[0]:g}, {sensor.point[1]:g}] is {rings.distance(shapely.Point(sensor.point)):.3g} m outside {path}: expected a point of the mesh")
        if sensor.joint:
            check_joint(where, sensor, mesh, path)


def check_joint(where, sensor, mesh, path):
    if sensor.joint not in mesh.face_sets:
        raise ReadingsError(f"{where}.joint: '{sensor.joint}': expected a face set of {path}: {', '.join(mesh.face_sets) or 'it has none'}")
    ends = mesh.vertices[blockmesh.face_ends(mesh, mesh.face_sets[sensor.joint])]
    length = shapely.union_all(shapely.linestrings(ends), grid_size=1e-6).length
    if sensor.position is not None and sensor.position > length + NEAR:
        raise ReadingsError(f"{where}.position: {sensor.position:g} m: expected 0 to {length:.4g} m, the length of joint {sensor.joint}")


