"""Failures of real dams, told blind: at which level of the water does which section of Bouzey dam fail (slid in 1884, broke in 1895)?"""

import models

WHAT = "Bouzey dam: level and section at which it fails, as it was built and as it was strengthened"
SOURCE = "facts of 1884 and 1895; levels by the gravity method by hand (examples/published/problems.yaml)"
BY = "what happened; the gravity method by hand"

CREST, HEIGHTS = 22, (0, 3, 6, 9, 11.38, 14, 17)  # of crest and joints above the foundation [m]


def run(case):
    for name in ("bouzey_1884", "bouzey_1895"):
        dry = (("stages.2.flood.loads", ["weight", "water"]), ("stages.1.filled.loads", ["weight", "water"]))
        ours = {}
        for what, changes in (("level of the water at which it fails [m]", ()), ("... friction of 1.0 [m]", (("joints.default.friction", 45),)),
                              ("... without uplift, as was reckoned in 1880 [m]", dry)):
            if case.short and changes and name == "bouzey_1884":
                continue
            ours[what], joint = failing(case.scene_of(name, None, *changes))
            if not changes:
                ours["depth of the section that fails [m]"] = CREST - HEIGHTS[int(joint[1:])]
        if name == "bouzey_1895":
            ours["... 5.60 m thick 12 m below the crest [m]"], _ = failing(case.scene_of(name, models.bouzey(10, True)))
        case.published(name, ours)


def failing(result):
    """Middle of what stands and fails [m above the foundation], and the joint that moves fastest."""
    told = result.stage_summary("flood")
    moves = told["mechanism"]
    return (told["flood"]["stable"] + told["flood"]["failing"]) / 2, max(moves, key=lambda joint: max(moves[joint]["slides"], moves[joint]["opens"]))
