"""What is proved of any joint by programs alone: above which load factor never, from which state safely.

Reading order: ``row_programs`` (over all rows of a joint), ``upper`` (λ_max and the safe slip),
``opened_by_mean_load`` and ``best_zone`` (which nodes stay open), ``least_slip`` (the least of a zone's safe
slips), ``safe_slip`` (most room at one load factor), ``exact_rows`` (a
problem's rows without round-off), ``certificate`` (exact enclosures), ``interior_point`` (the second
road to the bounds). Within them ``discs/``: the same with two tangential directions. Above them
``energy/``: what is proved from a given state on.
"""
