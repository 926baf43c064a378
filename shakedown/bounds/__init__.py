"""What programs alone prove about a joint: where shakedown is impossible, and from which states certain.

Reading order: ``registry`` (the kinds of bounds, what each is about), ``bound_result`` (the result of all),
``upper`` (λ_max and the safe slip), ``opened_by_mean_load`` and ``best_zone`` (which nodes
stay open), ``safe_slip`` (most slack at one load factor), ``results`` (their evidence), ``named_start``
(initial slips by name). The methods differ in the plane and in space: ``plane_or_space`` (which of
the two serve a joint), ``plane_methods`` (over ``row_programs`` of all rows),
``space_methods`` (over ``discs/``). ``onset``: up to where a given slip lasts, and where the contact
opens then. Then ``exact_rows`` (a problem's rows without round-off),
``certificate`` (exact enclosures), ``independent_solver`` (the bounds by another method). Beside them
``energy/`` and ``accumulated/``: what is proved from a given state on; ``collapse/``: first collapse λ_1
and how far it is a guarantee; ``uniqueness/``: are motions unique; ``every_state/``: proofs from every
initial state; ``enumeration/``: all critical load factors. How λ_max in space is computed, call by call,
stands in ``discs/``.
"""
