"""Many samples of a scene whose properties scatter: how likely it fails. It imports base, mesh and limit.

intervals   how sure a count is: Clopper and Pearson
variables   distributions, truncation, correlation; a stream of numbers by name
sampling    Monte Carlo, Latin hypercubes, Sobol sequences, samples about the design point
design      an ensemble as its file has it
models      what a sample is judged by: the solver, limit analysis
importance  the design point
ranks       samples over the ranks of one MPI allocation
journal     the rows that are there: samples done, also after a kill, also of several halves
running     samples that are missing are run, several at a time
analysis    probability with interval, fragility, sensitivity
workers     samples by processes of the solver that set its scene up once
"""
