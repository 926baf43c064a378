"""Prediction held against simulation.

Reading order: ``plan`` (which load factors and initial states, what is predicted there), ``verify``,
``random_paths`` (other paths through the same loads).
"""
