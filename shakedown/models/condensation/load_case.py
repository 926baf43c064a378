"""Load cases of an elastic model, and their factors at each load step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shakedown.ground.argument_kinds import check_fields
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import ProblemError, UsageError
from shakedown.ground.shown_values import LONGEST_NAME, shortened, visible
from shakedown.joint.arguments import real_array
from shakedown.joint.constraints import LARGEST_FORCE
from shakedown.joint.result import Result

# An array; as it is given, also what NumPy can turn into one, or None.
GivenArray = FloatArray | Any
LARGEST_DOMAIN = 12  # ranges; 4096 corners
MEAN_ROUND_OFF = 16 * np.finfo(float).eps  # of a mean of factors, relative to the largest of them


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class LoadCase(Result):
    """One load with its own time function, for :func:`shakedown.condense`.

    At load step k the model carries ``history[k]`` times everything below.

    Parameters
    ----------
    history : () or (m,)
        Factor of the case at each load step of one period [–]; a single number
        is a constant load. The period closes from the last step to the first.
    force : (N,), optional
        Nodal forces, one per row of the stiffness matrix [force].
    displacement : (N,), optional
        Prescribed displacements [length], one per row of the stiffness matrix;
        other than zero only where the row is held.
    reactions : (n, 2), in space (n, 3), optional
        Nodal reactions (x, y[, z]) on the (first) body at the contact nodes while
        all of them are clamped [force], for loads that were run elsewhere.
    opened : (n, 2), in space (n, 3), optional
        Displacements (x, y[, z]) of the contact nodes, of pairs those of the first body less those of
        the second, while nothing acts between the bodies [length], for loads that were run elsewhere.
    mean : float, optional
        Factor of the case in the constant part of the loading, which the load
        factor does not scale; by default the mean of ``history``.
    transient : (k,), optional
        Factors at the load steps before the first period [–].
    range : (low, high), optional
        Instead of a history: the factor takes any value between these limits,
        independently of the other cases with a range (a load domain). The load
        steps are then the corners of the domain, and the problem says so (``load_path``).
    value : float, optional
        What factor 1 stands for, in a unit of the user's: 20 where the force is that of a load
        of 20 kN. The problem then has its ``load_mean`` and ``load_amplitude``.
    unit : str, optional
        The unit of ``value``; given alone it says that the factors are the load in this unit, a value of 1.
    frequency : float, optional
        Circular frequency of the mode whose inertia forces the case is [1/time].
    name : str, optional
        Shown in messages.

    Raises
    ------
    ProblemError
        If nothing acts, there is neither a history nor a range or there are both, or an
        array is not real, finite and of its shape.

    Examples
    --------
    >>> import numpy as np
    >>> case = LoadCase(history=np.cos(2 * np.pi * np.arange(8) / 8), force=[0.0, -3.0])
    >>> case.history.shape
    (8,)
    """

    history: GivenArray = None
    force: GivenArray = None
    displacement: GivenArray = None
    reactions: GivenArray = None
    opened: GivenArray = None
    mean: float | None = None
    transient: GivenArray = None
    range: GivenArray = None
    value: float | None = None
    unit: str = ""
    frequency: float | None = None
    name: str = "load case"

    def __post_init__(self) -> None:
        check_fields(self, ProblemError, only=("mean", "value", "unit", "frequency", "name"))
        for key in ("mean", "value", "frequency"):
            if (given := getattr(self, key)) is not None and not abs(given) < LARGEST_FORCE:
                raise ProblemError(f"{self.name}: {key}: expected a finite number, found {given}")
        if self.value == 0:
            raise ProblemError(f"{self.name}: value: expected what factor 1 stands for, not 0, found 0")
        if self.frequency is not None and self.frequency <= 0:
            raise ProblemError(f"{self.name}: frequency: expected a number > 0, found {self.frequency}")
        if all(acting is None for acting in (self.force, self.displacement, self.reactions, self.opened)):
            raise ProblemError(
                f"{self.name}: expected a force, a displacement, clamped reactions or displacements with the "
                "contact open, found none"
            )
        dimensions = {"history": (0, 1), "reactions": (2,), "opened": (2,)}
        for key in ("history", "force", "displacement", "reactions", "opened", "transient", "range"):
            if (given := getattr(self, key)) is None:
                continue
            label, axes = f"{self.name}: {key}", dimensions.get(key, (1,))
            try:
                array = real_array(label, given)
            except UsageError as error:
                raise ProblemError(str(error)) from None
            if not (largest := np.abs(array).max(initial=0.0)) < LARGEST_FORCE:
                raise ProblemError(f"{label}: expected numbers below {LARGEST_FORCE:g}, found {largest:g}")
            if array.ndim not in axes:
                raise ProblemError(f"{label}: expected {axes[-1]} axis/axes, found shape {array.shape}")
            object.__setattr__(self, key, array)
        if (self.history is None) == (self.range is None):
            found = "both" if self.range is not None else "neither"
            raise ProblemError(f"{self.name}: expected a history or a range, found {found}")
        if self.range is not None and not (len(self.range) == 2 and self.range[0] <= self.range[1]):
            raise ProblemError(f"{self.name}: range: expected [low, high], found {self.range.tolist()}")
        super().__post_init__()


@dataclass(frozen=True)
class Histories:
    """The factors of all load cases, one column per case.

    Attributes
    ----------
    period : (m, c)
        Factors over one period [–].
    mean : (c,) or None
        Factors in the constant part, where a case states one [–].
    transient : (k, c) or None
        Factors before the first period, where a case states them [–].
    """

    period: FloatArray
    mean: FloatArray | None
    transient: FloatArray | None

    @property
    def means(self) -> FloatArray:
        """Factors in the constant part, (c,): the mean over the period where no case states one [–]."""
        return np.asarray(self.period.mean(axis=0)) if self.mean is None else self.mean


def histories(cases: Sequence[LoadCase]) -> Histories:
    """Bring the time functions of all load cases to one length.

    Raises
    ------
    ProblemError
        If there is no case, or two cases have time functions of different lengths.

    Examples
    --------
    >>> dead, live = LoadCase(history=1.0, force=[1.0]), LoadCase(history=[0.0, 2.0], force=[3.0])
    >>> histories([dead, live]).period
    array([[1., 0.],
           [1., 2.]])
    """
    if not cases:
        raise ProblemError("loads: expected at least one load case, found none")
    period = _columns("history", _factors(cases))
    mean = None
    if any(case.mean is not None for case in cases):
        mean = np.array(
            [h.mean() if c.mean is None else c.mean for c, h in zip(cases, period.T, strict=True)]
        )
    transient = None
    if any(case.transient is not None for case in cases):
        silent = np.zeros(())
        transient = _columns("transient", [silent if c.transient is None else c.transient for c in cases])
    return Histories(period, mean, transient)


def without_closing(cases: Sequence[LoadCase], steps: int | None) -> tuple[list[LoadCase], tuple[str, ...]]:
    """The cases without a last load step that repeats the first, and a warning that it is left out.

    The period closes by itself, so that this step would count twice in the mean. Where the number of load
    steps is stated, all of them stay.

    Raises
    ------
    ProblemError
        If a time function has another number of load steps than is stated.

    Examples
    --------
    >>> cases, warnings = without_closing([LoadCase(history=[0.0, 2.0, 0.0], force=[1.0])], None)
    >>> cases[0].history.tolist(), len(warnings)
    ([0.0, 2.0], 1)
    """
    moving = {k: c.history for k, c in enumerate(cases) if c.history is not None and c.history.ndim}
    if steps is not None:
        for k, factors in moving.items():
            if len(factors) != steps:
                raise ProblemError(
                    f"{cases[k].name}: history: expected {steps} factors, as 'steps' states, found "
                    f"{len(factors)} (the period closes by itself, from the last to the first)"
                )
        return list(cases), ()
    noise = {k: MEAN_ROUND_OFF * np.abs(h).max(initial=0.0) for k, h in moving.items()}
    again = all(len(h) > 2 and abs(h[-1] - h[0]) <= noise[k] for k, h in moving.items())
    if not again or all(np.ptp(h) <= noise[k] for k, h in moving.items()):
        return list(cases), ()
    count = len(next(iter(moving.values())))
    return [replace(c, history=moving[k][:-1]) if k in moving else c for k, c in enumerate(cases)], (
        f"the last of {count} load steps repeats the first and is left out, because the period closes by "
        f"itself (where 'steps' states {count}, it stays)",
    )


def stated_loads(cases: Sequence[LoadCase], factors: Histories) -> dict[str, Any]:
    """Load cases as fields of a problem (``load_mean`` and so on); nothing where no case is stated.

    The amplitude is the largest departure from the mean; a case without a value is a plain number.

    Examples
    --------
    >>> pull = LoadCase(history=[0.0, 2.0], force=[3.0], value=20.0, unit="kN", name="pull")
    >>> found = stated_loads([pull], histories([pull]))
    >>> found["load_mean"], found["load_amplitude"], found["load_units"]
    (array([20.]), array([20.]), ('kN',))
    """
    if not any(case.value is not None or case.unit for case in cases):
        return {}
    values = np.array([1.0 if case.value is None else case.value for case in cases])
    sizes = np.abs(factors.period).max(axis=0)
    mean = factors.means
    amplitude = np.abs(factors.period - mean).max(axis=0)
    return {
        "load_names": tuple(shortened(visible(case.name), LONGEST_NAME - 1) for case in cases),
        "load_mean": values * np.where(np.abs(mean) <= MEAN_ROUND_OFF * sizes, 0.0, mean),
        "load_amplitude": np.abs(values) * np.where(amplitude <= MEAN_ROUND_OFF * sizes, 0.0, amplitude),
        "load_units": tuple(case.unit for case in cases),
    }


def _factors(cases: Sequence[LoadCase]) -> list[FloatArray]:
    """The history of every case; cases with a range visit the corners of the domain that they span.

    One range changes from each corner to the next (Gray code), so that the loop
    through all corners runs along the edges of the domain.
    """
    varying = [case for case in cases if case.range is not None]
    if len(varying) > LARGEST_DOMAIN:
        raise ProblemError(f"loads: expected at most {LARGEST_DOMAIN} ranges, found {len(varying)}")
    moving = [case.name for case in cases if case.history is not None and case.history.ndim]
    if varying and moving:
        raise ProblemError(
            f"loads: expected constant factors beside ranges, found a history of '{moving[0]}' "
            "(give the range of each, or one loop of load steps for all)"
        )
    corners = np.arange(2 ** len(varying))
    corners ^= corners >> 1
    found = []
    for case in cases:
        if case.history is not None:
            found.append(case.history)
        else:
            assert case.range is not None
            found.append(case.range[corners & 1])
            corners = corners >> 1
    return found


def _columns(key: str, factors: Sequence[FloatArray]) -> FloatArray:
    lengths = {len(f) for f in factors if f.ndim == 1}
    if len(lengths) > 1:
        raise ProblemError(
            f"loads: expected every {key} of one length, found lengths {', '.join(map(str, sorted(lengths)))}"
        )
    steps = lengths.pop() if lengths else 1
    return np.column_stack([np.broadcast_to(f, (steps,)) for f in factors])
