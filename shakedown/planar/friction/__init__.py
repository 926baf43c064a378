"""Friction coefficients at which the evolution stops being unique, or a joint wedges.

Reading order: ``thresholds`` (single node, in contact, with open nodes), ``wedging``.
"""
