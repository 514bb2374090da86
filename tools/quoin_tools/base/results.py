"""Reads results of a run (docs/results_format.md): the only Python module that knows the files of an output folder.

quoin show FOLDER    table of stages, probes, joints and extreme stresses

results = Results("out")
results.stages                     # names, in order
stage = results.stage("water")     # .displacement, .s1, .contacts.sigma, .flow.pressure (None: no water flows), ...
results.frames("quake")            # names of the frames of a dynamic stage: results.stage("quake_3").time
results.summary, results.history   # dict of summary.json; dict of the columns of history.csv
"""

from __future__ import annotations

import csv
import os
import sys
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from quoin_tools.base import anchors, face_loads, flow, histories, laws, modes, tables
from quoin_tools.base.command import Parser
from quoin_tools.base.figures import Figure
from quoin_tools.base.files import reading
from quoin_tools.base.integrity import (
    VERSION,
    ResultsError,
    check_further,
    check_history,
    check_results,
    check_stages,
    expecting,
    read_summary,
)
from quoin_tools.base.language import _, ngettext, numeral
from quoin_tools.base.terminal import table

FORMAT = "quoin-results"
OPEN, SLIPPING, CRUSHING = 1, 2, 4  # bits of Contacts.state
VERTEX_FACE = 4  # Contacts.klass: a vertex on a face; end 1 repeats end 0 without force
NO_SHEAR = 1e3  # sliding factors beyond: the joint carries no shear but the residual of the iteration
ENERGIES = ("kinetic", "strain", "joints", "outside", "supports", "friction", "damping", "incoming", "radiated", "detection", "balance")
STAGE_FIELDS = ("displacement", "stress", "s1", "s2", "angle", "gauss_stress", "rotation")
SOME_STAGES = ("safety_factor", "safety_mode", "mechanism", "flow", "loads", "modes", "anchors", "bars", "envelope", "temperature", "stress_z", "built", "plastic_strain", "damage", "crack_width", "lost")  # members that some stages lack: None there
CONTACT_FIELDS = ("face", "joint", "class", "length", "open", "point", "displacement", "normal", "opening", "sliding", "slip", "broken", "sigma", "tau", "force", "state")
PROFILE_FIELDS = ("opening", "sliding", "slip", "broken", "sigma", "tau", "state")  # (n, 2): of both ends


@dataclass
class Mesh:
    """The blocks in the output, as they were at the start; see docs/results_format.md."""

    vertices: np.ndarray
    blocks: np.ndarray
    block_group: np.ndarray
    macroblock: np.ndarray
    group_names: list
    group_rigid: np.ndarray
    joint_names: list
    block_file: np.ndarray  # number in model.h5 of each block and vertex: others than their rows when a
    vertex_file: np.ndarray  # group has output: false
    rank: np.ndarray  # process that had the block when the run started

    def check(self):
        """Raises ValueError where the arrays do not belong together."""
        vertices, blocks = self.vertices, self.blocks
        if vertices.shape[1:] != (2,) or blocks.shape[1:] != (4,) or vertices.dtype.kind != "f" or blocks.dtype.kind != "i":
            raise ValueError("mesh: expected vertices (n, 2) and blocks (n, 4)")
        if blocks.size and (blocks.max() >= len(vertices) or blocks.min() < -1 or blocks[:, :3].min() < 0):
            raise ValueError("mesh: a block has a vertex that is not there")
        if any(len(rows) != len(blocks) for rows in (self.block_group, self.macroblock, self.block_file, self.rank)):
            raise ValueError("mesh: expected a group, a macroblock, a number and a rank for each block")

    def rings(self, vertices=None):
        """Corners (n_blocks, 4, 2), here or with vertices elsewhere; triangles repeat the first."""
        ring = np.where(self.blocks < 0, self.blocks[:, :1], self.blocks)
        return (self.vertices if vertices is None else vertices)[ring]

    def areas(self):
        """[m2] (n_blocks,)"""
        x, y = np.moveaxis(self.rings(), 2, 0)
        return 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)

    def centres(self):
        """[m] (n_blocks, 2), mean of the vertices."""
        used = (self.blocks >= 0)[:, :, None]
        return (self.vertices[self.blocks] * used).sum(axis=1) / used.sum(axis=1)

    def control(self, contacts):
        """Weight of each contact in the stresses of a joint: its length over a tenth of the shorter face, at most 1."""
        shorter = np.full(len(contacts), np.inf)
        for block, k in (contacts.face[:, :2].T, contacts.face[:, 2:].T):
            on_face = block >= 0
            ring = self.rings()[block[on_face]]
            n = np.where(self.blocks[block[on_face], 3] < 0, 3, 4)
            rows, start = np.arange(len(n)), k[on_face]
            length = np.linalg.norm(ring[rows, (start + 1) % n] - ring[rows, start], axis=1)
            shorter[on_face] = np.minimum(shorter[on_face], length)
        known = np.isfinite(shorter)
        return np.where(known, np.minimum(1.0, contacts.length / (0.1 * np.where(known, shorter, 1.0))), 1.0)

    def outline(self):
        """Vertices (n, 2) of the outer faces of all macroblocks."""
        following = np.roll(self.blocks, -1, axis=1)
        following = np.where(following < 0, self.blocks[:, :1], following)
        edges = np.stack([self.blocks, following], axis=2).reshape(-1, 2)
        edges = edges[edges[:, 0] >= 0]
        _, first, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
        return edges[np.sort(first[count == 1])]


class Contacts:
    """Contacts of a stage: an array per name of CONTACT_FIELDS (`class` as klass)."""

    def __init__(self, group):
        for name in CONTACT_FIELDS:
            setattr(self, "klass" if name == "class" else name, array(group[name]))
        self.closure = array(group["closure"]) if "closure" in group else np.zeros_like(self.opening)
        self.macroblock = array(group["macroblock"]) if "macroblock" in group else None  # None: written by an older program

    def on_b(self):
        """Force [N] (n, 2, 2) in x and y on side b of each contact, at both of its ends; side a has the opposite one."""
        along = np.stack([-self.normal[..., 1], self.normal[..., 0]], axis=-1)
        return self.force[..., :1] * self.normal + self.force[..., 1:] * along

    def on_body(self, number, joint=None):
        """Returns (X, Y, M about the origin) of all contacts, or of those of a row of joint_names, on a macroblock."""
        chosen = np.ones(len(self), dtype=bool) if joint is None else self.joint == joint
        side = (self.macroblock[:, 1] == number).astype(float) - (self.macroblock[:, 0] == number)
        forces = self.on_b() * (side * chosen)[:, None, None]
        at = self.point + self.displacement
        moments = at[..., 0] * forces[..., 1] - at[..., 1] * forces[..., 0]
        return np.array([*forces.sum(axis=(0, 1)), moments.sum()])

    def __len__(self):
        return len(self.length)


def table_of(kind, names, group):
    return kind(**{name: array(group[name]) for name in names})


GROUPS = {"contacts": Contacts, "flow": partial(table_of, flow.Flow, flow.column_names()), "loads": partial(table_of, face_loads.FaceLoads, face_loads.COLUMNS), "modes": modes.shapes_of,
          "anchors": partial(table_of, anchors.Anchors, anchors.column_names(anchors.Anchors)), "bars": partial(table_of, anchors.Bars, anchors.column_names(anchors.Bars)),
          "envelope": lambda group: histories.envelope_of(group, array)}  # what a stage has that is no array  # fmt: skip


class Stage:
    """Fields at the end of a stage, or in a frame of it; arrays are read when they are used."""

    def __init__(self, path, name):
        self.path, self.name = path, name
        with expecting(path, "a complete results file"), reading(path) as file:
            group = file["stages"][name]
            self.index, self.cycles = int(group.attrs["index"]), int(group.attrs["cycles"])
            self.frame, self.time = int(group.attrs.get("frame", 0)), float(group.attrs.get("time", 0.0))
            self.ratio = float(group.attrs["ratio"])
            self.verdict, self.evidence = text(group.attrs["verdict"]), text(group.attrs["evidence"])

    def __getattr__(self, name):
        if name not in STAGE_FIELDS + SOME_STAGES + tuple(GROUPS):
            raise AttributeError(name)
        with expecting(self.path, "a complete results file"), reading(self.path) as file:
            item = file["stages"][self.name].get(name)
            value = None if item is None and name in SOME_STAGES else GROUPS.get(name, array)(item)
        setattr(self, name, value)
        return value


class Results:
    """The results in an output folder. ResultsError, in one line: there are none, or they are damaged or of another version."""

    stages: list[str]  # names, in order
    mesh: Mesh  # blocks and vertices as they were at the start

    def __init__(self, folder: str | os.PathLike[str]):
        self.folder = os.fspath(folder)
        self.path = os.path.join(self.folder, "results.h5")
        if not os.path.isfile(self.path):
            raise ResultsError(f"{self.folder}: no results.h5 (a run writes it at the end of its first stage)")
        with expecting(self.path, "a complete results file"):
            check_results(self.path)
            with reading(self.path) as file:
                self._read(file)
        self._summary: dict[str, Any] = {}
        self._history: dict[str, np.ndarray] = {}
        self._joint_history = None
        if os.path.exists(os.path.join(self.folder, "summary.json")):
            check_further(self.folder, self.summary)

    def _read(self, file):
        if text(file.attrs.get("format", b"")) != FORMAT:
            raise ResultsError(f"{self.path}: not a results file of Quoin")
        if file.attrs["version"] != VERSION:
            raise ResultsError(f"{self.path}: version {file.attrs['version']}, this program reads {VERSION}")
        self.title, self.scene, self.model = (text(file.attrs[name]) for name in ("title", "scene", "model"))
        self.run = f"{int(file.attrs['run']):016x}"
        self.thickness = float(file.attrs["thickness"])
        mesh = file["mesh"]
        arrays = {name: array(mesh[name]) for name in ("vertices", "blocks", "block_group", "macroblock", "group_rigid")}
        arrays["rank"] = array(mesh["rank"]) if "rank" in mesh else np.zeros(len(arrays["blocks"]), dtype=int)
        for name, rows in (("block_file", "blocks"), ("vertex_file", "vertices")):
            arrays[name] = array(mesh[name]) if name in mesh else np.arange(len(arrays[rows]))
        names = {name: [text(word) for word in array(mesh[name])] for name in ("group_names", "joint_names")}
        self.mesh = Mesh(**arrays, **names)
        self.mesh.check()
        stages = file["stages"]
        order = {name: (item.attrs["index"], item.attrs.get("frame", 0)) for name, item in stages.items()}
        names = sorted(order, key=order.get)
        self.stages = [name for name in names if order[name][1] == 0]
        self._frames = {s: [n for n in names if order[n][0] == order[s][0] and n != s] for s in self.stages}

    def frames(self, stage: str) -> list[str]:
        """Names of the frames of a dynamic stage, in order; empty for another stage."""
        return self._frames[self.stage(stage).name]

    def stage(self, name: str | None = None) -> Stage:
        """A stage, or a frame of one, by name; the last stage by default."""
        if not self.stages:
            raise ResultsError(f"{self.path}: holds no stage")
        name = self.stages[-1] if name is None else name
        if name not in self.stages and not any(name in frames for frames in self._frames.values()):
            raise ResultsError(f"{self.path}: no stage '{name}', there are: {', '.join(self.stages)}")
        return Stage(self.path, name)

    @property
    def summary(self) -> dict[str, Any]:
        """Reads summary.json; null becomes None."""
        if not self._summary:
            path = os.path.join(self.folder, "summary.json")
            try:
                summary = read_summary(path)
            except OSError as error:
                raise ResultsError(f"{path}: {error.strerror}") from error
            check_stages(self.folder, summary)
            self._summary = summary
        return self._summary

    def stage_summary(self, name: str) -> dict[str, Any]:
        """Returns the member of summary["stages"] with this name."""
        for stage in self.summary["stages"]:
            if stage["name"] == name:
                return stage
        raise ResultsError(f"{self.folder}: summary.json has no stage '{name}', there are: {', '.join(s['name'] for s in self.summary['stages'])}")

    @property
    def history(self) -> dict[str, np.ndarray]:
        """Reads history.csv: arrays of numbers by column, `stage` an array of names."""
        if not self._history:
            path = os.path.join(self.folder, "history.csv")
            try:
                check_history(path, self.summary)
            except OSError as error:
                raise ResultsError(f"{path}: {error.strerror}") from error
            self._history = read_history(path)
        return self._history

    def table(self, kind: str, stage: str | None = None) -> tables.Table:
        """Table of pandas: vertices, blocks or contacts at the end of a stage (the last by default) or in a frame, or history, of the whole run.
        attrs["units"] has the unit of each column. TableError: no such kind."""
        return tables.table(self, kind, stage)

    @property
    def joint_history(self):
        """Returns for each joint its columns of joint_history.csv (base/histories.py); {} where no stage ran in time."""
        if self._joint_history is None:
            self._joint_history = histories.joint_history(self.folder, self.summary)
        return self._joint_history

    def joint_profile(self, stage: str, joint: str, *more: str) -> tuple[np.ndarray, ...]:
        """Distance from the start of the joint [m], sigma, tau [Pa], more fields by name: each (n, 2), a row per contact in order.

        ResultsError: no such joint or field, or the joint has no profile in this stage (without_profile says why). tau is positive when the upper side pushes the
        lower one to the end.
        """
        reason = self.without_profile(stage, joint)
        if reason:
            raise ResultsError(f"{self.path}: stage '{stage}': joint '{joint}' {reason}")
        contacts, line = self.stage(stage).contacts, self.stage_summary(stage)["joints"][joint]
        wrong = [name for name in more if name not in PROFILE_FIELDS]
        if wrong:
            raise ResultsError(f"{self.path}: contacts have no '{wrong[0]}' at their ends, there are: {', '.join(PROFILE_FIELDS)}")
        mine = contacts.joint == self.mesh.joint_names.index(joint)
        start, end = (np.array([line[name]["x"], line[name]["y"]]) for name in ("start", "end"))
        distance = (contacts.point[mine] - start) @ (end - start) / line["chord"]
        order = np.argsort(distance, axis=1, kind="stable")
        fields = (distance, contacts.sigma[mine], -contacts.tau[mine], *(getattr(contacts, name)[mine] for name in more))
        columns = [np.take_along_axis(array, order, axis=1) for array in fields]
        rows = np.argsort(columns[0].sum(axis=1), kind="stable")
        return tuple(array[rows] for array in columns)

    def without_profile(self, stage: str, joint: str) -> str | None:
        """Returns why a joint has no profile in a stage; None: it has one."""
        joints = self.stage_summary(stage)["joints"]
        if joint not in self.mesh.joint_names:
            raise ResultsError(f"{self.path}: no joint '{joint}', there are: {', '.join(joints)}")
        if joint not in joints:
            return f"has no contacts in it; there are: {', '.join(joints)}"
        if not joints[joint]["line"]:
            return "is no line, so it has no distance along it"
        if not (self.stage(stage).contacts.joint == self.mesh.joint_names.index(joint)).any():
            return "is between blocks that are not written (output.groups)"
        return None


def text(value):
    """Returns a str; HDF5 hands out bytes or str."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def array(item):
    """Reads a dataset. Its data must be in the file before memory is taken for its stated size."""
    if item.nbytes != item.id.get_storage_size():
        raise ValueError(f"{item.name}: its data are not in the file")
    return np.array(item)


def read_history(path):
    with expecting(path, "a history"):
        return columns_of(path)


def columns_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        rows = [row for row in csv.reader(file) if row]
    header = rows[0] if rows else []
    rows = [row for row in rows[1:] if len(row) == len(header)]  # the last one may be cut off in a run that goes on
    columns = zip(*rows) if rows else [()] * len(header)
    return {name: np.array(column, dtype=str if name == "stage" else float) for name, column in zip(header, columns)}


# ---- tables for the terminal


def fixed(value, scale=1.0, digits=3):
    return "-" if value is None else Figure(numeral(f"{round(value * scale, digits) + 0.0:.{digits}f}"), value * scale)


def sliding(value, digits=3):
    """Formats a sliding factor for people."""
    return _("> {0:.0f}", NO_SHEAR) if value is not None and value > NO_SHEAR else fixed(value, 1.0, digits)


def place(end):
    return "-" if end is None else _("({0:.2f}, {1:.2f})", end["x"], end["y"])


def stage_rows(s):
    ratio = "-" if s["ratio"] is None or energy_rows(s) else f"{s['ratio']:.2e}"
    forces = [fixed(s[force][x], 1e-3, 1) for force in ("applied", "reaction") for x in "xy"]
    return [(s["verdict"], s["cycles"], fixed(s["wall_s"], 1, 2), ratio, *forces)]


def effort_rows(s):
    """Returns lines on how the stage was solved; empty for results that are older than these facts."""
    return [(s["method"], s.get("connectivity", "-"), s["force_evaluations"], s["solves"], s["factorisations"])] if "method" in s and "modes" not in s else []


def condensed_words(summary):
    """Returns the line on condensed bodies; None without any."""
    c = summary.get("condensed")
    if c and c.get("large_strain"):
        return ngettext("{0} condensed body, corrected for large strain, {1} inner dofs left out", "{0} condensed bodies, corrected for large strain, {1} inner dofs left out", c["bodies"], c["inner_dofs"])
    return c and ngettext("{0} condensed body in small strain, {1} inner dofs left out", "{0} condensed bodies in small strain, {1} inner dofs left out", c["bodies"], c["inner_dofs"])


def probe_rows(s):
    return [(name, fixed(p["u_x"], 1e3), fixed(p["u_y"], 1e3)) for name, p in s["probes"].items()]


def support_rows(s):
    """Returns the force of each support where there are several; their sum stands with the stage."""
    rows = [(name, fixed(force["x"], 1e-3, 1), fixed(force["y"], 1e-3, 1)) for name, force in s.get("supports", {}).items()]
    return rows if len(rows) > 1 else []


def joint_rows(s):
    rows = []
    for name, j in s["joints"].items():
        ends = [fixed(j[end]["sigma"] if j["line"] else None, 1e-6) for end in ("start", "end")]
        forces = (fixed(j["N"], 1e-3, 1), fixed(j["T"], 1e-3, 1), fixed(j["friction_needed"], 1, 2))
        factors = (sliding(j["sliding_factor_peak"]), sliding(j["sliding_factor_residual"]))
        lengths = (fixed(j["length"]), fixed(j["open_length"]), fixed(j["length"] - j["open_length"]), fixed(j["slipping_length"]))
        rows.append((name, *forces, *factors, *lengths, *ends))
    return rows


def trials_of(s):
    """Returns the result of the trials of a stage; None: it has none."""
    return s.get("strength_reduction") or s.get("flood") or s.get("load_factor") or s.get("anchor_force")


def no_single_factor(found):
    """Tells whether joints of different angles slid."""
    return bool(found.get("factors")) and found["failing"] is not None and found["safety_factor_failing"] is None


def bracket_rows(s):
    found = trials_of(s)
    if not found:
        return []
    what = "factor on loads" if "raises" in found else "part of prestress" if "forces" in found else {"m": "level m", "degree": "friction deg"}.get(found["unit"], "strengths")
    ends = [fixed(found[end], digits=4) for end in ("stable", "failing")]
    factors = ["none: use strengths"] * 2 if no_single_factor(found) else [fixed(found.get(f"safety_factor_{end}")) for end in ("stable", "failing")]
    return [(what, *ends, *factors, fixed(found.get("moved"), 1e3))]


def factor_rows(s):
    """Returns lines on each joint whose friction a reduction lowers, and whether it slides in the mechanism."""
    found, moves = trials_of(s) or {}, s.get("mechanism") or {}
    return [(name, fixed(f["friction"], digits=2), fixed(f["factor_stable"]), fixed(f["factor_failing"]), _(moves[name]["moves"]) if name in moves else "-")
            for name, f in found.get("factors", {}).items()]  # fmt: skip


def mechanism_rows(s):
    """Returns lines on the joints of the mechanism; speeds are relative to the fastest vertex."""
    return [(name, _(m["moves"]), fixed(m["slides"]), fixed(m["opens"])) for name, m in (s.get("mechanism") or {}).items()]


def extreme_rows(s):
    rows = []
    for name, group in s["stress_by_group"].items():
        high, low = group["s1_max"], group["s2_min"]
        if high is not None:
            ends = [(fixed(end["value"], 1e-6), place(end)) for end in (high, low)]
            rows.append((name, *ends[0], *ends[1]))
    return rows


def energy_account(s):
    """Returns from a dynamic stage's summary the energy [J] that came from nothing, that renewed contacts lost, and that moved in all; None: no account.
    The moved energy is the work from outside, the kinetic energy at the start, and the stored energy that was released: prestress that stays moves nothing."""
    e = s.get("energy", {})
    if "balance" not in e or None in e.values():
        return None
    made, lost = abs(e["balance"]) + max(0.0, e["detection"]) + max(0.0, -e["friction"]), max(0.0, -e["detection"])
    if "moved" in e:
        return made, lost, e["moved"]
    incoming, radiated = e.get("incoming", 0.0), e.get("radiated", 0.0)  # older files lack members, and count all that was stored
    came = e["outside"] + e["supports"] + incoming - radiated
    start = e["kinetic"] + e["strain"] + e["joints"] + e["friction"] - e["detection"] + e["damping"] + e["balance"] - came
    return made, lost, abs(e["outside"]) + abs(e["supports"]) + incoming + start


def energy_rows(s):
    """The account of a dynamic stage."""
    energy = s.get("energy", {})
    if "balance" not in energy:
        return []
    return [(fixed(s["time"]), *("-" if energy.get(name) is None else f"{energy[name]:.4g}" for name in ENERGIES))]


body_rows = partial(histories.body_rows, fixed=fixed)
SECTIONS = (  # title, columns after the stage, rows of one stage
    ("Stages", "verdict|cycles|wall s|ratio|load x kN|load y kN|support x kN|support y kN", stage_rows),
    ("How they were solved", "method|contacts|force evaluations|solves|factorisations", effort_rows),
    ("What each support adds", "support|x kN|y kN", support_rows),
    ("Displacement of named points", "point|u_x mm|u_y mm", probe_rows),
    ("Joints", "joint|N kN|T kN|atan T/N deg|factor peak, c on closed|residual|length m|open m|closed m|slipping m|"
               "sigma start MPa|sigma end MPa", joint_rows),
    *flow.SECTIONS,
    *modes.SECTIONS,
    *anchors.SECTIONS,
    *laws.SECTIONS,
    ("Trials to failure", "value|last stable|first failing|factor, last stable|factor, first failing|moved mm", bracket_rows),
    ("Factors of joints whose friction was reduced", "joint|friction deg|last stable|first failing|in the mechanism", factor_rows),
    ("How it fails: joints of the mechanism, and their speed over that of the fastest vertex", "joint|it|sliding|opening", mechanism_rows),
    ("Energy of dynamic stages", "t s|" + "|".join(f"{name} J" for name in ENERGIES), energy_rows),
    *((title, header, lambda s, rows=rows: rows(s, fixed)) for title, header, rows in histories.SECTIONS),
    ("Extreme principal stresses at block centres", "group|s1 max MPa|at m|s2 min MPa|at m", extreme_rows),
)  # fmt: skip


def report(summary):
    """Returns the text of the whole table."""
    stages, ranks = summary["stages"], summary["ranks"]
    names = ("blocks", "vertices", "macroblocks", "contacts", "dofs")
    sizes = [f"{summary['n_' + name]} {name}" for name in names]
    lines = [summary["title"] or summary["model"], ", ".join(sizes + [f"{ranks} rank{'s' * (ranks != 1)}"])]
    lines += filter(None, [condensed_words(summary)])
    for title, header, rows_of in SECTIONS:
        rows = [(s["name"], *row) for s in stages for row in rows_of(s)]
        if rows:
            lines += ["", title, *table(["stage", *header.split("|")], rows)]
    lines += ["", "Why"] + [f"  {s['name']}: {s['evidence']}" for s in stages]
    return "\n".join(lines)


def main(arguments=None):
    parser = Parser(prog="quoin show", description="Table of the results of a run.")
    parser.add_argument("folder", help="output folder of a run")
    options = parser.parse_args(arguments)
    try:
        print(report(Results(options.folder).summary))
    except ResultsError as error:
        print(f"show: {error}", file=sys.stderr)
        return 2
    return 0
