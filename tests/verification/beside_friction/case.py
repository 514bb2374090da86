"""Code_Aster's test SSNV128A: an elastic plate is pressed on a rigid plane and pushed along it, and slides farther where it is pushed."""

WHAT = "elastic plate pushed along a rigid plane with friction, beside Code_Aster and GRECO"
SOURCE = "Code_Aster test SSNV128A (examples/published/problems.yaml)"
BY = "GRECO, Code_Aster"


def run(case):
    result = case.scene_of("plate_on_friction")
    places = {"A, x = 0": "A", "B, x = 1.25 mm": "B", "C, x = 5 mm": "C", "D, x = 7.5 mm": "D", "E, x = 11.25 mm": "E"}
    case.published("plate_on_friction", {f"sliding of {where} [m]": result.probe("pressed", point)[0] for where, point in places.items()})
