"""Checks that the loads of the scene file are those that the run applied.

    lines = complaints(case, "full", applied)       case: assessment.Case
"""

from dataclasses import replace

import numpy as np

from quoin_tools.assess import section_cut
from quoin_tools.assess.scene_loads import SceneLoads
from quoin_tools.base.language import _
from quoin_tools.base.solver import SolverError

ALIKE = 0.01  # applied forces of run and scene may differ by this


def asked(case, stage):
    """Returns the solver that is asked for the loads of the scene file in a stage."""
    absent = frozenset(case.scene.absent(stage))
    if absent not in case.solvers:
        case.solvers[absent] = SceneLoads(section_cut.standing(case.mesh, case.scene, stage)[0], case.scene, floods=False)
    return case.solvers[absent]


def complaints(case, stage, run):
    """Returns a line where the loads of the scene file on the section as drawn are not those that the run applied. run: (X, Y) [N] of all of them."""

    def alike(ours):
        return np.hypot(*(ours - run)) <= ALIKE * max(np.hypot(*ours), np.hypot(*run))

    def of(mesh, asked):
        return section_cut.total(section_cut.stage_forces(mesh, case.scene, stage, pressed=asked.of(case.scene, stage).table)[0])[:2]

    try:
        drawn = of(case.mesh, asked(case, stage))
    except SolverError as error:
        return [_("The loads of the scene file are not compared with those of the run: {0}.", error)]
    if alike(drawn):
        return []
    displacement = case.results.stage(stage).displacement  # water presses on faces where they are
    vertices = case.mesh.vertices.copy()
    vertices[case.results.mesh.vertex_file] += displacement
    moved = replace(case.mesh, vertices=vertices)
    if alike(of(moved, SceneLoads(section_cut.standing(moved, case.scene, stage)[0], case.scene, floods=False))):
        far = np.hypot(*displacement.T).max()
        return [_("Loads have turned with faces that moved by up to {0:.2f} m: they give ({1:.1f}, {2:.1f}) kN on the section as drawn, ({3:.1f}, {4:.1f}) kN in the run.", far, *drawn / 1e3, *run / 1e3)]
    return [_("Loads of the scene file give ({0:.1f}, {1:.1f}) kN, the run applied ({2:.1f}, {3:.1f}) kN: the file is not what was run.", *drawn / 1e3, *run / 1e3)]
