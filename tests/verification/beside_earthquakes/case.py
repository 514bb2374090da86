"""Earthquakes: periods and cracks of Koyna dam (Abaqus; crack models), periods of Pine Flat (vibration tests; finite elements with water), Newmark's block."""

import models
import numpy as np

WHAT = "Koyna and Pine Flat dams: frequencies, empty and with water, where Koyna cracks; a block that slides under a pulse"
SOURCE = "Abaqus example of Koyna, Bhattacharjee and Leger 1993, Lee and Fenves 1998; Newmark 1965; tests of Pine Flat dam quoted by Chopra; Samii and Lotfi 2007, Gorai and Maity 2020 (examples/published/problems.yaml)"
BY = "Abaqus; crack models of others; Newmark; vibration tests; Samii and Lotfi; Gorai and Maity"


def run(case):
    koyna(case)
    cracks(case)
    pine_flat(case)
    history = case.scene_of("newmark_block").history
    case.published("newmark_block", {"slip [m]": history["ground_ux_m"][-1] - history["foot_ux_m"][-1]})


def hertz(result, stage):
    return np.array([mode["f"] for mode in result.stage_summary(stage)["modes"]["list"]])


def koyna(case):
    fine = 2 * np.pi * hertz(case.scene_of("koyna", models.koyna(20, (28, 20)) if case.short else None), "dry")
    theirs = 2 * np.pi * hertz(case.scene_of("koyna", models.koyna(20, (22, 16)), ("materials.dam.element", "reduced")), "dry")
    wider = 2 * np.pi * hertz(case.scene_of("koyna", models.koyna(20, (28, 20), 71)), "dry")
    case.published("koyna", {"mode 1, base of 71 m [rad/s]": wider[0]} | {f"mode {i + 1} [rad/s]": fine[i] for i in range(4)}
                   | {f"mode {i + 1}, 760 elements of reduced integration [rad/s]": theirs[i] for i in range(4)})  # fmt: skip


def cracked(case, *changes):
    """Heights of the lifts that open while the dam is shaken, the first first."""
    result = case.scene_of("koyna_shaken", None, *changes)
    first = {}
    for joint, told in result.joint_history.items():
        opens = (told["stage"] == "shaken") & (told["open_length"] > 0)
        if opens.any():
            first[(0, 22, 44, 66.5, 78, 90)[int(joint[1:])]] = told["time"][opens][0]
    return sorted(first, key=first.get)


def cracks(case):
    wet = cracked(case)
    ours = {"height of the lift that cracks first [m]": wet[0], "lifts cracked after 3 s, of base and five more": len(wet)}
    if not case.short:
        dry = (("stages.0.full.loads", ["weight"]), ("stages.1.shaken.loads", ["weight"]))
        ours["height of the lift that cracks first, reservoir empty [m]"] = cracked(case, *dry)[0]
    case.published("koyna_shaken", ours)


def pine_flat(case):
    result = case.scene_of("pine_flat")
    low, high = (1 / hertz(result, stage)[0] for stage in ("low", "high"))
    stiffer = case.scene_of("pine_flat", None, ("materials.dam.young", float(22.41e9 * (low / 0.288) ** 2)))
    strain = case.scene_of("pine_flat", None, ("plane", "strain"))
    case.published("pine_flat", {"period, 94 m of water, plane strain [s]": 1 / hertz(strain, "low")[0], "period, 94 m of water [s]": low, "period, 105 m of water [s]": high, "second over first period": high / low,
                                 "period, 105 m of water, modulus for 0.288 s with 94 m [s]": 1 / hertz(stiffer, "high")[0]})  # fmt: skip
    theirs = [("materials.dam.young", 22.75e9), ("materials.dam.density", 2480), ("loads.full.density", 981)]
    ours = {what: hertz(case.scene_of("pine_flat", None, *theirs, ("plane", plane)), "full")[0] for what, plane in
            (("first frequency, reservoir of 116.88 m [Hz]", "strain"), ("... plane stress [Hz]", "stress"))}
    ours["... reservoir to the crest [Hz]"] = hertz(case.scene_of("pine_flat", None, *theirs, ("plane", "strain"), ("loads.full.level", 121.92)), "full")[0]
    case.published("pine_flat_full", ours)
