"""What becomes of a joint: shakedown, cyclic slip, ratchetting, separation, or undecided.

Reading order: ``energy_proof`` (a verdict with proof), ``state`` (the answer), ``cycle_map`` (one
cycle as an affine map), ``steady_period`` (what a period says), ``limit_search`` (the limit in closed
form), ``find_state``, ``many_states`` (from many initial slips), ``simulation`` (both roads behind one
function, and their path as a file). Below them ``stepping/``: cycle by cycle with fixed load steps;
``settling/``: the search in compiled code; ``nodes/``: what a period does to each node.
"""
