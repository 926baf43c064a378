"""Named parameters of a design: a joint with one of its quantities changed, or as a function of several."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import BudgetExceeded, UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import MANY
from shakedown.ground.visible_text import shortened
from shakedown.joint.arguments import is_finite, real_array, require_problem
from shakedown.joint.conjugate_loads import NO_LOADS, scaled_units
from shakedown.joint.loading import Loading, loading
from shakedown.joint.problem import Problem
from shakedown.models.importing.import_model import Import, import_model

ProblemOf = Callable[..., Problem]

# The quantity varied, and its unit.
PARAMETERS = {
    "f": "1", "friction": "1", "amplitude": "1", "mean": "1", "phase": "periods", "stiffness": "1",
    "coupling": "1",
}  # fmt: skip
FACTORS = ("friction", "amplitude", "mean", "stiffness", "coupling")
_NEAR = 64 * np.finfo(float).eps  # relative to a period: a shift this close to whole load steps counts as one


def parameter_of(name: str) -> str:
    """Which of the parameters a name of a sweep means; empty where none.

    A factor may be written NAME.factor: in an import configuration ``friction`` alone is the coefficient.

    Examples
    --------
    >>> parameter_of("friction"), parameter_of("friction.factor"), parameter_of("contact.gap")
    ('friction', 'friction', '')
    """
    bare = name.removesuffix(".factor")
    return name if name in PARAMETERS else bare if bare in FACTORS else ""


@checked
def with_parameter(problem: Problem, name: str, value: float) -> Problem:
    """The joint with one named parameter changed.

    ============== =========================================================================
    ``f``          the friction coefficient of every node (where all are alike)
    ``friction``   factor on the friction coefficient of every node
    ``amplitude``  factor on the periodic part r¹ of the loading, and on ``load_amplitude``
    ``mean``       factor on all that the load factor does not multiply: the constant part
                   r⁰, with what initial gaps and interference put there, and the transient
                   load steps, and on ``load_mean``
    ``phase``      the tangential periodic part comes later by this fraction of the period,
                   q¹(t − φ) against p¹(t)
    ``stiffness``  factor on κ: on A, B and C
    ``coupling``   factor on B
    ============== =========================================================================

    Between load steps the loading is piecewise linear in time, so a phase that is no whole
    number of load steps keeps the corners of both parts and doubles the number of load
    steps; the loads of a joint move both parts at once, so that after it no units of them are known
    (``load_reactions``). With ``stiffness`` the whole structure is as much stiffer (``load_compliance``,
    ``load_frequency``); ``coupling`` leaves no frequency. The constant part stays what it was. An
    initial slip of the problem is not changed.

    Parameters
    ----------
    problem
        The joint.
    name
        One of the names above.
    value
        Its value, dimensionless.

    Raises
    ------
    UsageError
        If there is no such parameter, the value is not finite or an amplitude negative, ``f``
        is asked for where the nodes differ, or a phase of a load domain, whose corners have no order.
    ProblemError
        If there is no such joint: a negative friction coefficient, κ not positive semi-definite.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> with_parameter(joint, "f", 0.2).f
    array([0.2, 0.2])
    >>> bound = shakedown.upper_bound(with_parameter(joint, "amplitude", 2.0)).load_factor
    >>> round(2.0 * bound, 6)
    0.739146
    """
    require_problem(problem)
    if name not in PARAMETERS:
        found = shortened(repr(name))
        raise UsageError(f"parameter: expected one of {', '.join(PARAMETERS)}, found {found}")
    if not is_finite(value):
        raise UsageError(f"parameter {name}: expected a finite number, found {shortened(repr(value))}")
    if name == "amplitude" and value < 0:
        raise UsageError(f"parameter amplitude: expected a number >= 0, found {value!r}")
    with np.errstate(over="ignore", invalid="ignore"):  # overflow means that there is no such joint
        return _changed(problem, name, float(value))


def _changed(problem: Problem, name: str, value: float) -> Problem:
    loop = loading(problem)
    match name:
        case "f":
            return _with_friction(problem, value)
        case "friction":
            return replace(problem, f=value * problem.f)
        case "amplitude":
            scaled = Loading(loop.q0, loop.p0, value * loop.q1, value * loop.p1)
            known = _scaled(problem, value, "load_amplitude")
            return _loaded(known, scaled, scaled_units(problem, amplitude=value))
        case "mean":
            scaled = Loading(value * loop.q0, value * loop.p0, loop.q1, loop.p1)
            known = _scaled(problem, value, "load_mean", "q_transient", "p_transient")
            return _loaded(known, scaled, scaled_units(problem, mean=value))
        case "phase":
            return _shifted(problem, value)
        case "coupling":
            return replace(problem, B=value * problem.B, load_frequency=None)
    C = None if problem.C is None else value * problem.C
    loads = _of_stiffer(problem, value) if value > 0 else NO_LOADS
    return replace(problem, A=value * problem.A, B=value * problem.B, C=C, **loads)


def _of_stiffer(problem: Problem, value: float) -> dict[str, Any]:
    """Stiffness-dependent fields where the whole structure is stiffer by a factor."""
    factors = {"load_compliance": 1.0 / value, "load_frequency": np.sqrt(value)}
    known = {key: (factor, getattr(problem, key)) for key, factor in factors.items()}
    return {key: factor * given for key, (factor, given) in known.items() if given is not None}


def _with_friction(problem: Problem, value: float) -> Problem:
    f = problem.f
    if (f != f[0]).any():
        raise UsageError(
            f"parameter f: expected the same friction coefficient at every node, found {f.min():g} to "
            f"{f.max():g}; 'friction' is a factor on all of them"
        )
    return replace(problem, f=np.full(problem.n, value))


def _loaded(problem: Problem, loop: Loading, loads: dict[str, Any]) -> Problem:
    """The joint under another loop, with an explicit constant part so that no sample mean replaces it."""
    q_w, p_w = loop.q0 + loop.q1, loop.p0 + loop.p1
    return replace(problem, q_w=q_w, p_w=p_w, q_mean=loop.q0, p_mean=loop.p0, **loads)


def _scaled(problem: Problem, value: float, *keys: str) -> Problem:
    """The joint with some of its arrays scaled, those that it has."""
    there = [key for key in keys if getattr(problem, key) is not None]
    return replace(problem, **{key: value * getattr(problem, key) for key in there})


def _shifted(problem: Problem, phase: float) -> Problem:
    """q¹(t − φ) against p¹(t), both polygons with all their corners."""
    if problem.is_domain:
        raise UsageError("parameter phase: expected load steps in their order, found those of a load domain")
    loop, m = loading(problem), problem.m
    share = phase % 1.0
    steps = round(share * m)
    if abs(share * m - steps) <= _NEAR * m:
        return _loaded(problem, Loading(loop.q0, loop.p0, np.roll(loop.q1, steps, axis=0), loop.p1), NO_LOADS)
    corners = np.arange(m) / m
    times = np.sort(np.concatenate([corners, (corners + share) % 1.0]))
    q1, p1 = _at(loop.q1, times - share), _at(loop.p1, times)
    return _loaded(problem, Loading(loop.q0, loop.p0, q1, p1), NO_LOADS)


def _at(periodic: FloatArray, times: FloatArray) -> FloatArray:
    """The closed polygon of the load steps at some times, in periods."""
    corners = np.arange(len(periodic)) / len(periodic)
    return np.stack([np.interp(times, corners, column, period=1.0) for column in periodic.T], axis=1)


@dataclass(frozen=True)
class Variation:
    """A joint, or a function that makes one, with the names of its parameters.

    Attributes
    ----------
    joint
        The joint whose named parameters are varied, one from a configuration whose numbers
        are varied too (another process imports it again, once), or problem(parameter, …).
    parameters
        Names; of a function in the order of its arguments.
    """

    joint: Problem | Import | ProblemOf
    parameters: tuple[str, ...]

    def __reduce__(self) -> tuple[Callable[..., "Variation"], tuple[object, tuple[str, ...]]]:
        if isinstance(self.joint, Import):
            return _imported, (os.path.abspath(self.joint.path), self.parameters)
        return Variation, (self.joint, self.parameters)

    @property
    def base(self) -> Problem | None:
        """The joint as it stands; None of a function."""
        if isinstance(self.joint, Import):
            return self.joint.problem
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
        if self.base is None:
            made: object = self.joint(*values)  # type: ignore[operator]
            if not isinstance(made, Problem):
                found = type(made).__name__
                raise UsageError(f"problem(parameter): expected it to return a Problem, found {found}")
            return made
        problem, chosen = self.base, list(zip(self.parameters, self.meanings, values, strict=True))
        numbers = {name: value for name, meaning, value in chosen if not meaning}
        if isinstance(self.joint, Import) and numbers:
            problem = import_model(self.joint.path, changes=numbers, before=self.joint).problem
        for _, meaning, value in chosen:
            if meaning:
                problem = with_parameter(problem, meaning, value)
        return problem


@lru_cache(maxsize=1)
def _imported(path: str, parameters: tuple[str, ...]) -> Variation:
    return Variation(import_model(path), parameters)


def checked_variation(
    joint: Problem | Import | ProblemOf, vary: Mapping[str, ArrayLike]
) -> tuple[Variation, tuple[FloatArray, ...]]:
    """The joint with its parameters, and their values; ``UsageError`` where they make no grid."""
    if not 1 <= len(vary) <= 2 or not all(isinstance(name, str) for name in vary):
        raise UsageError(f"vary: expected one or two parameters by name, found {shortened(repr(vary))}")
    if isinstance(joint, Problem | Import):
        base = joint if isinstance(joint, Problem) else joint.problem
        _check_meanings(vary, base.load_names or (), imported=isinstance(joint, Import))
    values = tuple(_rising(name, given) for name, given in vary.items())
    if (count := int(np.prod([len(v) for v in values]))) > MANY:
        raise BudgetExceeded(f"vary: {count:,} points are more than {MANY:,}; nothing was computed")
    return Variation(joint, tuple(vary)), values


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
