"""Readings of a dam's instruments: read, looked over, and split into water, season and time. It imports ensemble, mesh and base.

sensors    what the columns of a table are: quantity, place, sign, unit, accuracy
cells      cells of a CSV or XLSX file as numbers and dates
table      the readings in SI by date, with all that was found in them
findings   what is odd in a column: wrong units, outliers, jumps, gaps
correlation  how far coefficients scatter whose residuals are correlated
statistics HST and HTT: water, season, time; bands, drift, influence, a held-out year
responses  what each instrument would read in a run of the block model
surfaces   runs over level, season and parameters; polynomials through them, checked against others
posterior  the parameters by the readings: likelihood, samples, what is not identified
drift      a parameter that drifts: which, from when
hybrid     rounds of runs about what the readings allow; files for the ensemble
"""
