"""Statics and rules beside the block model. It imports mesh and base.

scene_loads         loads on faces of a scene that has not been run, from the solver
section_cut         a path through the mesh: its base, the part above, the forces on that part
uplift              uplift by the rules of the guidelines
gravity             the gravity method on one base
crack_start         whether a crack starts, by the criterion of a guideline
crack_notes         what the criteria of a guideline about cracks do on a base
heel                at which end of a joint the water stands
joint_uplift        uplift in other joints than the base, as loads of a cut
base_names          checks the names of bases in the options
base_water          the water on a base: by rule, of the scene, computed
surface             the level of water at the faces on which it presses
merged_anchors      anchors in the gravity method
wedge               the passive wedge at the toe
broken              a base with a key or steps as one plane
strength            strength of a path from its joints and blocks
earthquake          the factor at which a pseudo-static earthquake moves the part above
guidelines          limits of guidelines (guidelines.yaml) against numbers of a base
combinations        load combinations of a guideline: which one a case belongs to
planes              contact, lift or foundation: the kind of a base
partial_factors     partial factors on strengths and actions, by hand and in the run
assessment_options  options that the tables and the sheet share
method_differences  why block model and gravity method differ
judgement           limits of a guideline against the numbers of a base
load_check          are the loads of the scene file those of the run?
assessment          every joint that is a line, and any path, in every stage
sliding_paths       a path through a joint that is no base by itself
terminal            the tables of the gravity method in the terminal
lifts               level sections over the height
danger_level        from which level of the water a limit is broken, and the gravity method finds no safety
spectrum            response spectrum of a record
design_spectrum     response spectrum of a standard or a table, for design
modal_sums          sums of modes: SRSS, CQC, the part that follows the ground
modal_parts         inertia of modes on the part above a plane: blocks and water
compressible_water  pressure of a reservoir on a dam that swings
fenves_chopra       the first mode with reservoir and rock, the others as they follow the ground
by_spectrum         a design spectrum on the planes of a dam, three ways beside each other
spectrum_tables     its tables
newmark             Newmark's sliding block
shaken              Newmark's block beside a stage in time
not_modelled        effects that a shaken stage leaves out
hinges              limits of rigid hinges from runs with two stiffnesses
"""
