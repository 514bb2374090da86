"""Modules that every room uses; it imports no other room.

command  how a tool ends: one line for what it cannot do
shared   work shared out to copies of this process
solver   where the solver is, how it starts on some ranks
sample_rows  a solver that takes samples row by row
face_loads  forces of loads on faces, as a run applied them
language  texts of sheets and pictures in the language of the sheet
sheet_units  other units than SI in texts, tables and pictures of the sheet
solver_sentences  sentences of the solver in that language
figures  a number as printed that knows its value in full
files    files written completely or not at all
integrity  are the files of a run undamaged? checksums and headers
flow     water that flows in joints, of a stage
anchors  forces of anchors, of a stage
laws     blocks that yield or crack, of a stage
modes    free vibrations of a stage
terminal  tables for the terminal
results  reader of a run: the only module that knows the files of an output folder
tables   its fields as tables of pandas, with units
units    numbers with units, as the solver reads them
scene    reader of scenes as PETSc reads them
joints   the joint law: keys of a joint in force, strengths in a trial
record   records in time, as the solver reads them
ground   the records that shook a run
histories  histories of joints, envelopes and peaks of stages in time
time_series  time series of a dynamic stage
"""
