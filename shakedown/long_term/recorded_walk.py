"""Cycles recorded one by one: a run that was stopped goes on after the last."""

from collections.abc import Iterator

from shakedown.campaign.recorded_steps import RecordedSteps
from shakedown.campaign.stored_result import Folded, folded, unfolded
from shakedown.motion.cycle_record import Checkpoint, CycleRecord
from shakedown.motion.method import Motion, Walk, cycles_of


def recorded_cycles(
    motion: Motion, most: int, steps: RecordedSteps, *, record: bool = False
) -> Iterator[CycleRecord]:
    """As :func:`~shakedown.motion.method.cycles_of`; the motion stands after each only where it is new."""
    stand, records = steps.progress(), list[CycleRecord]()
    if stand.found is not None:
        followed, path, checkpoint = stand.found
        records, motion.pieces = unfolded(followed), unfolded(path)
        motion.restore(checkpoint)

    def where() -> tuple[Folded | None, Folded | None, Checkpoint]:
        return folded(records), folded(motion.pieces), motion.checkpoint()

    yield from list(records)
    for cycle in cycles_of(motion, most - len(records), record=record):
        records.append(cycle)
        yield cycle
        stand.note(where)


def recorded_walk(motion: Motion, most: int, steps: RecordedSteps) -> Walk:
    """As :func:`~shakedown.motion.method.walk`."""
    start = motion.state.u[motion.problem.layout.slips]
    records = tuple(recorded_cycles(motion, most, steps, record=True))
    return Walk(start, records, motion.history)
