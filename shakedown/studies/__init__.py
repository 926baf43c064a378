"""Many runs of one question: maps over initial states, designs over parameters, refinements over meshes.

Maps: ``samplers`` (which initial states: those with a name, the others each from its number alone),
``limit_cycles`` (the distinct limit cycles, how far apart final slips lie, whether all states end in the
same one, why some have no long-term state), ``basin_map`` (the results, at one load factor or several;
the public function, its pieces, the file).

Designs: ``design_point`` (named changes of a joint, a joint as a function of its parameters, all limits of
one joint), ``sweep`` (limits over one or two parameters, the regions between them, the public function).

Meshes: ``refined`` (a table of meshes, what a sequence of numbers does, the public function).
"""
