"""A joint as a function of one or two parameters."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.errors import BudgetExceeded, UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import MANY
from shakedown.ground.visible_text import shortened
from shakedown.joint.arguments import real_array
from shakedown.joint.problem import Problem
from shakedown.models.importing.import_model import Import, import_model
from shakedown.studies.parameters import FACTORS, PARAMETERS, parameter_of, with_parameter

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

    @property
    def meanings(self) -> tuple[str, ...]:
        """Which of ``PARAMETERS`` each one is; empty for numbers of a configuration and a function's own."""
        own = self.base is None
        return tuple("" if own else parameter_of(name) for name in self.parameters)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each parameter; empty where it is not known."""
        base = self.base
        loads = {load.name: load.unit for load in (base.loads if base is not None else ())}
        return tuple(
            PARAMETERS.get(meaning, loads.get(name, ""))
            for name, meaning in zip(self.parameters, self.meanings, strict=True)
        )

    def at(self, values: tuple[float, ...]) -> Problem:
        """The joint at some values of its parameters.

        Raises ``ShakedownError`` where there is no such joint.
        """
        chosen = list(zip(self.parameters, self.meanings, values, strict=True))
        if isinstance(self.joint, Configured):
            numbers = {name: value for name, meaning, value in chosen if not meaning}
            problem = self.joint.with_numbers(numbers)
        elif isinstance(self.joint, Problem):
            problem = self.joint
        else:
            return _made(self.joint(*values))
        for _, meaning, value in chosen:
            if meaning:
                problem = with_parameter(problem, meaning, value)
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
    if isinstance(joint, Problem | Import):
        base = joint if isinstance(joint, Problem) else joint.problem
        _check_meanings(vary, base.load_names or (), imported=isinstance(joint, Import))
    values = tuple(_rising(name, given) for name, given in vary.items())
    if (count := int(np.prod([len(v) for v in values]))) > MANY:
        raise BudgetExceeded(f"vary: {count:,} points are more than {MANY:,}; nothing was computed")
    return Variation(Configured(joint) if isinstance(joint, Import) else joint, tuple(vary)), values


def _check_meanings(names: Iterable[str], loads: Sequence[str], *, imported: bool) -> None:
    """Raise ``UsageError`` where a name means nothing, or may mean two things, or two mean the same."""
    for name in names:
        if not imported and not parameter_of(name):
            found = shortened(repr(name))
            hint = " (a load can be varied in the CONFIG.toml of its import)" if name in loads else ""
            raise UsageError(f"vary: expected one of {', '.join(PARAMETERS)}, found {found}{hint}")
        if imported and name in loads and parameter_of(name):
            raise UsageError(f"vary: expected a name of one thing, found {name!r}, a parameter and a load")
        if imported and name == "friction":
            raise UsageError(
                "vary: expected f (the friction coefficient) or friction.factor (a factor on it), found "
                "'friction', which is both a key of the configuration and the name of the factor"
            )
    meanings = [parameter_of(name) for name in names if parameter_of(name) in FACTORS]
    if len(set(meanings)) < len(meanings):
        raise UsageError(f"vary: expected each parameter once, found the factor {meanings[0]} twice")


def _rising(name: str, given: ArrayLike) -> FloatArray:
    values = real_array(f"vary {shortened(name)}", [given] if isinstance(given, Real) else given)
    if values.ndim != 1 or len(values) == 0:
        raise UsageError(f"vary {shortened(name)}: expected one value or more, found shape {values.shape}")
    falling = np.flatnonzero(np.diff(values) <= 0)
    if falling.size:
        before, after = values[falling[0]], values[falling[0] + 1]
        raise UsageError(f"vary {shortened(name)}: expected rising values, found {after:g} after {before:g}")
    return values
