"""The data of one run of the compiled loops."""

from shakedown.ground.named_state import NamedState
from shakedown.motion.course import Course
from shakedown.motion.plane.active_set import ActiveSet
from shakedown.motion.plane.moving_state import PlaneMotion, Record
from shakedown.motion.plane.rate_problem import Rates


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
