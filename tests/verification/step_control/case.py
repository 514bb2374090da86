"""The step of a stage in time by itself (dt_factor: auto), and its account up to the end of the stage."""

import json

import numpy as np
from driver import changed
from quoin_tools.base.integrity import check_folder
from quoin_tools.base.results import ResultsError
from quoin_tools.mesh.meshing import join, rectangle, renamed, split_triangles

WHAT = "dt_factor: auto: short steps where blocks hit, the account across changes of the step and up to the end, ranks, restart"
SOURCE = "free fall; the account of a scheme that conserves energy: 0; the same motion at 0.01 of the bound; the run on one rank"
BY = "by hand; Quoin itself, a hundredth of the step"

G, RHO = 9.81, 2400.0
SCENE = {
    "gravity": G,
    "materials": {"block": {"density": RHO}, "base": {"density": RHO}},
    "joints": {"default": {"k_n": 1e9, "k_s": 1e9, "friction": 35, "damping": 5e-4}},
    "relaxation": {"allow_floating": True, "history_every": 1, "tolerance": 1e-8},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}
VARIABLE = ("contact", {"connectivity": "variable", "tolerance": 0.005})
ELASTIC = ("materials.block", {"density": RHO, "young": 5e9, "poisson": 0.2})


LONG = ("ranks_and_restart", "hits")  # parts that the short form leaves out


def run(case):
    up_to_the_end(case)
    across_changes(case)
    where_inertia_is_a_matrix(case)
    hits(case)
    slides(case)
    times(case)
    ranks_and_restart(case)
    after_the_last_step(case)
    one_step(case)
    words(case)
    history_lost(case)


def base():
    return renamed(rectangle(-2, -1, 6, 1, group="base", rigid=True), {})


def block(y, *cells, name="at", shape=None):
    cut = rectangle(0, y, 1, 0.5, *cells, group="block", rigid=not cells)
    return renamed(shape(cut) if shape else cut, {}, {name: "top_left", f"{name}_other": "bottom_right"})


def stages(duration, rests=True, **keys):
    return ("stages", ([{"rest": {"loads": ["weight"]}}] if rests else []) + [{"go": {"type": "dynamic", "loads": ["weight"], "duration": duration, "dt_factor": "auto"} | keys}])


def history(result, stage="go"):
    mine = result.history["stage"] == stage
    return {name: column[mine] for name, column in result.history.items() if name != "stage"}


def changes(result):
    return int(result.stdout.split("the step has changed ")[1].split()[0])


def moved(energy, h):
    return abs(energy["outside"]) + abs(energy["supports"]) + abs(energy["incoming"]) + max(h["kinetic_J"]) + max(h["strain_J"])


def up_to_the_end(case):
    """A block falls freely: the energies of the summary are those of the end, not of a step before it."""
    for strain in ("small", "large"):
        for what, cells, material in (("rigid", (), ("strain", strain)), ("deforms", (2, 1), ELASTIC)):
            result = case.run(join([base(), block(2.0, *cells)]), changed(SCENE, ("strain", strain), material, stages(0.1, rests=False, dt_factor=0.5)))
            energy, dt = result.stage_summary("go")["energy"], result.stage_summary("go")["dt"]
            weight, fallen = RHO * 0.5 * G, -result.probe("go", "at")[1]
            case.check(f"free fall, {what}, {strain} strain: work of the weight at the end [J]", energy["outside"], weight * fallen, relative=1e-9)
            case.check("... kinetic energy there, m (v^2 - (g dt/2)^2)/2 [J]", energy["kinetic"], 0.25 * RHO * G**2 * (0.1**2 - dt**2 / 4), relative=1e-9)
            case.check("... balance over the work", energy["balance"] / energy["outside"], 0.0, absolute=1e-9)


def across_changes(case):
    """A block thrown up comes down again and again on the joint it stood on: the account closes however often the step changes."""
    for strain, closes in (("small", 1e-12), ("large", 1e-6)):
        kinds = (("rigid", (), None, ()), ("quadrilaterals", (2, 1), None, (ELASTIC,)), ("triangles", (2, 1), split_triangles, (ELASTIC,)))
        for what, cells, shape, material in kinds:
            for damped in ({}, {"alpha": 2.0, "beta": 0.0 if what == "rigid" else 2e-6}):
                result = case.run(join([base(), block(0.0, *cells, shape=shape)]),
                                  changed(SCENE, ("strain", strain), *material, ("materials.block.velocity", [0.0, 0.5]), stages(0.5, **damped)))  # fmt: skip
                h, energy = history(result), result.stage_summary("go")["energy"]
                off = np.append(h["balance_J"], energy["balance"]) / moved(energy, h)
                case.check(f"hops, {what}, {strain} strain{', damped' if damped else ''}: balance over the energy moved", off, 0.0, absolute=closes)
                case.check("... the step has changed more often than to begin with", changes(result) > 10, True)


def where_inertia_is_a_matrix(case):
    """Ground that lets waves out, with a wave, and water that moves with a face: what is solved by the step is solved again."""
    ground = ("materials", {"ground": {"density": 2500, "young": 8.64e9, "poisson": 0.2}})
    t = np.arange(0, 0.2001, 5e-4)
    wave = "".join(f"{a:.9g}, {b:.17g}, 0\n" for a, b in zip(np.append(t, 9.0), np.append(0.1 * np.sin(np.pi * t / 0.2) ** 2, 0.0), strict=True))
    keys = (("supports", {"bottom": {"fix": "xy", "boundary": "quiet", "input": "incident", "motion": "wave.csv"}}), ("joints.default", {"law": "elastic", "k_n": 1e9, "k_s": 1e9}),
            ("loads", {"water": {"type": "added_mass", "faces": "right", "level": 15.0}}), stages(0.3, rests=False, loads=["water"], alpha=3.0))  # fmt: skip
    for strain, closes in (("small", 1e-12), ("large", 1e-7)):
        folder = case.prepare(rectangle(0, 0, 4, 20, 4, 20, group="ground"), changed(SCENE, ground, ("strain", strain), *keys))
        (folder / "wave.csv").write_text(wave)
        result = case.again(folder)
        h, energy = history(result), result.stage_summary("go")["energy"]
        case.check(f"quiet base, wave, added mass, alpha, {strain} strain: balance over the energy moved", np.append(h["balance_J"], energy["balance"]) / moved(energy, h), 0.0, absolute=closes)
        case.check("... the step has changed", changes(result) >= 4, True)
        fine = history(case.again(folder, "-stages_go_dt_factor", "0.05"))
        u = np.interp(h["time_s"], fine["time_s"], fine["top_left_ux_m"])
        case.check("... displacement of the top beside that at 0.05, over the largest", (h["top_left_ux_m"] - u) / max(abs(u)), 0.0, absolute=2e-3)


def column():
    return join([base(), *(block(0.05 * (i + 1) + 0.5 * i, name=f"at_{i}") for i in range(4))])


def hits(case):
    """A column of four falls together: nearer to the truth than 0.1 of the bound, for fewer steps. Mean of three values of gravity."""
    found = {}
    for factor in (0.01, 0.1, "auto"):
        scenes = [changed(SCENE, VARIABLE, ("gravity", part * G), ("relaxation.history_every", 10 if factor == 0.01 else 1), stages(0.6, rests=False, dt_factor=factor)) for part in (0.95, 1.0, 1.05)]
        found[factor] = case.run_all([(column(), scene) for scene in scenes])
    off = {}
    for factor, results in found.items():
        pairs = [(history(a), history(b)) for a, b in zip(results, found[0.01], strict=True)]
        worst = [max(abs(np.interp(h["time_s"], truth["time_s"], truth[name]) - h[name]).max() / np.ptp(truth[name]) for name in ("at_1_uy_m", "at_3_uy_m")) for h, truth in pairs]
        off[factor] = np.sqrt(np.mean(np.square(worst)))
    steps = {factor: np.mean([r.stage_summary("go")["cycles"] for r in results]) for factor, results in found.items()}
    case.report("column of four falls: error of auto over that of 0.1", off["auto"] / off[0.1], 1.0)
    case.check("... error of auto, at most a fifth of that of 0.1, and 0.3 % of the way", [bool(off["auto"] <= off[0.1] / 5), bool(off["auto"] < 0.003)], [True, True])
    case.report("... steps of auto over those of 0.1", steps["auto"] / steps[0.1], 1.0)
    case.check("... fewer than those of 0.1", bool(steps["auto"] < steps[0.1]), True)


def slides(case):
    """A dam of blocks that deform rocks and slides on a shaken base: its way depends on the phase of vibrations. Near the truth for less than half
    of the steps of 0.05; where the joint holds, for a twentieth."""
    t = np.linspace(0, 1.5, 301)
    record = "".join(f"{x:.9g}, {y:.17g}, 0\n" for x, y in zip(np.append(t, [1.6, 99.0]), np.append(0.55 * G * np.sin(np.pi * t / 1.5) ** 2 * np.sin(4 * np.pi * t), [0.0, 0.0]), strict=True))
    mesh = join([base(), renamed(rectangle(0, 0, 2, 5, 3, 7, group="block"), {}, {"at": "top_left"})])
    shaken = ("supports.base", {"fix": "xy", "motion": "quake.csv", "quantity": "acceleration"})
    for what, friction, fewer in (("slides", {"friction": 30, "damping": 1e-4}, 0.5), ("held", {"law": "elastic"}, 0.05)):
        scene = changed(SCENE, ELASTIC, shaken, ("joints.default", {"k_n": 1e10, "k_s": 4e9} | friction), stages(1.8))
        folder = case.prepare(mesh, scene)
        (folder / "quake.csv").write_text(record)
        found, steps = {}, {}
        for factor, every in (("0.01", 10), ("0.05", 2), ("auto", 1)):
            result = case.again(folder, "-stages_go_dt_factor", factor, "-relaxation_history_every", every)
            found[factor], steps[factor] = history(result), result.stage_summary("go")["cycles"]
        truth = found["0.01"]
        off = {factor: abs(np.interp(h["time_s"], truth["time_s"], truth["at_rx_m"]) - h["at_rx_m"]).max() / np.ptp(truth["at_rx_m"]) for factor, h in found.items()}
        case.report(f"dam on a shaken base, {what}: error of 0.05 over the range of its crest", off["0.05"], 0.0)
        case.check("... error of auto", off["auto"], 0.0, absolute=2e-3)
        case.report("... steps over those of 0.05", steps["auto"] / steps["0.05"], fewer)
        case.check(f"... at most {fewer}", bool(steps["auto"] < fewer * steps["0.05"]), True)


def times(case):
    """Rows of the history, frames and the end stand at equal times, whatever the steps between them."""
    result = case.run(column(), changed(SCENE, VARIABLE, ("relaxation.history_every", 20), stages(0.4, rests=False, frames=4)))
    t = history(result)["time_s"][1:-1]
    case.check("times of the history: differences over the first [-]", np.diff(t) / (t[1] - t[0]), 1.0, relative=1e-6)
    case.check("... end of the stage [s]", result.stage_summary("go")["time"], 0.4, relative=1e-12)
    case.check("... times of the frames, at most a longest step late [s]", [result.stage(name).time for name in result.frames("go")], [0.08, 0.16, 0.24, 0.32], absolute=1.2e-4)


def ranks_and_restart(case):
    for strain, cells, shape in (("small", (2, 2), split_triangles), ("large", (2, 2), None), ("large", (), None)):
        mesh = join([base(), *(block(0.01 * (i + 1) + 0.5 * i, *cells, name=f"at_{i}", shape=shape) for i in range(4))])
        keys = (VARIABLE, ELASTIC) if cells else (VARIABLE,)
        if strain == "small":  # contacts stay: the blocks stand on each other and are thrown up
            mesh = join([base(), *(block(0.5 * i, *cells, name=f"at_{i}", shape=shape) for i in range(4))])
            keys = (ELASTIC, ("materials.block.velocity", [0.0, 0.02]))
        scene = changed(SCENE, ("strain", strain), *keys, ("relaxation.history_every", 4), ("checkpoint", {"every": 100, "keep": 100}), stages(0.08, rests=strain == "small"))
        what = f"{strain} strain, {'rigid' if not cells else 'triangles' if shape else 'quadrilaterals'}"
        folder = case.prepare(mesh, scene)
        told = [(r.stage_summary("go")["checksum"], changes(r)) for r in (case.again(folder, ranks=n) for n in case.ranks(2, 3, 4))]
        whole = case.again(folder)
        case.check(f"four blocks fall, {what}: checksums and changes of the step on 1 to 4 ranks", len({*told, (whole.stage_summary("go")["checksum"], changes(whole))}), 1)
        case.check("... changes, beside the four it begins with", changes(whole) > 4, True)
        case.again(folder, "-output", "kept")
        files = sorted((folder / "kept" / "checkpoints").iterdir())[-5:]
        same, within = [], 0
        for number, file in enumerate(files):
            again = case.again(folder, "-restart", file, ranks=1 + number % 2)
            same.append([again.stage_summary("go")[name] for name in ("checksum", "cycles")] == [whole.stage_summary("go")[name] for name in ("checksum", "cycles")])
            within += "the step has changed" in again.stdout  # else the checkpoint is behind the stage
            same.append("the step has changed" not in again.stdout or changes(again) == changes(whole))
            same.append(number % 2 or json.dumps(again.stage_summary("go")["energy"]) == json.dumps(whole.stage_summary("go")["energy"]))
        case.check("... restart from checkpoints, on 1 and 2 ranks: same bits, steps, energies", [within > 3, bool(np.all(same))], [True, True])


def after_the_last_step(case):
    """A checkpoint of the last step of a stage: the restart makes no other step, and ends the stage as the run did."""
    folder = case.prepare(join([base(), block(0.01)]), changed(SCENE, VARIABLE, stages(0.01, rests=False)))
    steps = case.again(folder).stage_summary("go")["cycles"]
    whole = case.again(folder, "-checkpoint_every", steps, "-checkpoint_keep", 10)
    expected = [whole.stage_summary("go")[name] for name in ("checksum", "energy")]
    case.again(folder, "-checkpoint_every", steps, "-checkpoint_keep", 10, "-output", "kept")
    within = [file for file in sorted((folder / "kept" / "checkpoints").iterdir()) if f"stage go, cycle {steps}" in case.again(folder, "-restart", file).stdout]
    case.check("checkpoints at the last step", len(within) > 0, True)
    for ranks in case.ranks(1, 2):
        again = case.again(folder, "-restart", within[0], ranks=ranks)
        case.check(f"restart from there, {ranks} ranks: bits and energies of the whole run", [again.stage_summary("go")[name] for name in ("checksum", "energy")], expected)


def one_step(case):
    """Condensed bodies and free ground have velocities of their own: auto keeps one step and says so."""
    mesh = join([base(), block(0.0, 4, 4)])
    condensed = case.run(mesh, changed(SCENE, ("materials.block", {"density": RHO, "young": 5e9, "poisson": 0.2, "condensed": True, "highest_frequency": 500}), stages(0.02)))
    case.check("condensed body: one step, said", ["auto keeps this step: there are condensed bodies" in condensed.stdout, "the step has changed" in condensed.stdout], [True, False])
    case.check("... 0.9 of the bound", "0.9 of the stability bound" in condensed.stdout, True)
    energy = condensed.stage_summary("go")["energy"]
    case.check("... balance at the end over the work of the weight", energy["balance"] / (RHO * 0.5 * G * 0.01), 0.0, absolute=1e-9)


def words(case):
    """What cannot be is refused or told."""
    held = case.run(base(), changed(SCENE, ("materials", {"base": {"density": RHO}}), ("loads", {}), stages(0.1, rests=False, loads=[])))
    case.check("all is held: exit code, and why", [held.exit_code, "supports hold all blocks, so nothing sets its time step" in held.stderr, held.stderr.count("\n")], [2, True, 1])
    ground = rectangle(0, 0, 4, 10, 2, 5, group="block")
    quiet = changed(SCENE, ("materials", {"block": ELASTIC[1]}), ("supports", {"bottom": {"fix": "xy", "boundary": "quiet"}}), stages(0.01))
    lone = case.again(case.prepare(ground, quiet), "-stages", "go")
    case.check("a stage in time alone on a quiet base: exit code, and why", [lone.exit_code, "no stage runs before this one" in lone.stderr, "of the stage before" in lone.stderr], [2, True, False])
    # t2pt makes energy where it opens and closes
    scene = changed(SCENE, ("joints.default", {"k_n": 1e9, "k_s": 0, "friction": 60, "stress_model": "t2pt"}), ("materials.block.spin", -4.0), VARIABLE, stages(1.0))
    for factor, said, not_said in (("auto", "give dt_factor a small number", "lower dt_factor"), (0.9, "lower dt_factor", "give dt_factor")):
        told = case.again(case.prepare(join([base(), block(0.0)]), scene), "-stages_go_dt_factor", factor)
        text = told.stdout + told.stderr + told.stage_summary("go")["evidence"]
        case.check(f"an account that is out, dt_factor {factor}: what helps", [said in text, not_said in text], [True, False])


def history_lost(case):
    """A finished run is gone on with from its last checkpoint, and its histories are gone: the summary has the checksum of those that start again."""
    folder = case.prepare(join([base(), block(0.05)]), changed(SCENE, VARIABLE, ("checkpoint", {"every": 100, "keep": 100}), stages(0.02, rests=False)))
    before = case.again(folder).summary
    case.again(folder, "-output", "out")
    for name in ("history.csv", "joint_history.csv"):
        (folder / "out" / name).unlink()
    again = case.again(folder, "-restart", sorted((folder / "out" / "checkpoints").iterdir())[-1])
    case.check("restart without the histories: exit code, it says so", [again.exit_code, "it starts again" in again.stderr], [0, True])
    try:
        wrong = "" if len(check_folder(str(folder / "out"))) >= 5 else "files are missing"
    except ResultsError as error:
        wrong = str(error)
    case.check("... what is wrong with the files", wrong, "")
    case.check("... the same numbers of contacts and unknowns in the summary", [again.summary[k] for k in ("n_contacts", "n_dofs")], [before[k] for k in ("n_contacts", "n_dofs")])
