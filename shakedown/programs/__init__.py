"""Programs over the rows of a joint: linear ones and cones, in floats and in exact arithmetic.

Reading order: ``equilibration`` (scaling by powers of two), ``vertex`` (polish),
``linear_program`` (HiGHS), ``row_programs`` (load factor and largest margin over all rows),
``polygon`` (corners in the plane), ``cone_program`` (one second-order cone, Clarabel). Below
them ``exact/`` (rational arithmetic) and ``interior/`` (dense interior points).
"""
