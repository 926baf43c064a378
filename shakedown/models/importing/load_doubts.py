"""Doubtful loads: loads that do not vary, or reach no contact node."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.joint.problem import Problem
from shakedown.models.condensation.load_case import MEAN_ROUND_OFF, LoadCase, histories
from shakedown.models.readers.text import quoted


def sampling_doubts(names: Sequence[str], doubts: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Warnings about what load steps do not show of the time functions of loads."""
    return tuple(
        f"load {quoted(name)}: {doubt}" for name, own in zip(names, doubts, strict=True) for doubt in own
    )


def load_doubts(
    cases: Sequence[LoadCase],
    names: Sequence[str],
    unit: FloatArray,
    stiffness: FloatArray,
    held: NDArray[np.bool_],
) -> tuple[str, ...]:
    """Warnings about single loads, and about all of them together.

    Parameters
    ----------
    unit : (L, (d + 1) n)
        The welded reactions of each load at factor 1 [force].
    stiffness
        κ [force/length].
    held : (N,)
        Rows of the stiffness that are held.
    """
    factors = histories(cases)
    mean = factors.period.mean(axis=0) if factors.mean is None else factors.mean
    steps = len(factors.period)
    swing = np.abs(factors.period - mean).max(axis=0)
    still = swing <= MEAN_ROUND_OFF * np.maximum(np.abs(factors.period).max(axis=0), np.abs(mean))
    warnings, stiff = [], float(np.abs(stiffness).max())
    for case, name, reactions, is_still, factor in zip(
        cases, names, unit, still, factors.period.T, strict=True
    ):
        if is_still and (case.history is None or case.history.ndim):
            found = "0" if not factor.any() else f"{factor[0]:.4g}"
            warnings.append(
                f"load {quoted(name)} does not vary: its factor is {found} at every one of {steps} load "
                "step(s)"
            )
        warnings += [f"load {quoted(name)} {how}" for how in _unfelt(case, reactions, stiff, held)]
    if still.all():
        warnings.append(
            f"no load varies over the {steps} load step(s): the periodic part is zero, and every load factor "
            "leaves the joint as it is"
        )
    for case, name, m, factor in zip(cases, names, mean, factors.period.T, strict=True):
        if case.mean is not None and not factor.min() <= m <= factor.max():
            warnings.append(
                f"load {quoted(name)} swings about a mean of {m:.4g} that it never passes: its factors lie "
                f"between {factor.min():.4g} and {factor.max():.4g}"
            )
    return tuple(warnings)


def _unfelt(case: LoadCase, reactions: FloatArray, stiff: float, held: NDArray[np.bool_]) -> list[str]:
    """How a load fails to reach the contact; nothing where it does."""
    acting = [
        part for part in (case.force, case.displacement, case.reactions, case.opened) if part is not None
    ]
    if not any(part.any() for part in acting):
        return ["is zero: it has no effect"]
    sizes = [np.abs(part).max(initial=0.0) for part in (case.force, case.reactions) if part is not None]
    sizes += [stiff * np.abs(part).max() for part in (case.displacement, case.opened) if part is not None]
    # welded reactions that are round-off of the condensation
    if np.abs(reactions).max() > NEGLIGIBLE * max(sizes):
        return []
    if case.force is not None and len(acting) == 1 and not case.force[~held].any():
        return ["acts on held rows only, and reaches no contact node"]
    return ["reaches no contact node: the welded contact carries nothing of it"]


def pulled_open(problem: Problem, gap: FloatArray) -> tuple[str, ...]:
    """A warning about a mean load that does not press the contact together or does not close a gap."""
    p_mean = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    if p_mean.sum() < 0 and gap.max() > 0:
        return (
            f"the mean load leaves an initial gap of up to {gap.max():.3g} open: 'gap' is positive where the "
            "bodies lie apart and negative where they interfere",
        )
    if p_mean.sum() < 0:
        return (
            "the mean load pulls the welded contact open: the normals must point into the (first) body and "
            "reactions must be the forces on it",
        )
    if not p_mean.any():
        return ("no mean load presses the contact together",)
    return ()
