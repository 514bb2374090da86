"""Limit analysis beside the simulation: what rigid blocks can bear at most. It imports mesh, base and assess.

assembly   bodies, the faces where they meet, supports and anchors, from a block mesh and its scene
forces     loads of a stage on each body
program    the linear programme: multiplier, forces, mechanism, and the checks of its solution
friction   the estimate for friction without dilation, by a sequence of programmes
bounds     the limit of a stage: load factor, level of a flood, reduction of strengths
"""
