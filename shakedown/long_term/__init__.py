"""What becomes of a joint: shakedown, cyclic slip, ratchetting, separation, or undecided.

Reading order: ``outcome``, ``state`` (the answer), ``cycle_map`` (one cycle as an affine map),
``limit_search`` and ``find_state`` (the limit in closed form), ``fixed_steps`` (the Gauss–Seidel
road), ``simulation`` (both roads behind one function), ``transient_limit`` (λ_T).
"""
