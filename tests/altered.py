"""Results with another number in them, as an error of the toolkit would leave it."""

from copy import copy
from dataclasses import replace

from shakedown.assessment.assess import Assessment


def with_limits(verification, **found):
    """A verification whose limits say something else."""
    limits = copy(verification.limits)
    vars(limits).update(found)
    return replace(verification, assessment=Assessment(limits))
