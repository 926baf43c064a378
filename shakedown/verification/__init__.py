"""Prediction held against simulation.

Reading order: ``plan`` (which load factors and initial states, what is predicted there),
``second_road`` (the bounds by another method), ``verify``, ``random_paths`` (other
paths through the same loads).
"""
