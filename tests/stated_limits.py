"""Limits with other numbers in them, to state what follows from numbers that no joint at hand has."""

from copy import copy
from functools import cache

import shakedown


@cache
def _limits(name):
    return shakedown.assess(shakedown.example(name), open_nodes=()).details


def stated(name="two-node", *, zone="auto", **bounds):
    """The limits of a built-in joint with fields of some of its bounds replaced."""
    limits = copy(_limits(name))
    vars(limits).update(
        {word: getattr(limits, word).but(**fields) for word, fields in bounds.items()}, zone=zone
    )
    return limits
