"""Writes results as CSV for spreadsheets and other programs.

    quoin export FOLDER [--stage NAME]... [--to FOLDER]

writes <stage>_vertices.csv, <stage>_blocks.csv, <stage>_contacts.csv (two rows per contact: its ends); of all stages joints.csv, supports.csv,
and where there are trials or a collapse trials.csv and factors.csv (a row for the stage, "joint" empty, then one for each joint). Where water
flows in joints <stage>_flow.csv (two rows per piece of a joint: its ends); of all stages discharges.csv and uplifts.csv. Of dynamic stages
with envelopes <stage>_envelope_blocks.csv and <stage>_envelope_contacts.csv; histories are CSV as they are.
--dxf writes <stage>.dxf, a drawing, in place of them; --paraview paraview_state.py, with which ParaView opens the run.
SI units, signs of docs/results_format.md; the first row names columns with their units.
"""

import csv
import io
import os
import sys

import numpy as np

from quoin_tools.base.command import Parser, words_of
from quoin_tools.base.files import write_file
from quoin_tools.base.flow import facts_of
from quoin_tools.base.results import Results, ResultsError, trials_of
from quoin_tools.show import dxf, paraview_state

JOINT = ("law", "length", "open_length", "closed_length", "slipping_length", "crushing_length", "N", "T", "M", "friction_needed", "sliding_factor_peak",
         "sliding_factor_residual", "chord", "sigma_linear_start", "sigma_linear_end")  # fmt: skip
UNITS = {"length": "m", "chord": "m", "N": "N", "T": "N", "M": "N m", "friction_needed": "deg", "sigma_linear_start": "Pa",
         "sigma_linear_end": "Pa", "open_length": "m", "closed_length": "m", "slipping_length": "m", "crushing_length": "m"}  # fmt: skip


UPLIFT = {"length": "length [m]", "uplift": "force [N]", "centre_x": "centre x [m]", "centre_y": "centre y [m]", "widest": "widest [m]",
          "at_residual": "part at residual aperture", "at_max": "part at largest aperture", "reynolds": "Reynolds number"}  # fmt: skip


def plain(value):
    """Returns the shortest text that reads back as the same number; empty for an undefined number."""
    if value is None or (isinstance(value, (float, np.floating)) and np.isnan(value)):
        return ""
    return repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)


def write(path, header, rows):
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(header)
    writer.writerows([plain(value) for value in row] for row in rows)
    write_file(path, text.getvalue())
    return path


def vertices(results, stage):
    header = ("vertex", "x [m]", "y [m]", "u_x [m]", "u_y [m]")
    mesh = results.mesh
    return header, ((i, *at, *u) for i, at, u in zip(mesh.vertex_file, mesh.vertices, stage.displacement))


def blocks(results, stage):
    header = ("block", "group", "macroblock", "x [m]", "y [m]", "s_xx [Pa]", "s_yy [Pa]", "s_xy [Pa]", "s1 [Pa]", "s2 [Pa]", "angle [rad]",
              "rotation [rad]")  # fmt: skip
    mesh = results.mesh
    columns = zip(mesh.block_file, mesh.block_group, mesh.macroblock, mesh.centres(), stage.stress, stage.s1, stage.s2, stage.angle,
                  stage.rotation)  # fmt: skip
    return header, ((i, mesh.group_names[group], macroblock, *at, *stress, s1, s2, angle, rotation)
                    for i, group, macroblock, at, stress, s1, s2, angle, rotation in columns)  # fmt: skip


def numbered(mesh, face):
    """Faces of contacts (n, 4) with the numbers of model.h5."""
    face = face.copy()
    for block, place in ((0, 1), (2, 3)):
        vertex = face[:, block] == -1
        face[vertex, place] = mesh.vertex_file[face[vertex, place]]
        face[face[:, block] >= 0, block] = mesh.block_file[face[face[:, block] >= 0, block]]
    return face


def contacts(results, stage):
    header = ("contact", "end", "joint", "class", "block a", "face a", "block b", "face b", "length [m]", "x [m]", "y [m]", "normal x",
              "normal y", "opening [m]", "sliding [m]", "slip [m]", "broken", "sigma [Pa]", "tau [Pa]", "force normal [N]", "force along [N]",
              "state", "macroblock a", "macroblock b", "force on b x [N]", "force on b y [N]")  # fmt: skip
    c, names = stage.contacts, results.mesh.joint_names
    face, on_b = numbered(results.mesh, c.face), c.on_b()
    body = c.macroblock if c.macroblock is not None else np.full((len(c), 2), np.nan)
    rows = ((i, end, names[c.joint[i]], c.klass[i], *face[i], c.length[i], *c.point[i, end], *c.normal[i, end], c.opening[i, end],
             c.sliding[i, end], c.slip[i, end], c.broken[i, end], c.sigma[i, end], c.tau[i, end], *c.force[i, end], c.state[i, end],
             *body[i], *on_b[i, end])
            for i in range(len(c)) for end in (0, 1))  # fmt: skip
    return header, rows


def flow(results, stage):
    header = ("piece", "end", "joint", "x [m]", "y [m]", "head [m]", "pressure [Pa]", "aperture [m]", "saturation", "discharge [m2/s]", "length [m]")
    water, names = stage.flow, results.mesh.joint_names
    rows = (
        (i, end, names[water.joint[i]], *water.point[i, end], water.head[i, end], water.pressure[i, end], water.aperture[i, end],
         water.saturation[i, end], water.discharge[i], water.length[i]) for i in range(len(water)) for end in (0, 1))  # fmt: skip
    return header, rows


def envelope_blocks(results, stage):
    header = ("block", "group", "x [m]", "y [m]", "largest s1 [Pa]", "at [s]", "least s2 [Pa]", "at [s]", "least safety factor", "at [s]")
    mesh, e = results.mesh, stage.envelope
    none = np.full(len(mesh.blocks), np.nan)
    factors = (none, none) if e.safety_factor_min is None else (e.safety_factor_min, e.safety_factor_min_time)
    columns = zip(mesh.block_file, mesh.block_group, mesh.centres(), e.s1_max, e.s1_max_time, e.s2_min, e.s2_min_time, *factors)
    return header, ((i, mesh.group_names[group], *at, *numbers) for i, group, at, *numbers in columns)


def envelope_contacts(results, stage):
    header = ("contact", "end", "joint", "x [m]", "y [m]", "largest sigma [Pa]", "least sigma [Pa]", "largest opening [m]", "largest slip [m]")
    c, e, names = stage.contacts, stage.envelope.contacts, results.mesh.joint_names
    rows = ((i, end, names[c.joint[i]], *c.point[i, end], e.sigma_max[i, end], e.sigma_min[i, end], e.opening_max[i, end], e.slip_max[i, end])
            for i in range(len(c)) for end in (0, 1))  # fmt: skip
    return header, rows


def discharges(results, stages):
    """Writes rows of heads, drains and inflows: the flow that leaves the joints there."""
    rows = ((stage, name, c["nodes"], c["discharge"], c["litres_per_minute"]) for stage in stages
            for name, c in facts_of(results.stage_summary(stage)).get("conditions", {}).items())  # fmt: skip
    return ("stage", "load", "nodes", "discharge [m2/s]", "discharge [litres per minute and metre]"), rows


def uplifts(results, stages):
    """Force of the water in each joint."""
    rows = ((stage, name, *(j[key] for key in UPLIFT)) for stage in stages
            for name, j in facts_of(results.stage_summary(stage)).get("joints", {}).items())  # fmt: skip
    return ("stage", "joint", *UPLIFT.values()), rows


def joints(results, stages):
    header = ("stage", "joint", *(f"{key} [{UNITS[key]}]" if key in UNITS else key for key in JOINT))
    rows = ((stage, name, *(facts.get(key) for key in JOINT)) for stage in stages
            for name, facts in results.stage_summary(stage)["joints"].items())  # fmt: skip
    return header, rows


def supports(results, stages):
    rows = ((stage, name, force["x"], force["y"]) for stage in stages
            for name, force in results.stage_summary(stage).get("supports", {}).items())  # fmt: skip
    return ("stage", "support", "x [N]", "y [N]"), rows


def factors(results, stages):
    """Writes rows of trials and collapses: one for the stage, then one for each joint that has a factor or moves in the mechanism."""
    rows = []
    for name in stages:
        s = results.stage_summary(name)
        found, moves = trials_of(s) or {}, s.get("mechanism") or {}
        if not found and not moves:
            continue
        ends = [found.get(key) for key in ("friction", "safety_factor_stable", "safety_factor_failing")]
        rows.append((name, None, found.get("unit"), found.get("stable"), found.get("failing"), *ends, None, None))
        for joint in dict.fromkeys([*found.get("factors", {}), *moves]):
            own, motion = found.get("factors", {}).get(joint, {}), moves.get(joint, {})
            numbers = [own.get(key) for key in ("friction", "factor_stable", "factor_failing")]
            rows.append((name, joint, None, None, None, *numbers, motion.get("slides"), motion.get("opens")))
    header = ("stage", "joint", "unit", "stable", "failing", "friction [deg]", "factor stable", "factor failing", "slides", "opens")
    return header, rows


def trials(results, stages):
    header = ("stage", "value", "outcome", "cycles", "moved [m]", "max displacement [m]")
    rows = [(name, t["value"], t["outcome"], t["cycles"], t.get("moved"), t["max_displacement"]) for name in stages
            for t in (trials_of(results.stage_summary(name)) or {}).get("trials", ())]  # fmt: skip
    return header, rows


def export(results, stages=None, folder=None):
    """Paths of the files written."""
    folder = folder or results.folder
    os.makedirs(folder, exist_ok=True)
    stages, written = stages or results.stages, []
    for name in stages:
        stage = results.stage(name)
        for words, of in (("vertices", vertices), ("blocks", blocks), ("contacts", contacts)):
            written.append(write(os.path.join(folder, f"{name}_{words}.csv"), *of(results, stage)))
        if stage.flow is not None:
            written.append(write(os.path.join(folder, f"{name}_flow.csv"), *flow(results, stage)))
        for of in (envelope_blocks, envelope_contacts) if stage.envelope is not None else ():
            written.append(write(os.path.join(folder, f"{name}_{of.__name__}.csv"), *of(results, stage)))
    for of in (joints, supports, factors, trials, discharges, uplifts):
        header, rows = of(results, stages)
        rows = list(rows)
        if rows or of in (joints, supports):
            written.append(write(os.path.join(folder, f"{of.__name__}.csv"), header, rows))
    return written


def drawings(results, stages=None, folder=None):
    """Paths of <stage>.dxf: section with displacements or mechanism."""
    written = []
    for name in stages or results.stages:
        written.append(os.path.join(folder or results.folder, f"{name}.dxf"))
        write_file(written[-1], dxf.drawing(results, name))
    return written


def paraview(results, folder=None):
    """Path of a copy of paraview_state.py that knows where the run is."""
    path = os.path.join(folder or results.folder, "paraview_state.py")
    with open(paraview_state.__file__, encoding="utf-8") as file:
        write_file(path, file.read().replace('FOLDER = ""', f"FOLDER = {os.path.abspath(results.folder)!r}", 1))
    return [path]


def main(arguments=None):
    parser = Parser(prog="quoin export", description="Results of a run as CSV, or as drawings.")
    parser.add_argument("folder", help="output folder of a run")
    parser.add_argument("--stage", action="append", metavar="NAME", help="this stage only (again for more); default: all")
    parser.add_argument("--to", metavar="FOLDER", help="where to write; default: the output folder")
    parser.add_argument("--dxf", action="store_true", help="drawings in place of tables: <stage>.dxf, section and mechanism")
    parser.add_argument("--paraview", action="store_true", help="paraview_state.py in place of tables: ParaView opens the run with it")
    options = parser.parse_args(arguments)
    try:
        results = Results(options.folder)
        made = paraview(results, options.to) if options.paraview else (drawings if options.dxf else export)(results, options.stage, options.to)
    except (ResultsError, OSError) as error:
        print(f"export: {words_of(error)}", file=sys.stderr)
        return 2
    print("\n".join(made))
    return 0
