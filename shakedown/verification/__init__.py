"""Prediction held against simulation.

Reading order: ``from_state`` (energy or box bound), ``plan`` (which load factors and
initial states, what is predicted there),
``arrival`` (what the transient leaves of a state), ``second_road`` (the bounds by another
method), ``open_ends`` (what has no answer, or a disputed one), ``verify``,
``random_paths`` (other paths through the same loads).
"""
