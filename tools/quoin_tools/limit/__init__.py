"""Limit analysis beside the simulation: the largest load that rigid blocks can bear. It imports mesh, base and assess.

assembly   bodies and the faces where they meet, supports, from a block mesh and its scene
anchor_limits  anchors, grouted bars and dowels between bodies
forces     loads of a stage on each body
water      water that flows in joints, as a run has found it, on each body
program    the linear programme: multiplier, forces, mechanism
solvers    Clarabel and HiGHS, and the checks of their solutions
cracked    the limit with water in the crack of a joint
bounds     the limit of a stage: load factor, level of a flood, reduction of strengths
raised     what the trials of a stage raise: a factor, a level, or a divisor of strengths
path       rigid blocks whose joints slide without dilation, step by step until they move
mechanism  a mechanism without dilation, checked with the forces that keep it going
standing   runs of the solver near the limit, their forces checked
beside     runs of the solver beside what the main thread computes
both       the limit without dilation from both sides
"""


class LimitError(ValueError):
    """Limit analysis does not apply; the message is one line."""
