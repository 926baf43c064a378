"""Prediction held against simulation.

Reading order: ``load_regions`` (where a load factor lies), ``plan`` (which load factors and initial
states, what is predicted there), ``runs`` (the simulations), ``second_road`` (the bounds by another
method), ``open_ends`` (what has no answer, or a disputed one), ``work`` (its pieces, and what is
asked beside), ``verify``, ``random_paths`` (other paths through the same loads).
"""
