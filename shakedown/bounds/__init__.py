"""What is proved of any joint by programs alone: above which load factor never, from which state safely.

Reading order: ``row_programs`` (over all rows of a joint), ``upper`` (λ_max and the safe slip),
``opened_by_mean_load`` and ``best_zone`` (which nodes stay open), ``least_slip`` (the least of a zone's safe
slips), ``safe_slip`` (most room at one load factor), ``exact_rows`` (a
problem's rows without round-off), ``certificate`` (exact enclosures), ``independent_solver`` (the
bounds by another method). Within them ``discs/``: the same with two tangential directions. Above them
``energy/``: what is proved from a given state on; ``collapse/``: first collapse λ_1 and how far it is a
guarantee; ``uniqueness/``: may the motion branch; ``every_state/``: proofs from every initial state;
``enumeration/``: all critical load factors.
"""
