"""Compiled loops of the evolution. They know arrays and small named states, no ``Problem``.

Reading order: ``gauss_seidel`` (fixed load steps), ``active_set`` (systems of the moving nodes),
``moving_state`` (the state between events), ``rate_problem`` and ``rate_search`` (rates at an
event), ``event_loop`` (from event to event), ``lemke`` (last resort for the rates), ``code_cache`` (where
compiled code is kept).
"""

from shakedown.kernels.code_cache import ensure_code_can_be_compiled

ensure_code_can_be_compiled()
