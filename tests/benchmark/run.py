"""Cost of a cycle: nanoseconds and instructions per element and contact, ratios within one run.

    python tests/benchmark/run.py                              # table; sides 32 and 316, 1 and 2 ranks
    python tests/benchmark/run.py --sides 32 316 1000 --json build/benchmark.json
    python tests/benchmark/run.py --instructions               # counts under valgrind
    python tests/benchmark/run.py --exchange                   # what ranks tell each other, in two ways
    python tests/benchmark/run.py --check                      # every kernel against limits.json: exit code 1 over one, 77 with another compiler

Scenes: one for every kernel, a row of SCENES each. `block`: one body of side x side distorted quadrilaterals; `t2pt`,
`tptm`: single quadrilaterals with joints all around, about side^2 contacts, all elastic. All are shaken, so that joints
without tensile strength are open by half, in no order: `tptm open` with cohesion that breaks, those that slide with hardly
any friction where they are closed. STEPS are scenes of which the program itself runs a stage in time; counted are the instructions of its
steps, energy account and all. Times are the least of many samples of processor time: caches and memory are shared with
what else the machine does: trust the ratios. SOLVED are scenes of which a static stage by Newton's method is counted, all of it.
Instructions are exact for one compiler; under valgrind the x86-64-v3 code runs."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools")]

from driver import ENVIRONMENT, dump  # noqa: E402
from quoin_tools.mesh.blockmesh import write  # noqa: E402
from quoin_tools.mesh.meshing import rectangle, split_triangles  # noqa: E402
from quoin_tools.mesh.stacks import block_grid, two_bodies  # noqa: E402

LIMITS = HERE / "limits.json"
SHAKE = 2e-6  # m
NOT_JUDGED = 77  # exit code that CTest shows as skipped
# counts that the parts of bench_cycle are of
PARTS = {"textbook": "n_elements", "update": "n_elements", "elements": "n_elements", "plain": "n_contacts", "contacts": "n_contacts",
         "motion": "n_vertices", "rigid": "n_bodies", "condensed": "n_entries", "laws": "n_elements",
         "cycle": "n_elements"}  # fmt: skip


def block(side):
    """A square of 100 m, inner vertices moved by up to a tenth of a block."""
    mesh = rectangle(0.0, 0.0, 100.0, 100.0, side, side)
    inner = np.all((mesh.vertices > 1e-6) & (mesh.vertices < 100.0 - 1e-6), axis=1)
    mesh.vertices[inner] += np.random.default_rng(1).uniform(-10.0 / side, 10.0 / side, (inner.sum(), 2))
    return mesh


def triangles(side):
    return split_triangles(block(side))


def single(side):
    return block_grid(round(side / 2**0.5), round(side / 2**0.5), 1, 1)


def halves(side):
    """Two bodies that meet in `side` vertices each."""
    return block_grid(1, 2, side - 1, side // 4)


def uneven(side):
    """Two bodies whose faces do not match, about side^2 contacts."""
    return two_bodies(round(0.4 * side**2), round(0.6 * side**2), 1, 1, size=float(side**2))


def few(side):
    """A sixteenth of the blocks."""
    return block(side // 4)


STEEL = {"area": 1e-3, "young": 200e9, "spacing": 10}


def tendons():
    """Ten for each of 64 blocks, all of which work; a block alone, of which there are few here, takes 265."""
    ends = np.random.default_rng(2).uniform([5, 60, 5, 5], [95, 95, 95, 40], (640, 4)).tolist()
    return {f"a{i}": STEEL | {"head": end[:2], "root": end[2:], "compression": True} for i, end in enumerate(ends)}


def bars():
    """Ten pieces for each of 64 blocks."""
    return {f"b{i}": STEEL | {"head": [2, y], "root": [98, y + 1], "bond_stiffness": 1e7, "segment": 2.4001} for i, y in enumerate(np.linspace(10, 90, 16).tolist())}


def long_bars():
    """Two through both bodies of `halves`, 2000 pieces for 496 blocks: the stiffness of a bar is dense over its own scale, not over the bar."""
    return {f"l{i}": STEEL | {"head": [x, 0.02], "root": [x + 0.01, 1.98], "bond_stiffness": 5e12, "segment": 0.00196} for i, x in enumerate((0.3, 0.6))}


ELASTIC = {"cohesion": 1e9, "tension": 1e9}  # without tensile strength a sixth is open at side 32
SLIDES = {"friction": 1}
DYNAMIC = {"stages": [{"all": {"type": "dynamic", "loads": ["weight"]}}]}
STRONG = {"law": "mohr_coulomb", "cohesion": 1e9, "friction": 45, "tension": 1e8}  # nothing of it yields
SCENES = {  # mesh; keys of materials, joints and the scene that differ
    "block": (block, {}, {}, {}),
    "block small": (block, {}, {}, {"strain": "small"}),
    "bending": (block, {"element": "bending"}, {}, {}),
    "bending small": (block, {"element": "bending"}, {}, {"strain": "small"}),
    "reduced": (block, {"element": "reduced"}, {}, {}),
    "triangles": (triangles, {}, {}, {}),
    "strong": (block, STRONG, {}, {}),
    "yields": (block, STRONG | {"cohesion": 0, "friction": 1, "dilation": 0, "tension": 0}, {}, {}),
    "whole": (block, {"law": "damage", "tension": 1e9, "fracture_energy": 1e12}, {}, {}),
    "cracks": (block, {"law": "damage", "tension": 1e2, "fracture_energy": 1e2}, {}, {}),
    "strong triangles": (triangles, STRONG, {}, {}),
    "triangles small": (triangles, {}, {}, {"strain": "small"}),
    "rigid": (single, {"rigid": True}, ELASTIC, {}),
    "condensed": (halves, {"condensed": True}, ELASTIC, {}),
    "t2pt": (single, {}, ELASTIC | {"stress_model": "t2pt"}, {}),
    "tptm": (single, {}, ELASTIC, {}),
    "tptm uneven": (uneven, {}, ELASTIC, {}),
    **{f"{model} slides": (single, {}, SLIDES | {"stress_model": model}, {}) for model in ("pt", "r2pt", "r3pt", "t2pt", "t3pt", "tptm")},
    "tptm open": (single, {}, {"cohesion": 1e9}, {}),
    "tptm in time": (single, {}, SLIDES, DYNAMIC),
}
MOVED = {"strain": "large", "motions": {"quake": {"file": "quake.csv", "direction": "x"}},
         "supports": {"bottom": {"fix": "xy", "motion": "quake"}},
         "stages": [{"all": {"type": "dynamic", "loads": [], "alpha": 1.0, "duration": 0.2, "dt_factor": 0.5}}]}  # fmt: skip
STEPS = {  # as SCENES
    "block in time": (block, {}, {}, MOVED),
    "block on quiet ground": (block, {}, {}, MOVED | {"supports": {"bottom": {"fix": "xy", "motion": "quake", "boundary": "quiet"}}}),
    "block with water": (block, {}, {}, MOVED | {"loads": {"water": {"type": "added_mass", "faces": "left", "level": 100}},
                                           "stages": [{"all": MOVED["stages"][0]["all"] | {"loads": ["water"]}}]}),
    "single in time": (single, {}, ELASTIC, MOVED),
    "tendons": (few, {}, {}, MOVED | {"anchors": tendons()}),
    "grouted bars": (few, {}, {}, MOVED | {"anchors": bars()}),
}  # fmt: skip
NEWTON = {"relaxation": {"method": "preconditioned"}}
SOLVED = {  # as SCENES
    "two bodies by Newton": (halves, {}, {}, NEWTON),
    "two tendons by Newton": (halves, {}, {}, NEWTON | {"anchors": {name: STEEL | {"head": [x, 1.9], "root": [x, 0.1]} for name, x in (("t", 0.3), ("u", 0.6))}}),
    "long bars by Newton": (halves, {}, {}, NEWTON | {"anchors": long_bars()}),
}
CYCLES = ["block", "t2pt", "tptm", "tptm open"]  # those of the table of cycles


def prepared(folder, name, side, file="scene.yaml", **keys):
    """Writes mesh and scene into the folder; keys: more of the scene."""
    make, material, joint, other = (SCENES | STEPS | SOLVED)[name]
    mesh, model = make(side), file.replace(".yaml", ".h5")
    scene = {"model": model,
             "materials": {g: {"density": 2400, "young": 10e9, "poisson": 0.2} | material for g in mesh.group_names},
             "supports": {"bottom": {"fix": "xy"}},
             "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 35, "stress_model": "tptm"} | joint},
             "loads": {"weight": {"type": "self_weight"}}, "stages": [{"all": {"loads": ["weight"]}}]}  # fmt: skip
    write(os.path.join(folder, model), mesh)
    Path(folder, file).write_text(dump(scene | other | keys), encoding="utf-8")


def measure(program, name, side, ranks, seconds, **keys):
    """Nanoseconds of each part, and counts, as bench_cycle prints them; keys: more of the scene."""
    with tempfile.TemporaryDirectory() as folder:
        prepared(folder, name, side, **keys)
        command = [program, "scene.yaml", str(seconds), str(SHAKE)]
        if ranks > 1:
            bind = "core" if ranks == 2 == os.cpu_count() else "none"  # a rank to a core, where there are no more of them
            command = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", "--bind-to", bind, *command]
        environment = dict(os.environ) | ENVIRONMENT | {"OMPI_MCA_mpi_yield_when_idle": "0"}
        result = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        if result.returncode:
            raise SystemExit(f"{name}, side {side}, {ranks} ranks: {result.stderr[-2000:]}")
        return {"scene": name, "side": side} | json.loads(result.stdout.splitlines()[-1])


def instructions(program, names, side=32):
    """Rows of instructions of one call of each part, x86-64-v3 code, exact; all scenes in one run, which starts slowly."""
    with tempfile.TemporaryDirectory() as folder:
        files = [f"{i}.yaml" for i in range(len(names))]
        for name, file in zip(names, files):
            prepared(folder, name, side, file)
        command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=counts", "--collect-atstart=no", "--toggle-collect=Measure*",
                   *(f"--dump-after=Measure{part.capitalize()}" for part in PARTS), program, ",".join(files), "0", str(SHAKE)]  # fmt: skip
        result = subprocess.run(command, cwd=folder, env=dict(os.environ) | ENVIRONMENT, capture_output=True, text=True, check=False)
        if result.returncode:
            raise SystemExit(f"{', '.join(names)}: {result.stderr[-2000:]}")
        rows = [{"scene": name, "side": side} | json.loads(line) for name, line in zip(names, result.stdout.splitlines()[-len(names):])]
        for i in range(len(names) * len(PARTS)):  # a file for each part of the first scene, then of the next ...
            lines = dict(line.split(": ", 1) for line in Path(folder, f"counts.{i + 1}").read_text().splitlines() if ": " in line)
            rows[i // len(PARTS)][lines["desc"].split("Measure")[1].lower()] = int(lines["totals"])
        return rows


def steps(program, name, side=32):
    """Instructions of a step of a stage in time per block, counted within the function that makes one; of SOLVED those of all Newton's method."""
    function = "NewtonRelax" if name in SOLVED else "cycle"
    with tempfile.TemporaryDirectory() as folder:
        prepared(folder, name, side)
        Path(folder, "quake.csv").write_text("0, 0\n0.05, 3\n0.15, -3\n0.2, 0\n", encoding="utf-8")
        command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=counts", f"--toggle-collect={function}", program, "-options_file", "scene.yaml",
                   "-output", "out", "-relaxation_history_every", "1000000"]  # fmt: skip
        result = subprocess.run(command, cwd=folder, env=dict(os.environ) | ENVIRONMENT, capture_output=True, text=True, check=False)
        if result.returncode:
            raise SystemExit(f"{name}: {result.stdout[-2000:]}{result.stderr[-2000:]}")
        summary = json.loads(Path(folder, "out", "summary.json").read_text(encoding="utf-8"))
        counts = dict(line.split(": ", 1) for line in Path(folder, "counts").read_text().splitlines() if ": " in line)
        return int(counts["totals"]) / (1 if name in SOLVED else summary["stages"][0]["cycles"]) / summary["n_blocks"]


def least(row, part):
    """Of the samples of a time, the one that others on the machine disturbed least; a count as it is."""
    return row[f"{part}_least"] or row[part] if f"{part}_least" in row else row[part]


def per_item(row):
    """Each part per element, contact, vertex, body or entry of a matrix; a cycle per element."""
    return {part: least(row, part) / max(1, row[count]) for part, count in PARTS.items() if row.get(part)}


def header(unit):
    print(f"{'':41s}{unit} per element{'':16s}{unit} per contact{'':16s}{unit} of a cycle per element\n"
          f"{'scene':15s} {'elements':>8s} {'contacts':>8s} {'ranks':>5s} {'textbook':>9s} {'elements':>9s} {'ratio':>6s}"
          f" {'plain':>9s} {'contacts':>9s} {'ratio':>6s} {'textbook':>9s} {'cycle':>9s} {'ratio':>6s}", flush=True)


def show(row):
    per, joints = per_item(row), row["n_contacts"] > 0
    contacts = (f"{per['plain']:9.2f} {per['contacts']:9.2f} {per['contacts'] / per['plain']:6.2f}" if joints
                else f"{'-':>9s} {'-':>9s} {'-':>6s}")
    textbook = per["textbook"] + per["update"]
    cycle = (f"{'-':>9s} {per['cycle']:9.2f} {'-':>6s}" if joints
             else f"{textbook:9.2f} {per['cycle']:9.2f} {textbook / per['cycle']:6.2f}")
    print(f"{row['scene']:15s} {row['n_elements']:8d} {row['n_contacts']:8d} {row['ranks']:5d} {per['textbook']:9.2f} "
          f"{per['elements']:9.2f} {per['textbook'] / per['elements']:6.2f} {contacts} {cycle}", flush=True)
    return row


def exchange(program, sides, ranks, seconds):
    """A cycle of one body and what ranks tell each other in it: through shared memory and by messages."""
    print(f"{'blocks':>8s} {'ranks':>5s} {'':14s} {'exchange':>9s} {'sums':>9s} {'cycle':>9s} us")
    rows = []
    for side in sides:
        for n in (n for n in ranks if n > 1):
            for how in ("auto", "messages"):
                row = measure(program, "block", side, n, seconds, exchange=how)
                print(f"{row['n_elements']:8d} {n:5d} {'shared memory' if how == 'auto' else how:14s} {row['exchange'] / 1e3:9.2f} "
                      f"{row['sums'] / 1e3:9.2f} {row['cycle'] / 1e3:9.2f}", flush=True)
                rows.append(row | {"how": how})
    return rows


def check(program):
    """Counts against limits.json, which has every scene and is set with one compiler; the names of those that are over, None with another
    compiler, whose counts are printed beside the limits. In the short form (QUOIN_SHORT=1) the kernels alone, in one run; not the stages
    in time and by Newton's method, each of which is a run of its own."""
    limits, over = json.loads(LIMITS.read_text(encoding="utf-8")), []
    known = limits.pop("compiler")
    if limits.keys() != (SCENES | STEPS | SOLVED).keys():
        raise SystemExit(f"{LIMITS}: scenes {', '.join(limits.keys() ^ (SCENES | STEPS | SOLVED).keys())}: either no limit or no such scene")
    rows = instructions(program, list(SCENES))
    found = [(row["scene"], per_item(row)) for row in rows]
    if not os.environ.get("QUOIN_SHORT"):
        found += [(name, {"step": steps(str(Path(program).parent.parent / "quoin"), name)}) for name in STEPS | SOLVED]
    for name, per in found:
        for part, limit in limits[name].items():
            print(f"{name:21s} {part:9s} {per[part]:8.2f} instructions, limit {limit:8.2f}  "
                  f"{'ok' if per[part] <= limit else 'OVER'}", flush=True)
            over += [f"{name} {part}"] if per[part] > limit else []
    if rows[0]["compiler"] != known:
        print(f"not judged: the limits are those of {known}, and {rows[0]['compiler']} has compiled this program")
        return None
    return over


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=str(ROOT / "build" / "tests" / "bench_cycle"))
    parser.add_argument("--scenes", nargs="+", default=CYCLES, choices=list(SCENES))
    parser.add_argument("--sides", type=int, nargs="+", default=[32, 316])
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--seconds", type=float, default=0.3, help="for each measurement")
    parser.add_argument("--instructions", action="store_true", help="counts under valgrind, side 32, one rank")
    parser.add_argument("--exchange", action="store_true", help="what ranks tell each other, and nothing else")
    parser.add_argument("--check", action="store_true", help="counts against limits.json; exit code 1 over one")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    if options.check:
        over = check(program)
        sys.exit(NOT_JUDGED if over is None else bool(over))
    if options.exchange:
        rows = exchange(program, options.sides, options.ranks, options.seconds)
    elif options.instructions:
        header("instr.")
        rows = [show(row) for row in instructions(program, options.scenes)]
    else:
        header("ns")
        rows = [show(measure(program, name, side, ranks, options.seconds))
                for name in options.scenes for side in options.sides for ranks in options.ranks]
    if options.json:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
