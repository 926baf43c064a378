"""Cycles one by one, recorded as they are followed: a run that was stopped goes on after the last of them."""

from collections.abc import Iterator

from shakedown.campaign.recorded_steps import RecordedSteps
from shakedown.campaign.stored_result import Folded, folded, unfolded
from shakedown.motion.cycle_record import Checkpoint, CycleRecord
from shakedown.motion.method import Motion, Walk, cycles_of


def recorded_cycles(
    motion: Motion, most: int, steps: RecordedSteps, *, record: bool = False
) -> Iterator[CycleRecord]:
    """As :func:`~shakedown.motion.method.cycles_of`; the motion stands after each only where it is new."""
    halt, records = steps.halt(), list[CycleRecord]()
    if halt.found is not None:
        followed, path, checkpoint = halt.found
        records, motion.pieces = unfolded(followed), unfolded(path)
        motion.restore(checkpoint)

    def progress() -> tuple[Folded | None, Folded | None, Checkpoint]:
        return folded(records), folded(motion.pieces), motion.checkpoint()

    yield from list(records)
    for cycle in cycles_of(motion, most - len(records), record=record):
        records.append(cycle)
        yield cycle
        halt.note(progress)


def recorded_walk(motion: Motion, most: int, steps: RecordedSteps) -> Walk:
    """As :func:`~shakedown.motion.method.walk`."""
    start = motion.state.u[motion.problem.layout.slips]
    records = tuple(recorded_cycles(motion, most, steps, record=True))
    return Walk(start, records, motion.history)
