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
    changed = {word: getattr(limits, word).but(**fields) for word, fields in bounds.items()}
    vars(limits).pop("open_nodes", None)  # follows from λ_max
    vars(limits).update(changed, zone=zone)
    return limits
