"""Programs in plain arrays: a linear cost over rows and bounds, or over discs, in floats and exactly.

Reading order:

- linear programs: ``program`` (the statement, scaled by powers of two; the solution, and a vertex polished),
  ``simplex`` (HiGHS, held for many solves; the point with the most slack; corners of polygons);
- without round-off, through FLINT: ``exact_program`` (systems of integers, optimality of a basis);
- cone programs by interior points: ``disc_program`` (very many cones of three numbers, those of one, and a
  large one; discs, and the normal equations), ``self_dual`` (the optimum, or the proof that there is none,
  with the scaling of Nesterov and Todd and the steps of Mehrotra).

The results are only starting points: the subpackages above check them, as they check those of any solver.
"""
