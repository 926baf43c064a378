"""What becomes of a joint: shakedown, cyclic slip, ratchetting, separation, or undecided.

Reading order: ``cycle_log`` (what each cycle did), ``verdict``, ``energy_proof`` (a verdict with
proof), ``state`` (the answer), ``cycle_map`` (one cycle as an affine map), ``steady_period`` (what a
period says), ``limit_search`` (the limit in closed form), ``find_state``, ``many_states``
(from many initial slips), ``fixed_steps`` (the Gauss–Seidel road), ``simulation`` (both roads behind
one function, and their path as a file). Below them ``settling/``: the same search in compiled code.
"""
