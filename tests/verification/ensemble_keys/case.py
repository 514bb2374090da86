"""What may scatter in an ensemble: records of earthquakes by choice, against Newmark's block; each kind of key, in a shared process and in a process each."""

import json
import os
import re

import h5py
import numpy as np
import yaml
from cases.case import BASE, STONE
from cases.case import dam as dam_of
from cases.case import scene as scene_of
from ensembles.case import FRICTION, command, rows_of
from quoin_tools.ensemble.models import Solver
from quoin_tools.mesh.blockmesh import write
from quoin_tools.mesh.meshing import join, rectangle, renamed
from quoin_tools.show import ensemble_part

WHAT = "ensembles: records by choice, fragility over their largest acceleration; kinds of keys that scatter, in a shared process and a process each"
SOURCE = "Newmark: s = (A - a_c) A t0^2 / 2 a_c; the same samples in runs of their own"
BY = "closed form of Newmark, by hand; Quoin itself, runs of their own"


def run(case):
    os.environ["QUOIN_SOLVER"] = os.path.abspath(case.quoin)
    records(case)
    kinds_of_keys(case)


PULSES, PGAS = {"short.csv": 0.2, "long.csv": 0.4}, [4, 8]


def slid(values, pga):
    """Newmark's block on ground that a pulse of constant acceleration pushes. values: record, angle of friction."""
    yields = 9.81 * np.tan(np.radians(values[1]))
    return max(pga - yields, 0) * pga * PULSES[values[0]] ** 2 / (2 * yields)


def shaken(case):
    """A block on ground that is shaken by one of two records, with a friction that scatters; fails beyond 0.2 m."""
    folder = case.folder / "shaken"
    folder.mkdir(parents=True)
    rock, block = rectangle(-2, -1, 8, 1, group="rock", rigid=True), rectangle(0, 0, 1, 0.5, group="block", rigid=True)
    write(str(folder / "model.h5"), join([renamed(rock, {}), renamed(block, {"foot": "bottom"})]))
    for name, end in PULSES.items():
        (folder / name).write_text(f"0, 1\n{end}, 1\n{end + 1e-9}, 0\n2, 0\n", encoding="utf-8")
    scene = {
        "model": str(folder / "model.h5"),
        "materials": {"rock": {"density": 2400, "rigid": True}, "block": {"density": 2400, "rigid": True}},
        "joints": {"foot": {"k_n": 1e9, "k_s": 1e9, "friction": 30, "damping": 1e-4}},
        "motions": {"quake": {"file": str(folder / "short.csv"), "direction": "x", "pga": 4}},
        "supports": {"rock": {"fix": "xy", "motion": "quake"}},
        "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
        "stages": [{"rest": {"loads": ["weight"]}}, {"shake": {"type": "dynamic", "loads": ["weight"], "duration": 1.2}}],
    }
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene, sort_keys=False), encoding="utf-8")
    rows = {"motions.quake.file": {"distribution": "choice", "values": list(PULSES), "weights": [0.6, 0.4]}, "joints.foot.friction": FRICTION | {"mean": 0.5, "cov": 0.2, "min": 0.35}}
    wanted = {"scene": "scene.yaml", "samples": 4, "variables": rows, "fail": "abs(peaks.joints.foot.slip.largest) > 0.2", "levels": {"keys": ["motions.quake.pga"], "values": PGAS}}
    (folder / "ensemble.yaml").write_text(yaml.safe_dump(wanted, sort_keys=False), encoding="utf-8")
    return folder, wanted


def records(case):
    """Records by choice, each scaled to the largest acceleration of a level: slips by Newmark's formula, sample by sample."""
    folder, wanted = shaken(case)
    _, said = command(folder, "-o", str(folder / "out"), "-j", "2")
    _, found = rows_of(folder)
    rows = {key: found[key] for key in sorted(found)}
    case.check("records by choice: slip of each sample [m]", [row.response for row in rows.values()], [slid(row.values, row.level) for row in rows.values()], absolute=3e-3)
    case.check("... outcomes", [row.outcome for row in rows.values()], ["fails" if slid(row.values, row.level) > 0.2 else "stands" for row in rows.values()])
    found = json.loads((folder / "out/ensemble.json").read_text(encoding="utf-8"))
    counts = [[sum(row.values[0] == name and row.level == pga for row in rows.values()), sum(row.values[0] == name and row.level == pga and row.outcome == "fails" for row in rows.values())] for name in PULSES for pga in PGAS]
    case.check("... counted for each record and level, reported", [[c["n"], c["fails"]] for c in found["choices"]] + [sum(line.strip().startswith("motions.quake.file  ") for line in said.split("\n"))], [*counts, 4])
    with h5py.File(folder / "out/samples.h5") as file:
        case.check("... names in the table of samples", sorted(set(file["variables/motions.quake.file"].asstr()[:])), sorted(PULSES))
    case.check("... on the page of the sheet", f"<td>{PGAS[0]}</td>" in re.sub(' class="n"', "", (page := ensemble_part.ensemble_part(str(folder / "out")))) and "long.csv" in page, True)
    code, said = command(folder, "-o", str(folder / "again"), "--sample", "3")
    one = rows[3, float(PGAS[-1])]
    case.check("... one sample alone", [code, f"{one.response:.6g}" in said, one.values[0] in said], [{"stands": 0, "fails": 6}[one.outcome], True, True])
    (folder / "short.csv").write_text("0, 1\n0.3, 1\n0.300001, 0\n2, 0\n", encoding="utf-8")
    case.check("... rows of another record are refused", "rows of another ensemble" in message_of(folder), True)
    (folder / "ensemble.yaml").write_text(yaml.safe_dump(wanted | {"fail": "collapsed"}, sort_keys=False), encoding="utf-8")
    case.check("... a stage in time has no collapse", "stage shake goes in time" in message_of(folder, "none"), True)


def message_of(folder, output="out"):
    try:
        return command(folder, "-o", str(folder / output))[1]
    except ValueError as error:
        return str(error)


def between(low, high):
    return {"distribution": "uniform", "min": low, "max": high}


def kinds_of_keys(case):
    """Each kind of key changes the answer, in a shared process and in processes of their own; where both can be, rows are the same."""
    materials = {"rock": STONE, "low": STONE | {"law": "mohr_coulomb", "cohesion": 3e4, "friction": 30, "tension": 1e4}, "high": STONE}
    anchor = {"head": [1, 7.5], "root": [2, -3], "area": 2e-3, "young": 2e11, "prestress": 4e5, "lock": "full"}
    one = scene_of([*BASE, {"pushed": {"loads": ["weight", "water", "uplift", "push"]}}], materials=materials, anchors={"a": anchor}, relaxation={"tolerance": 1e-6, "method": "preconditioned"})
    one["loads"]["uplift"] = {"type": "uplift", "faces": "foot", "level": 6, "rule": "usace", "drain": 1.5, "efficiency": 0.5}
    shared = {"loads.uplift.efficiency": between(0, 0.6), "loads.uplift.drain": between(1, 3), "loads.water.level": between(5, 6.5), "loads.push.value[0]": between(3e4, 6e4),
              "anchors.a.prestress": between(2e5, 5e5), "anchors.a.area": between(1e-3, 3e-3), "joints.default.k_s": between(3e9, 5e9), "stages.pushed.joints.default.friction": between(30, 40)}  # fmt: skip
    apart = {"materials.low.density": between(2200, 2500), "materials.rock.young": between(5e9, 2e10), "materials.low.cohesion": between(2e4, 3e4), "anchors.a.head[0]": between(0.8, 1.5), "gravity": between(9.7, 9.9),
             "joints.default.stress_model": {"distribution": "choice", "values": ["tptm", "pt"]}, "loads.push.value": {"distribution": "choice", "values": ["6e4,0", "3e4,-1e3"]}}  # fmt: skip
    folder = case.folder / "keys"
    folder.mkdir(parents=True)
    write(str(folder / "model.h5"), dam_of())
    (folder / "scene.yaml").write_text(yaml.safe_dump(one | {"model": str(folder / "model.h5")}, sort_keys=False), encoding="utf-8")
    for rows, what in ((shared, "a shared process"), (apart, "a process each")):
        (folder / "ensemble.yaml").write_text(yaml.safe_dump({"scene": "scene.yaml", "samples": len(rows) + 2, "seed": 5, "method": "sobol_indices", "response": "max_displacement.value", "variables": rows}, sort_keys=False), encoding="utf-8")
        command(folder, "-o", str(folder / what.replace(" ", "_")), "-j", "2")
        wanted, found = rows_of(folder, what.replace(" ", "_"))
        case.check(f"keys of {what}: those that change nothing", [name for k, name in enumerate(rows) if found[k + 2, None].response in (None, found[0, None].response) and found[k + 2, None].values != found[0, None].values], [])
        if rows is shared:
            solver = Solver(wanted, str(folder / "alone"), shares=False)
            case.check("... rows that differ from those of a process each", [i for (i, _), row in found.items() if i % 3 == 0 and solver.judge(row.values, i, None) != (row.outcome, row.response, row.why)], [])
