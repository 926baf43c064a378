"""A joint as a function of one or two parameters."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from shakedown.designs.parameters import PARAMETERS, with_parameter
from shakedown.errors import BudgetExceeded, UsageError
from shakedown.importing.import_model import Import, import_model
from shakedown.model.arguments import real_array
from shakedown.model.problem import FloatArray, Problem
from shakedown.visible_text import shortened

MOST_POINTS = 1_000_000
ProblemOf = Callable[..., Problem]


@dataclass(frozen=True)
class Configured:
    """A joint from an import configuration; another process imports it again, once."""

    made: Import

    def with_numbers(self, changes: dict[str, float]) -> Problem:
        """The joint with some numbers of its configuration changed."""
        if not changes:
            return self.made.problem
        return import_model(self.made.path, changes=changes, before=self.made).problem

    def __reduce__(self) -> tuple[Callable[[str], "Configured"], tuple[str]]:
        return configured, (os.path.abspath(self.made.path),)


@lru_cache(maxsize=1)
def configured(path: str) -> Configured:
    """The joint of a configuration, read once in a process."""
    return Configured(import_model(path))


@dataclass(frozen=True)
class Variation:
    """A joint, or a function that makes one, with the names of its parameters.

    Attributes
    ----------
    joint
        The joint whose named parameters are varied, one from a configuration whose numbers
        are varied too, or problem(parameter, …).
    parameters
        Names; of a function in the order of its arguments.
    """

    joint: Problem | Configured | ProblemOf
    parameters: tuple[str, ...]

    @property
    def base(self) -> Problem | None:
        """The joint as it stands; None of a function."""
        if isinstance(self.joint, Configured):
            return self.joint.made.problem
        return self.joint if isinstance(self.joint, Problem) else None

    @property
    def name(self) -> str:
        """Name of the joint, or of the function that makes it."""
        return getattr(self.joint, "__name__", "") if self.base is None else self.base.name

    def at(self, values: tuple[float, ...]) -> Problem:
        """The joint at some values of its parameters.

        Raises ``ShakedownError`` where there is no such joint.
        """
        chosen = dict(zip(self.parameters, values, strict=True))
        if isinstance(self.joint, Configured):
            numbers = {name: value for name, value in chosen.items() if name not in PARAMETERS}
            problem = self.joint.with_numbers(numbers)
        elif isinstance(self.joint, Problem):
            problem = self.joint
        else:
            return _made(self.joint(*values))
        for name, value in chosen.items():
            if name in PARAMETERS:
                problem = with_parameter(problem, name, value)
        return problem


def _made(problem: object) -> Problem:
    if not isinstance(problem, Problem):
        raise UsageError(
            f"problem(parameter): expected it to return a Problem, found {type(problem).__name__}"
        )
    return problem


def checked_variation(
    joint: Problem | Import | ProblemOf, vary: Mapping[str, ArrayLike]
) -> tuple[Variation, tuple[FloatArray, ...]]:
    """The joint with its parameters, and their values; ``UsageError`` where they make no grid."""
    if not isinstance(vary, Mapping) or not 1 <= len(vary) <= 2 or not all(isinstance(k, str) for k in vary):
        raise UsageError(f"vary: expected one or two parameters by name, found {shortened(repr(vary))}")
    if not isinstance(joint, Problem | Import) and not callable(joint):
        found = type(joint).__name__
        raise UsageError(f"sweep: expected a Problem, an Import or a function that makes one, found {found}")
    for name in vary:
        if isinstance(joint, Problem) and name not in PARAMETERS:
            found = shortened(repr(name))
            raise UsageError(f"vary: expected one of {', '.join(PARAMETERS)}, found {found}")
    values = tuple(_rising(name, given) for name, given in vary.items())
    if (count := int(np.prod([len(v) for v in values]))) > MOST_POINTS:
        raise BudgetExceeded(f"vary: {count:,} points are more than {MOST_POINTS:,}; nothing was computed")
    return Variation(Configured(joint) if isinstance(joint, Import) else joint, tuple(vary)), values


def _rising(name: str, given: ArrayLike) -> FloatArray:
    values = real_array(f"vary {shortened(name)}", [given] if isinstance(given, Real) else given)
    if values.ndim != 1 or len(values) == 0:
        raise UsageError(f"vary {shortened(name)}: expected one value or more, found shape {values.shape}")
    falling = np.flatnonzero(np.diff(values) <= 0)
    if falling.size:
        before, after = values[falling[0]], values[falling[0] + 1]
        raise UsageError(f"vary {shortened(name)}: expected rising values, found {after:g} after {before:g}")
    return values
