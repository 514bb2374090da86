"""Gravity dams and a retaining wall of textbooks, by the gravity method: forces on the base, pressures of its ends, sliding, an earthquake."""

import models

WHAT = "gravity dams and a retaining wall of textbooks: resultants, pressures of heel and toe, sliding, pseudo-static earthquakes"
SOURCE = "examples of textbooks whose solutions are public programs (examples/published/problems.yaml)"
BY = "solutions of textbooks (FOSSEE)"


def run(case):
    small(case)
    gallery(case)
    tail_and_earth(case)
    leaning(case)
    shaken(case)


def base(result, stage):
    """V, P [kN], pressures of heel and toe [kPa]."""
    told = result.stage_summary(stage)["joints"]["base"]
    return 1e-3 * told["N"], 1e-3 * told["T"], -1e-3 * told["sigma_linear_start"], -1e-3 * told["sigma_linear_end"]


def small(case):
    result = case.scene_of("textbook_dam_45")
    (_, _, heel, toe), (_, _, heel_wet, toe_wet) = base(result, "empty"), base(result, "uplift")
    case.published("textbook_dam_45", {"empty: pressure of the toe [kPa]": toe, "empty: pressure of the heel [kPa]": heel,
                                       "full: pressure of the toe [kPa]": toe_wet, "full: pressure of the heel [kPa]": heel_wet})
    V, P, heel, toe = base(case.scene_of("textbook_dam_6"), "uplift")
    wider = base(case.scene_of("textbook_dam_6", models.gravity_dam([((0, 0), (4.9458, 0)), ((0, 6), (1.5, 6))])), "uplift")
    case.published("textbook_dam_6", {"V [kN]": V, "P [kN]": P, "pressure of the toe [kPa]": toe, "sliding": 0.6 * V / P, "pressure of the toe, base of 4.9458 m [kPa]": wider[3]})
    V, P, heel, toe = base(case.scene_of("textbook_dam_10"), "uplift")
    case.published("textbook_dam_10", {"V [kN]": V, "P [kN]": P, "pressure of the toe [kPa]": toe, "tension of the heel [kPa]": -heel, "sliding": 0.75 * V / P,
                                       "shear friction factor": (0.75 * V + 1400 * 8.25) / P})  # fmt: skip


def gallery(case):
    result = case.scene_of("textbook_dam_70")
    (_, _, heel, toe), (full, _, heel_full, toe_full), (V, P, heel_wet, toe_wet) = (base(result, stage) for stage in ("empty", "full", "uplift"))
    case.published("textbook_dam_70", {
        "empty: pressure of the toe [kPa]": toe, "empty: pressure of the heel [kPa]": heel,
        "full: pressure of the toe [kPa]": toe_full, "full: pressure of the heel [kPa]": heel_full,
        "uplift [kN]": full - V, "with uplift: pressure of the toe [kPa]": toe_wet, "with uplift: pressure of the heel [kPa]": heel_wet,
        "sliding": 0.7 * V / P, "shear friction factor": (0.7 * V + 1400 * 52.5) / P, "sliding by IS 6512": (0.7 * V / 1.5 + 1400 * 52.5 / 3.6) / P,
    })  # fmt: skip


def tail_and_earth(case):
    V, P, heel, toe = base(case.scene_of("textbook_dam_84"), "uplift")
    case.published("textbook_dam_84", {"V [kN]": V, "P [kN]": P, "pressure of the toe [kPa]": toe, "tension of the heel [kPa]": -heel})
    _, _, heel, toe = base(case.scene_of("textbook_retaining"), "filled")
    case.published("textbook_retaining", {"pressure of the toe [kPa]": toe, "pressure of the heel [kPa]": heel})


def alone(case, name, constant, depth, levels):
    """The textbook's force of the water, constant 0.726 k rho g h^2 with a moment of 0.299 k rho g h^3, along x at two points of the face, and the inertia of the dam."""
    force, moment = 0.726 * constant * 0.1 * 9810 * depth**2, 0.299 * constant * 0.1 * 9810 * depth**3
    upper = (moment - levels[0] * force) / (levels[1] - levels[0])
    changes = [("loads.quake", {"type": "pseudo_static", "coefficient": [0.1, 0.08 if depth == 70 else 0], "groups": ["dam"]}),
               ("loads.low", {"type": "point_force", "point": "face_1", "value": [force - upper, 0]}),
               ("loads.high", {"type": "point_force", "point": "face_2", "value": [upper, 0]}),
               ("stages.3.quake.loads", ["weight", "water", "uplift", "quake", "low", "high"])]  # fmt: skip
    return base(case.scene_of(name, None, *changes), "quake")


def leaning(case):
    upper = base(case.scene_of("textbook_zangar"), "shaken")
    whole = base(case.scene_of("textbook_zangar", models.gravity_dam([((0, 0), (30, 0)), ((15, 100), (30, 100))])), "shaken")
    book = base(case.scene_of("textbook_zangar", None, ("loads.quake.coefficient", [0.1 * 0.665 / 0.6789, 0])), "shaken")  # 0.7412 - 0.0073 * 8.53 degrees
    case.published("textbook_zangar", {"shear of the upper 50 m [kN]": upper[1], "shear of all 100 m [kN]": whole[1], "shear of the upper 50 m, the textbook's 0.665 [kN]": book[1]})


def shaken(case):
    V, H, heel, toe = base(case.scene_of("textbook_dam_70"), "quake")
    V_book, H_book, heel_book, _ = alone(case, "textbook_dam_70", 0.712, 70, (35, 60))
    along = "the textbook's water along x alone"
    case.published("textbook_quake_70", {"H [kN]": H, "V [kN]": V, "pressure of the toe [kPa]": toe, "tension of the heel [kPa]": -heel,
                                         f"H, {along} [kN]": H_book, f"V, {along} [kN]": V_book, f"tension of the heel, {along} [kPa]": -heel_book})  # fmt: skip
    V, H, heel, toe = base(case.scene_of("textbook_dam_90"), "quake")
    V_book, H_book, heel_book, toe_book = alone(case, "textbook_dam_90", 0.735, 89, (28, 83))
    case.published("textbook_quake_90", {
        "H [kN]": H, "V [kN]": V, "pressure of the toe [kPa]": toe, "tension of the heel [kPa]": -heel, "sliding": 0.75 * V / H, "shear friction factor": (0.75 * V + 1400 * 73.1) / H,
        f"H, {along} [kN]": H_book, f"V, {along} [kN]": V_book, f"pressure of the toe, {along} [kPa]": toe_book, f"tension of the heel, {along} [kPa]": -heel_book,
    })  # fmt: skip
