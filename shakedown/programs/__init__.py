"""Programs over the rows of a joint: linear ones, in floats and in exact arithmetic, cones, and a search.

Reading order: ``equilibration`` (scaling by powers of two), ``vertex`` (polish),
``linear_program`` (HiGHS), ``row_programs`` (load factor and largest margin over all rows),
``polygon`` (corners in the plane), ``cone_program`` (one second-order cone, Clarabel),
``best_zone`` (which nodes stay open), ``integer_algebra`` (FLINT), ``exact_rows`` (a problem's
rows without round-off), ``exact_program`` (exact optimality of a basis), ``verified_vertex`` (the
same of large ones, by exact residuals), ``blas_threads`` (one thread for small matrices).
"""
