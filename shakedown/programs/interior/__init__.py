"""Interior points for dense programs: no solver's overhead, one product of matrices an iteration.

``symmetric_cone`` (the positive orthant, with one second-order cone or without),
``predictor_corrector`` (the method of Mehrotra, with the scaling of Nesterov and Todd),
``dense_programs`` (programs in any units: rows that meet in a vertex, the optimum over a cone). For very
many cones of three: ``small_cones`` (triples, beside numbers ≥ 0 and one large cone), ``self_dual`` (the
optimum, or the proof that there is none), ``disc_program`` (discs that share coefficients node by node).
What it finds is a start: rows that meet in the optimum, multipliers to be sharpened. The subpackages
above check it, as they check what a solver says.
"""
