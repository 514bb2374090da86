"""Python tools of Quoin; run with PYTHONPATH=tools.

blockmesh       the block mesh `model.h5`: write, read, check (the only Python module that knows the format)
meshing         pieces for generators: patches, grading, joining, splitting in triangles, doubling vertices
dam             gravity dam on rock, default section G1 of the Guilhofrei dam
fig6            the triangle dam of the paper's Fig. 6 on rigid ground
stacks          columns, patches, cantilevers and grids of macroblocks for tests and benchmarks
reference_mesh  the meshes of tests/data/reference as block meshes
gmsh_import     Gmsh .msh 2.2 and 4.1 to a block mesh, joints at named curves
plot_mesh       picture of a block mesh
"""

__version__ = "0.1.0"
