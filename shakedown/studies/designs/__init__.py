"""Designs: how the limits of a joint move with its parameters, and where its first cycle lies.

Reading order: ``parameters`` (named changes of a joint), ``variation`` (a joint as a function of its
parameters), ``design_point`` (all limits of one joint), ``diagram`` (limits over one or two parameters,
and the regions between them), ``sweep`` (all points of a diagram); ``cycle_pattern`` (where a sequence
of contact states first closes to a cycle), ``attacking_states`` (initial slips to try), ``descent`` (from
a cycle down to smaller load factors), ``cycle_search`` (the rounds of the search), ``smallest_cycle``.
"""
