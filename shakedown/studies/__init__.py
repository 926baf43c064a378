"""Many runs of one question: maps over initial states, designs over parameters, refinements over meshes.

Maps: ``samplers`` (which initial states: those with a name, the others each from its number alone),
``map_pieces`` (the long-term states of some of them), ``map_file`` (all of them on disk), ``limit_cycles``
(the distinct limit cycles, how far apart final slips lie), ``final_states`` (whether all states end in the
same one, and why some have no long-term state), ``basin_map`` (the results, at one load factor or several),
``mapping`` (the public function).

Designs: ``parameters`` (named changes of a joint), ``variation`` (a joint as a function of its
parameters), ``design_point`` (all limits of one joint), ``diagram`` (limits over one or two parameters,
and the regions between them), ``sweep`` (all points of a diagram).

Meshes: ``refined`` (a table of meshes, and what a sequence of numbers does), ``finer_meshes`` (the study).
"""
