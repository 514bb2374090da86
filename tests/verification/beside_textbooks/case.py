"""Gravity dams of textbooks, by the gravity method: forces on the base, pressures of its ends, sliding."""

WHAT = "gravity dams of textbooks: resultants, pressures of heel and toe, sliding"
SOURCE = "the gravity method of textbooks (examples/published/problems.yaml)"
BY = "by hand, with the formulas of textbooks"


def base(result, stage):
    """V, P [kN], pressures of heel and toe [kPa]."""
    told = result.stage_summary(stage)["joints"]["base"]
    return 1e-3 * told["N"], 1e-3 * told["T"], -1e-3 * told["sigma_linear_start"], -1e-3 * told["sigma_linear_end"]


def run(case):
    for height, friction in ((6, 0.6), (10, 0.75)):
        V, P, heel, toe = base(case.scene_of(f"textbook_dam_{height}"), "uplift")
        ours = {"V [kN]": V, "P [kN]": P, "pressure of the toe [kPa]": toe, "sliding": friction * V / P}
        case.published(f"textbook_dam_{height}", ours | ({"tension of the heel [kPa]": -heel} if height == 10 else {}))
    result = case.scene_of("textbook_dam_70")
    (_, _, heel, toe), (full, _, heel_full, toe_full), (V, P, heel_wet, toe_wet) = (base(result, stage) for stage in ("empty", "full", "uplift"))
    case.published("textbook_dam_70", {
        "empty: pressure of the toe [kPa]": toe, "empty: pressure of the heel [kPa]": heel,
        "full: pressure of the toe [kPa]": toe_full, "full: pressure of the heel [kPa]": heel_full,
        "uplift [kN]": full - V, "with uplift: pressure of the toe [kPa]": toe_wet, "with uplift: pressure of the heel [kPa]": heel_wet,
        "sliding": 0.7 * V / P, "shear friction factor": (0.7 * V + 1400 * 52.5) / P, "sliding by IS 6512": (0.7 * V / 1.5 + 1400 * 52.5 / 3.6) / P,
    })  # fmt: skip
