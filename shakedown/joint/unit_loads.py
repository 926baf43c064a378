"""Loads by a unit of each: reactions, histories, compliance; whether they give the welded reactions."""

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.numbers import symmetrised


def check_unit_loads(arrays: dict[str, FloatArray]) -> None:
    """Hold the loads of a problem, by key, against its welded reactions; make the compliance symmetric.

    Raises
    ------
    ProblemError
        If the welded reactions less those of the loads differ from load step to load step, the compliance
        is not symmetric, or a frequency not above 0.
    """
    if "load_reactions" not in arrays:
        return
    unit, history = arrays["load_reactions"], arrays["load_history"]
    welded = np.hstack([arrays["q_w"], arrays["p_w"]])
    left = welded - history @ unit
    off = np.abs(left - left[0])
    size = np.abs(welded).max() + (np.abs(history) @ np.abs(unit)).max()
    if off.max() > DEFAULT.printed_digits * size:
        k, j = np.unravel_index(int(off.argmax()), off.shape)
        n = arrays["q_w"].shape[1]
        what = f"q_w[{k},{j}]" if j < n else f"p_w[{k},{j - n}]"
        raise ProblemError(
            "keys 'q_w', 'p_w': expected a constant and load_history @ load_reactions, found "
            f"{what} off by {off.max():.6g} (other loads take the keys load_reactions, load_history along)"
        )
    if "load_compliance" in arrays:
        S = arrays["load_compliance"]
        arrays["load_compliance"] = symmetrised("load_compliance", S, 0.0, float(np.abs(S).max(initial=0.0)))
    for j in np.flatnonzero(arrays.get("load_frequency", np.ones(0)) <= 0):
        raise ProblemError(
            f"key 'load_frequency': expected frequencies > 0 or NaN, found {arrays['load_frequency'][j]:g} "
            f"of load {j}"
        )
