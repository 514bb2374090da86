"""What people look at: pictures, the sheet, tables for other programs. It imports ensemble, limit, assess, mesh and base.

style      what all pictures share: colours, fonts, the part of the section they show
plot_mesh  picture of a block mesh
seepage    pictures of the water in joints
joints     pictures of what joints carry
anchor_pictures  pictures of anchors
stress     pictures of stress, and of its envelope over time
laws       pictures of blocks that yield or crack
shaking    pictures of a stage in time
plots      pictures of a run
mechanism  how a stage fails
limit      limit analysis beside a run: table and picture
limit_part the part of the sheet about it
modes      how a structure swings
animate    film of a stage in time: to a file
film       what a film shows
motion     a record, its spectrum, a block that slides on it, points of a run
section    the section and its bases, for the sheet
section_marks  elevations, drains, labels off each other in it
viewer     one page to look into a run; its script and style are in page/
viewer_data  what that page holds
browser    HTML to PDF
hypertext  pieces of HTML
shaken_part  the part of the sheet about earthquakes in time
anchors_part  that about anchors
materials_part  those about materials, lifts, temperature
translate  the language of sheet and pictures
report     the sheet: HTML and PDF
front_page  its first page
matrix     the matrix on it: each case and base
main_part  its pages 2 to 4
lifts_part lifts over the height
annex      all tables in full behind them
caveats       what speaks against its numbers, each remark once
spreadsheet  its tables as a spreadsheet
verify     a sheet held against the files it is about
export     a run as CSV
dxf        a stage of a run as a drawing
paraview_state  how ParaView opens a run: copied beside its results
ensemble_part  the page of the sheet about an ensemble
ensembles  what an ensemble leaves: table and pictures
compare    two runs side by side
"""
