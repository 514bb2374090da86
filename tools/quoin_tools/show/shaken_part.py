"""Writes the part of the sheet about dynamic stages that are shaken."""

import numpy as np

from quoin_tools.assess.not_modelled import not_modelled
from quoin_tools.base.results import energy_account, fixed, sliding, trials_of
from quoin_tools.base.time_series import reach
from quoin_tools.show.hypertext import esc, notes, table

CLOSED = 0.01  # of the largest velocity: velocity allowed at the end of a record
FREQUENCIES = (1.0, 3.0, 10.0)  # [Hz] at which damping is reported


def peak(time, values):
    """Returns (value that is largest in size, its time)."""
    at = int(np.abs(values).argmax())
    return float(values[at]), float(time[at])


def timed(pair, scale=1.0, digits=2):
    return f"{fixed(pair[0], scale, digits)} at {pair[1]:.2f} s"


# ---- records


def records(shaken, gravity):
    rows = []
    for s in shaken.shakings:
        r = s.record
        first, last = r.significant()
        end = f"{r.v[-1]:.2g}" + (", not closed" if abs(r.v[-1]) > CLOSED * r.pgv else "")
        rows.append((s.words, r.name, f"{r.pga:.3f} ({r.pga / gravity:.3f} g)", fixed(r.pgv), fixed(r.pgd), fixed(r.arias(gravity)[-1]),
                     f"{last - first:.2f} ({first:.2f} to {last:.2f})", end))  # fmt: skip
    if rows:
        return table(("support", "record", "PGA [m/s²]", "PGV [m/s]", "PGD [m]", "Arias [m/s]", "5 to 95 % of it [s]", "ends with [m/s]"), rows, range(2, 8))
    return notes([f"The record is not known: {shaken.missing}" if shaken.missing else "Nothing shakes the ground by a record."])


def boundaries(scene):
    words = []
    for name, keys in scene.supports.items():
        kind, motion = keys.get("boundary", "fixed"), keys.get("motion")
        followed = " ".join(motion) if isinstance(motion, list) else motion
        moves = f", {'waves of' if kind != 'fixed' else 'moves by'} {followed}" if followed else ""
        wave = f" ({keys.get('input', 'outcrop')})" if followed and kind == "quiet" else ""
        words.append(f"{name}: {kind}, holds {keys.get('fix', '')}{moves}{wave}")
    return "; ".join(words)


def number(value):
    """0 for what is none."""
    return float(value) if isinstance(value, (int, float)) else 0.0


def damping(scene, keys, facts):
    """Words about what takes energy out besides friction and waves."""
    alpha, beta, words = facts["alpha"] or 0.0, number(facts.get("beta", keys.get("beta"))), []
    if alpha:
        words.append(f"alpha {alpha:g} 1/s against {'the ground' if keys.get('frame', 'ground') == 'ground' else 'what rests'}")
    if beta:
        words.append(f"beta {beta:g} s")
    if words:
        ratios = [100 * (alpha / (4 * np.pi * f) + np.pi * f * beta) for f in FREQUENCIES]
        words = [", ".join(words) + " (" + ", ".join(f"{ratio:.2g} % at {f:g} Hz" for ratio, f in zip(ratios, FREQUENCIES)) + ")"]
    for section in (scene.materials, scene.joints):
        for name, own in section.items():
            words += [f"{key} of {name} {number(own.get(key)):g} s" for key in ("beta", "damping") if number(own.get(key))]
    return "; ".join(words) or "none but friction, and waves that go out"


def set_up(case, shaken, stage):
    facts, keys = case.results.stage_summary(stage), case.scene.stages.get(stage, {})
    block = shaken.block
    rows = [("supports", boundaries(case.scene)), ("damping", damping(case.scene, keys, facts)),
            ("step", f"{facts['dt']:.4g} s, {facts['cycles']} steps; dt_factor {keys.get('dt_factor', 0.05)}")]  # fmt: skip
    if block is not None:
        source = "given" if block.from_stage is None else f"stage {block.from_stage}: {abs(block.stable):.4g} stands" + (
            f", {abs(block.failing):.4g} fails" if block.failing is not None else ", no trial failed")  # fmt: skip
        rows.append(("yield coefficient k_y", f"{abs(block.stable):.4g} along {'+x' if block.way > 0 else '-x'} ({source})"))
    for name, water in (facts.get("added_mass") or {}).items():
        rows.append((f"water {name}", f"{water['mass_x'] / 1e3:.1f} t move along x, {water['depth']:.2f} m deep"))
    return table(("", ""), rows)


# ---- response


def joint_rows(shaken, stage, series):
    """Returns (joint, what, value, its time [s]) of joints that can slide; slip since the stage began."""
    rows = []
    for name in series.sliding():
        c = series.joints[name]
        t, slip = c["time"], c["slip"] - c["slip"][0]
        factor = np.where(np.isfinite(c["factor_peak"]), c["factor_peak"], np.inf)
        block = shaken.block_beside(stage, name)
        found = [("largest mean slip [mm]", fixed(peak(t, slip)[0], 1e3, 2), peak(t, slip)[1]), ("mean slip at the end [mm]", fixed(slip[-1], 1e3, 2), t[-1]),
                 *([] if block is None else [("Newmark's block: slip at its end [mm]", fixed(block.slip.final, 1e3, 2), (block.slip.ends() or [None, 0])[1])]),
                 ("largest slip of an end, with that of before [mm]", fixed(peak(t, c["slip_largest"])[0], 1e3, 2), peak(t, c["slip_largest"])[1]),
                 ("least sliding factor of one moment, peak strength [-]", sliding(float(factor.min()), 2), t[factor.argmin()]),
                 ("largest T [kN]", fixed(peak(t, c["T"])[0], 1e-3, 0), peak(t, c["T"])[1]), ("least N [kN]", fixed(c["N"].min(), 1e-3, 0), t[c["N"].argmin()]),
                 ("largest opening [mm]", fixed(max(c["opening"].max(), 0), 1e3, 2), t[c["opening"].argmax()]),
                 (f"largest open length [m], of {fixed(c['length'].max(), 1, 2)}", fixed(c["open_length"].max(), 1, 2), t[c["open_length"].argmax()])]  # fmt: skip
        rows += [(name, what, value, fixed(at, 1, 2)) for what, value, at in found]
    return rows


def newmark_words(shaken, stage, series):
    block = shaken.block
    if block is None or not any(shaken.block_beside(stage, name) for name in series.joints):
        return []
    ends = block.slip.ends()
    when = f", between {ends[0]:.2f} and {ends[1]:.2f} s" if ends else ""
    largest = max((reach(series.joints[name]) for name in block.joints or series.joints if name in series.joints), default=0.0)
    return [f"Newmark's rigid block with k_y {abs(block.stable):.4g} on the same record slides {1e3 * abs(block.slip.final):.2f} mm{when}; the model {1e3 * largest:.2f} mm. "
            "The block is rigid and slides one way; the model answers with its own frequencies, opens and rocks."]  # fmt: skip


def point_rows(series):
    rows = []
    for name in series.probes:
        for axis in "xy":
            relative, absolute = (series.probe(name, axis, which) for which in (True, False))
            rows.append((name, f"u_{axis}", "-" if relative is None else timed(peak(series.time, relative), 1e3),
                         timed(peak(series.time, absolute), 1e3), fixed(absolute[-1], 1e3, 2)))  # fmt: skip
    return rows


def shear_rows(series):
    rows = []
    for axis in "xy":
        if series.shear(axis) is not None:
            forces = {name: series.columns[f"{name}_f{axis}_N"] for name in series.supports}
            rows += [(name, axis, timed(peak(series.time, force), 1e-3, 0)) for name, force in forces.items() if force.any()]
            rows += [("all supports", axis, timed(peak(series.time, series.shear(axis)), 1e-3, 0))] if len(series.supports) > 1 else []
    return rows


ENERGY = {"incoming": "brought by waves", "radiated": "taken by waves", "supports": "work of moving supports", "outside": "work of loads",
          "friction": "lost in joints", "damping": "lost to damping", "balance": "not accounted for"}  # fmt: skip


def energies(facts):
    e, account = facts["energy"], energy_account(facts)
    rows = [(words, fixed(e[name], 1e-3, 3)) for name, words in ENERGY.items() if e.get(name) is not None and (e[name] or name == "balance")]
    if facts.get("kinetic_water"):
        rows.append(("kinetic energy of the water at the end", fixed(facts["kinetic_water"], 1e-3, 3)))
    if account:
        rows.append(("moved in all", fixed(account[2], 1e-3, 3)))
    return rows


def after(case, stage):
    """Static stages and reductions behind a stage: (stage, joint, factor or bracket, slip since the end of the shaking)."""
    names, rows = case.results.stages, []
    for name in names[names.index(stage) + 1 :]:
        facts = case.results.stage_summary(name)
        if "balance" in facts["energy"]:
            break
        found = trials_of(facts)
        if found:
            ends = [sliding(found.get(f"safety_factor_{end}"), 3) for end in ("stable", "failing")]
            rows.append((name, facts["verdict"], "trials", " to ".join(ends) if ends != ["-", "-"] else f"{fixed(found['stable'], 1, 4)} stands"))
            continue
        rows += [(name, facts["verdict"], joint, sliding(j["sliding_factor_peak"], 3)) for joint, j in facts["joints"].items()
                 if j["sliding_factor_peak"] is not None]  # fmt: skip
    return rows


# ---- the part


def stage_part(case, shaken, stage):
    facts, series = case.results.stage_summary(stage), shaken.series(stage)
    part = f"<h3>Stage {esc(stage)}: what shook it</h3>" + records(shaken, case.scene.gravity) + set_up(case, shaken, stage)
    part += "<h3>Not modelled</h3>" + notes(not_modelled(case, stage, shaken.shakings, series))
    rows = joint_rows(shaken, stage, series)
    if rows:
        part += "<h3>Joints over time</h3>" + table(("joint", "", "", "at [s]"), rows, (2, 3)) + (
            "<p><small>Slip since the stage began, positive when the upper side moves towards the end of the joint; of a net of joints sizes, "
            "and sums of forces. The factor of one moment is no verdict.</small></p>")
        part += notes(newmark_words(shaken, stage, series))
    if series.probes:
        part += "<h3>Points</h3>" + table(("point", "", "largest, less the ground [mm]", "largest, absolute [mm]", "absolute at the end [mm]"), point_rows(series), range(2, 5)) + (
            "<p><small>Displacements from the mesh, with those of before the shaking.</small></p>")
    if shear_rows(series):
        part += "<h3>Force of the supports on the model</h3>" + table(("support", "along", "largest [kN]"), shear_rows(series), (2,)) + (
            "<p><small>That of all supports is the shear at the bottom of the model, with the inertia of ground that has mass; the shear at the base of a dam is T of its joint.</small></p>")  # fmt: skip
    part += "<h3>Energy</h3>" + table(("", "[kJ]"), energies(facts), (1,))
    if after(case, stage):
        part += "<h3>After it</h3>" + table(("stage", "verdict", "joint", "sliding factor"), after(case, stage), (3,))
    return part


def shaken_part(case, shaken):
    """HTML of all stages that are shaken; empty: none is."""
    part = "".join(stage_part(case, shaken, stage) for stage in shaken.stages if shaken.is_shaken(stage))
    return f"<h2>Earthquake in time</h2>{part}" if part else ""
