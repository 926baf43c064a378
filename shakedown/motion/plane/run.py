"""The data of one run of the compiled loops, and its progress."""

from typing import NamedTuple

from shakedown.ground.named_state import NamedState
from shakedown.motion.plane.active_set import ActiveSet
from shakedown.motion.plane.moving_state import Course, PlaneMotion, Record
from shakedown.motion.plane.rate_problem import Rates


class Progress(NamedTuple):
    """Where a run has got to.

    Attributes
    ----------
    passes, step, time
        How often the course has been passed; load steps done of the present
        pass, and share done of the next.
    concerned
        The node for which the motion stopped, or −1.
    """

    passes: int
    step: int
    time: float
    concerned: int


class PlaneRun(NamedState):
    """A moving state with the equations and rates of its nodes, its course and its record."""

    active: ActiveSet
    rates: Rates
    motion: PlaneMotion
    record: Record
    course: Course


def run_along(
    active: ActiveSet, rates: Rates, motion: PlaneMotion, record: Record, course: Course
) -> PlaneRun:
    """The run of a moving state along a course, recorded where the record has capacity."""
    return PlaneRun({}, active=active, rates=rates, motion=motion, record=record, course=course)


def progress(motion: NamedState) -> Progress:
    """Where a moving state has got to on its course."""
    at = motion.content
    return Progress(at.passes, at.step, at.time, at.concerned)
