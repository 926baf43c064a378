"""A design: a joint with some parameters changed, and its limits."""

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, nan
from numbers import Real
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.every_limit import JointLimits
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.registry import BOUNDS, Claim, kinds_of
from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import EPS, MOST_ENTRIES, SIX_DIGITS, THREE_DIGITS, FloatArray
from shakedown.ground.errors import BudgetExceeded, Missing, UsageError, attempt_any
from shakedown.ground.shown_values import few, nodes_in_words, short, shortened, up
from shakedown.ground.status import Guarantee, Outcome, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import is_finite, real_array
from shakedown.joint.constraints import Loading, loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import NO_LOADS, scaled_units
from shakedown.models.importing.import_model import Import, import_model

# The quantity varied, and its unit.
PARAMETERS = {"f": "1", "friction": "1", "amplitude": "1", "mean": "1", "phase": "periods"}
FACTORS = ("friction", "amplitude", "mean")


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
    ============== =========================================================================

    Between load steps the loading is piecewise linear in time, so a phase that is no whole
    number of load steps keeps the corners of both parts and doubles the number of load
    steps; the loads of a joint move both parts at once, so that after it no units of them are known
    (``load_reactions``). The constant part stays what it was. An initial slip of the problem is not changed.

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
    loop, f = loading(problem), problem.f
    match name:
        case "f":
            if (f != f[0]).any():
                raise UsageError(
                    "parameter f: expected the same friction coefficient at every node, found "
                    f"{f.min():g} to {f.max():g}; 'friction' is a factor on all of them"
                )
            return replace(problem, f=np.full(problem.n, value))
        case "friction":
            return _scaled(problem, f=value)
        case "amplitude":
            scaled = Loading(loop.q0, loop.p0, value * loop.q1, value * loop.p1)
            known = _scaled(problem, load_amplitude=value)
            return _loaded(known, scaled, scaled_units(problem, amplitude=value))
        case "mean":
            scaled = Loading(value * loop.q0, value * loop.p0, loop.q1, loop.p1)
            known = _scaled(problem, load_mean=value, q_transient=value, p_transient=value)
            return _loaded(known, scaled, scaled_units(problem, mean=value))
    return _shifted(problem, value)


def _scaled(problem: Problem, **factors: float) -> Problem:
    """The joint with some of its arrays scaled, those that it has."""
    known = {key: getattr(problem, key) for key in factors}
    return replace(problem, **{key: factors[key] * x for key, x in known.items() if x is not None})


def _loaded(problem: Problem, loop: Loading, loads: dict[str, Any]) -> Problem:
    """The joint under another loop, with an explicit constant part so that no sample mean replaces it."""
    q_w, p_w = loop.q0 + loop.q1, loop.p0 + loop.p1
    return replace(problem, q_w=q_w, p_w=p_w, q_mean=loop.q0, p_mean=loop.p0, **loads)


def _shifted(problem: Problem, phase: float) -> Problem:
    """q¹(t − φ) against p¹(t), both polygons with all their corners."""
    if problem.is_domain:
        raise UsageError("parameter phase: expected load steps in their order, found those of a load domain")
    loop, m = loading(problem), problem.m
    share = phase % 1.0
    steps = round(share * m)
    # relative to a period: a shift this close to whole load steps counts as one
    if abs(share * m - steps) <= 64 * EPS * m:
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

    joint: Problem | Import | Callable[..., Problem]
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
        return tuple(PARAMETERS.get(meaning, "") for meaning in self.meanings)

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
    joint: Problem | Import | Callable[..., Problem], vary: Mapping[str, ArrayLike]
) -> tuple[Variation, tuple[FloatArray, ...]]:
    """The joint with its parameters, and their values; ``UsageError`` where they make no grid."""
    if not 1 <= len(vary) <= 2 or not all(isinstance(name, str) for name in vary):
        raise UsageError(f"vary: expected one or two parameters by name, found {shortened(repr(vary))}")
    meanings = [parameter_of(name) for name in vary]
    for name, meaning in zip(vary, meanings, strict=True):
        if isinstance(joint, Problem) and not meaning:
            found = shortened(repr(name))
            raise UsageError(f"vary: expected one of {', '.join(PARAMETERS)}, found {found}")
        if isinstance(joint, Import) and name == "friction":
            raise UsageError(
                "vary: expected f (the friction coefficient) or friction.factor (a factor on it), found "
                "'friction', also a key of the configuration"
            )
    if isinstance(joint, Problem | Import) and len(vary) == 2 and meanings[0] == meanings[1] != "":
        raise UsageError(f"vary: expected each parameter once, found {meanings[0]} twice")
    values = tuple(_rising(name, given) for name, given in vary.items())
    if (count := int(np.prod([len(v) for v in values]))) > MOST_ENTRIES:
        raise BudgetExceeded(f"vary: {count:,} points are more than {MOST_ENTRIES:,}; nothing was computed")
    return Variation(joint, tuple(vary)), values


def _rising(name: str, given: ArrayLike) -> FloatArray:
    where = f"vary {shortened(name)}"
    values = real_array(where, [given] if isinstance(given, Real) else given)
    if values.ndim != 1 or not len(values) or (np.diff(values) <= 0).any():
        raise UsageError(f"{where}: expected rising values, at least one, found {short(values)}")
    return values


ALL = 9  # digits, so that contradictions are visible


Record = dict[str, Any]
"""What is known of a point, as JSON says it; numbers may be NaN or infinite."""


def no_point(values: Mapping[str, float], reason: str) -> Record:
    """The record of a point at which there is no joint; the keys of every record, but for those of limits.

    ``exists``, ``values`` of the parameters, ``reason`` why there is no joint; ``guarantee``: whether λ_1 is
    a guarantee, empty where it was not asked for; ``open_nodes`` in the state that λ_max and λ_E belong to;
    ``proved_from_this_state`` as ``assess`` has it, whichever limits from this state are asked for;
    ``contradictions``: limits that cannot all be right,
    in words.
    """
    return {
        "exists": not reason,
        "values": dict(values),
        "reason": reason,
        "guarantee": "",
        "open_nodes": [],
        "proved_from_this_state": nan,
        "contradictions": [],
    }


def design_point(
    problem: Problem,
    values: Mapping[str, float],
    *,
    bounds: tuple[str, ...] = tuple(BOUNDS),
    initial_slip: FloatArray | None = None,
    open_nodes: tuple[int, ...] | Literal["auto"] = "auto",
    quick: bool = False,
    slip_below: float | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Record:
    """The limits of one joint, each by its fastest method: the keys of :func:`no_point`, and one per limit.

    Each limit has its ``load_factor``, NaN where there is none, inf where every one is on its safe side; its
    ``status`` (:class:`Status`); a ``remark``; of λ_T ``low``, at which shakedown is proved, and ``high``, at
    which a cycle was found. A limit whose program fails is undecided, with the reason as its remark. With
    ``slip_below`` there is ``slip_criterion``, as :class:`~shakedown.assessment.transient_limit.SlipLimit`.
    The other arguments are those of :func:`~shakedown.studies.sweep.sweep`.

    Examples
    --------
    >>> import shakedown
    >>> point = design_point(shakedown.example("two-node"), {"f": 0.35}, bounds=("lower", "energy"))
    >>> round(point["lower"]["load_factor"], 3), round(point["energy"]["load_factor"], 3)
    (0.657, 0.662)
    """
    joint = JointLimits(
        problem,
        initial_slip,
        zone=open_nodes,
        certify=False,
        accuracy=THREE_DIGITS if quick else SIX_DIGITS,
        tolerances=tolerances,
    )
    found: dict[str, Any] = {name: attempt_any(getattr, joint, name) for name in bounds}
    found |= {name: each for name, each in vars(joint).items() if name in BOUNDS}  # what these rest on
    limits = {name: _limit(name, each) for name, each in found.items()}
    guarantee = str(found["lower"].guarantee) if found.get("lower") else ""
    opened = found["upper"].open_nodes if found.get("upper") else ()
    proofs = [kind.name for kind in kinds_of(Claim.THIS_STATE)]
    here = attempt_any(getattr, joint, "proved_from_this_state") if {*bounds} & {*proofs} else nan
    if problem.q_transient is None:  # these are about closed nodes, and a transient may open some
        proofs += ["universal"] + ["lower"] * (guarantee == Guarantee.PROVED)
    numbers = {name: limit["load_factor"] for name, limit in limits.items()}
    contradictions = [*out_of_order(numbers, tolerances, closed=not opened)]
    if found.get("transient") and not opened:
        proved = {name: numbers[name] for name in proofs if name in numbers}
        contradictions += cycles_below(proved, found["transient"], tolerances)
    record = no_point(values, "") | {name: limits[name] for name in bounds}
    if slip_below is not None:
        slips = attempt_any(joint.slip, slip_below)
        known = (slips.load_factor, slips.largest) if slips else (nan, nan)
        words = ("below", "load_factor", "largest")
        record["slip_criterion"] = dict(zip(words, (slip_below, *known), strict=True))
    return record | {
        "guarantee": guarantee if "lower" in bounds else "",
        "open_nodes": list(opened),
        "proved_from_this_state": nan if isinstance(here, Missing) else here,
        "contradictions": contradictions,
    }


def _limit(name: str, result: Bound | Missing | None) -> Record:
    """A limit with how it was found."""
    words = "load_factor", "status", "remark", "low", "high"
    if result is None or isinstance(result, Missing):
        why = "no finite λ_max to scan up to" if result is None else result.reason
        return dict(zip(words, (nan, str(Status.UNDECIDED), why, nan, nan), strict=True))
    remarks, status, least = [result.reason] if result.reason else [], result.status, result.least_load_factor
    if BOUNDS[name].claim == Claim.IMPOSSIBLE:
        if result.open_nodes:
            zone = f"of the zone with {nodes_in_words(result.open_nodes)} open"
            remarks.append(f"{zone}: no upper bound of the joint")
        if least > 0:
            remarks.append(f"safe slips exist only from λ = {up(least)} on")
    elif 0 < least < inf:
        remarks, status = [f"proved only from λ = {up(least)} on"], Status.UNDECIDED
    followed = BOUNDS[name].claim == Claim.FOLLOWED
    load_factor = nan if followed and status != Status.OPTIMAL else float(result.load_factor)
    ends = (result.proved, result.cycling) if followed else (nan, nan)
    if BOUNDS[name].claim == Claim.CREEP:
        ends = (result.proved, load_factor)
    return dict(zip(words, (load_factor, str(status), "; ".join(remarks), *ends), strict=True))


def out_of_order(limits: Mapping[str, float], tolerances: Tolerances, *, closed: bool) -> Iterator[str]:
    """Contradictions to λ_U ≤ λ_1 and, of closed nodes, to λ_1, λ_U, λ_E, λ_S ≤ λ_max."""
    pairs = [("universal", "lower")]
    if closed:  # λ_1 and λ_U are about all nodes in contact
        proofs = [kind.name for kind in kinds_of(Claim.THIS_STATE)]
        pairs += [(name, "upper") for name in ("lower", "universal", *proofs)]
    for small, large in pairs:
        a, b = limits.get(small, nan), limits.get(large, nan)
        if a * (1.0 - tolerances.agreement) > b:
            yield f"{BOUNDS[small].symbol} = {few(a, ALL)} exceeds {BOUNDS[large].symbol} = {few(b, ALL)}"


def cycles_below(proved: Mapping[str, float], history: Bound, tolerances: Tolerances) -> Iterator[str]:
    """Contradictions to no cycle below what is proved of this history."""
    slips = np.isin(history.outcomes, [Outcome.CYCLIC_SLIP, Outcome.RATCHETTING])
    for first in history.scanned[slips][:1]:
        for name, limit in proved.items():
            if limit * (1.0 - tolerances.agreement) > first:
                below = f"below {BOUNDS[name].symbol} = {few(limit, ALL)}"
                yield f"slip goes on for ever at λ = {few(first, ALL)}, {below}"
