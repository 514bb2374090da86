"""The command `quoin` and its Python interface: everything together, on top of the solver. It imports all other rooms.

running     runs or checks a scene with the solver
scene_check checks of a scene what the solver does not: what_if, uplift against a guideline
new         makes a folder with a scene and a block mesh to begin with
importing   makes a block mesh of a section, a drawing, a Gmsh file; generators of meshes
show        prints the numbers of a run, draws a block mesh
study       a scene over values of its keys: a table
cases       load combinations of a guideline as loads and stages of a scene
ensemble    samples of a scene that scatters
readings    readings of instruments: findings, statistics
topics      help about keys and documents, in 80 columns
python      run() for Python programs
schema      the JSON Schema of the scene, for editors
site        opens the pages with a search, in a browser
main        the commands: which function each calls, how it ends
"""
