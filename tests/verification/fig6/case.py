"""The triangle dam of the paper's Fig. 6 on rigid ground, elastic joint, self-weight and full reservoir."""

import json

from driver import MODELS, REFERENCE, changed
from reference_mesh import from_reference

WHAT = "dam of the paper's Fig. 6: joint stress at toe and heel, crest displacement (V14)"
SOURCE = "fig6_stress_models.json (implicit finite elements with joint segments), meshes of tests/data/reference"
BY = "independent finite elements of this project"

SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-7, "velocity_tolerance": 1e-7, "history_every": 1000},
    "materials": {"dam": {"density": 2400, "young": 30e9, "poisson": 0.2}, "ground": {"density": 0, "rigid": True}},
    "joints": {"default": {"law": "elastic", "k_n": 30e9, "k_s": 10e9}, "base": {}},
    "supports": {"ground": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["dam"]},
              "water": {"type": "reservoir", "faces": "upstream", "level": 100}},
    "stages": [{"full": {"loads": ["weight", "water"]}}],
}


def run(case):
    with open(REFERENCE / "fig6_stress_models.json", encoding="utf-8") as file:
        reference = {(row["fam"], row["n"]): row for row in json.load(file)}
    for family in "GM":
        for n in (8, 16, 32):
            mesh = from_reference(REFERENCE / f"mesh_fig6_{family}_n{n}.json")
            results = case.run_all([(mesh, changed(SCENE, ("joints.base.stress_model", model))) for model in MODELS])
            bases = [result.stage_summary("full")["joints"]["base"] for result in results]
            # the three linear ones are one model as long as the joint is elastic
            toe, heel, crest = zip(*(reference[family, n].get(model, reference[family, n]["trapezoid"]) for model in MODELS))
            what = f"mesh {family}, n = {n}, six models"
            case.check(f"{what}: toe [MPa]", [base["end"]["sigma"] * 1e-6 for base in bases], toe, relative=5e-3)
            case.check(f"{what}: heel [MPa]", [base["start"]["sigma"] * 1e-6 for base in bases], heel, relative=5e-3)
            case.check(f"{what}: crest u_x [mm]", [r.probe("full", "crest")[0] * 1e3 for r in results], crest, relative=2e-3)
