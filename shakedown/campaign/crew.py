"""The workers of a campaign: this process, several, or a cluster."""

import multiprocessing
from collections.abc import Callable
from dataclasses import dataclass

from shakedown.ground.argument_kinds import check_count, check_fields
from shakedown.ground.blas_threads import all_cores
from shakedown.ground.errors import SolverError, UsageError

Work = Callable[[int], bytes]  # picklable; the same number gives the same bytes

MOST_LOSSES = 3  # successive workers lost without any piece done: then the work itself is the cause
IN_HAND = 2  # pieces queued per process, or per thread of a cluster


@dataclass(frozen=True)
class Crew:
    """The workers of a campaign.

    Attributes
    ----------
    workers
        Number of processes: 1 is this process itself, None one for each core. More of them
        start afresh and read the script that asks for them, so that it has to keep what it does
        under ``if __name__ == "__main__":``; one that does not is told so.
    scheduler
        Address of a dask scheduler: its workers work, whatever ``workers`` says.
    """

    workers: int | None = 1
    scheduler: str | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        if self.workers is not None:
            check_count("workers", self.workers)
        if self.scheduler is not None and not (isinstance(self.scheduler, str) and self.scheduler):
            raise UsageError(f"scheduler: expected an address, found {self.scheduler!r}")
        if self.processes > 1 and self.scheduler is None and _being_started():
            raise SystemExit(1)  # the worker's copy of the script got here again; the parent reports it

    @property
    def processes(self) -> int:
        """The number of processes."""
        return all_cores() if self.workers is None else self.workers


def _being_started() -> bool:
    """Whether this process is a worker still importing the script of its parent."""
    return bool(getattr(multiprocessing.current_process(), "_inheriting", False))


class Losses:
    """Counts workers lost while nothing gets done, and gives up at ``MOST_LOSSES``."""

    def __init__(self) -> None:
        self.in_a_row = 0

    def progress(self) -> None:
        self.in_a_row = 0

    def another(self) -> None:
        self.in_a_row += 1
        if self.in_a_row >= MOST_LOSSES:
            raise SolverError(
                f"{MOST_LOSSES} workers died one after the other without finishing a piece of work "
                "(killed, or out of memory?)"
            )
