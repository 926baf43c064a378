"""Linear programs, in floats and in exact arithmetic. Nothing here knows what a contact is.

Reading order: ``equilibration`` (scaling by powers of two), ``vertex`` (polish),
``linear_program`` (HiGHS),
``widest`` (largest margin), ``integer_algebra`` (FLINT), ``exact_rows`` (a problem's rows without
round-off), ``exact_program`` (exact optimality of a basis).
"""
