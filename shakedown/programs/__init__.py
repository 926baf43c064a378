"""Programs in plain arrays: a linear cost over rows and bounds, or over discs, in floats and exactly.

Reading order: ``program`` (statement of a linear program, numbers near 1, solution and polish of a vertex;
scaling by powers of two), ``simplex`` (HiGHS, held for many solves; the point with the most slack;
corners of polygons).

Without round-off, through FLINT: ``exact_program`` (systems of integers, optimality of a basis).

Interior points for dense programs, one product of matrices an iteration: ``disc_program`` (cones, very
many of three numbers, those of one, and a large one; discs, and the normal equations), ``self_dual`` (the
optimum, or the proof that there is none, with the scaling of Nesterov and Todd and the steps of Mehrotra).
Their results are only starting points: the subpackages above check them, as they check those of any solver.
"""
