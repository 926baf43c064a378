"""What a joint is: stiffness, friction, loading, and the frictional constraints that follow.

Reading order: ``problem`` (read-only data, validated once), ``fields`` (the shape of every field; how large
and small numbers may be; text, names, JSON), ``places`` (areas, directions and faces of the nodes),
``contact_surface`` (strips, patches in space, and their edges),
``hat_functions`` (a joint averaged over a length), ``law`` (where the slip
and the gap of a node stand; Coulomb's law: an interval or a disc), ``rigid_slips`` (motions of a body that
only friction holds, and where they are pinned), ``constraints`` (constant and periodic part of the loads,
load factor, initial gaps; the rows G v + λ d ≤ g of the thesis, (5.3)–(5.7), or cones), ``contact_zone`` (a
joint with some nodes open, the joints that a joint falls into), ``units`` (loads in units of their own,
likely mistakes), ``arguments`` (checks of arguments; what is built once for a problem), ``result`` (common
methods of results).
"""
