"""A long run of dependent steps, recorded step by step, and resumed where it was stopped.

The steps of such a run follow from each other and are numbered in the order in which they begin, those within
a step by themselves; the run is simply made again, but for what the steps that are recorded have found. What
a step finds has to be a result: dataclasses, arrays, numbers.
"""

import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import version
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from shakedown.campaign.journal import Journal, journal_at
from shakedown.campaign.stored_result import packed, restored, stored, unpacked
from shakedown.ground.errors import ProblemError, ShakedownError
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem

EVERY = 1.0  # seconds of work recorded together, which a kill may cost
LEISURE = 20.0  # least interval between snapshots of a step, as a multiple of the time one takes
SIZE = 1 << 22  # approximate bytes per second written for such snapshots, of which only the latest is used
WASTE = 1 << 24  # bytes of superseded snapshots at which the file is compacted, if they are most of it

T = TypeVar("T")


class _Place(NamedTuple):
    """The place of a recorded step: its group, and its range in it."""

    group: int
    start: int
    end: int


class RecordedSteps:
    """The steps of one run; recorded where there is a journal, else simply done.

    Parameters
    ----------
    problem
        The joint that the run is about.
    journal
        Where they are recorded; None: nowhere.

    Examples
    --------
    >>> import shakedown
    >>> steps = RecordedSteps(shakedown.example("two-node"))
    >>> steps.done(lambda: 2 + steps.done(lambda: 3))
    5
    """

    def __init__(self, problem: Problem, journal: Journal | None = None) -> None:
        self.problem, self._journal = problem, journal
        self._places: dict[str, _Place] = {}
        self._waiting: dict[str, bytes] = {}  # results that are not recorded yet
        self._read = -1, b""  # the group that was read last
        self._begun = [0]  # how many steps have begun, within each that has not ended
        self._since, self._wait = time.monotonic(), EVERY
        for group in () if journal is None else sorted(journal.done()):
            self._note(group)

    def done(self, step: Callable[[], T]) -> T:
        """The result of a step, computed or recorded; steps may be nested."""
        if self._journal is None:
            return step()
        name = self._enter()
        found = self._recorded(name)
        if found is not None:
            return found.result
        self._begun.append(0)
        try:
            result = step()
        finally:
            self._begun.pop()
        for kept in (self._waiting, self._places):
            for within in [key for key in kept if key.startswith(f"{name}/")]:
                del kept[within]
        self._waiting[name] = stored(result, self.problem)
        if time.monotonic() - self._since >= EVERY:
            self.record()
        return result

    def progress(self) -> "StepProgress":
        """The point at which the present step was stopped, and the means to report its progress."""
        name = self._enter()
        found = self._recorded(name)
        return StepProgress(self, name, None if found is None else found.result)

    @property
    def _due(self) -> bool:
        """Whether a long step should report its progress."""
        return self._journal is not None and time.monotonic() - self._since >= self._wait

    def _record_progress(self, name: str, progress: Any) -> None:
        """Record how far a step has got, in place of what was said before."""
        began = time.monotonic()
        self._waiting[name] = stored(progress, self.problem)
        size = len(self._waiting[name])
        self.record()
        self._wait = max(EVERY, LEISURE * (time.monotonic() - began), size / SIZE)

    def _enter(self) -> str:
        """Begin the next step: its name is its number, behind those of the steps that it is within."""
        *around, number = self._begun
        self._begun[-1] += 1
        return "/".join([*(str(begun - 1) for begun in around), str(number)])

    def record(self) -> None:
        """Record what waits for it."""
        if not self._waiting or self._journal is None:
            return
        ends = np.cumsum([len(result) for result in self._waiting.values()])
        content = np.frombuffer(b"".join(self._waiting.values()), dtype=np.uint8)
        names = np.array(list(self._waiting))
        group = max(self._journal.done(), default=-1) + 1
        self._journal.add(group, packed({"names": names, "ends": ends, "results": content}))
        self._place(group, names.tolist(), ends.tolist())
        self._waiting, self._since = {}, time.monotonic()
        self._tidy(self._journal)

    def _tidy(self, journal: Journal) -> None:
        """Leave out what other steps have taken the place of."""
        for group in journal.done() - {place.group for place in self._places.values()}:
            journal.drop(group)
        if journal.waste > max(WASTE, journal.size - journal.waste):
            journal.compact()

    def _place(self, group: int, names: list[str], ends: list[int]) -> None:
        spans = zip([0, *ends[:-1]], ends, strict=True)
        self._places |= {name: _Place(group, *span) for name, span in zip(names, spans, strict=True)}

    def remove(self) -> None:
        """Forget the run, which is over and saved."""
        if self._journal is not None:
            self._waiting = {}
            self._journal.remove()

    def _note(self, group: int) -> None:
        """Where the steps of a group of the journal lie; one that is none is left out."""
        assert self._journal is not None
        try:
            about = unpacked(self._journal.piece(group), "names", "ends")
            self._place(group, about["names"].tolist(), about["ends"].tolist())
        except (ProblemError, TypeError, ValueError):
            self._journal.drop(group)

    def _recorded(self, name: str) -> "RecordedAnswer[Any] | None":
        """The recorded result of a step, where it can be read."""
        place = self._places.get(name)
        if place is None or self._journal is None:
            return None
        try:
            if self._read[0] != place.group:
                content = unpacked(self._journal.piece(place.group), "results")["results"]
                self._read = place.group, content.tobytes()
            return RecordedAnswer(restored(self._read[1][place.start : place.end], self.problem))
        except ProblemError:
            return None


class RecordedAnswer(NamedTuple, Generic[T]):
    """A recorded result, which may be None."""

    result: T


class StepProgress(NamedTuple):
    """The progress record of a long step.

    Attributes
    ----------
    steps, name
        Whose it is, and which.
    found
        Where a run before was stopped; None at the beginning.
    """

    steps: RecordedSteps
    name: str
    found: Any

    def note(self, progress: Callable[[], Any]) -> None:
        """Record how far it has got, if it is time to."""
        if self.steps._due:
            self.steps._record_progress(self.name, progress())


@contextmanager
def recorded_steps(
    path: str | os.PathLike[str] | None, header: Mapping[str, str], problem: Problem, *, resume: bool = False
) -> Iterator[RecordedSteps]:
    """The steps of a run, recorded at a path as they are done, or nowhere; the caller removes them.

    Parameters
    ----------
    path
        Where; None: nowhere.
    header
        What the run is, by name: everything that its results depend on.
    problem
        The joint that it is about.
    resume
        Whether to go on with what is recorded there, if anything is.

    Raises
    ------
    UsageError
        As :func:`~shakedown.campaign.journal.journal_at`.
    """
    if path is None:
        yield RecordedSteps(problem)
        return
    with journal_at(path, header, resume=resume) as journal:
        steps = RecordedSteps(problem, journal)
        try:
            yield steps
        except ShakedownError:
            raise  # what cannot be done is not to be gone on with, unless much was done before
        except BaseException:
            steps.record()
            raise
        steps.record()


def run_header(run: str, problem: Problem, tolerances: Tolerances, asked: dict[str, Any]) -> dict[str, str]:
    """Everything that a run depends on, by name: the task, the joint, the settings."""
    about: dict[str, Any] = {"problem": problem.fingerprint, "stiffness_accuracy": problem.stiffness_accuracy}
    known = {"run": run, "version": version("shakedown-bounds"), "tolerances": repr(tolerances)}
    return known | {word: repr(value) for word, value in (about | asked).items()}
