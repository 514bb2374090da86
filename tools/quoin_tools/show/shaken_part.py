"""Writes the part of the sheet about dynamic stages that are shaken."""

import numpy as np

from quoin_tools.assess.not_modelled import not_modelled
from quoin_tools.base import sheet_units
from quoin_tools.base.language import N_, _, numeral
from quoin_tools.base.results import energy_account, fixed, sliding, trials_of
from quoin_tools.base.time_series import reach
from quoin_tools.show.hypertext import head, notes, small, table

CLOSED = 0.01  # of the largest velocity: velocity allowed at the end of a record
FREQUENCIES = (1.0, 3.0, 10.0)  # [Hz] at which damping is reported


def peak(time, values):
    """Returns (value that is largest in size, its time)."""
    at = int(np.abs(values).argmax())
    return float(values[at]), float(time[at])


def timed(pair, scale=1.0, digits=2):
    return _("{0} at {1:.2f} s", fixed(pair[0], scale, digits), pair[1])


# ---- records


def records(shaken, gravity):
    rows = []
    for s in shaken.shakings:
        r = s.record
        first, last = r.significant()
        end = _("{0:.2g}, not closed", r.v[-1]) if abs(r.v[-1]) > CLOSED * r.pgv else numeral(f"{r.v[-1]:.2g}")
        rows.append((s.words, r.name, f"{fixed(r.pga)} ({fixed(r.pga / gravity)} g)", fixed(r.pgv), fixed(r.pgd), fixed(r.arias(gravity)[-1]),
                     _("{0:.2f} ({1:.2f} to {2:.2f})", last - first, first, last), end))  # fmt: skip
    if rows:
        return table((_("support"), _("record"), "PGA [m/s²]", "PGV [m/s]", "PGD [m]", "Arias [m/s]", _("5 to 95 % of it [s]"), _("ends with [m/s]")), rows, range(2, 8))
    return notes([_("The record is not known: {0}", shaken.missing) if shaken.missing else _("Nothing shakes the ground by a record.")])


# without a motion, and with one
BOUNDARIES = {"fixed": (N_("fixed, holds {0}"), N_("fixed, holds {0}, moves by {1}")), "quiet": (N_("quiet, holds {0}"), N_("quiet, holds {0}, waves of {1} ({2})")),
              "free_field": (N_("free_field, holds {0}"), N_("free_field, holds {0}, waves of {1}"))}  # fmt: skip
INPUTS = {"outcrop": N_("outcrop"), "incident": N_("incident")}


def boundaries(scene):
    words = []
    for name, keys in scene.supports.items():
        kind, motion = keys.get("boundary", "fixed"), keys.get("motion")
        followed = " ".join(motion) if isinstance(motion, list) else motion
        held = _(BOUNDARIES[kind][bool(followed)], keys.get("fix", ""), followed, _(INPUTS[keys.get("input", "outcrop")]))
        words.append(f"{name}: {held}")
    return "; ".join(words)


def number(value):
    """0 for what is none."""
    return float(value) if isinstance(value, (int, float)) else 0.0


OWN = {"beta": N_("beta of {0} {1:g} s"), "damping": N_("damping of {0} {1:g} s")}


def damping(scene, keys, facts):
    """Words about what takes energy out besides friction and waves."""
    alpha, beta, words = facts["alpha"] or 0.0, number(facts.get("beta", keys.get("beta"))), []
    if alpha:
        words.append(_("alpha {0:g} 1/s against the ground", alpha) if keys.get("frame", "ground") == "ground" else _("alpha {0:g} 1/s against what rests", alpha))
    if beta:
        words.append(_("beta {0:g} s", beta))
    if words:
        ratios = [100 * (alpha / (4 * np.pi * f) + np.pi * f * beta) for f in FREQUENCIES]
        words = [", ".join(words) + " (" + ", ".join(_("{0:.2g} % at {1:g} Hz", ratio, f) for ratio, f in zip(ratios, FREQUENCIES)) + ")"]
    for section in (scene.materials, scene.joints):
        for name, own in section.items():
            words += [_(text, name, number(own[key])) for key, text in OWN.items() if number(own.get(key))]
    return "; ".join(words) or _("none but friction, and waves that go out")


def set_up(case, shaken, stage):
    facts, keys = case.results.stage_summary(stage), case.scene.stages.get(stage, {})
    block = shaken.block
    rows = [(_("supports"), boundaries(case.scene)), (_("damping"), damping(case.scene, keys, facts)),
            (_("step"), _("{0:.4g} s, {1} steps; dt_factor {2}", facts["dt"], facts["cycles"], keys.get("dt_factor", "auto")))]  # fmt: skip
    if block is not None:
        source = (_("given") if block.from_stage is None else _("stage {0}: {1:.4g} stands, no trial failed", block.from_stage, abs(block.stable)) if block.failing is None else
                  _("stage {0}: {1:.4g} stands, {2:.4g} fails", block.from_stage, abs(block.stable), abs(block.failing)))  # fmt: skip
        rows.append((_("yield coefficient k_y"), _("{0:.4g} along {1} ({2})", abs(block.stable), "+x" if block.way > 0 else "-x", source)))
    for name, water in (facts.get("added_mass") or {}).items():
        rows.append((_("water {0}", name), _("{0:.1f} t move along x, {1:.2f} m deep", water["mass_x"] / 1e3, water["depth"])))
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
        found = [(_("largest mean slip [mm]"), fixed(peak(t, slip)[0], 1e3, 2), peak(t, slip)[1]), (_("mean slip at the end [mm]"), fixed(slip[-1], 1e3, 2), t[-1]),
                 *([] if block is None else [(_("Newmark's block: slip at its end [mm]"), fixed(block.slip.final, 1e3, 2), (block.slip.ends() or [None, 0])[1])]),
                 (_("largest slip of an end, with that of before [mm]"), fixed(peak(t, c["slip_largest"])[0], 1e3, 2), peak(t, c["slip_largest"])[1]),
                 (_("least sliding factor of one moment, peak strength [-]"), sliding(float(factor.min()), 2), t[factor.argmin()]),
                 (_("largest T [kN]"), fixed(peak(t, c["T"])[0], 1e-3, 0), peak(t, c["T"])[1]), (_("least N [kN]"), fixed(c["N"].min(), 1e-3, 0), t[c["N"].argmin()]),
                 (_("largest opening [mm]"), fixed(max(c["opening"].max(), 0), 1e3, 2), t[c["opening"].argmax()]),
                 (_("largest open length [m], of {0}", sheet_units.number(fixed(c["length"].max(), 1, 2), "m")), fixed(c["open_length"].max(), 1, 2), t[c["open_length"].argmax()])]  # fmt: skip
        rows += [(name, what, value, fixed(at, 1, 2)) for what, value, at in found]
    return rows


def newmark_words(shaken, stage, series):
    block = shaken.block
    if block is None or not any(shaken.block_beside(stage, name) for name in series.joints):
        return []
    ends = block.slip.ends()
    largest = max((reach(series.joints[name]) for name in block.joints or series.joints if name in series.joints), default=0.0)
    slides = (_("Newmark's rigid block with k_y {0:.4g} on the same record slides {1:.2f} mm, between {3:.2f} and {4:.2f} s; the model {2:.2f} mm.",
                abs(block.stable), 1e3 * abs(block.slip.final), 1e3 * largest, *ends) if ends else
              _("Newmark's rigid block with k_y {0:.4g} on the same record slides {1:.2f} mm; the model {2:.2f} mm.", abs(block.stable), 1e3 * abs(block.slip.final), 1e3 * largest))  # fmt: skip
    return [slides + " " + _("The block is rigid and slides one way; the model answers with its own frequencies, opens and rocks.")]


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
            rows += [(_("all supports"), axis, timed(peak(series.time, series.shear(axis)), 1e-3, 0))] if len(series.supports) > 1 else []
    return rows


ENERGY = {"incoming": N_("brought by waves"), "radiated": N_("taken by waves"), "supports": N_("work of moving supports"), "outside": N_("work of loads"),
          "friction": N_("lost in joints"), "damping": N_("lost to damping"), "balance": N_("not accounted for")}  # fmt: skip


def energies(facts):
    e, account = facts["energy"], energy_account(facts)
    rows = [(_(words), fixed(e[name], 1e-3, 3)) for name, words in ENERGY.items() if e.get(name) is not None and (e[name] or name == "balance")]
    if facts.get("kinetic_water"):
        rows.append((_("kinetic energy of the water at the end"), fixed(facts["kinetic_water"], 1e-3, 3)))
    if account:
        rows.append((_("moved in all"), fixed(account[2], 1e-3, 3)))
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
            rows.append((name, _(facts["verdict"]), _("trials"), _("{0} to {1}", *ends) if ends != ["-", "-"] else _("{0} stands", fixed(found["stable"], 1, 4))))
            continue
        rows += [(name, _(facts["verdict"]), joint, sliding(j["sliding_factor_peak"], 3)) for joint, j in facts["joints"].items()
                 if j["sliding_factor_peak"] is not None]  # fmt: skip
    return rows


# ---- the part


def stage_part(case, shaken, stage):
    facts, series = case.results.stage_summary(stage), shaken.series(stage)
    part = head(_("Stage {0}: what shook it", stage), 3) + records(shaken, case.scene.gravity) + set_up(case, shaken, stage)
    part += head(_("Not modelled"), 3) + notes(not_modelled(case, stage, shaken.shakings, series))
    rows = joint_rows(shaken, stage, series)
    if rows:
        part += head(_("Joints over time"), 3) + table((_("joint"), "", "", _("at [s]")), rows, (2, 3)) + small(
            _("Slip since the stage began, positive when the upper side moves towards the end of the joint; of a net of joints sizes, "
              "and sums of forces. The factor of one moment is no verdict."))  # fmt: skip
        part += notes(newmark_words(shaken, stage, series))
    if series.probes:
        part += head(_("Points"), 3) + table((_("point"), "", _("largest, less the ground [mm]"), _("largest, absolute [mm]"), _("absolute at the end [mm]")), point_rows(series), range(2, 5))
        part += small(_("Displacements from the mesh, with those of before the shaking."))
    if shear_rows(series):
        part += head(_("Force of the supports on the model"), 3) + table((_("support"), _("along"), _("largest [kN]")), shear_rows(series), (2,)) + small(
            _("That of all supports is the shear at the bottom of the model, with the inertia of ground that has mass; the shear at the base of a dam is T of its joint."))  # fmt: skip
    part += head(_("Energy"), 3) + table(("", "[kJ]"), energies(facts), (1,))
    if after(case, stage):
        part += head(_("After it"), 3) + table((_("stage"), _("verdict"), _("joint"), _("sliding factor")), after(case, stage), (3,))
    return part


def shaken_part(case, shaken):
    """HTML of all stages that are shaken; empty: none is."""
    part = "".join(stage_part(case, shaken, stage) for stage in shaken.stages if shaken.is_shaken(stage))
    return head(_("Earthquake in time")) + part if part else ""
