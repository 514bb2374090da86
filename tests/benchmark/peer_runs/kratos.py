"""Kratos' explicit central differences on n by n square quadrilaterals: nanoseconds per element and step.

Plane strain, self-weight, the bottom fixed; element TotalLagrangianElement2D4N, or SmallDisplacementElement2D4N with
--small. Seconds are of --steps calls of Solve() after the first, one thread, no output. The last line also holds the
displacement of the top left node and the time, for a comparison of what is computed."""

import KratosMultiphysics as Kratos
from fig6_dam import DENSITY, GRAVITY, POISSON, YOUNG, Clock, arguments, report
from KratosMultiphysics import StructuralMechanicsApplication as Structural

SIDE = 100.0  # [m]


def model_part(model, n, element):
    part = model.CreateModelPart("block", 2)
    for variable in (Kratos.DISPLACEMENT, Kratos.VELOCITY, Kratos.ACCELERATION, Kratos.REACTION, Kratos.VOLUME_ACCELERATION,
                     Kratos.NODAL_MASS, Kratos.FORCE_RESIDUAL, Kratos.RESIDUAL_VECTOR, Structural.MIDDLE_VELOCITY):  # fmt: skip
        part.AddNodalSolutionStepVariable(variable)
    part.ProcessInfo[Kratos.DOMAIN_SIZE] = 2
    part.ProcessInfo[Kratos.COMPUTE_LUMPED_MASS_MATRIX] = True
    masonry = part.CreateNewProperties(1)
    for variable, value in ((Kratos.YOUNG_MODULUS, YOUNG), (Kratos.POISSON_RATIO, POISSON), (Kratos.DENSITY, DENSITY),
                            (Kratos.THICKNESS, 1.0), (Kratos.CONSTITUTIVE_LAW, Structural.LinearElasticPlaneStrain2DLaw())):  # fmt: skip
        masonry.SetValue(variable, value)
    for j in range(n + 1):
        for i in range(n + 1):
            part.CreateNewNode(1 + j * (n + 1) + i, SIDE * i / n, SIDE * j / n, 0.0)
    for j in range(n):
        for i in range(n):
            first = 1 + j * (n + 1) + i
            part.CreateNewElement(element, 1 + j * n + i, [first, first + 1, first + n + 2, first + n + 1], masonry)
    Kratos.VariableUtils().AddDof(Kratos.DISPLACEMENT_X, Kratos.REACTION_X, part)
    Kratos.VariableUtils().AddDof(Kratos.DISPLACEMENT_Y, Kratos.REACTION_Y, part)
    Kratos.VariableUtils().AddDof(Kratos.DISPLACEMENT_Z, Kratos.REACTION_Z, part)
    for node in part.Nodes:
        node.SetSolutionStepValue(Kratos.VOLUME_ACCELERATION_Y, 0, -GRAVITY)
        node.Fix(Kratos.DISPLACEMENT_Z)
        if node.Y0 == 0.0:
            node.Fix(Kratos.DISPLACEMENT_X)
            node.Fix(Kratos.DISPLACEMENT_Y)
    part.SetBufferSize(2)
    return part


def main():
    options = arguments(("--steps", {"type": int, "default": 40}), ("--small", {"action": "store_true"}))
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    Kratos.ParallelUtilities.SetNumThreads(1)
    model = Kratos.Model()
    part = model_part(model, options.n, "SmallDisplacementElement2D4N" if options.small else "TotalLagrangianElement2D4N")
    # half of what a square of this size stands at the speed of pressure waves
    speed = (YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON)) / DENSITY) ** 0.5
    dt = 0.5 * SIDE / options.n / speed
    scheme = Structural.ExplicitCentralDifferencesScheme(1.0, 0.33, 0.0)
    strategy = Structural.MechanicalExplicitStrategy(part, scheme, False, False, True)  # the element measures from where the nodes are
    strategy.SetEchoLevel(0)
    strategy.Initialize()
    clock = None
    for step in range(options.steps + 1):
        if step == 1:
            clock = Clock()
        part.ProcessInfo[Kratos.STEP] = step + 1
        part.CloneTimeStep((step + 1) * dt)
        strategy.Solve()
    cost = clock.read()
    corner = part.GetNode(1 + options.n * (options.n + 1))
    report(elements=options.n**2, ns_per_element_step=cost["cpu_s"] / options.steps / options.n**2 * 1e9, time=(options.steps + 1) * dt,
           u_x=corner.GetSolutionStepValue(Kratos.DISPLACEMENT_X), u_y=corner.GetSolutionStepValue(Kratos.DISPLACEMENT_Y), **cost)


if __name__ == "__main__":
    main()
