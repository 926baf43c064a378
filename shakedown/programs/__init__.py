"""Programs in arrays alone: a linear cost over rows, bounds and second-order cones, in floats and exactly.

Reading order: ``program`` (statement, numbers near 1, solution with residuals), ``scaling`` (by powers
of two), ``solver`` (the road that the cones ask for; planes that cut cones), ``simplex`` (held for many
solves), ``highs`` (what it stands on), ``vertex`` (polish), ``conic`` (Clarabel, cvxpy), ``disc_solver``
(the cones of two tangential directions), ``margin`` (the point with the most room), ``polygon`` (corners in
the plane), ``cone_rays`` (how far a cone reaches). Below them ``exact/`` (rational arithmetic) and
``interior/`` (dense interior points).
"""
