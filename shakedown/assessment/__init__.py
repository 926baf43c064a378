"""What an engineer asks of a joint, each limit computed once.

Reading order: ``shakedown_bounds`` (lower and upper bound together), ``transient_limit`` (λ_T, up to
which the joint shakes down from its own start).
"""
