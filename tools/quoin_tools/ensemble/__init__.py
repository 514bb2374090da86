"""Many samples of a scene whose properties scatter: how likely it fails. It imports base, mesh and limit.

intervals   confidence of a counted probability: Clopper and Pearson
variables   distributions, truncation, correlation; a stream of numbers by name
sampling    Monte Carlo, Latin hypercubes, Sobol sequences, samples about the design point
design      an ensemble as its file has it
drawn       variables by the posterior that readings have left
models      judges a sample by the solver or by limit analysis
importance  the design point
journal     stores the rows of finished samples, also after a kill, also of several parts
running     runs the missing samples, several at a time, here or over the ranks of one MPI allocation
analysis    probability with interval, fragility, sensitivity
what_if     runs the dams of the section what_if of a scene
workers     a process of the solver that sets a scene up once and takes a sample at a time
"""
