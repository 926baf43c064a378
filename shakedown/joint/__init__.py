"""What a joint is: stiffness, friction, loading, and the frictional constraints that follow.

Reading order: ``problem`` (the data, validated once), ``field_table`` (every field once: its part, its
shape), ``numbers`` (how large and small they may be; stiffness, unit loads), ``texts`` (text, names,
JSON), ``places`` (areas, directions and faces of the nodes),
``contact_patches`` (its patches in space), ``contact_surface`` (strips, patches and their edges),
``hat_functions`` (a joint averaged over a length), ``read_only`` (protected arrays), ``layout`` (where
the slip and the gap of a node stand), ``law`` (Coulomb's law: an interval or a disc), ``loading``
(constant and periodic part, load factor, initial gaps), ``conjugate_loads`` (how many units of each load
act), ``rigid_slips`` (motions of a body that only friction holds, and where they are pinned),
``constraints`` (the rows G v + λ d ≤ g of the thesis, (5.3)–(5.7), or cones), ``contact_zone`` (a joint
with some nodes open), ``coupled_parts`` (the joints that a joint falls into), ``derived`` (data derived
from a problem, built once), ``units``, ``arguments`` (checks of arguments), ``doubtful_data`` (likely
mistakes), ``result`` (common methods of results).
"""
