"""What a stage in time leaves for people to read: histories of joints, forces of supports, displacements over the ground, peaks."""

import shutil
from pathlib import Path

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, rectangle, renamed, split_triangles
from quoin_tools.mesh.stacks import block_on_plane, one_contact

WHAT = "histories of joints and supports, displacements over the ground, peaks: closed forms, ranks, restart"
SOURCE = "Newmark's block on a pulse: N = m g, T = m a_c, slip in parabolas; a wave through a quiet base: rho c v; sums over contacts of results.h5"
BY = "closed form of Newmark, by hand; sums over the results"

G, MASS = 9.81, 2400 * 0.2
A, A_C, T0 = 0.5 * G, 0.2 * G, 0.5  # of the ground, at which the block slides; s
BLOCK = {
    "strain": "small", "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "history_every": 100},
    "materials": {"block": {"density": 2400}, "base": {"density": 2400}},
    "joints": {"default": {"k_n": 1e9, "k_s": 1e9, "friction": float(np.degrees(np.arctan(0.2)))}},
    "supports": {"base": {"fix": "xy", "motion": "motion.csv", "quantity": "acceleration"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
    "stages": [{"rest": {"loads": ["weight"]}}, {"shake": {"type": "dynamic", "loads": ["weight"], "duration": 1.5, "dt_factor": 0.2}}],
}  # fmt: skip


LONG = ("envelopes_of_frames",)  # parts that the short form leaves out


def run(case):
    newmark(case)
    wave(case)
    sums(case)
    swing(case)
    column(case)
    envelopes_of_frames(case)
    suction(case)
    ranks(case)
    restart(case)


def in_time(result, stage="shake"):
    """Columns of history.csv in a stage."""
    rows = result.history["stage"] == stage
    return {name: column[rows] for name, column in result.history.items()}


def pulse(sign):
    return "".join(f"{t:.12g}, {sign * a:.12g}, 0\n" for t, a in ((0, A), (T0, A), (T0 + 1e-9, 0), (9, 0)))


def slip_at(t):
    """Slip of the block towards where the ground comes from, under a pulse A from 0 to T0."""
    relative = np.where(t < T0, (A - A_C) * t, A * T0 - A_C * t)  # velocity of the ground over the block
    stop = A * T0 / A_C
    early = (A - A_C) * np.minimum(t, T0) ** 2 / 2
    late = np.where(t > T0, (A * T0 - A_C * T0 + np.maximum(relative, 0)) / 2 * (np.minimum(t, stop) - T0), 0)
    return early + late


def newmark(case):
    """A block on a base that is shaken one way and the other, contacts kept and found again."""
    variable = (("strain", "large"), ("contact", {"connectivity": "variable", "tolerance": 0.005}), ("joints.default.k_n", 1e10), ("joints.default.k_s", 1e10))
    for what, sign, changes in (("small strain", 1, ()), ("small strain, the other way", -1, ()), ("large strain, contacts found again", -1, variable)):
        folder = case.prepare(block_on_plane(slope_degrees=0, plane_length=6.0, start=2.5), changed(BLOCK, *changes))
        (folder / "motion.csv").write_text(pulse(sign))
        result = case.again(folder)
        joint, h = result.joint_history["default"], in_time(result)
        t, sliding = joint["time"], (joint["time"] > 0.05) & (joint["time"] < 1.2)
        case.check(f"block, {what}: N over m g", joint["N"] / (MASS * G), 1.0, relative=1e-5)
        case.check("... T while it slides, over m a_c", joint["T"][sliding] / (MASS * A_C), -sign, relative=1e-5)
        case.check("... factor while it slides", joint["factor_peak"][sliding], 1.0, relative=1e-9)
        final = (A - A_C) * A * T0**2 / (2 * A_C)
        case.check("... slip in time over the last", joint["slip"] / final, -sign * slip_at(t) / final, absolute=2e-3)
        case.check("... largest slip of an end, over the last", joint["slip_largest"] / final, -sign * slip_at(t) / final, absolute=2e-3)
        case.check("... reads: first and last time [s]", [t[0], t[-1]], [0.0, 1.5], absolute=1e-12)
        case.check("... force of the base on it along x while it slides, over m a_c; along y over m g", [h["base_fx_N"][h["time_s"] < 1.2][8:] / (MASS * A_C) * sign,
                   h["base_fy_N"][h["time_s"] < 1.2][8:] / (MASS * G)], 1.0, relative=1e-5)  # fmt: skip
        over = h["bottom_left_rx_m"] - h["bottom_left_rx_m"][0]
        case.check("... its displacement over the ground, over the last slip", over / final, -sign * slip_at(h["time_s"]) / final, absolute=2e-3)
        peaks = result.stage_summary("shake")["peaks"]
        slip = peaks["joints"]["default"]["slip"]
        case.check("... peaks: slip before, after, largest over the last", np.array([slip["start"], slip["end"], slip["largest"]]) / final, [0, -sign, -sign], absolute=2e-3)
        case.check("... the first time of the largest: when it stops [s]", slip["time"], A * T0 / A_C, absolute=0.02)
        times = h["time_s"][1:-1]
        case.check("... time between two looks, which peaks miss [s]", peaks["sampled_every"], np.diff(times).max(), relative=1e-6)
        check_peaks(case, result)


def check_peaks(case, result, stage="shake"):
    """Those of the summary against the rows of the files."""
    peaks, h = result.stage_summary(stage)["peaks"], in_time(result, stage)
    apart = []
    for name, found in peaks["joints"].items():
        joint = {key: column[result.joint_history[name]["stage"] == stage] for key, column in result.joint_history[name].items()}
        for key in ("N", "T"):
            apart += [*ends(found[key], joint[key], joint["time"])]
        for key, end in (("factor_peak", "least"), ("factor_residual", "least"), ("opening", "largest"), ("open_length", "largest")):
            known = joint[key][np.isfinite(joint[key])]
            if known.size:
                apart.append(abs(found[key][end] - (known.min() if end == "least" else known.max())) / (abs(known).max() + 1e-30))
    for name, found in peaks["supports"].items():
        for x in "xy":
            apart += [*ends(found[x], h[f"{name}_f{x}_N"], h["time_s"] - h["dt_s"])]
    for x in "xy":
        apart += [*ends(peaks["base_shear"][x], sum(h[f"{name}_f{x}_N"] for name in peaks["supports"]), h["time_s"] - h["dt_s"])]
    for name, found in peaks["probes"].items():
        for key, column in (("u_x", "ux"), ("u_y", "uy"), ("relative_x", "rx"), ("relative_y", "ry")):
            apart += [*ends(found[key], h[f"{name}_{column}_m"], h["time_s"])] if key in found else []
    case.check("... peaks in the summary are those of the rows: values and times", max(apart), 0.0, absolute=1e-8)


def ends(found, column, time):
    """How far a range and its times are from those of a column; where several rows are the same in ten digits, from the nearest of these."""
    size = abs(column).max() + 1e-30
    for end, value in (("least", column.min()), ("largest", column.max())):
        yield abs(found[end] - value) / size
        near = time[abs(column - value) <= 2e-10 * size]
        yield abs(found[f"time_{end}"] - near).min() / (1 + abs(time).max())


# ---- a wave that comes through the ground

RHO, CS, NU, HEIGHT, WIDTH = 2500.0, 1200.0, 0.2, 60.0, 4.0
GROUND = {
    "strain": "small", "relaxation": {"history_every": 1},
    "materials": {"ground": {"density": RHO, "young": 2 * (1 + NU) * RHO * CS**2, "poisson": NU}},
    "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}},
    "supports": {"bottom": {"fix": "y", "boundary": "quiet", "input": "incident", "motion": "wave.csv"}, "level": {"target": "ground", "fix": "y"}},
    "stages": [{"shake": {"type": "dynamic", "loads": [], "duration": 0.4, "dt_factor": 0.5}}],
}


def bell(t, length=0.2):
    return 0.1 * np.sin(np.pi * t / length) ** 2 * ((t > 0) & (t < length))


def moved(t, length=0.2):
    """What the bell has moved by."""
    t = np.clip(t, 0, length)
    return 0.1 * (t / 2 - length / (4 * np.pi) * np.sin(2 * np.pi * t / length))


def wave(case):
    """Its force through the base as it comes in and goes out; the top moves twice as far, as free ground does."""
    t = np.linspace(0, 0.2, 801)
    text = "".join(f"{a:.9g}, {b:.17g}, 0\n" for a, b in zip(t, bell(t), strict=True))
    for what, part, fix, order in (("quadrilaterals", lambda mesh: mesh, "x", ("bottom", "level")), ("quadrilaterals", lambda mesh: mesh, "xy", ("level", "bottom")),
                                   ("triangles", split_triangles, "y", ("bottom", "level"))):
        supports = {name: GROUND["supports"][name] for name in order}
        supports["bottom"] = supports["bottom"] | {"fix": fix}
        scene = changed(GROUND, ("supports", supports), ("relaxation.allow_floating", True))
        folder = case.prepare(renamed(part(rectangle(0, 0, WIDTH, HEIGHT, 1, 60, group="ground")), {"bottom": "bottom"}, {"top": "top_left", "foot": "bottom_left"}), scene)
        (folder / "wave.csv").write_text(text)
        result = case.again(folder)
        h = in_time(result)
        at, full = h["time_s"] - h["dt_s"], RHO * CS * WIDTH * 0.1
        expected = RHO * CS * WIDTH * (bell(at) - bell(at - 2 * HEIGHT / CS))
        case.check(f"wave through a strip of {what}, held along {fix}, supports {', '.join(order)}: force through the base over rho c v", h["bottom_fx_N"] / full, expected / full, absolute=0.01)
        case.check("... the supports that level it bear nothing along x [N]", h["level_fx_N"], 0.0, absolute=1e-9)
        twice = 2 * moved(h["time_s"] - HEIGHT / CS) - 2 * moved(h["time_s"])
        case.check("... displacement of the top over free ground, over twice the wave's", h["top_rx_m"] / (2 * moved(1)), twice / (2 * moved(1)), absolute=0.005)
        check_peaks(case, result)


# ---- sums over contacts

def pile(n=5):
    """Blocks of which some deform, that fall on each other, slide and open."""
    bodies = [rectangle(-1, -1, 6, 1, group="base", rigid=True), rectangle(0, 0, 2, 1, 4, 2, group="wall")]
    bodies += [rectangle(0.12 * i, 1.0 + 0.52 * i, 1, 0.5, 2 if i % 2 else 1, 1, group="soft" if i % 2 else "block", rigid=i % 2 == 0) for i in range(n)]
    bodies += [rectangle(3.2, i, 1, 1, group="soft") for i in range(2)]  # so that the contacts of `default` are no line
    return join([renamed(body, {}, {f"p{i}": "bottom_left"}) for i, body in enumerate(bodies)])


PILE = {
    "contact": {"connectivity": "variable", "tolerance": 0.005}, "relaxation": {"allow_floating": True, "history_every": 25},
    "materials": {"block": {"density": 2400}, "soft": {"density": 2400, "young": 2e7, "poisson": 0.2}, "base": {"density": 2400}, "wall": {"density": 2400, "young": 2e7, "poisson": 0.2}},
    "joints": {"default": {"k_n": 1e8, "k_s": 1e8, "friction": 20, "cohesion": 2e3, "tension": 1e3, "damping": 5e-4},
               "base+wall": {"k_n": 1e8, "k_s": 1e8, "friction": 30, "stress_model": "tptm", "tension": 1e4}},
    "supports": {"base": {"fix": "xy", "motion": "motion.csv"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block", "soft", "wall"]}},
    "stages": [{"shake": {"type": "dynamic", "loads": ["weight"], "duration": 0.12, "dt_factor": 0.1, "alpha": 0.5, "envelope_every": 7}}],
}  # fmt: skip


def shaken_pile(case, *changes, ranks=1, options=(), folder=None):
    if folder is None:
        folder = case.prepare(pile(), changed(PILE, *changes))
        t = np.linspace(0, 0.2, 101)
        (folder / "motion.csv").write_text("".join(f"{a:.9g}, {0.4 * np.sin(40 * a):.17g}, {0.1 * np.sin(70 * a):.17g}\n" for a in t))
    return folder, case.again(folder, *options, ranks=ranks)


def sums(case):
    """The last row of each joint against the summary and results.h5."""
    for what, changes in (("contacts found again", ()), ("small strain, contacts kept, tptm", (("strain", "small"), ("contact.connectivity", "fixed"), ("joints.default.stress_model", "tptm"), ("relaxation.history_every", 50)))):
        _, result = shaken_pile(case, *changes)
        s, contacts = result.stage_summary("shake"), result.stage("shake").contacts
        for name, facts in s["joints"].items():
            row = {key: column[-1] for key, column in result.joint_history[name].items()}
            sizes = np.array([facts["length"], facts["length"], *2 * [1 + abs(facts["N"]) + abs(facts["T"])]])
            case.check(f"pile, {what}, {name}: last length, open length, N, T less those of the summary, over their size",
                       (np.array([row["length"], row["open_length"], row["N"], row["T"]]) - [facts["length"], facts["open_length"], facts["N"], facts["T"]]) / sizes, 0.0, absolute=1e-9)
            mine = contacts.joint == result.mesh.joint_names.index(name)
            case.check("... largest opening of an end [m]", row["opening"], contacts.opening[mine].max(), absolute=1e-9 * abs(contacts.opening).max())
            if facts["sliding_factor_peak"] is not None and facts["N"] > 0:
                case.check("... factors", [row["factor_peak"], row["factor_residual"]], [facts["sliding_factor_peak"], facts["sliding_factor_residual"]], relative=1e-8)
        weight = G * 2400 * (2 + 5 * 0.5 + 2)
        peaks = s["peaks"]
        case.check("... joints: all that has contacts", sorted(peaks["joints"]), sorted(s["joints"]))
        case.check("... some joint has opened and slipped", [max(j["open_length"]["largest"] for j in peaks["joints"].values()) > 0.1, max(abs(j["slip"]["largest"]) for j in peaks["joints"].values()) > 1e-4], [True, True])
        case.check("... mean force of the support along y, over the weight", in_time(result)["base_fy_N"].mean() / weight, 1.0, absolute=0.7)
        check_peaks(case, result)


# ---- envelopes

def swing(case):
    """A rigid block that swings on its joint: the extremes of a sine."""
    k, m, v = 1e9, 1000.0, 0.01
    scene = {"strain": "small", "relaxation": {"history_every": 100}, "materials": {"block": {"density": m, "velocity": [0.0, v]}, "base": {"density": 0}},
             "joints": {"default": {"law": "elastic", "k_n": k, "k_s": k}}, "supports": {"base": {"fix": "xy"}},
             "stages": [{"shake": {"type": "dynamic", "loads": [], "duration": 0.02, "dt_factor": 0.02, "envelope_every": 2}}]}
    for model in ("pt", "tptm"):
        result = case.run(one_contact(), changed(scene, ("joints.default.stress_model", model)))
        e = result.stage("shake").envelope
        size = v * np.sqrt(m / k)  # of the displacement; one metre wide and high
        case.check(f"rigid block that swings on its joint, {model}: largest, least sigma over v sqrt(k m), largest opening over v sqrt(m/k)",
                   np.array([e.contacts.sigma_max / (k * size), -e.contacts.sigma_min / (k * size), e.contacts.opening_max / size]), 1.0, relative=1e-4)
        case.check("... no stress, no slip", [bool(np.isnan(e.s1_max).all()), float(abs(e.contacts.slip_max).max()), e.safety_factor_min is None], [True, 0.0, True])


def column(case):
    """A pulse of pressure runs up a bar and comes back from its free top as tension: envelopes and their times in between."""
    e, rho, height, length = 1e9, 2400.0, 40.0, 0.02
    c = np.sqrt(e / rho)
    scene = {"strain": "small", "relaxation": {"history_every": 10}, "materials": {"ground": {"density": rho, "young": e, "poisson": 0.0, "tension": 2e5, "compression": 3e5}},
             "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}}, "supports": {"bottom": {"fix": "xy", "motion": "wave.csv"}},
             "stages": [{"shake": {"type": "dynamic", "loads": [], "duration": 2 * height / c + length, "dt_factor": 0.9, "envelope_every": 1}}]}
    t = np.linspace(0, length, 201)
    text = "".join(f"{x:.9g}, 0, {v:.17g}\n" for x, v in zip(t, bell(t, length), strict=True))
    for what, part in (("quadrilaterals", lambda mesh: mesh), ("triangles", split_triangles)):
        folder = case.prepare(renamed(part(rectangle(0, 0, 0.2, height, 1, 200, group="ground")), {"bottom": "bottom"}, {"top": "top_left"}), scene)
        (folder / "wave.csv").write_text(text)
        result = case.again(folder)
        s = result.stage("shake")
        envelope, y = s.envelope, result.mesh.centres()[:, 1]
        alone = (y > 8) & (y < 32)  # where the pulse meets neither itself nor an end
        case.check(f"pulse in a bar of {what}: least s2 over rho c v", envelope.s2_min[alone] / (0.1 * rho * c), -1.0, relative=0.01)
        case.check("... largest s1, as it comes back", envelope.s1_max[alone] / (0.1 * rho * c), 1.0, relative=0.01)
        case.check("... times of both [s]", np.array([envelope.s2_min_time[alone] - y[alone] / c, envelope.s1_max_time[alone] - (2 * height - y[alone]) / c]), length / 2, absolute=3e-4)
        factors = np.array([2e5 / envelope.s1_max, 3e5 / -envelope.s2_min])
        case.check("... least safety factor: of tension or of compression", envelope.safety_factor_min[alone] / factors.min(axis=0)[alone], 1.0, relative=1e-9)
        case.check("... its mode, its time: those of the tension", [np.unique(envelope.safety_mode_min[alone]).tolist(), bool((envelope.safety_factor_min_time == envelope.s1_max_time)[alone].all())], [[1], True])
        case.check("... the end of the stage is within", [bool((envelope.s1_max >= s.s1).all()), bool((envelope.s2_min <= s.s2).all()), bool((envelope.safety_factor_min <= s.safety_factor).all())], [True] * 3)
        case.check("... samples", envelope.samples, result.stage_summary("shake")["cycles"] + 1)


def extremes(result, stages):
    """Those of frames and end, of blocks and of contacts by their faces."""
    found = [result.stage(name) for name in stages]
    ends = {tuple(face): [np.zeros(2)] * 4 for face in result.stage("shake_1").contacts.face}  # nothing bears at the start
    for s in found:
        for face, sigma, opening, slip in zip(s.contacts.face, s.contacts.sigma, s.contacts.opening, s.contacts.slip):
            row = ends[tuple(face)] = list(ends.get(tuple(face), [-np.inf, np.inf, -np.inf, 0.0]))
            row[0], row[1] = np.maximum(row[0], sigma), np.minimum(row[1], sigma)
            row[2], row[3] = np.maximum(row[2], opening), np.maximum(row[3], abs(slip))
    return np.max([s.s1 for s in found], axis=0), np.min([s.s2 for s in found], axis=0), ends


def envelopes_of_frames(case):
    """Sampled at the very steps of frames: the same numbers; blocks and contacts of all kinds, some groups not written."""
    for what, changes, ranks in (("kept", (("contact.connectivity", "fixed"), ("joints.default.stress_model", "tptm")), 1), ("found again", (), 1),
                                 ("found again, 3 ranks", (), 3),
                                 ("kept, without the blocks", (("contact.connectivity", "fixed"), ("joints.default.stress_model", "tptm"), ("materials.soft.output", False)), 2)):
        stage = PILE["stages"][0]["shake"]
        scene = changed(PILE, ("stages", [{"shake": stage | {"duration": 0.05}}]), *changes)
        steps = int(shaken_pile(case, ("stages", scene["stages"]), *changes)[1].stage_summary("shake")["cycles"])
        every = steps // 8
        _, result = shaken_pile(case, ("stages", [{"shake": stage | {"duration": 0.05, "frames": steps - 1, "envelope_every": every}}]), *changes, ranks=ranks)
        frames = [result.stage(name) for name in result.frames("shake")]
        chosen = [f"shake_{k}" for k in range(every, steps, every)] + ["shake"]
        s1, s2, ends = extremes(result, chosen)
        s = result.stage("shake")
        envelope = s.envelope
        case.check(f"pile, contacts {what}: frames and samples", [len(frames), envelope.samples, envelope.every], [steps - 1, len(chosen) + 1, every])
        near = np.isfinite(s1)
        case.check("... largest s1, least s2 of blocks that deform: of these frames, or of the start, where they were 0", [bool(np.array_equal(envelope.s1_max[near], np.maximum(s1, 0)[near])),
                   bool(np.array_equal(envelope.s2_min[near], np.minimum(s2, 0)[near])), bool(np.isnan(envelope.s1_max[~near]).all())], [True] * 3)
        rows = np.array([ends[tuple(face)] for face in s.contacts.face])
        found = np.stack([envelope.contacts.sigma_max, envelope.contacts.sigma_min, envelope.contacts.opening_max, envelope.contacts.slip_max], axis=1)
        case.check("... sigma, opening, slip at ends of contacts, less those of these frames, over the largest", (found - rows) / (1e-300 + abs(rows).max(axis=(0, 2)))[:, None], 0.0, absolute=1e-12)


# ---- suction

def suction(case):
    """A rigid dam that is pushed off its water with an acceleration that is known: by hand, and at rest again."""
    depth, a = 30.0, 3.0
    for rule in ("westergaard", "zangar"):
        base = renamed(rectangle(0, -5, 20, 5, group="base", rigid=True), {}, {"foot": "top_left"})
        mesh = join([base, renamed(rectangle(0, 0, 20, depth, 1, 10, group="dam", rigid=True), {"upstream": "left"}, {"crest": "top_left"})])
        scene = {"strain": "small", "relaxation": {"history_every": 50}, "materials": {"dam": {"density": 2400}, "base": {"density": 2400}},
                 "joints": {"default": {"law": "elastic", "k_n": 1e13, "k_s": 1e13, "damping": 1e-5}}, "supports": {"dam": {"fix": "xy", "motion": "motion.csv", "quantity": "acceleration"}, "base": {"fix": "xy", "motion": "motion.csv", "quantity": "acceleration"}},
                 "loads": {"hydro": {"type": "added_mass", "faces": "upstream", "level": depth, "rule": rule}},
                 "stages": [{"shake": {"type": "dynamic", "loads": ["hydro"], "duration": 0.1, "dt_factor": 1e-3}}]}
        for direction in (1, -1):
            folder = case.prepare(mesh, scene)
            t = np.linspace(0, 0.1, 201)
            (folder / "motion.csv").write_text("".join(f"{x:.9g}, {direction * a * np.sin(np.pi * x / 0.1)**2:.17g}, 0\n" for x in t))
            results = [case.again(folder, ranks=n) for n in (1, 2)]
            found = results[0].stage_summary("shake")["added_mass"]["hydro"]["suction"]
            z = np.linspace(0, depth, 3000001)
            s = z / depth
            q = 7 / 8 * np.sqrt(s) if rule == "westergaard" else 0.7412 / 2 * (s * (2 - s) + np.sqrt(s * (2 - s)))
            total = 1000 * (G * z - depth * q * a * direction)  # the dam moves off its water to the right
            told = [line for line in results[0].stdout.splitlines() if "pulled more than" in line]
            if direction < 0:
                case.check(f"{rule}: the dam is pushed into its water only: suction, warnings", [found["pressure"], found["length"], len(told)], [0.0, 0.0, 0])
                continue
            case.check(f"{rule}: the dam moves off its water with {a} m/s2: suction over [m]", found["length"], (total < 0).sum() * depth / 3e6, relative=1e-4)
            case.check("... least pressure [Pa]", found["pressure"], total.min(), relative=0.01)
            case.check("... at depth [m]", depth - found["y"], z[total.argmin()], relative=0.1)
            case.check("... at the time of the largest acceleration [s]", found["time"], 0.05, absolute=0.002)
            case.check("... reported once", [len(told), f"over {found['length']:.3g} m" in told[0] if told else False], [1, True])
            case.check("... on 2 ranks", results[1].stage_summary("shake")["added_mass"] == results[0].stage_summary("shake")["added_mass"], True)


def joint_file(result):
    return Path(result.folder, "joint_history.csv").read_bytes()


def forces(result):
    """What of history.csv has the same bits on any number of ranks."""
    h = in_time(result)
    return [h[name].tolist() for name in h if name.endswith(("_N", "_m"))]


def envelope_bytes(result):
    e = result.stage("shake").envelope
    return [e.samples] + [array.tobytes() for part in (e, e.contacts) for array in vars(part).values() if isinstance(array, np.ndarray)]


def ranks(case):
    for what, changes in (("contacts found again", ()), ("contacts kept, tptm", (("contact.connectivity", "fixed"), ("joints.default.stress_model", "tptm")))):
        results = [shaken_pile(case, *changes, ranks=n)[1] for n in case.ranks(*((1, 3) if changes else (1, 2, 3, 4)))]
        files = {joint_file(r) for r in results}
        first = results[0]
        case.check(f"pile, {what}: joint_history.csv on {len(results)} numbers of ranks: the same bytes", [len(files), len(first.joint_history["default"]["time"]) > 20], [1, True])
        case.check("... forces of supports, displacements", all(forces(r) == forces(first) for r in results), True)
        case.check("... envelopes", all(envelope_bytes(r) == envelope_bytes(first) for r in results), True)
        case.check("... peaks", all(r.stage_summary("shake")["peaks"] == first.stage_summary("shake")["peaks"] for r in results), True)


def restart(case):
    """From each checkpoint within the stage, on 1 and 2 ranks."""
    folder, whole = shaken_pile(case, ("checkpoint", {"every": 250, "keep": 100}))
    case.again(folder, "-output", "kept")
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    wanted, columns, envelope, peaks = joint_file(whole), forces(whole), envelope_bytes(whole), whole.stage_summary("shake")["peaks"]
    same = []
    for number, file in enumerate(files[1:-1]):
        shutil.copytree(folder / "kept", folder / "out", dirs_exist_ok=True)  # the files of a run that was killed later
        again = case.again(folder, "-restart", file, ranks=1 + number % 2)
        same += [joint_file(again) == wanted, again.stage_summary("shake")["peaks"] == peaks, forces(again) == columns,
                 envelope_bytes(again) == envelope]
    case.check("restart in the middle, on 1 and 2 ranks: the same bytes, peaks, forces, envelopes", [len(files), all(same)], [6, True])
