"""What programs alone prove about a joint: where shakedown is impossible, and from which states certain.

Reading order: ``registry`` (the kinds of bounds, what each is about, which joints take long),
``bound_result`` (the result of all), ``upper`` (λ_max, most slack at one load factor),
``largest_load_factor`` (of any limits: in the plane by linear programs over rows, in space by cone programs
over ``discs/``; which nodes stay open), ``named_start`` (initial slips by name). ``onset``:
up to where a given slip lasts, and where the contact opens then. Then ``certificate`` (the rows as a program,
exact enclosures), ``independent_solver`` (the bounds by another method). Beside them ``energy/`` and
``accumulated/``: what is proved from a given state on; ``collapse/``: first collapse λ_1 and how far it is a
guarantee; ``uniqueness/``: are motions unique; ``every_state/``: proofs from every initial state;
``enumeration/``: all critical load factors. How λ_max in space is computed, call by call, stands in
``discs/``.
"""
