"""Compares two runs, stage by stage: what differs, by how much.

    quoin compare A B [--tolerance 1e-3] [--all]

Prints the numbers of summary.json that differ and the fields of results.h5 (--all: every one), those of anchors, bars, water, heat and yielded or cracked blocks too.
"The same bits": the checksum of the state, every such number and every array are. Exit code 0: the same stages and verdicts, and
every number within the tolerance (relative to the largest of its kind in the stage; factors and brackets of trials to themselves; fields by
their largest difference over their largest value); 1: not; 2: a folder cannot be read.
"""

import re
import sys

import numpy as np

from quoin_tools.base.command import Parser
from quoin_tools.base.files import reading
from quoin_tools.base.flow import LITRES
from quoin_tools.base.integrity import expecting
from quoin_tools.base.results import NO_SHEAR, Results, ResultsError
from quoin_tools.base.terminal import table

KINDS = (  # words, unit, factor, pattern of the path of the number
    ("displacement", "mm", 1e3, r"\.u_[xy]$|^peaks\.probes\..*\.(least|largest)$|^peaks\.joints\..*\.(slip|slip_largest|opening)\.(start|end|largest)$|^anchors\.[^.]+\.(elongation|plastic)$"),
    ("force", "kN", 1e-3, r"^(applied|reaction|supports\..*)\.[xy]$|\.[NT]$|^flow\.joints\..*\.uplift$"
     r"|^peaks\.(supports\..*|base_shear)\.[xy]\.(least|largest)$|^peaks\.joints\..*\.[NT]\.(least|largest)$|^anchors\.[^.]+\.(force|largest)$"),
    ("moment", "kN m", 1e-3, r"\.M$"),
    ("stress", "MPa", 1e-6, r"\.sigma_linear_(start|end)$|\bs[12]_(max|min)\.value$|\.sigma$"),
    ("length", "m", 1.0, r"[._]length$|^peaks\.joints\..*\.open_length\.largest$|^flow\.joints\..*\.centre_[xy]$"),
    ("discharge", "l/(min m)", LITRES, r"^flow\.inflow$|^flow\.conditions\..*\.discharge$"),
    ("aperture", "mm", 1e3, r"^flow\.joints\..*\.widest$"),
    ("factor", "", 1.0, r"\.(sliding_|safety_)?factor_[a-z]+$|^safety\..*\.value$|^peaks\..*\.factor_(peak|residual)\.least$"),
    ("angle", "deg", 1.0, r"\.friction_needed$"),
    ("temperature", "K", 1.0, r"^temperature\.(min|max)$"),
    ("bracket", "", 1.0, r"^(strength_reduction|flood|load_factor|anchor_force)\.(stable|failing)$"),
)
ALONE = ("factor", "bracket")  # kinds of which each number is held against itself: one large one would hide the others
TINY = {"displacement": 1e-9, "force": 1.0, "moment": 1.0, "stress": 1.0, "length": 1e-6, "factor": 1e-9, "angle": 1e-6, "bracket": 1e-9,
        "discharge": 1e-12, "aperture": 1e-9, "temperature": 1e-9, "number": 1e-12}  # fmt: skip


def kind_of(path):
    """Words, unit and factor; None for a number that is not compared."""
    return next((kind[:3] for kind in KINDS if re.search(kind[3], path)), None)


def numbers(stage, path=""):
    """Every number of a stage that has a kind: path to value; null is left out."""
    found = {}
    for key, value in stage.items():
        here = f"{path}.{key}" if path else key
        if isinstance(value, dict):
            found |= numbers(value, here)
        elif isinstance(value, (int, float)) and not isinstance(value, bool) and kind_of(here):
            found[here] = min(float(value), NO_SHEAR) if "sliding_factor" in key or (path.startswith("peaks.") and "factor_" in path) else float(value)
    return found


def fields(stage):
    """Arrays of a stage of results.h5: path to (array, kind)."""
    kinds = {kind[0]: kind[:3] for kind in KINDS}
    found = {"displacement": (stage.displacement, kinds["displacement"]), "stress": (stage.stress, kinds["stress"])}
    contacts = stage.contacts
    for name, kind in (("opening", "length"), ("sliding", "length"), ("sigma", "stress"), ("tau", "stress"), ("force", "force")):
        found[f"contacts.{name}"] = (getattr(contacts, name), kinds[kind])
    return {f"field {path}": value for path, value in found.items()}


def water(stage):
    """The same of the water in joints; empty where none flows."""
    kinds, flow = {kind[0]: kind[:3] for kind in KINDS}, stage.flow
    named = (("pressure", "stress"), ("aperture", "aperture"), ("discharge", "discharge"))
    return {} if flow is None else {f"field flow.{name}": (getattr(flow, name), kinds[kind]) for name, kind in named}


# more arrays of a stage, where it has them: pattern of the path in results.h5, kind; those that are not here (directions, places, states) only count as bits
MORE = (
    (r"anchors/force|bars/(force|bond)", "force"),
    (r"(anchors|bars)/(elongation|plastic|slip)|crack_width", "displacement"),
    (r"contacts/(slip|closure)", "length"),
    (r"temperature", "temperature"),
    (r"stress_z|envelope/.*(s1|s2|stress|sigma|tau).*", "stress"),
    (r"anchors/lost|lost|plastic_strain|damage|built|rotation|contacts/broken|flow/(head|saturation)|envelope/.*", "number"),
)


def arrays(run, name):
    """Every array of a stage: path in results.h5 to its values."""
    found = {}
    with expecting(run.path, "a complete results file"), reading(run.path) as file:
        file["stages"][name].visititems(lambda path, item: found.update({path: item[()]}) if hasattr(item, "shape") else None)
    return found


def more_fields(left, right):
    """Compares the fields of MORE, as compare_fields does; also returns the paths of all arrays that do not have the same bits."""
    kinds = {kind[0]: kind[:3] for kind in KINDS} | {"number": ("number", "", 1.0)}
    other = sorted(path for path in {*left, *right} if path not in left or path not in right or left[path].tobytes() != right[path].tobytes())
    rows = []
    for path in other:
        kind = next((kinds[kind] for pattern, kind in MORE if re.fullmatch(pattern, path)), None)
        if kind and path in left and path in right and left[path].shape == right[path].shape:
            rows += compare_fields({f"field {path.replace('/', '.')}": (left[path], kind)}, {f"field {path.replace('/', '.')}": (right[path], kind)})
        elif kind:
            rows.append((f"field {path.replace('/', '.')}", *(float(np.nanmax(np.abs(side[path]), initial=0.0)) if path in side else None for side in (left, right)), float("inf"), kind))
    return rows, other


def compare_fields(left, right):
    """Rows as those of compare_stage, of arrays that do not have the same bits: their largest size in each run. None where the runs have other
    blocks or contacts."""
    if left.keys() != right.keys() or any(left[path][0].shape != right[path][0].shape for path in left):
        return None
    rows = []
    for path, (x, kind) in left.items():
        y = right[path][0]
        if x.tobytes() == y.tobytes():
            continue
        sizes = [float(np.nanmax(np.abs(array), initial=0.0)) for array in (x, y)]
        apart = float(np.nanmax(np.abs(x - y), initial=0.0)) if np.array_equal(np.isnan(x), np.isnan(y)) else float("inf")
        rows.append((path, *sizes, apart / max(*sizes, TINY[kind[0]]), kind))
    return rows


def compare_stage(a, b):
    """Rows (path, a, b, difference over the size of its kind, kind); a or b None where one run has no such number."""
    left, right = numbers(a), numbers(b)
    sizes = dict(TINY)
    for path, value in [*left.items(), *right.items()]:
        kind = kind_of(path)[0]
        sizes[kind] = max(sizes[kind], abs(value))
    rows = []
    for path in dict.fromkeys([*left, *right]):
        pair, kind = (left.get(path), right.get(path)), kind_of(path)
        size = max(TINY[kind[0]], *(abs(x) for x in pair if x is not None)) if kind[0] in ALONE else sizes[kind[0]]
        relative = float("inf") if None in pair else abs(pair[1] - pair[0]) / size
        rows.append((path, *pair, relative, kind))
    return rows


def compare(a, b):
    """Rows by stage of two runs, lines about what is not a number and differs, and lines about what was not compared."""
    stages = [{s["name"]: s for s in run.summary["stages"]} for run in (a, b)]
    differences = [f"stage {name}: only in {'A' if name in stages[0] else 'B'}" for name in dict.fromkeys([*stages[0], *stages[1]])
            if not (name in stages[0] and name in stages[1])]  # fmt: skip
    rows, left_out = {}, []
    for name, s in stages[0].items():
        if name not in stages[1]:
            continue
        other = stages[1][name]
        if s["verdict"] != other["verdict"]:
            differences.append(f"stage {name}: verdict {s['verdict']} in A, {other['verdict']} in B")
        found, flowing = (compare_fields(of(a.stage(name)), of(b.stage(name))) for of in (fields, water))
        if found is None:
            left_out.append(f"stage {name}: other blocks or contacts are written: fields are not compared")
        if flowing is None:
            left_out.append(f"stage {name}: water flows in other pieces of joints: its fields are not compared")
        stage_rows = compare_stage(s, other)
        more, differing = more_fields(arrays(a, name), arrays(b, name)) if found is not None else ([], [])
        same = s["checksum"] == other["checksum"] and not any(row[3] for row in stage_rows) and not differing and found == [] and flowing == []
        rows[name] = [] if same else stage_rows + (found or []) + (flowing or []) + more
    return rows, differences, left_out


def printed(value, factor):
    return "-" if value is None else f"{value * factor:.6g}"


def text_of(rows, tolerance, everything):
    """Lines of the terminal, and whether all numbers are within the tolerance."""
    out, good = [], True
    for stage, all_rows in rows.items():
        beyond = [row for row in all_rows if row[3] > tolerance]
        good &= not beyond
        shown = all_rows if everything else beyond
        worst = max((row[3] for row in all_rows), default=0.0)
        what = "the same bits" if not all_rows else f"{len(beyond)} of {len(all_rows)} numbers beyond {tolerance:g}, largest {worst:.2e}"
        out += ["", f"Stage {stage}: {what}"]
        if shown:
            cells = [(path + (f" [{kind[1]}]" if kind[1] else ""), printed(a, kind[2]), printed(b, kind[2]),
                      printed(None if a is None or b is None else b - a, kind[2]), f"{relative:.2e}")
                     for path, a, b, relative, kind in shown]  # fmt: skip
            out += table(["number", "A", "B", "B - A", "relative"], cells)
    return out, good


def main(arguments=None):
    parser = Parser(prog="quoin compare", description="Two runs side by side.")
    parser.add_argument("a", help="output folder of a run")
    parser.add_argument("b", help="output folder of another run")
    parser.add_argument("--tolerance", type=float, default=1e-3, help="relative, %(default)g by default")
    parser.add_argument("--all", action="store_true", help="print numbers within the tolerance too")
    options = parser.parse_args(arguments)
    if not 0 <= options.tolerance < float("inf"):
        parser.error(f"--tolerance {options.tolerance:g}: expected 0 or more: a part of each number")
    try:
        runs = [Results(folder) for folder in (options.a, options.b)]
        rows, differences, left_out = compare(*runs)
    except ResultsError as error:
        print(f"compare: {error}", file=sys.stderr)
        return 2
    for letter, folder, summary in zip("AB", (options.a, options.b), (run.summary for run in runs)):
        print(f"{letter}: {folder}: {summary['title'] or summary['model']}, Quoin {summary['quoin']}")
    lines, good = text_of(rows, options.tolerance, options.all)
    print("\n".join(lines + [f"  {line}" for line in differences + left_out]))
    return 0 if good and not differences else 1
