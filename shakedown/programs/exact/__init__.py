"""Programs without round-off, through FLINT.

Reading order: ``integer_algebra`` (systems of integers), ``exact_program`` (optimality of a basis),
``verified_vertex`` (the same of large ones, by exact residuals).
"""
