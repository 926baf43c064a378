"""Load steps solved as a whole: slips and gaps after each, for two tangential directions.

They know arrays and small named states, no ``Problem``. Reading order: ``swept_stiffness`` (κ with its
open nodes eliminated, and the state in it), ``sweeps`` (the law at one node, its neighbours held;
Gauss–Seidel over the nodes), ``dense_solver`` (linear equations), ``newton_rounds`` (Newton on
the slipping nodes), ``load_steps`` (both together, the law re-checked, step after step),
``implicit_step`` (what Python calls).
"""

from shakedown.ground.code_cache import ensure_code_can_be_compiled

ensure_code_can_be_compiled()
