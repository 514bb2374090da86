#!/usr/bin/env python3
"""The default against the best: processor time and error of what a scene gets that says nothing of its method, beside every other way.

    PYTHONPATH=tools python tests/benchmark/best.py --quoin build/quoin                    # every scene: an hour with the references, 20 minutes without
    PYTHONPATH=tools python tests/benchmark/best.py --quoin build/quoin --only S1 Wall     # scenes whose names hold one of these
    PYTHONPATH=tools python tests/benchmark/best.py --quoin build/quoin --large            # 7776 and 20 032 stones too
    PYTHONPATH=tools python tests/benchmark/best.py --quoin build/quoin --short            # three tiny scenes; exit code 1 where the default is not right
    PYTHONPATH=tools python tests/benchmark/best.py --draw                                 # table and chart alone, from the data

Ways: what the schema of the program lists for relaxation.method and contact.connectivity, bodies condensed or not, shorter ramps; in time
dt_factor. Seconds are processor time of the whole process on one rank, the least of three runs below a second where a way is among the fastest, ways in turn. Error: the
largest, over the static stages, of the difference of displacements over the largest displacement, and of the forces of joints over their sum;
of trials the gap between brackets, over the value; in time of the histories of the points, over the largest range of one. It is against explicit cycles whose
tolerance is tighter by 100, with a ramp ten times as long (or as long, where that finds no end within --reference seconds), with variable
connectivity where fixed contacts collapse, or against statics. Scenes of static stages alone have stiffness_mass with a ramp four times as long beside it. An
answer in which slip was kept as it came counts only where there is no other: friction did not follow its law. `Unsure` is how much the references
that count differ: where it is above 0.5 %, friction has several equilibria.
The best way is the fastest of those with the verdict of the reference and an error below 0.5 %, or below `unsure`. One that warns where the default
does not is none: its user would not trust it. A way is stopped after 2.2
times the seconds of the default (1 s at least; 30 s where the default is not right), and the default after --limit.
A scene whose rows are of this program is left out (--again: not). References stay in build/best.
Writes docs/data/best.json after each scene, the table of docs/generated/benchmarks.md and docs/img/best.png."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Lock

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "tests" / "verification"), str(ROOT / "tools"), str(ROOT / "tests" / "benchmark")]

from best_scenes import scenes  # noqa: E402
from driver import ENVIRONMENT, VERDICTS  # noqa: E402
from quoin_tools.base.files import save_figure  # noqa: E402
from quoin_tools.base.results import Results  # noqa: E402
from record import DATA, DOCS, keep, replace_between, table  # noqa: E402

RIGHT = 0.005  # error of an answer that is right
BAND = 2.0  # the default may take so many times the seconds of the best
NOISE = 0.02  # [s] by which two runs of a process differ
TRIALS = ("strength_reduction", "flood", "load_factor", "anchor_force")
SHORT, CLOSE = 1.0, 1.3  # [s] below which a run is repeated, where it took so many times the best at most
LADDER = ((100, 10), (100, 1), (10, 1))  # of references: tolerance over, ramp times
SLIP_KEPT = "slip kept as it came"  # in the evidence of a stage whose friction did not follow its law to the end
KEPT = ROOT / "build" / "best"


# ---- a run

def run(command, folder, limit):
    """Exit code (None: stopped at the limit), processor seconds, whether it warned."""
    command = ["sh", "-c", f'ulimit -t {int(np.ceil(limit))}; exec "$@"', "sh", *command]
    with open(folder / "printed", "w", encoding="utf-8") as printed:
        process = subprocess.Popen(command, cwd=folder, env=os.environ | ENVIRONMENT, stdout=printed, stderr=printed)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = code = os.waitstatus_to_exitcode(status)
    told = (folder / "printed").read_text(encoding="utf-8", errors="replace")
    seconds = usage.ru_utime + usage.ru_stime
    return (None, seconds, False) if code in (-9, -24) else (code, seconds, "warning" in told)


def answer(folder, code):
    """What a run says: its verdict, fields and forces of static stages, brackets of trials, histories of the points in time."""
    found = {"verdict": VERDICTS.get(code, f"exit code {code}"), "fields": {}, "forces": {}, "brackets": {}, "motions": {}, "method": "", "lawful": True}
    if code not in VERDICTS or code == 2:
        return found
    results = Results(str(folder / "out"))
    columns = {name: np.asarray(values, dtype=float) for name, values in results.history.items() if name == "time_s" or name.endswith(("ux_m", "uy_m"))}
    of_stage = np.asarray(results.history["stage"])
    methods = []
    for name in results.stages:
        stage = results.stage_summary(name)
        methods.append(stage.get("method", "in time"))
        found["lawful"] &= SLIP_KEPT not in stage.get("evidence", "")
        trial = next((stage[kind] for kind in TRIALS if kind in stage), None)
        if trial is not None:
            found["brackets"][name] = (trial["stable"], trial["failing"])
        elif stage["verdict"] == "completed":
            found["motions"][name] = {column: values[of_stage == name].tolist() for column, values in columns.items()}
        elif stage["verdict"] == "converged":
            found["fields"][name] = results.stage(name).displacement
            found["forces"][name] = {joint: (row["force"]["x"], row["force"]["y"]) for joint, row in stage.get("joints", {}).items() if "force" in row}
    found["method"] = "; ".join(dict.fromkeys(methods))
    return found


def gap(one, other):
    """Between brackets, over the value; ends that nothing was found for are open."""
    low, high = (sorted(end for end in bracket if end is not None) for bracket in (one, other))
    if not low or not high:
        return np.inf
    apart = max(low[0] - high[-1], high[0] - low[-1], 0.0)
    return apart / max(abs(np.mean(high)), 1e-300)


def error(found, right, exact):
    """The largest over stages and quantities; nan where the two have none in common."""
    errors = []
    for name in set(found["fields"]) & set(right["fields"]):
        one, other = found["fields"][name], right["fields"][name]
        if one.shape == other.shape and np.abs(other).max() > 0:
            errors.append(np.hypot(*(one - other).T).max() / np.hypot(*other.T).max())
        one, other = found["forces"].get(name, {}), right["forces"].get(name, {})
        size = sum(np.hypot(*force) for force in other.values())
        if size > 0:
            errors.append(sum(np.hypot(*np.subtract(one.get(joint, (0, 0)), other.get(joint, (0, 0)))) for joint in {*one, *other}) / size)
    for name in set(found["motions"]) & set(right["motions"]):
        one, other = found["motions"][name], right["motions"][name]
        points = [column for column in other if column != "time_s"]
        off = [np.abs(np.interp(other["time_s"], one["time_s"], one[column]) - other[column]).max() for column in points]
        errors.append(max(off) / max(np.ptp(other[column]) for column in points) if points else np.nan)
    for name, bracket in found["brackets"].items():
        known = (exact[name], exact[name]) if name in exact else right["brackets"].get(name)
        if known is not None:
            errors.append(gap(bracket, known))
    return max(errors, default=np.nan)


# ---- ways

def enumeration(program, *path):
    """Values of a key and its default, of the schema."""
    key = json.loads(subprocess.run([program, "-schema"], capture_output=True, text=True, check=True, env=os.environ | ENVIRONMENT).stdout)
    for name in path:
        key = key["properties"][name]
    return next(part["enum"] for part in key["allOf"] if "enum" in part), key["default"]


def can_vary(scene):
    """Whether it leaves connectivity open, and its strain allows it to be variable."""
    keys = scene.keys()
    return "connectivity" not in keys.get("contact", {}) and keys.get("strain", "large") == "large"


def ways_of(scene, program):
    """{name: options}, the default first."""
    methods, method = enumeration(program, "relaxation", "method")
    connectivities, connectivity = enumeration(program, "contact", "connectivity")
    types = scene.types()
    methods = [name for name in methods if name != method]
    by = {name: ("-relaxation_method", name) for name in methods}
    ways = {"default": ()} | by
    if can_vary(scene):
        for kind in connectivities:
            if kind == connectivity:
                continue
            words = ("-contact_connectivity", kind)
            ways |= {f"{kind} connectivity": words} | {f"{name}, {kind} connectivity": (*options, *words) for name, options in by.items() if kind == "variable" and name == "stiffness_mass"}
    condensed = tuple(word for group in scene.condensable() for word in (f"-materials_{group}_condensed", "true"))
    if condensed and "dynamic" not in types:
        ways |= {"condensed": condensed} | {f"{name}, condensed": (*options, *condensed) for name, options in by.items()}
    if types & {"static", *TRIALS} and "dynamic" not in types and not any("ramp" in stage for _, stage in scene.run_stages()):
        ways |= {f"{name}, ramp of 200": (*by[name], "-relaxation_ramp", "200") for name in by if name in ("explicit", "stiffness_mass")}
    for name, stage in scene.run_stages():
        if stage.get("type") == "dynamic":
            ways |= {f"dt_factor: {factor}": (f"-stages_{name}_dt_factor", factor) for factor in ("0.9", "0.3", "0.1")}
    return ways


def named(way):
    """The name of a way in table and chart."""
    return way.replace("preconditioned", "Newton")


# ---- references

def reference(program, scene, words, folder, limit, kept):
    """The right answer, how it was found, and by how much references differ."""
    path = kept / f"{scene.name.replace(' ', '_')}.json"
    identity = json.dumps((scene.keys(), scene.options, scene.stages))
    if path.exists():
        known, right, how, unsure = json.loads(path.read_text(encoding="utf-8"))
        if known == identity:
            return right | {"fields": {name: np.array(field) for name, field in right["fields"].items()}}, how, unsure
    relaxation = scene.keys().get("relaxation", {})
    tolerance, ramp = float(relaxation.get("tolerance", 1e-6)), int(relaxation.get("ramp", 1000))
    in_time = [f"-stages_{name}_dt_factor" for name, stage in scene.run_stages() if stage.get("type") == "dynamic"]
    found, weak = [], []

    def fine(method, tighter, longer):
        return ("-relaxation_method", method, "-relaxation_tolerance", f"{tolerance / tighter:g}", "-relaxation_velocity_tolerance", "1e-7",
                "-relaxation_ramp", str(longer * ramp), "-relaxation_max_cycles", "3000000")  # fmt: skip

    for tighter, longer in LADDER:
        tighter = 10 if scene.types() & set(TRIALS) else tighter
        options = [*fine("explicit", tighter, longer), *(word for key in in_time for word in (key, "0.05"))]
        variable = ()
        code, seconds, _ = run([program, *words, *options], folder, limit)
        if VERDICTS.get(code) == "collapsed" and can_vary(scene):  # fixed connectivity may have been outgrown
            variable = ("-contact_connectivity", "variable")
            fallen = answer(folder, code)
            code, seconds, _ = run([program, *words, *options, *variable], folder, limit)
            if VERDICTS.get(code) not in ("converged", "collapsed"):
                weak.append((fallen, f"tolerance / {tighter}, ramp x {longer}; variable connectivity without an end"))
        how = f"tolerance / {tighter}, ramp x {longer}" + (", variable connectivity" if variable else "")
        print(f"{scene.name}: reference, {how}: {VERDICTS.get(code, 'stopped')}, {seconds:.1f} s", flush=True)
        if code is not None and VERDICTS.get(code) in ("converged", "collapsed"):
            found.append((answer(folder, code), how))
        if longer == 1 and (found or weak):
            break
    if found and scene.types() == {"static"}:
        code, seconds, _ = run([program, *words, *fine("stiffness_mass", 100, 4)], folder, limit)
        print(f"{scene.name}: reference, stiffness_mass: {VERDICTS.get(code, 'stopped')}, {seconds:.1f} s", flush=True)
        if VERDICTS.get(code) in ("converged", "collapsed"):
            found.append((answer(folder, code), "stiffness_mass, tolerance / 100, ramp x 4"))
    right, how, unsure = chosen(found + weak)
    kept.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps((identity, right, how, unsure), default=np.ndarray.tolist), encoding="utf-8")
    return right, how, unsure


def chosen(found):
    """The reference of those found [(answer, how)], and by how much they differ: the first by the law of friction, beside all others by the law; else the first of all."""
    counted = [each for each in found if each[0]["lawful"]] or found
    if not counted:
        return {"verdict": "", "fields": {}, "forces": {}, "brackets": {}, "motions": {}}, "none", np.nan
    right, how = counted[0]
    other = next(((answer, way) for answer, way in counted[1:] if answer["verdict"] != right["verdict"]), None)
    if other:
        return right, f"{how}; {other[1]}: {other[0]['verdict']}", np.inf
    return right, how, max((error(answer, right, {}) for answer, _ in counted[1:]), default=np.nan)


# ---- a scene

def measure(program, scene, options, kept=KEPT):
    """A row for each way."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        words = scene.prepare(folder)
        right, how, unsure = reference(program, scene, words, folder, options.reference, kept)
        if options.only_references:
            return []
        ways, rows, limit = ways_of(scene, program), {}, options.limit
        for turn in range(1 if scene.kind == "short" else 3):
            least = best_of(list(rows.values())) or rows.get("default")
            for way, keys in ways.items():
                if turn and (rows[way]["seconds"] > SHORT or way != "default" and rows[way]["seconds"] > CLOSE * least["seconds"]):
                    continue
                code, seconds, warned = run([program, *words, *keys], folder, limit)
                if turn:
                    rows[way]["seconds"] = min(rows[way]["seconds"], seconds)
                    continue
                found = answer(folder, code) if code is not None else None
                off = error(found, right, scene.exact) if found else np.nan
                rows[way] = {"scene": scene.name, "way": way, "keys": " ".join(keys), "seconds": seconds, "stopped": code is None,
                             "verdict": found["verdict"] if found else "stopped", "error": finite(off), "method": found["method"] if found else "",
                             "warned": warned, "right_verdict": right["verdict"], "reference": how, "unsure": finite(unsure),
                             "brackets": found["brackets"] if found else {}, "right_brackets": right["brackets"]}  # fmt: skip
                if way == "default":
                    limit = min(limit, max(1.0 if is_right(rows[way]) else 30.0, 2.2 * seconds))
    best = best_of(list(rows.values()))
    default = rows["default"]
    print(f"{scene.name}: default {default['seconds']:.2f} s, {default['verdict']}, off {percent(default['error'])}; best "
          + (f"{named(best['way'])}, {best['seconds']:.2f} s, off {percent(best['error'])}" if best else "none"), flush=True)  # fmt: skip
    return list(rows.values())


def finite(value):
    return float(value) if np.isfinite(value) else None


def percent(value):
    return "-" if value is None else f"{100 * value:.2g} %"


def is_right(row):
    """Whether verdict and answer are those of the reference, or within what references differ by."""
    if row["stopped"] or row["verdict"] not in ("converged", "collapsed"):
        return False
    if row["right_verdict"] and row["verdict"] != row["right_verdict"]:
        return False
    return row["error"] is None or row["error"] <= max(RIGHT, row["unsure"] or 0.0)


def best_of(rows):
    """The fastest that is right, and warns of nothing where the default does not; the default where that is faster by noise alone."""
    quiet = any(row["way"] == "default" and is_right(row) and not row["warned"] for row in rows)
    good = [row for row in rows if is_right(row) and not (quiet and row["warned"])]
    best = min(good, key=lambda row: row["seconds"], default=None)
    return good[0] if best and good[0]["way"] == "default" and good[0]["seconds"] < best["seconds"] + NOISE else best


def ratio_of(default, best):
    """Seconds of the default over those of the best."""
    return default["seconds"] / best["seconds"]


# ---- table and chart

def of_bracket(bracket):
    stable, failing = (f"{end:.5g}" if end is not None else "none" for end in bracket)
    return f"stands at {stable}, fails at {failing}"


def remark(default, rows):
    """What a reader has to know of the default."""
    said = []
    if default["stopped"]:
        said.append("stopped")
    elif default["right_verdict"] and default["verdict"] != default["right_verdict"]:
        said.append(f"**verdict {default['verdict']}**, reference {default['right_verdict']}")
    others = sorted({row["verdict"] for row in rows if row["verdict"] in ("converged", "collapsed", "undecided", "diverged") and row["verdict"] != default["verdict"]})
    for verdict in others:
        ways = [named(row["way"]) for row in rows if row["verdict"] == verdict]
        said.append(f"{verdict}: " + (", ".join(ways) if len(ways) < 4 else f"{len(ways)} ways"))
    if default["error"] is not None and default["error"] > RIGHT:
        said.append(("error told by a warning" if default["warned"] else "**error not told**") if default["error"] > (default["unsure"] or 0.0) else "")
        for name, bracket in default["brackets"].items():
            known = default.get("right_brackets", {}).get(name)
            said += [f"{name}: {of_bracket(bracket)}, reference {of_bracket(known)}"] if known and gap(bracket, known) > RIGHT else []
    if default["unsure"] is not None and default["unsure"] > RIGHT:
        said.append(f"several equilibria: references differ by {percent(default['unsure'])}")
    return "; ".join(word for word in said if word)


def by_scene(rows):
    order = {scene.name: i for i, scene in enumerate(scenes(("short", "usual", "large")))}
    names = sorted(dict.fromkeys(row["scene"] for row in rows), key=lambda name: order.get(name, len(order)))
    return {name: [row for row in rows if row["scene"] == name] for name in names}


HEAD = ["scene", "default ran", "time [s]", "error [%]", "best way", "time [s]", "error [%]", "default / best", "remark"]


def cells(rows):
    default, best = rows[0], best_of(rows)
    time = f"{'> ' if default['stopped'] else ''}{default['seconds']:.2f}"
    off = [percent(row["error"]).removesuffix(" %") if row else "" for row in (default, best)]
    beside = [named(best["way"]), f"{best['seconds']:.2f}", off[1], f"{ratio_of(default, best):.1f}"] if best else ["none", "", "", ""]
    if best and ratio_of(default, best) > BAND:
        beside[3] = f"**{beside[3]}**"
    return [rows[0]["scene"], named(default["method"]), time, off[0], *beside, remark(default, rows)]


def summary(groups):
    pairs = [(rows[0], best_of(rows)) for rows in groups.values()]
    within = sum(best is not None and is_right(default) and ratio_of(default, best) <= BAND for default, best in pairs)
    wrong = [default["scene"] for default, _ in pairs if not is_right(default)]
    slow = [default["scene"] for default, best in pairs if best and is_right(default) and ratio_of(default, best) > BAND]
    lines = [f"Of {len(pairs)} scenes the default is right and within {BAND:g} times the best in {within}."]
    of = {}
    for default, _ in pairs:
        of.setdefault(default.get("program"), []).append(default["scene"])
    if len(of) > 1:
        older = [scene for mark, names in of.items() if mark != max(of, key=lambda mark: len(of[mark])) for scene in names]
        lines.append(f"Measured with another build than the others: {'; '.join(older)}.")
    if slow:
        lines.append(f"Right, but slower than that: {'; '.join(slow)}.")
    if wrong:
        lines.append(f"Another verdict, an error above {100 * RIGHT:g} %, or stopped: {'; '.join(wrong)}.")
    return "\n\n".join(lines) + "\n\n"


def draw(groups, path):
    """A line a scene: how many times the seconds of the best the default takes, beside it its error."""
    names = list(groups)[::-1]
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(11, 1.6 + 0.23 * len(names)), sharey=True, constrained_layout=True, width_ratios=(3, 2))
    left.axvspan(1 / BAND, BAND, color="#009e73", alpha=0.12, label="within 2 of the best")
    right.axvspan(1e-7, 100 * RIGHT, color="#009e73", alpha=0.12)
    for y, name in enumerate(names):
        default, best = groups[name][0], best_of(groups[name])
        good = is_right(default)
        if best:
            ratio = ratio_of(default, best)
            colour = "#d55e00" if ratio > BAND or not good else "#0072b2"
            left.plot([1, ratio], [y, y], color=colour, linewidth=1.2)
            left.plot(ratio, y, "o" if good else "X", color=colour, markersize=5)
            left.text(max(ratio, 1) * 1.12, y, f"{default['seconds']:.2g} s" + ("" if ratio <= 1 else f"; {named(best['way'])} {best['seconds']:.2g} s"), va="center", fontsize=6.5)
        else:
            left.text(1.1, y, f"{default['seconds']:.2g} s; no way is right", va="center", fontsize=6.5, color="#d55e00")
        if default["unsure"]:
            right.plot(np.clip(100 * default["unsure"], 1e-5, 100), y, "|", color="grey", markersize=8)
        if default["error"] is not None:
            right.plot(np.clip(100 * default["error"], 1e-5, 100), y, "o" if good else "X", color="#0072b2" if good else "#d55e00", markersize=5)
        else:
            right.text(2e-5, y, f"{default['verdict']}" + ("" if good else ", wrong"), va="center", fontsize=6.5, color="black" if good else "#d55e00")
    left.set_yticks(range(len(names)), names, fontsize=7)
    most = max([ratio_of(rows[0], best_of(rows)) for rows in groups.values() if best_of(rows)], default=1)
    left.set(xscale="log", xlim=(0.3, max(30, 12 * most)), ylim=(-0.8, len(names) - 0.2), xlabel="processor time of the default over that of the best way [-]")
    ticks = [tick for tick in (0.5, 1, 2, 5, 10, 20, 50, 100, 200) if tick <= max(30, 2 * most)]
    left.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    left.minorticks_off()
    right.set(xscale="log", xlim=(1e-5, 150), xlabel="error of the default [%]")
    marks = [pyplot.Line2D([], [], color="#0072b2", marker="o", linestyle="none", label="right"),
             pyplot.Line2D([], [], color="#d55e00", marker="o", linestyle="none", label="right, slower than 2 x the best"),
             pyplot.Line2D([], [], color="#d55e00", marker="X", linestyle="none", label="wrong verdict, or error > 0.5 %"),
             pyplot.Line2D([], [], color="grey", marker="|", linestyle="none", markersize=8, label="by how much references differ")]  # fmt: skip
    for axes in (left, right):
        axes.grid(axis="y", alpha=0.25)
        axes.grid(axis="x", alpha=0.15)
    figure.legend(handles=marks, loc="outside upper center", ncols=4, fontsize=8)
    save_figure(figure, path, dpi=130)


def written(rows, picture=True):
    groups = by_scene(rows)
    replace_between("best", summary(groups) + table(HEAD, map(cells, groups.values())))
    if picture:
        draw(groups, DOCS / "img" / "best.png")


def check(program, options):
    """Three tiny scenes: the default is right, the table and the chart are made; nothing is kept."""
    with tempfile.TemporaryDirectory() as folder:
        found = [row for scene in scenes(("short", )) for row in measure(program, scene, options, Path(folder))]
        groups = by_scene(found)
        print(summary(groups) + table(HEAD, map(cells, groups.values())))
        draw(groups, Path(folder) / "best.png")
        drawn = (Path(folder) / "best.png").stat().st_size > 10000
    return 0 if drawn and len(groups) == 3 and all(is_right(rows[0]) for rows in groups.values()) else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quoin", default=str(ROOT / "build" / "quoin"))
    parser.add_argument("--only", nargs="+", default=[""], help="scenes whose names hold one of these")
    parser.add_argument("--large", action="store_true", help="7776 and 20 032 stones, and reductions of 2003, too")
    parser.add_argument("--limit", type=float, default=120.0, help="[s] of processor time of the default (%(default)s)")
    parser.add_argument("--reference", type=float, default=200.0, help="[s] of each attempt at a reference (%(default)s)")
    parser.add_argument("--only-references", action="store_true", help="find them and end")
    parser.add_argument("--again", action="store_true", help="measure scenes that this program has rows of, too")
    parser.add_argument("--workers", type=int, default=1, help="scenes at a time (%(default)s)")
    parser.add_argument("--short", action="store_true", help="three tiny scenes; nothing is written")
    parser.add_argument("--draw", action="store_true", help="table and chart from the data")
    options = parser.parse_args()
    program = os.path.abspath(options.quoin)
    if options.short:
        return check(program, options)
    path = DATA / "best.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    if options.draw:
        return written(known)
    mark = f"{zlib.crc32(Path(program).read_bytes()):08x}"
    chosen = [scene for scene in scenes(("usual", "large") if options.large else ("usual", )) if any(word.lower() in scene.name.lower() for word in options.only)]
    done = {row["scene"] for row in known if row["program"] == mark and not options.again}
    lock, failed = Lock(), []

    def one(scene):
        if scene.name in done and not options.only_references:
            print(f"{scene.name}: kept", flush=True)
            return
        try:
            rows = [row | {"program": mark} for row in measure(program, scene, options)]
        except Exception as problem:
            failed.append(scene.name)
            print(f"{scene.name}: {type(problem).__name__}: {problem}", flush=True)
            return
        with lock:  # rows of ways that are no more go
            if rows:
                old = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
                path.write_text(json.dumps([row for row in old if row["scene"] != scene.name]), encoding="utf-8")
                written(keep("best", rows, ("scene", "way")), picture=False)

    with ThreadPoolExecutor(options.workers) as pool:
        list(pool.map(one, chosen))
    if path.exists() and not options.only_references:
        written(json.loads(path.read_text(encoding="utf-8")))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
