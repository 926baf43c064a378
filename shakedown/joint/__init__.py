"""What a joint is: stiffness, friction, loading, and the frictional constraints that follow.

Reading order: ``problem`` (the data, validated once), ``field_values`` (one field of them, and
how large and small numbers may be), ``loading`` (constant and periodic part, load factor),
``rigid_slips`` (motions of a body that only friction holds, and where they are pinned),
``constraints`` (the rows G v + λ d ≤ g of the thesis, (5.3)–(5.7)), ``contact_zone`` (a joint
with some nodes open), ``initial_gap`` (gaps and interference), ``derived`` (what a problem
determines is built once), ``units``, ``arguments`` (checks of what callers pass in), ``result``
(what every result can do).
"""
