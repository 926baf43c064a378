"""Linear programs, in floats and in exact arithmetic. Nothing here knows what a contact is.

Reading order: ``equilibration`` (scaling by powers of two), ``linear_program`` (HiGHS, polished),
``widest`` (largest margin), ``rational`` (exact rows, integer algebra), ``exact_program`` (exact
optimality of a basis).
"""
