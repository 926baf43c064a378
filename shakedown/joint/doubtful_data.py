"""Likely mistakes in the data of a joint: a wrong sign, per cent, units, load steps out of order."""

from collections.abc import Iterator

import numpy as np

from shakedown.joint.loading import MEAN_ROUND_OFF
from shakedown.joint.problem import Problem

LARGEST_USUAL_FRICTION = 2.0
LEAST_USUAL_STRAIN = 1e-8  # steel at 2 kPa; with loads in N, mm and a modulus in Pa it is 5e-9 at 1000 MPa
JUMP = 5.0  # times the usual distance of load steps: a step so far from both neighbours may be misplaced
UNALIKE = 100.0  # ratio of stiffnesses of one body beyond which they are probably in different units


def is_pulled_everywhere(problem: Problem) -> bool:
    """Whether the mean load pulls the bodies apart at every node, as with a wrong sign of p_w."""
    mean = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    return bool((mean < 0).all())


def doubtful_data(problem: Problem) -> list[str]:
    """What is unusual in the data of a joint, each in one sentence.

    Examples
    --------
    >>> import shakedown
    >>> doubtful_data(shakedown.example("two-node"))
    []
    """
    hints = list[str]()
    if is_pulled_everywhere(problem):
        hints.append(
            "The mean pressure is negative at every node: compression is positive in p_w. Is its sign right? "
            "Or does an initial gap stay open?"
        )
    if np.any(problem.f > LARGEST_USUAL_FRICTION):
        hints.append(f"The friction coefficient {problem.f.max():g} is unusually large: is it in percent?")
    return [*hints, *_units_in_doubt(problem), *_steps_in_doubt(problem)]


def _units_in_doubt(problem: Problem) -> Iterator[str]:
    """Inconsistent numbers, as where one file is in mm and another one in m."""
    # on as many feet as hold a body it moves without strain, so that C may be zero
    C, strained = problem.A if problem.C is None else problem.C, problem.n > problem.directions + 1
    tangential, normal, coupling = (float(np.abs(each).max()) for each in (problem.A, C, problem.B))
    for key, size, least in (("C", normal, strained / UNALIKE), ("B", coupling, 0.0)):
        if tangential > 0 and not least <= size / tangential <= UNALIKE:
            yield (
                f"The largest stiffness in {key} is {size / tangential:.3g} times the largest in A: are both "
                "in the same units?"
            )
    place = problem.x if problem.coordinates is None else problem.coordinates
    if place is None or tangential == 0:
        return
    extent = float(np.ptp(place.reshape(problem.n, -1), axis=0).max())
    along, across = (np.abs(r).max() / np.diagonal(problem.A).max() for r in (problem.q_w, problem.p_w))
    moved, spacing = float(max(along, across)), extent / problem.n ** (1 / problem.directions)
    if 0 < extent < along or 0 < moved < LEAST_USUAL_STRAIN * spacing:
        yield (
            f"The load is as large as the stiffness times {moved:.3g}, {moved / extent:.2g} of the size of "
            f"the contact, {extent:.3g}: are forces, stiffnesses and positions in the same units?"
        )


def _steps_in_doubt(problem: Problem) -> Iterator[str]:
    """A load step that is there twice, or out of its order."""
    path = np.hstack([problem.q_w, problem.p_w])
    noise, count = MEAN_ROUND_OFF * np.abs(path).max(), problem.m
    onwards = np.abs(np.roll(path, -1, axis=0) - path).max(axis=1)
    if problem.is_domain or count < 3 or onwards.max() <= noise:
        return
    if onwards[-1] <= noise and (problem.q_mean is None or problem.p_mean is None):
        yield (
            "The last load step repeats the first. The period closes by itself, so that it counts twice in "
            "the mean: is it meant to?"
        )
    away = np.minimum(onwards, np.roll(onwards, 1))  # from the nearer neighbour
    for k in np.flatnonzero(away > JUMP * np.median(onwards)):
        apart = np.abs(path - path[k]).max(axis=1)
        apart[[k - 1, k, (k + 1) % count]] = np.inf
        if JUMP * apart.min() < away[k]:
            yield (
                f"Load step {k} lies next to load step {apart.argmin()}, and far from those before and after "
                "it: are the load steps in their order, and each there once?"
            )
            return
