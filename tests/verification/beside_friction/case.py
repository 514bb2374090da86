"""Friction in Code_Aster's tests: an elastic plate is pressed on a rigid plane and pushed along it (SSNV128A), a joint is closed and sheared (SSNP162D)."""

WHAT = "elastic plate pushed along a rigid plane with friction, a joint closed and sheared, beside Code_Aster and GRECO"
SOURCE = "Code_Aster tests SSNV128A, SSNP162D (examples/published/problems.yaml)"
BY = "GRECO, Code_Aster"


def run(case):
    result = case.scene_of("plate_on_friction")
    places = {"A, x = 0": "A", "B, x = 1.25 mm": "B", "C, x = 5 mm": "C", "D, x = 7.5 mm": "D", "E, x = 11.25 mm": "E"}
    case.published("plate_on_friction", {f"sliding of {where} [m]": result.probe("pressed", point)[0] for where, point in places.items()})
    found = case.scene_of("joint_friction").stage_summary("sheared")["load_factor"]
    case.published("joint_friction", {"largest shear stress [Pa]": 1e6 * (found["stable"] + found["failing"]) / 2})
