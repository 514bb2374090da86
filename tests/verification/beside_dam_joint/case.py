"""The dam on a brittle joint of Code_Aster's tests SSNP142: given uplift, and water that flows in the joint. n columns along the base.

Grout that presses a joint open (SSNP143A); a textbook has oil between two plates."""

import models
import numpy as np
from quoin_tools.mesh.meshing import split_triangles

WHAT = "dam on a brittle joint beside Code_Aster and GEFDYN: given uplift, coupled flow; a joint that grout opens; oil between plates"
SOURCE = "Code_Aster tests SSNP142A, B, E, I, SSNP143A and GEFDYN's numbers in them (examples/published/problems.yaml)"
BY = "Code_Aster, GEFDYN; solutions of textbooks (FOSSEE)"


def run(case):
    given(case, 20 if case.short else 50)
    flowing(case, 10 if case.short else 20)
    grouted(case)
    case.published("plates", {"mean velocity under its pressure drop of 38.4 kPa [m/s]": case.scene_of("plates").stage_summary("flows")["flow"]["inflow"] / 0.01})


def grouted(case):
    def openings(mesh=None):
        result = case.scene_of("grouted_joint", mesh)
        return {y: result.probe("grouted", f"r_{10 * y:.0f}")[0] - result.probe("grouted", f"l_{10 * y:.0f}")[0] for y in (2, 4.5, 5, 8, 8.5)}

    fine, triangles = openings(), openings(split_triangles(models.grouted_joint(10, 20)))
    case.published("grouted_joint", {f"opening {y} m above the base [m]": opening for y, opening in fine.items()}
                   | {f"opening {y} m above the base, triangles of 0.5 m [m]": triangles[y] for y in (2, 5, 8)},
                   {"": (list(fine), [1e6 * opening for opening in fine.values()])})  # fmt: skip


def along(result, stage, field):
    """Returns the field of the base as a function of x [m]."""
    distance, *_, values = result.joint_profile(stage, "base", field)
    return lambda x: float(np.interp(x, distance.ravel(), values.ravel()))


def drawn(opening):
    x = np.linspace(0, 5, 101)
    return x, [1e7 * opening(at) for at in x]


def given(case, n):
    mesh = models.dam_on_joint(n)
    result = case.scene_of("dam_on_joint", mesh)
    opening, sliding, dry = along(result, "uplift", "opening"), along(result, "uplift", "sliding"), along(result, "full", "opening")
    before = along(case.scene_of("dam_on_joint", mesh, ("loads.water.level", 8.8), ("loads.uplift.level", 8.8)), "uplift", "sliding")
    def total(x):
        return 1e12 * opening(x) - 88290 * (1 - x / 5)
    case.published("dam_on_joint", {
        "opening of the heel [m]": opening(0),
        "opening at x = 1.3 m [m]": opening(1.3),
        "closure of the toe [m]": -opening(5),
        "total stress at x = 3.2 m [Pa]": total(3.2),
        "total stress at x = 4.6 m [Pa]": total(4.6),
        "sliding at x = 3.2 m [m]": sliding(3.2),
        "sliding at x = 4.6 m [m]": sliding(4.6),
        "sliding at x = 1.3 m, where the joint is open [m]": sliding(1.3),
        "... twice this less that at 8.8 m of water [m]": 2 * sliding(1.3) - before(1.3),
    } | {f"stress at x = {x} m without uplift [Pa]": 1e12 * dry(x) for x in (1.3, 3.2, 4.6)}, {"with uplift": drawn(opening), "without": drawn(dry)})


def flowing(case, n):
    opening = along(case.scene_of("dam_on_joint_flow", models.dam_on_joint(n)), "full", "opening")
    coarse = {}
    if not case.short:
        other = along(case.scene_of("dam_on_joint_flow", models.dam_on_joint(10)), "full", "opening")
        coarse = {"opening of the heel, base in 10 contacts, not 20 [m]": other(0), "closure of the toe, base in 10 contacts, not 20 [m]": -other(5)}
    case.published("dam_on_joint_flow", {
        "opening of the heel [m]": opening(0),
        "opening at x = 1.3 m [m]": opening(1.3),
        "closure of the toe [m]": -opening(5),
        "closure at x = 4.6 m [m]": -opening(4.6),
    } | coarse, {"": drawn(opening)})
