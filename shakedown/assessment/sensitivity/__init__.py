"""By how much a bound moves with friction, constant load and load amplitude, at every node.

Reading order: ``row_rates`` (how the room in every row changes with a parameter), ``one_sided``
(what that makes of the load factor, on either side), ``sensitivities``.
"""
