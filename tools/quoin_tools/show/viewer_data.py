"""Collects the data of the page of a run (viewer.py): its mesh, steps, forces and histories, as one block of numbers and their places."""

import base64
import hashlib
import math

import numpy as np

from quoin_tools.assess.assessment import ERRORS
from quoin_tools.assess.joint_uplift import joined, joint_chord
from quoin_tools.assess.section_cut import meets, stage_forces, standing, wet_segments
from quoin_tools.assess.surface import WATERS, level_at_faces
from quoin_tools.base import scene
from quoin_tools.base.anchors import STATES, facts_of
from quoin_tools.base.flow import at_end
from quoin_tools.base.modes import modes_of, number
from quoin_tools.mesh.blockmesh import face_ends
from quoin_tools.mesh.of_run import mesh_of
from quoin_tools.show import style

FIELDS = {  # of blocks: name for people, unit of results.h5
    "s1": ("principal stress s1", "Pa"), "s2": ("principal stress s2", "Pa"), "temperature": ("change of temperature", "K"),
    "safety_factor": ("local failure factor", "-"), "plastic_strain": ("plastic strain", "-"), "damage": ("damage", "-"), "crack_width": ("width of cracks", "m"),
}  # fmt: skip
BLOCK_FIELDS = ("s1", "s2", "angle", "temperature", "safety_factor", "plastic_strain", "damage", "crack_width", "built")
CONTACT_FIELDS = ("displacement", "sigma", "tau", "opening", "slip")
WATER = 1000.0  # [kg/m3]
THIN_WATER = 0.05  # of that: a reservoir of another density is no water, and has no level of water


class Numbers:
    """Packs arrays behind each other as float32 or int32; equal arrays are written once."""

    def __init__(self):
        self.parts, self.known, self.size = [], {}, 0

    def add(self, array, kind="<f4"):
        """[type, place, count] of an array."""
        data = np.ascontiguousarray(array, dtype=kind).tobytes()
        key = (kind, hashlib.blake2b(data, digest_size=16).digest())
        if key not in self.known:
            self.known[key] = ["f" if kind == "<f4" else "i", self.size, len(data) // 4]
            self.parts.append(data)
            self.size += len(data) // 4
        return self.known[key]

    def whole(self, array):
        return self.add(array, "<i4")

    def text(self):
        return base64.b64encode(b"".join(self.parts)).decode("ascii")


class Page:
    """The data of one run. most: numbers of the steps; above it steps and contacts are left out."""

    def __init__(self, results, most):
        self.results, self.most, self.numbers, self.notes = results, most, Numbers(), []
        low, high = results.mesh.vertices.min(axis=0), results.mesh.vertices.max(axis=0)
        self.origin = np.floor(0.5 * (low + high))  # so that float32 has room for millimetres far from the origin
        self.scene = self.mesh = None
        try:
            self.scene = scene.of_run(results.folder, results.summary)
            self.mesh = mesh_of(results, self.scene)[0]
        except (*ERRORS, OSError) as error:
            self.notes.append(f"Water on faces, uplift by rules and named points are left out: {error}")

    def places(self, points):
        """Places in the mesh, from the origin of the page."""
        return self.numbers.add(np.asarray(points, dtype=float) - self.origin)

    # ---- the whole

    def content(self):
        r, mesh, add = self.results, self.results.mesh, self.numbers
        box, _ = style.view(mesh)
        whole, _ = style.view(mesh, whole=True)
        steps, every = self.chosen()
        return {
            "title": r.title or r.model, "run": r.run, "thickness": r.thickness, "origin": self.origin.tolist(),
            "box": self.box(box), "whole": self.box(whole), "groups": mesh.group_names, "rigid": mesh.group_rigid.astype(int).tolist(),
            "joints": mesh.joint_names, "fields": FIELDS, "fills": style.FILLS, "lines": style.LINES,
            "mesh": {"vertices": self.places(mesh.vertices), "blocks": add.whole(mesh.blocks), "group": add.whole(mesh.block_group), "number": add.whole(mesh.block_file),
                     "outline": add.whole(mesh.outline())},
            "points": self.points(), "steps": [self.step(name, every) for name in steps], "charts": self.charts(), "notes": self.notes,
        }  # fmt: skip

    def box(self, box):
        x, y = self.origin
        return [box[0] - x, box[1] - x, box[2] - y, box[3] - y]

    def points(self):
        """Named points whose vertices are written: name and row of the vertex."""
        if self.mesh is None:
            return []
        row = {number: i for i, number in enumerate(self.results.mesh.vertex_file.tolist())}
        return [[name, row[vertex]] for name, vertex in self.mesh.points.items() if vertex in row]

    # ---- which steps, how many contacts

    def chosen(self):
        """Chooses the steps that are shown, and how many contacts that are closed and do not slip one stands for; it reports what is left out."""
        r = self.results
        mesh, ends = r.mesh, r.stages
        contacts = max(len(r.stage(name).contacts) for name in ends)
        own = 2 * len(mesh.vertices) + 4 * len(mesh.blocks)
        one = own + 14 * contacts
        every = 1
        if one * len(ends) > self.most and contacts:
            every = min(20, max(2, math.ceil(14 * contacts * len(ends) / max(self.most - own * len(ends), 1))))
            one = own + 14 * contacts // every
            self.notes.append(f"Of the contacts that are closed and hold every {every}th is drawn; those that are open, slip or crush are all drawn.")
        kept = ends[-max(1, self.most // one) :]
        if len(kept) < len(ends):
            self.notes.append(f"{len(ends) - len(kept)} of {len(ends)} stages are left out, the first ones: the model has {len(mesh.blocks)} blocks.")
        frames = sum(len(r.frames(name)) for name in kept)
        room = max(0, self.most // one - len(kept))
        nth = math.ceil(frames / room) if room and frames > room else 1
        steps = [name for end in kept for name in [*(r.frames(end)[::-1][::nth][::-1] if room else []), end]]
        if len(steps) < frames + len(kept):
            self.notes.append(f"{len(steps) - len(kept)} of {frames} frames of stages in time are shown: the model has {len(mesh.blocks)} blocks.")
        return steps, every

    # ---- one step

    def step(self, name, every):
        stage, add = self.results.stage(name), self.numbers
        end = next(end for end in self.results.stages if name == end or name in self.results.frames(end))
        facts = self.results.stage_summary(end)
        of_blocks = {field: getattr(stage, field) for field in BLOCK_FIELDS}
        found = {
            "stage": end, "frame": stage.frame, "verdict": stage.verdict, "evidence": stage.evidence,
            "time": stage.time if stage.frame or self.results.frames(end) else None,
            "displacement": add.add(stage.displacement), "blocks": {key: add.add(array) for key, array in of_blocks.items() if array is not None},
            "shapes": self.shapes(stage, facts), "contacts": self.contacts(stage.contacts, every), "flow": self.flow(stage), "anchors": self.anchors(stage, facts),
            "faces": self.faces(end), "forces": self.forces(end), "uplift": self.uplift(end, facts),
            "table": [] if stage.frame else self.joint_table(facts),
        }  # fmt: skip
        return found

    def shapes(self, stage, facts):
        """Motions that have no size: how a stage fails, free vibrations."""
        found = [] if stage.mechanism is None else [["motion of the failure", self.numbers.add(stage.mechanism)]]
        shapes = [] if stage.modes is None else stage.modes
        return found + [[f"mode {i + 1}, {number(mode['f'], '.4g')} Hz", self.numbers.add(shape)] for i, (mode, shape) in enumerate(zip(modes_of(facts), shapes))]

    def contacts(self, contacts, every):
        kept = (contacts.state != 0).any(axis=1) | (np.arange(len(contacts)) % every == 0)
        found = {field: self.numbers.add(getattr(contacts, field)[kept]) for field in CONTACT_FIELDS}
        return found | {"point": self.places(contacts.point[kept]), "joint": self.numbers.whole(contacts.joint[kept]), "state": self.numbers.whole(contacts.state[kept])}

    def flow(self, stage):
        flow = stage.flow
        return None if flow is None else {"point": self.places(flow.point), "pressure": self.numbers.add(flow.pressure), "joint": self.numbers.whole(flow.joint)}

    def anchors(self, stage, facts):
        table = stage.anchors
        if table is None:
            return None
        found = {"names": list(facts_of(facts)), "head": self.places(table.head), "root": self.places(table.root), "force": self.numbers.add(table.force),
                 "spacing": self.numbers.add(table.spacing), "state": [STATES[state] for state in table.state]}  # fmt: skip
        if stage.bars is not None:
            found["bars"] = {"anchor": self.numbers.whole(stage.bars.anchor), "place": self.places(stage.bars.place), "force": self.numbers.add(stage.bars.force)}
        return found

    def faces(self, end):
        """Reservoirs of a stage: level, and wet faces with the vertices they move with (-1: not written)."""
        found = []
        if self.mesh is None:
            return found
        row = np.full(len(self.mesh.vertices), -1)
        row[self.results.mesh.vertex_file] = np.arange(len(self.results.mesh.vertex_file))
        for name, load in self.scene.stage_loads(end).items():
            if load.get("type") in WATERS and load.get("faces") in self.mesh.face_sets:
                density = float(load["density"])
                found.append({"name": name, "level": level_at_faces(load) - self.origin[1], "unit": density * float(load.get("partial_factor", 1)) * self.scene.gravity, "density": density,
                              "water": abs(density / WATER - 1) <= THIN_WATER, "ends": self.places(wet_segments(self.mesh, load)),
                              "rows": self.numbers.whole(row[face_ends(self.mesh, self.mesh.face_sets[load["faces"]])])})  # fmt: skip
        return found

    def forces(self, end):
        """Loads of a stage that are neither water at rest nor weight, silt, ice, waves, tractions, pressures: resultant [N] of the slice, and the place where it meets their faces."""
        found = []
        if self.mesh is None:
            return found
        mesh, _ = standing(self.mesh, self.scene, end)
        loads = self.scene.stage_loads(end)
        for name, force in stage_forces(self.mesh, self.scene, end, pressed=self.results.stage(end).loads)[0].items():
            place = None if loads[name]["type"] in (*WATERS, "self_weight", "pseudo_static") else meets(mesh, loads[name], force)
            if place is not None:
                found.append({"name": name, "at": (place - self.origin).tolist(), "force": force[:2].tolist()})
        return found

    def uplift(self, end, facts):
        """Pressure of uplift loads along the chords of their joints."""
        found = []
        for name, load in (self.scene.stage_loads(end) if self.mesh is not None else {}).items():
            diagram = (at_end(facts).get("uplift") or {}).get(name, {}).get("diagram")
            if diagram and load.get("faces") in self.mesh.face_sets:
                chord = joint_chord(self.mesh, self.scene, name, joined(self.mesh, self.mesh.face_sets[load["faces"]])[1])
                found.append({"name": name, "point": self.places([chord.at(s) for s, _ in diagram]), "pressure": self.numbers.add([p for _, p in diagram])})
        return found

    @staticmethod
    def joint_table(facts):
        """Name, length, N, T, factor, open and slipping length of each joint; its ends where it is a line."""
        rows = []
        for name, joint in facts["joints"].items():
            ends = [[joint[key]["x"], joint[key]["y"]] for key in ("start", "end")] if joint["line"] else None
            rows.append({"name": name, "length": joint["length"], "N": joint.get("N"), "T": joint.get("T"), "factor": joint.get("sliding_factor_peak"), "open": joint["open_length"],
                         "slipping": joint["slipping_length"], "ends": ends})  # fmt: skip
        return rows

    # ---- histories

    def charts(self):
        """Displacements of named points, and the unbalanced ratio, over cycles; of each stage in time over time, with its joints."""
        history = self.results.history
        if not len(history.get("cycle", ())):
            return []
        points = [column[:-5] for column in history if column.endswith("_ux_m")]
        moved = [(f"{point} u_{x}", history[f"{point}_u{x}_m"]) for point in points for x in "xy"] or [("largest", history["u_max_m"])]
        every = np.ones(len(history["cycle"]), dtype=bool)
        over_cycles = "cycle", "cycle at the ends of stages [-]" if len(set(history["stage"])) > 1 else "cycle [-]", history["cycle"]
        found = [self.chart("Displacement of points", "mm", 1e3, *over_cycles, moved, every, history["stage"])]
        if (history["ratio"] > 0).any():
            found.append(self.chart("Unbalanced ratio", "-", 1, *over_cycles, [("ratio", history["ratio"])], every, history["stage"], log=True))
        for stage in self.results.stages:
            mine = history["stage"] == stage
            if "time_s" in history and mine.any() and np.isfinite(history["balance_J"][mine]).any():
                found.append(self.chart(f"Displacement of points, stage {stage}", "mm", 1e3, stage, "time [s]", history["time_s"], moved, mine))
                found += self.joint_charts(stage)
        return found

    def joint_charts(self, stage):
        found = []
        for column, title in (("slip_largest", "Slip of joints"), ("opening", "Opening of joints")):
            joints = {name: c for name, c in self.results.joint_history.items() if (c["stage"] == stage).any() and np.isfinite(c[column]).any()}
            if joints:
                first = next(iter(joints.values()))
                mine = first["stage"] == stage
                series = [(name, c[column]) for name, c in joints.items() if len(c[column]) == len(mine)]
                found.append(self.chart(f"{title}, stage {stage}", "mm", 1e3, stage, "time [s]", first["time"], series, mine))
        return found

    def chart(self, title, unit, factor, over, label, x, series, mine, stages=None, log=False):
        """over: a stage of which this is the time, or cycle; stages: name of the stage of each row."""
        rows = thinned(np.flatnonzero(mine), [values for _, values in series])
        if len(rows) < mine.sum():
            self.notes.append(f"Chart {title}: {len(rows)} of {mine.sum()} rows, among them all extremes.")
        spans = []
        for name in dict.fromkeys(stages[rows].tolist() if stages is not None else []):
            at = x[mine & (stages == name)]
            spans.append([name, float(at.min()), float(at.max())])
        return {"title": title, "unit": unit, "over": over, "label": label, "x": self.numbers.add(x[rows]), "log": log, "spans": spans,
                "series": [[name, self.numbers.add(factor * values[rows])] for name, values in series]}  # fmt: skip


ROWS = 3000  # of a chart


def thinned(rows, columns):
    """Rows of a history that a chart shows: all, or of each of many stretches the least and the largest of every column."""
    if len(rows) <= ROWS:
        return rows
    pieces = np.array_split(rows, max(8, ROWS // (2 * len(columns))))
    kept = {int(rows[0]), int(rows[-1])}
    for values in columns:
        for piece in pieces:
            known = piece[np.isfinite(values[piece])]
            kept |= {int(known[values[known].argmin()]), int(known[values[known].argmax()])} if len(known) else set()
    return np.array(sorted(kept))
