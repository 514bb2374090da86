"""Block meshes: the format, pieces for generators, generators. It imports base.

blockmesh    `model.h5`: write, read, check; the only Python module that knows the format
supports     what a support of a scene holds
of_run       the block mesh of a run
meshing      pieces for generators: patches, grading, joining, splitting in triangles, doubling vertices
polygons     Voronoi polygons cut to a section, without short edges
stacks       columns, patches, cantilevers and grids of macroblocks
dam          gravity dam on rock; default: section G1 of the Guilhofrei dam
voronoi      dam of random polygons between facing courses
crest        coping and bonded stones of such a dam
rock         rock that sets of parallel joints cut into blocks
declared     a YAML file of the user's, read key by key, with a line for each mistake
plan         regions, joints and named lines, meshed by gmsh
patterns     stones of a shape: courses with a bond, Voronoi polygons, joint sets
lengths      units of length of drawings and meshes of other programs
curves       entities of a drawing as polylines within a chord
entities     the content of a drawing (DXF): curves by layer, blocks taken apart, within limits
drawing      a DXF drawing as a plan: layers become groups, joints, faces, drains, anchors
draft        a first scene with the names of a section
section      a dam declared in one YAML file
walls        walls in running bond, arches of voussoirs, slopes of stepped blocks
gmsh_import  Gmsh .msh 2.2 and 4.1 to a block mesh, joints at named curves
"""
