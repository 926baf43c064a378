"""Cycle by cycle, and what the last cycles show.

Reading order: ``cycle_log`` (what each cycle did), ``verdict`` (how the last of them are judged),
``fixed_steps`` (the Gauss–Seidel road).
"""
