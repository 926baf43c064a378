"""Everything that one run of the compiled loops works on, and where it has got to."""

from typing import NamedTuple

from numba import types
from numba.experimental import structref

from shakedown.ground.named_state import NamedState, entered, keeping
from shakedown.motion.plane.active_set import ACTIVE_SET, ActiveSet
from shakedown.motion.plane.moving_state import COURSE, MOTION, RECORD, Course, Motion, Record
from shakedown.motion.plane.rate_problem import RATES, Rates


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


@structref.register
class RunType(types.StructRef):
    """Compiled type of :class:`Run`."""


class Run(NamedState):
    """A moving state with the equations and rates of its nodes, its course and its record."""

    active: ActiveSet
    rates: Rates
    motion: Motion
    record: Record
    course: Course


structref.define_boxing(RunType, Run)
RUN = RunType(
    [("active", ACTIVE_SET), ("rates", RATES), ("motion", MOTION), ("record", RECORD), ("course", COURSE)]
)


def run_along(active: ActiveSet, rates: Rates, motion: Motion, record: Record, course: Course) -> Run:
    """The run of a moving state along a course, recorded where the record has room."""
    parts = {"active": active, "rates": rates, "motion": motion, "record": record, "course": course}
    return keeping(_run(*parts.values()), parts)


@entered
def _run(active, rates, motion, record, course):  # type: ignore[no-untyped-def]
    run = structref.new(RUN)
    run.active, run.rates, run.motion, run.record, run.course = active, rates, motion, record, course
    return run


def progress(motion: NamedState) -> Progress:
    """Where a moving state has got to on its course."""
    at = motion.content
    return Progress(at.passes, at.step, at.time, at.concerned)
