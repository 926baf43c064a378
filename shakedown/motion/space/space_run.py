"""The data of one run of the compiled loops in space."""

from typing import NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import NamedState
from shakedown.motion.checked_law import Scales
from shakedown.motion.course import JUMPS, LOAD_STEP, Course, Precision
from shakedown.motion.space.moving_state import (
    CompiledJoint,
    CurveRecord,
    SpaceMotion,
    compiled_joint,
    motion_at_rest,
)
from shakedown.motion.space.step_state import (
    EXPLICIT,
    PATIENCE,
    Slipping,
    SpaceRates,
    Step,
    StepControl,
    Turning,
    empty_slipping,
    empty_space_rates,
    empty_step,
    empty_turning,
)


class Measures(NamedTuple):
    """What counts as zero, and how accurate a path is to be.

    Attributes
    ----------
    precision
        Round-off, and how near a limit a node is at it.
    scale
        Of the scene.
    accuracy
        Error allowed for one passage of the course, relative to the length scale.
    """

    precision: Precision
    scale: Scales
    accuracy: float

    @property
    def near(self) -> float:
        """Distance from a limit at which a node is there [force]."""
        return self.precision.settled

    @property
    def of_steps(self) -> dict[str, float]:
        """What steps are measured against, by its name in :class:`StepControl`."""
        scales = {"force_scale": self.scale.force, "length_scale": self.scale.length}
        return scales | {"accuracy": self.accuracy}


class SpaceRun(NamedState):
    """A joint and its moving state, with the data of rates and steps, course and record."""

    joint: CompiledJoint
    motion: SpaceMotion
    rates: SpaceRates
    slipping: Slipping
    step: Step
    turning: Turning
    control: StepControl
    course: Course
    record: CurveRecord


def run_in_space(
    kappa: FloatArray, friction: FloatArray, measures: Measures, course: Course, record: CurveRecord
) -> SpaceRun:
    """A state at rest at the origin of a joint (κ (3n, 3n), f (n,)), at the beginning of a course."""
    n, control = len(friction), StepControl({})
    control.set(**measures.of_steps)
    run = SpaceRun(
        {},
        joint=compiled_joint(kappa, friction),
        motion=motion_at_rest(n),
        rates=empty_space_rates(n),
        slipping=empty_slipping(n),
        step=empty_step(n),
        turning=empty_turning(n),
        control=control,
        course=course,
        record=record,
    )
    begin(run)
    return run


def begin(run: SpaceRun) -> None:
    """Put the state at the start of its course and count from zero."""
    motion = run.motion
    for counted in (motion.slip, motion.work, motion.opened, motion.closed):
        counted[:] = 0
    motion.set(
        passes=0, step=0, time=0.0, entered=False, under_way=False, concerned=-1, crowd=0, events=0, error=0.0
    )
    motion.set(node=-1, kind=LOAD_STEP, came_node=-1, came_kind=LOAD_STEP)
    motion.set(signature=0, last_states=0)
    run.step.set(method=EXPLICIT)
    run.control.set(h=1.0, capped=False, long=1.0, wait=0, patience=PATIENCE, apex_ahead=np.inf, taken=0)


def resume(run: SpaceRun, time: float, kind: int = JUMPS) -> None:
    """Continue after a jump or another change of the state, from a given share of the load step."""
    motion = run.motion
    motion.set(time=time, node=-1, kind=kind, came_node=-1, came_kind=kind)
    motion.set(entered=False, under_way=False, events=motion.events + 1)
