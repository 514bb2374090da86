"""The command `quoin` and its Python interface: everything together, on top of the solver. It imports all other rooms.

running     run, check, advise: the solver with a scene
new         a folder with a scene and a block mesh to begin with
show        the numbers of a run, its pictures and films; the picture of a block mesh
study       a scene over values of its keys: a table
ensemble    samples of a scene that scatters
topics      help about keys and documents, in 80 columns
python      run() for Python programs
schema      the JSON Schema of the scene, for editors
main        the commands: which function each calls, how it ends
"""
