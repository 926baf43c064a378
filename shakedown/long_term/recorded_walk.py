"""Cycles one by one, recorded stretch by stretch: a run that was stopped goes on after the last of them."""

from collections.abc import Iterator
from typing import NamedTuple

from shakedown.campaign.recorded_steps import RecordedSteps
from shakedown.campaign.stored_result import Folded, folded, unfolded
from shakedown.motion.cycle_record import Checkpoint, CycleRecord
from shakedown.motion.method import Motion, Walk, cycles_of


class _Stretch(NamedTuple):
    """Cycles that have been followed: how many were before, what they did and left, and where they end."""

    before: int
    records: Folded | None
    pieces: Folded | None
    checkpoint: Checkpoint


def recorded_cycles(
    motion: Motion, most: int, steps: RecordedSteps, *, record: bool = False
) -> Iterator[CycleRecord]:
    """As :func:`~shakedown.motion.method.cycles_of`; the motion stands after each only where it is new."""
    left = most
    while (found := steps.found(lambda stretch: stretch.before == motion.done)) is not None:
        stretch: _Stretch = found.result
        motion.pieces.extend(unfolded(stretch.pieces))
        motion.restore(stretch.checkpoint)
        records = unfolded(stretch.records)
        left -= len(records)
        yield from records
    before, since, records = motion.done, len(motion.pieces), []
    for cycle in cycles_of(motion, left, record=record):
        records.append(cycle)
        yield cycle
        if steps.due:
            kept = folded(records), folded(motion.pieces[since:])
            steps.keep(_Stretch(before, *kept, motion.checkpoint()))
            before, since, records = motion.done, len(motion.pieces), []


def recorded_walk(motion: Motion, most: int, steps: RecordedSteps) -> Walk:
    """As :func:`~shakedown.motion.method.walk`."""
    start = motion.state.u[motion.problem.layout.slips]
    records = tuple(recorded_cycles(motion, most, steps, record=True))
    return Walk(start, records, motion.history)
