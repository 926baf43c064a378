"""The run of a campaign: missing pieces are computed, and recorded as they finish."""

from collections.abc import Callable, Iterator

from shakedown.campaign.crew import Crew, Work
from shakedown.campaign.journal import Journal
from shakedown.ground.errors import ShakedownError
from shakedown.joint.problem import Problem

Progress = Callable[[int, int], None]
Fits = Callable[[int, bytes], bool]


def run_campaign(
    work: Work,
    count: int,
    journal: Journal,
    crew: Crew | None = None,
    progress: Progress | None = None,
    fits: Fits | None = None,
) -> None:
    """Do the pieces 0 … count − 1 of a campaign that its journal does not hold yet.

    Parameters
    ----------
    work
        From the number of a piece to its bytes; see the subpackage's docstring.
    count
        How many pieces there are.
    journal
        Where they are recorded, each as soon as it is done.
    crew
        Who works; this process by default.
    progress
        Called as ``progress(done, count)`` at the start and after each piece.
    fits
        Whether a piece that is recorded can be what the work gives for its number; one that
        cannot is done again.

    Raises
    ------
    UsageError
        If the cluster does not answer, or the journal cannot be written.
    SolverError
        If workers die again and again with nothing done.

    Examples
    --------
    >>> from shakedown.campaign.journal import journal_at
    >>> with journal_at(None, {}) as journal:
    ...     run_campaign(lambda number: bytes([number]), 3, journal)
    ...     list(journal.pieces())
    [b'\\x00', b'\\x01', b'\\x02']
    """
    for number in journal.done():
        if number >= count or not (fits is None or fits(number, journal.piece(number))):
            journal.drop(number)
    done = journal.done()
    todo = [number for number in range(count) if number not in done]
    finished = count - len(todo)
    if progress is not None:
        progress(finished, count)
    for number, piece in _worked(work, todo, crew or Crew()):
        journal.add(number, piece)
        finished += 1
        if progress is not None:
            progress(finished, count)


def _worked(work: Work, todo: list[int], crew: Crew) -> Iterator[tuple[int, bytes]]:
    """(number, piece) of all missing pieces."""
    if not todo:
        return
    if crew.scheduler is not None:
        from shakedown.campaign.cluster import by_cluster  # dask is needed only here

        yield from by_cluster(work, todo, crew.scheduler)
    elif crew.processes == 1 or len(todo) == 1:
        yield from ((number, work(number)) for number in todo)
    else:
        from shakedown.campaign.processes import by_processes

        yield from by_processes(work, todo, crew.processes)


def function_stamp(make: Callable[..., Problem], *first: object) -> str:
    """Its name, and the fingerprint of what it makes of its first arguments: it may have been changed.

    Examples
    --------
    >>> import shakedown
    >>> function_stamp(shakedown.example, "two-node")[:45]
    'shakedown.files.examples.example 3053854690ce'
    """
    try:
        made = make(*first)
        found = made.fingerprint if isinstance(made, Problem) else type(made).__name__
    except ShakedownError as error:  # no such joint is an answer, too
        found = str(error)
    return f"{getattr(make, '__module__', '')}.{getattr(make, '__qualname__', repr(make))} {found}"
