"""Loads in units of their own, units in words, and likely mistakes in the data."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import NEGLIGIBLE, ROUND_OFF, FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.ground.shown_values import FEW_DIGITS, down, few, up
from shakedown.joint.arguments import once_per_problem, require_problem
from shakedown.joint.constraints import loading
from shakedown.joint.problem import AXES, NamedLoad, Problem

FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "MN": 1e6, "GN": 1e9, "daN": 10.0, "kgf": 9.80665}  # in N
FORCES |= {"lbf": 4.4482216152605, "kip": 4448.2216152605}
LENGTHS = {
    "m": 1.0,
    "mm": 1e-3,
    "cm": 1e-2,
    "µm": 1e-6,
    "um": 1e-6,
    "km": 1e3,
    "in": 0.0254,
    "ft": 0.3048,
}  # in m


class Units(NamedTuple):
    """The units of force and of length, and those made of them; empty where one that they need has none.

    Examples
    --------
    >>> known = [Units(*pair) for pair in (("N", "mm"), ("kN", "m"), ("lbf", "in"), ("", "mm"))]
    >>> [units.stress for units in known]
    ['MPa', 'kPa', 'lbf/in²', '']
    >>> known[0].work, known[0].stiffness, known[0].density, known[3].area
    ('N mm', 'N/mm', 'N/mm³', 'mm²')
    """

    force: str
    length: str

    @property
    def area(self) -> str:
        """The unit of areas."""
        return f"{self.length}²" if self.length else ""

    @property
    def stress(self) -> str:
        """The unit of tractions: a pascal with its prefix where there is one, else force per area."""
        pascals = round(FORCES[self.force] / LENGTHS[self.length] ** 2) if all(self) else 0
        return {1: "Pa", 10**3: "kPa", 10**6: "MPa", 10**9: "GPa"}.get(pascals, self._joined("{}/{}²"))

    @property
    def density(self) -> str:
        """The unit of forces per volume."""
        return self._joined("{}/{}³")

    @property
    def stiffness(self) -> str:
        """The unit of forces per length, and of works per area."""
        return self._joined("{}/{}")

    @property
    def work(self) -> str:
        """The unit of works and dissipations."""
        return self._joined("{} {}")

    def _joined(self, form: str) -> str:
        return form.format(*self) if all(self) else ""


@checked
def units_of(problem: Problem | None) -> Units:
    """Units of force and of length, from texts like "N, mm"; empty where the text names none.

    Examples
    --------
    >>> import shakedown
    >>> units_of(shakedown.example("block-9"))
    Units(force='N', length='mm')
    """
    return units_in("" if problem is None else problem.units)


def units_in(text: str) -> Units:
    """Units of force and of length that a text names."""
    parts = [part.strip() for part in text.split(",")]
    force, length = ([part for part in parts if part in known] for known in (FORCES, LENGTHS))
    return Units(force[0] if force else "", length[0] if length else "")


@checked
def loads_in_words(
    problem: Problem,
    load_factor: float = 1.0,
    rounding: Literal["down", "up", "nearest"] = "nearest",
    *,
    constant: bool = True,
) -> str:
    """What a load factor means in the loads that the user knows; empty where the problem does not say them.

    λ scales the amplitudes only. Loads that vary come first.

    Parameters
    ----------
    problem
        A joint with ``load_mean`` and ``load_amplitude``.
    load_factor
        λ ≥ 0; of inf the amplitude is any, of NaN there is nothing to say.
    rounding
        How amplitudes are rounded: ``"down"`` to four digits for "safe up to", ``"up"`` to four
        digits for "impossible above"; ``"nearest"`` to six digits for what is given or asked for.
        Constant parts have six digits.
    constant
        Whether loads that do not vary are named, too.

    Examples
    --------
    >>> import dataclasses, shakedown
    >>> loads = {"load_mean": [12, 20], "load_amplitude": [0, 20], "load_units": ["kN", "kN"]}
    >>> names = ["bolt preload", "axial load"]
    >>> joint = dataclasses.replace(shakedown.example("two-node"), load_names=names, **loads)
    >>> loads_in_words(joint)
    'axial load 20 ± 20 kN; bolt preload 12 kN, unchanged'
    >>> loads_in_words(joint, 1.2734, "down"), loads_in_words(joint, 1.2734, "up")
    ('axial load 20 ± 25.46 kN; bolt preload ...', 'axial load 20 ± 25.47 kN; bolt preload ...')
    """
    if math.isnan(load_factor):
        return ""
    named = [load for load in problem.loads if load.amplitude != 0]
    named += [load for load in problem.loads if load.amplitude == 0 and constant]
    return "; ".join(_load_in_words(load, load_factor, rounding) for load in named)


def _load_in_words(load: NamedLoad, load_factor: float, rounding: str) -> str:
    mean, unit = few(load.mean, 6), load.unit
    if load.amplitude == 0:
        return f"{' '.join(filter(None, [load.name, mean, unit]))}, unchanged"
    if math.isinf(load_factor):
        return f"{' '.join(filter(None, [load.name, mean, unit]))} with any amplitude"
    varying = float(f"{load_factor * load.amplitude:.12g}")  # 0.7 times 3 is 2.1
    rounded = {"down": down, "up": up}.get(rounding)
    text = rounded(varying, FEW_DIGITS) if rounded else few(varying, 6)
    return " ".join(filter(None, [load.name, mean if load.mean else "", f"± {text}", unit]))


NO_LOADS: dict[str, Any] = dict.fromkeys(key for key, axes in AXES.items() if "L" in axes)


class LoadUnit(NamedTuple):
    """What one unit of ``load_history`` is of a load, and the units of that and of its displacement.

    Attributes
    ----------
    size
        How much of the load it is: times it histories are loads, over it their displacements are conjugate to
        these. 1 where the problem does not say, and of a load that has the shape of a mode.
    load, displacement, stiffness
        The units of load, displacement, and load over displacement; of a force those of force, length and
        force per length of the problem. Empty where they are not known.
    """

    size: float = 1.0
    load: str = ""
    displacement: str = ""
    stiffness: str = ""

    def moved(self, problem: Problem) -> str:
        """The unit of the displacement, or that it is work per unit of the load, whatever that is."""
        return self.displacement or f"{units_of(problem).work or 'work'} per unit of load"


@checked
def without_loads(problem: Problem) -> Problem:
    """The joint without the unit reactions of its loads, so that its welded reactions may be anything.

    Examples
    --------
    >>> joint = Problem(A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[1.0], [-1.0]], p_w=[[3.0], [3.0]],
    ...                 load_reactions=[[1.0, 0.0]], load_history=[[1.0], [-1.0]])
    >>> without_loads(joint).load_history is None
    True
    """
    return replace(problem, **NO_LOADS)


def require_loads(problem: Problem, *, compliance: bool = False) -> tuple[FloatArray, FloatArray]:
    """``load_reactions`` and ``load_history``; ``ProblemError`` where there are none, or no compliance."""
    require_problem(problem)
    if problem.load_reactions is None or problem.load_history is None:
        raise ProblemError(
            "key 'load_reactions': needed for what a load does, found none (fem, condense, import write it)"
        )
    if compliance and problem.load_compliance is None:
        raise ProblemError(
            "key 'load_compliance': needed for the displacement of a load, found none (a load that was run "
            "elsewhere comes without it)"
        )
    return problem.load_reactions, problem.load_history


@once_per_problem
def constant_units(problem: Problem) -> FloatArray:
    """Units of each load in the constant part r⁰ of the loading, (L,): those that a load factor leaves alone.

    The mean of the histories where that is what r⁰ says; else the least change of it that does. What no
    loads explain (an initial gap) is constant, and moves displacements by a constant alone.

    Examples
    --------
    >>> joint = Problem(A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[1.0], [0.0]], p_w=[[3.0], [3.0]],
    ...                 load_reactions=[[1.0, 0.0]], load_history=[[1.0], [0.0]])
    >>> constant_units(joint)
    array([0.5])
    """
    unit, history = require_loads(problem)
    loop, mean = loading(problem), history.mean(axis=0)
    first = np.concatenate([problem.q_w[0], problem.p_w[0]]) - history[0] @ unit
    missing = np.concatenate([loop.q0, loop.p0]) - first - mean @ unit
    noise = NEGLIGIBLE * max(np.abs(problem.q_w).max(), np.abs(problem.p_w).max())
    if np.abs(missing).max() <= noise:
        return np.asarray(mean)
    lengths = np.linalg.norm(unit, axis=1)
    lengths[lengths == 0] = 1.0
    change, *_ = np.linalg.lstsq((unit / lengths[:, None]).T, missing, rcond=None)
    return np.asarray(mean + change / lengths)


def units_at(problem: Problem, load_factor: float, mean: float = 1.0) -> FloatArray:
    """Units of each load at the load steps at a load factor, and a factor on their constant part, (m, L)."""
    constant, history = constant_units(problem), require_loads(problem)[1]
    return mean * constant + load_factor * (history - constant)


def scaled_units(problem: Problem, *, mean: float = 1.0, amplitude: float = 1.0) -> dict[str, Any]:
    """The histories of a joint whose constant or periodic loading is scaled; empty where it has none."""
    if problem.load_history is None:
        return {}
    return {"load_history": units_at(problem, amplitude, mean)}


def units_in_time(problem: Problem, load_factor: float, cycle: FloatArray) -> FloatArray:
    """Units of each load at times in cycles, (s, L); NaN before the first load step of the first period.

    Load step k of m is at the time k/m of every cycle.
    """
    steps = units_at(problem, load_factor)
    closed, corners = np.vstack([steps, steps[:1]]), np.arange(problem.m + 1) / problem.m
    found = np.stack([np.interp(cycle % 1.0, corners, column) for column in closed.T], axis=1)
    return np.where((cycle < -NEGLIGIBLE)[:, None], np.nan, found)


def load_units(problem: Problem) -> tuple[LoadUnit, ...]:
    """The units of each load, by ``load_units``, ``load_amplitude`` and ``load_mean``.

    Examples
    --------
    >>> joint = Problem(A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[1.0], [-1.0]], p_w=[[3.0], [3.0]], units="N, mm",
    ...                 load_reactions=[[1.0, 0.0]], load_history=[[1.0], [-1.0]],
    ...                 load_names=["push"], load_mean=[0.0], load_amplitude=[3.0], load_units=["kN"])
    >>> load_units(joint)
    (LoadUnit(size=3000.0, load='N', displacement='mm', stiffness='N/mm'),)
    """
    history, units = require_loads(problem)[1], units_of(problem)
    count, constant, modes = history.shape[1], constant_units(problem), problem.load_frequency
    if len(problem.loads) != count or not units.work:
        return (LoadUnit(),) * count
    varying = np.abs(history - constant).max(axis=0)
    modal = np.zeros(count, dtype=bool) if modes is None else np.isfinite(modes)
    rows = zip(problem.loads, constant.tolist(), varying.tolist(), modal, strict=True)
    return tuple(LoadUnit() if of_mode else _unit(load, units, *pair) for load, *pair, of_mode in rows)


def _unit(load: NamedLoad, units: Units, constant: float, varying: float) -> LoadUnit:
    """The unit of a load, so many of which are constant and vary."""
    size = load.mean / constant if constant and load.mean else load.amplitude / varying if varying else 0.0
    if not (load.unit and size):
        return LoadUnit()
    for known, own, other in ((FORCES, units.force, units.length), (LENGTHS, units.length, units.force)):
        if load.unit in known:
            return LoadUnit(size * known[load.unit] / known[own], own, other, f"{own}/{other}")
    moved = f"{units.work}/({load.unit})"
    return LoadUnit(size, load.unit, moved, f"{load.unit}/({moved})")


def is_pulled_everywhere(problem: Problem) -> bool:
    """Whether the mean load pulls the bodies apart at every node, as with a wrong sign of p_w."""
    mean = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    return bool((mean < 0).all())


def doubtful_data(problem: Problem) -> list[str]:
    """What is unusual in the data of a joint, each in one sentence.

    Examples
    --------
    >>> import shakedown
    >>> doubtful_data(shakedown.example("two-node"))
    []
    """
    hints = list[str]()
    if is_pulled_everywhere(problem):
        hints.append(
            "The mean pressure is negative at every node: compression is positive in p_w. Is its sign right? "
            "Or does an initial gap stay open?"
        )
    if np.any(problem.f > 2.0):
        hints.append(f"The friction coefficient {problem.f.max():g} is unusually large: is it in percent?")
    return [*hints, *_units_in_doubt(problem), *_steps_in_doubt(problem)]


def _units_in_doubt(problem: Problem) -> Iterator[str]:
    """Inconsistent numbers, as where one file is in mm and another one in m."""
    unalike = 100.0  # ratio of stiffnesses of one body beyond which they are probably in different units
    # on as many feet as hold a body it moves without strain, so that C may be zero
    C, strained = problem.A if problem.C is None else problem.C, problem.n > problem.directions + 1
    tangential, normal, coupling = (float(np.abs(each).max()) for each in (problem.A, C, problem.B))
    for key, size, least in (("C", normal, strained / unalike), ("B", coupling, 0.0)):
        if tangential > 0 and not least <= size / tangential <= unalike:
            yield (
                f"The largest stiffness in {key} is {size / tangential:.3g} times the largest in A: are both "
                "in the same units?"
            )
    place = problem.x if problem.coordinates is None else problem.coordinates
    if place is None or tangential == 0:
        return
    extent = float(np.ptp(place.reshape(problem.n, -1), axis=0).max())
    along, across = (np.abs(r).max() / np.diagonal(problem.A).max() for r in (problem.q_w, problem.p_w))
    moved, spacing = float(max(along, across)), extent / problem.n ** (1 / problem.directions)
    # steel at 2 kPa; with loads in N, mm and a modulus in Pa it is 5e-9 at 1000 MPa
    if 0 < extent < along or 0 < moved < 1e-8 * spacing:
        yield (
            f"The load is as large as the stiffness times {moved:.3g}, {moved / extent:.2g} of the size of "
            f"the contact, {extent:.3g}: are forces, stiffnesses and positions in the same units?"
        )


def _steps_in_doubt(problem: Problem) -> Iterator[str]:
    """A load step that is there twice, or out of its order."""
    jump = 5.0  # times the usual distance of load steps: a step so far from both neighbours may be misplaced
    path = np.hstack([problem.q_w, problem.p_w])
    noise = ROUND_OFF * np.abs(path).max()
    onwards = np.abs(np.roll(path, -1, axis=0) - path).max(axis=1)
    if problem.is_domain or onwards.max() <= noise:
        return
    if onwards[-1] <= noise and (problem.q_mean is None or problem.p_mean is None):
        yield (
            "The last load step repeats the first. The period closes by itself, so that it counts twice in "
            "the mean: is it meant to?"
        )
    away = np.minimum(onwards, np.roll(onwards, 1))  # from the nearer neighbour
    for k in np.flatnonzero(away > jump * np.median(onwards)):
        apart = np.abs(path - path[k]).max(axis=1)
        apart[k] = np.inf
        if jump * apart.min() < away[k]:
            yield (
                f"Load step {k} lies next to load step {apart.argmin()}, and far from those before and after "
                "it: are the load steps in their order, and each there once?"
            )
            return
