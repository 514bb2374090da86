"""Dams that earthquakes made known: periods of Koyna (Abaqus; Chopra and Chakrabarti) and Pine Flat (vibration tests; finite elements with water)."""

import models
import numpy as np

WHAT = "Koyna and Pine Flat dams: frequencies, empty and with water"
SOURCE = "Abaqus example of Koyna; tests of Pine Flat dam quoted by Chopra; Samii and Lotfi 2007, Gorai and Maity 2020 (examples/published/problems.yaml)"
BY = "Abaqus; vibration tests; Samii and Lotfi; Gorai and Maity"


def run(case):
    koyna(case)
    pine_flat(case)


def hertz(result, stage):
    return np.array([mode["f"] for mode in result.stage_summary(stage)["modes"]["list"]])


def koyna(case):
    fine = 2 * np.pi * hertz(case.scene_of("koyna", models.koyna(20, (28, 20)) if case.short else None), "dry")
    theirs = 2 * np.pi * hertz(case.scene_of("koyna", models.koyna(20, (22, 16)), ("materials.dam.element", "reduced")), "dry")
    wider = 2 * np.pi * hertz(case.scene_of("koyna", models.koyna(20, (28, 20), 71)), "dry")
    case.published("koyna", {"mode 1, base of 71 m [rad/s]": wider[0]} | {f"mode {i + 1} [rad/s]": fine[i] for i in range(4)}
                   | {f"mode {i + 1}, 760 elements of reduced integration [rad/s]": theirs[i] for i in range(4)})  # fmt: skip


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
    case.published("pine_flat_full", ours)
