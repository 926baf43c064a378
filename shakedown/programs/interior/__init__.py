"""Interior points for dense programs: no solver's overhead, one product of matrices an iteration.

``symmetric_cone`` (the positive orthant, with one second-order cone or without), ``small_cones`` (very many
cones of three numbers beside it), ``self_dual`` (the optimum, or the proof that there is none, with the
scaling of Nesterov and Todd and the steps of Mehrotra), ``disc_program`` (discs that share coefficients node
by node), ``dense_programs`` (rows in any units: those that meet in a vertex, the optimum over a cone).
What it finds is a start: rows that meet in the optimum, multipliers to be sharpened. The subpackages
above check it, as they check what a solver says.
"""
