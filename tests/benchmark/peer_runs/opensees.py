"""OpenSees on the dam of Fig. 6: quad (2 x 2 points) and tri31, UMFPACK, one load step.

The joint is at the nodes of the base, k_n and k_s times a node's share: zeroLength with elastic springs, or, with
--friction, zeroLengthContact2D (node to node, no tension, Coulomb) and Newton's method to 1e-9 m. Seconds are of analyze(),
without building the model. The stress model pt of the solver under test is the same joint."""

import numpy as np
import openseespy.opensees as ops
from fig6_dam import FRICTION, K_N, K_S, POISSON, YOUNG, Clock, Dam, arguments, report


def build(dam, friction):
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    for i, xy in enumerate(dam.xy.tolist(), 1):
        ops.node(i, *xy)
    ops.nDMaterial("ElasticIsotropic", 1, YOUNG, POISSON)
    for kind, nodes, first in (("quad", dam.quads, 1), ("tri31", dam.triangles, 1 + len(dam.quads))):
        for i, row in enumerate((nodes + 1).tolist(), first):
            ops.element(kind, i, *row, 1.0, "PlaneStrain", 1)
    element = 1 + len(dam.quads) + len(dam.triangles)
    for k, (node, share) in enumerate(zip((dam.base + 1).tolist(), dam.share.tolist())):
        ground, material = len(dam.xy) + 1 + k, 2 + 2 * k
        ops.node(ground, *dam.xy[node - 1].tolist())
        ops.fix(ground, 1, 1)
        if friction:
            ops.element("zeroLengthContact2D", element + k, node, ground, K_N * share, K_S * share, FRICTION, "-normal", 0.0, 1.0)
        else:
            ops.uniaxialMaterial("Elastic", material, K_S * share)
            ops.uniaxialMaterial("Elastic", material + 1, K_N * share)
            ops.element("zeroLength", element + k, ground, node, "-mat", material, material + 1, "-dir", 1, 2)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    for i, force in enumerate(dam.loads.tolist(), 1):
        ops.load(i, *force)


def main():
    options = arguments()
    dam = Dam(options.n)
    build(dam, options.friction)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("UmfPack")
    ops.integrator("LoadControl", 1.0)
    if options.friction:
        ops.test("NormDispIncr", 1e-9, 60)
        ops.algorithm("Newton")
    else:
        ops.algorithm("Linear")
    ops.analysis("Static")
    clock = Clock()
    if ops.analyze(1):
        raise SystemExit("OpenSees: the analysis failed")
    cost = clock.read()
    u_y = np.array([ops.nodeDisp(node, 2) for node in (dam.base + 1).tolist()])
    report(crest=ops.nodeDisp(int(dam.crest) + 1, 1), toe=dam.toe_stress(u_y), iterations=ops.testIter() if options.friction else 1, **cost)


if __name__ == "__main__":
    main()
