"""Where the friction stands against its thresholds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.shown_values import down, up

if TYPE_CHECKING:
    from shakedown.joint.problem import Problem
    from shakedown.planar.friction.thresholds import FrictionThresholds, Threshold


def friction_in_words(problem: Problem, limits: FrictionThresholds) -> list[str]:
    """Where the friction of a problem stands against its thresholds, and what follows.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("jump")
    >>> friction_in_words(joint, shakedown.friction_thresholds(joint))[0]
    'The friction lies above the threshold of uniqueness (0.3556757): the evolution may have ...'
    """
    friction = 1.0 if limits.factor else float(problem.f.max())
    closed, opened = limits.uniqueness_in_contact, limits.uniqueness
    if opened is None:
        pairs = [(" with all nodes in contact", closed)]
    elif (opened.low, opened.high) == (closed.low, closed.high):
        pairs = [("", closed)]
    else:
        pairs = [(" with all nodes in contact", closed), (" where nodes separate", opened)]
    sentences = [_uniqueness(friction, where, threshold) for where, threshold in pairs]
    if any(sentence.startswith("It is open") for sentence in sentences):
        sentences.append(
            "Below it a motion has one continuation; above it may have several or none, and then it jumps."
        )
    wedging = limits.wedging
    if wedging.high <= friction:
        sentences.append(
            f"It lies above the threshold of wedging ({up(wedging.high)}): locked-in slip can hold "
            "the joint without any load."
        )
    elif wedging.low <= friction:
        known = f" ({wedging.reason})" if wedging.reason else ""
        sentences.append(f"It is open whether locked-in slip can hold the joint without any load{known}.")
    return sentences


def _uniqueness(friction: float, where: str, threshold: Threshold) -> str:
    name = f"the threshold of uniqueness{where}"
    if friction >= threshold.high:
        return (
            f"The friction lies above {name} ({up(threshold.high)}): the evolution may have several "
            "continuations or none, and then it jumps."
        )
    if threshold.low == threshold.high == np.inf:
        return f"Friction of any size leaves the evolution unique{where}."
    if friction < threshold.low:
        limit = down(threshold.low)
        limit = limit if threshold.low == threshold.high else f"at least {limit}"
        return f"The friction lies below {name} ({limit})."
    between = f"between {down(threshold.low)} and {up(threshold.high)}"
    if np.isinf(threshold.high):
        between = f"at {down(threshold.low)} or above"
    return f"It is open whether the friction lies below {name}, which is only known to lie {between}."
