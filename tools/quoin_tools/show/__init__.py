"""Output for people: pictures, the sheet, tables for other programs. It imports readings, ensemble, limit, assess, mesh and base.

style      style of all pictures: colours, fonts, the part of the section they show
plot_mesh  picture of a block mesh
seepage    pictures of the water in joints
joints     pictures of the forces in joints
anchor_pictures  pictures of anchors
stress     pictures of stress, and of its envelope over time
laws       pictures of blocks that yield or crack
shaking    pictures of a stage in time
plots      pictures of a run
mechanism  how a stage fails
limit      limit analysis beside a run: table
limit_picture  thrust and mechanism of limit analysis
limit_both  words about a limit without dilation, held from both sides
limit_part the part of the sheet about limit analysis
modes      shapes of free vibrations
animate    film of a stage in time: to a file
film       composes a film
motion     a record, its spectrum, a block that slides on it, points of a run
section    the section and its bases, for the sheet
section_marks  elevations, drains, labels moved off each other
viewer     one page to look into a run; its script and style are in page/
viewer_data  the data of that page
browser    HTML to PDF
hypertext  pieces of HTML
shaken_part  the part of the sheet about earthquakes in time
spectrum_part  the part about an earthquake by a design spectrum
anchors_part  the part about anchors
materials_part  the parts about materials, lifts, temperature
pushover   force over the displacement of a pushover
report     the sheet: HTML and PDF
front_page  its first page
matrix     the matrix on it: each case and base
main_part  its pages 2 to 4
what_if_part  the dam with each item of what_if: a line and a table
lifts_part lifts over the height
annex      all tables in full behind them
caveats    remarks that limit trust in its numbers, each once
spreadsheet  its tables as a spreadsheet
verify     checks a sheet against its files
export     a run as CSV
dxf        a stage of a run as a drawing
paraview_state  opens a run in ParaView: copied beside its results
ensemble_part  the page of the sheet about an ensemble
ensembles  result of an ensemble: table and pictures
readings_pictures  pictures of the readings of a sensor
updated            what readings have said of the model's parameters: lines, pictures
readings_part  readings as a page, JSON, CSV
compare    two runs side by side
"""
