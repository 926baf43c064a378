"""A design: a joint with some parameters changed, and its limits."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import inf, nan
from numbers import Real
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.every_limit import JointLimits
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.registry import BOUNDS, Claim, kinds_of
from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import EPS, MANY, SIX_DIGITS, THREE_DIGITS, FloatArray
from shakedown.ground.errors import BudgetExceeded, Missing, UsageError, allowed
from shakedown.ground.shown_values import few, nodes_in_words, shortened, up
from shakedown.ground.status import Guarantee, Outcome, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import is_finite, real_array, require_problem
from shakedown.joint.constraints import Loading, loading
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.units import NO_LOADS, scaled_units
from shakedown.long_term.find_state import long_term_state
from shakedown.models.importing.import_model import Import, import_model

ProblemOf = Callable[..., Problem]

# The quantity varied, and its unit.
PARAMETERS = {
    "f": "1", "friction": "1", "amplitude": "1", "mean": "1", "phase": "periods", "stiffness": "1",
    "coupling": "1",
}  # fmt: skip
FACTORS = ("friction", "amplitude", "mean", "stiffness", "coupling")


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
        case "phase":
            return _shifted(problem, value)
        case "coupling":
            return _scaled(replace(problem, load_frequency=None), B=value)
    if not value > 0:
        return _scaled(replace(problem, **NO_LOADS), A=value, B=value, C=value)
    loads = {"load_compliance": 1.0 / value, "load_frequency": np.sqrt(value)}
    return _scaled(problem, A=value, B=value, C=value, **loads)


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


ALL = 9  # digits, so that contradictions are visible


class DesignLimit(NamedTuple):
    """One limit of the load factor.

    Attributes
    ----------
    load_factor
        NaN where there is none, inf where every load factor is on its safe side.
    status
        How it was found (:class:`Status`).
    remark
        What else should be known; empty where nothing.
    low, high
        For λ_T: shakedown is proved at ``low``, a cycle was found at ``high``; else NaN.
    """

    load_factor: float
    status: Status
    remark: str = ""
    low: float = nan
    high: float = nan


class SlipAllowed(NamedTuple):
    """The load factor up to which slips stay below a length, as ``slip_limit.SlipLimit`` has it.

    Attributes
    ----------
    below
        The length [length].
    load_factor
        The largest load factor simulated up to which every slip range does; NaN where there is none.
    largest
        The largest slip range there [length].
    """

    below: float
    load_factor: float
    largest: float


@dataclass(frozen=True, eq=False, repr=False)
class DesignPoint(Result):
    """The limits of the load factor of one joint.

    Attributes
    ----------
    values
        The values of the parameters.
    limits
        By name (``lower``, ``universal``, ``energy``, ``accumulated``, ``transient``, ``upper``);
        empty where there is no such joint.
    guarantee
        Whether λ_1 is a guarantee (as that bound says it); empty where it was not asked for.
    open_nodes
        Nodes that stay open in the state that λ_max and λ_E belong to.
    reason
        Why there is no such joint; empty where there is.
    proved_from_this_state
        As ``assess`` has it, whichever limits from this state are asked for; NaN where none is, or not known.
    outcomes
        What becomes of the joint at each load factor that was asked for (:class:`Outcome`).
    contradictions
        Limits that cannot all be right, in words: an error of this toolkit or of its theory.
    slip_criterion
        Up to which load factor slips stay below a length; None where that was not asked for.
    """

    values: tuple[float, ...]
    limits: dict[str, DesignLimit] = field(default_factory=dict)
    guarantee: str = ""
    open_nodes: tuple[int, ...] = ()
    reason: str = ""
    proved_from_this_state: float = nan
    outcomes: tuple[Outcome, ...] = ()
    contradictions: tuple[str, ...] = ()
    slip_criterion: SlipAllowed | None = None

    @property
    def exists(self) -> bool:
        """Whether the values of the parameters make a joint."""
        return not self.reason


def point_of(said: dict[str, Any]) -> DesignPoint:
    """The point whose fields JSON has said."""
    fields: dict[str, Any] = {
        name: tuple(each) if isinstance(each, list) else each for name, each in said.items()
    }
    limits = {
        name: DesignLimit(at, Status(status), *rest) for name, (at, status, *rest) in said["limits"].items()
    }
    fields |= {"limits": limits, "outcomes": tuple(map(Outcome, said["outcomes"]))}
    slips = said["slip_criterion"]
    return DesignPoint(**fields | {"slip_criterion": slips and SlipAllowed(*slips)})


class Question(NamedTuple):
    """The request for every point.

    Attributes
    ----------
    bounds
        Names of the limits.
    load_factors
        Where to simulate.
    initial_slip : (n,) or None
        The state that λ_E, λ_S, λ_T and simulations are about [length]; zero by default.
    open_nodes
        ``"auto"``: the zone with the largest λ_max; ``()``: all nodes in contact.
    quick
        λ_T to 0.1 %.
    slip_below
        A length that slip ranges are to stay below; None: nothing is asked about slips.
    tolerances
        What decides.
    """

    bounds: tuple[str, ...] = tuple(BOUNDS)
    load_factors: tuple[float, ...] = ()
    initial_slip: FloatArray | None = None
    open_nodes: tuple[()] | Literal["auto"] = "auto"
    quick: bool = False
    slip_below: float | None = None
    tolerances: Tolerances = DEFAULT


def design_point(problem: Problem, values: tuple[float, ...], question: Question) -> DesignPoint:
    """The limits of one joint, each by its fastest method.

    A limit whose program fails is undecided, with the reason as its remark.

    Examples
    --------
    >>> import shakedown
    >>> point = design_point(shakedown.example("two-node"), (0.35,), Question())
    >>> {name: round(limit.load_factor, 3) for name, limit in point.limits.items()}
    {'lower': 0.657, 'universal': 0.657, 'energy': 0.662, 'accumulated': 0.732, ...}
    """
    start, tolerances = question.initial_slip, question.tolerances
    joint = JointLimits(
        problem,
        start,
        zone=question.open_nodes,
        certify=False,
        accuracy=THREE_DIGITS if question.quick else SIX_DIGITS,
        tolerances=tolerances,
    )
    found: dict[str, Any] = {name: allowed(getattr, joint, name) for name in question.bounds}
    found |= {name: each for name, each in vars(joint).items() if name in BOUNDS}  # what these rest on
    limits = {name: _limit(name, each) for name, each in found.items()}
    guarantee = found["lower"].guarantee if found.get("lower") else ""
    open_nodes = found["upper"].open_nodes if found.get("upper") else ()
    here = allowed(getattr, joint, "proved_from_this_state") if {*question.bounds} & {*from_here()} else nan
    ends = [  # missing where loads are too large to follow
        allowed(long_term_state, problem, x, start, tolerances=tolerances) for x in question.load_factors
    ]
    slips = None if question.slip_below is None else _slips(joint, question.slip_below)
    proofs = from_here()
    if problem.q_transient is None:  # these are about closed nodes, and a transient may open some
        proofs += ["universal"] + ["lower"] * (guarantee == Guarantee.PROVED)
    proved = {name: limits[name] for name in proofs if name in limits}
    contradictions = [*out_of_order(limits, tolerances, closed=not open_nodes)]
    if found.get("transient") and not open_nodes:
        contradictions += cycles_below(proved, found["transient"], tolerances)
    return DesignPoint(
        values=values,
        limits={name: limits[name] for name in question.bounds},
        guarantee=guarantee if "lower" in question.bounds else "",
        open_nodes=open_nodes,
        proved_from_this_state=nan if isinstance(here, Missing) else here,
        outcomes=tuple(end.outcome if end else Outcome.UNDECIDED for end in ends),
        contradictions=tuple(contradictions),
        slip_criterion=slips,
    )


def _limit(name: str, result: Bound | Missing | None) -> DesignLimit:
    """A limit with how it was found."""
    if result is None or isinstance(result, Missing):
        reason = "no finite λ_max to scan up to" if result is None else result.reason
        return DesignLimit(nan, Status.UNDECIDED, reason)
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
    load_factor = nan if followed and status != Status.OPTIMAL else result.load_factor
    ends = (result.proved, result.cycling) if followed else ()
    return DesignLimit(load_factor, status, "; ".join(remarks), *ends)


def from_here() -> list[str]:
    """The limits that are proved from the state asked about."""
    return [kind.name for kind in kinds_of(Claim.THIS_STATE)]


def _slips(joint: JointLimits, below: float) -> SlipAllowed:
    found = allowed(joint.slip, below)
    if isinstance(found, Missing):
        return SlipAllowed(below, nan, nan)
    return SlipAllowed(below, found.load_factor, found.largest)


def out_of_order(limits: Mapping[str, DesignLimit], tolerances: Tolerances, *, closed: bool) -> Iterator[str]:
    """Contradictions to λ_U ≤ λ_1 and, of closed nodes, to λ_1, λ_U, λ_E, λ_S ≤ λ_max."""
    pairs = [("universal", "lower")]
    if closed:  # λ_1 and λ_U are about all nodes in contact
        pairs += [(name, "upper") for name in ("lower", "universal", *from_here())]
    for small, large in pairs:
        if small in limits and large in limits:
            a, b = limits[small].load_factor, limits[large].load_factor
            if a * (1.0 - tolerances.agreement) > b:
                yield f"{BOUNDS[small].symbol} = {few(a, ALL)} exceeds {BOUNDS[large].symbol} = {few(b, ALL)}"


def cycles_below(proved: Mapping[str, DesignLimit], history: Bound, tolerances: Tolerances) -> Iterator[str]:
    """Contradictions to no cycle below what is proved of this history."""
    slips = np.isin(history.outcomes, [Outcome.CYCLIC_SLIP, Outcome.RATCHETTING])
    for first in history.scanned[slips][:1]:
        for name, limit in proved.items():
            if limit.load_factor * (1.0 - tolerances.agreement) > first:
                below = f"below {BOUNDS[name].symbol} = {few(limit.load_factor, ALL)}"
                yield f"slip goes on for ever at λ = {few(first, ALL)}, {below}"
