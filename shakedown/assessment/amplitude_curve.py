"""What a joint does over the amplitude of a load: displacement, dissipation, stiffness, damping."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isnan
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.files.table_file import write_table
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import SIX_DIGITS
from shakedown.ground.shown_values import plain
from shakedown.ground.status import Outcome
from shakedown.ground.visible_text import with_unit
from shakedown.joint.conjugate_loads import LoadUnit
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.units import units_of


class AmplitudePoint(NamedTuple):
    """One amplitude: the long-term state there, as it is recorded.

    Attributes
    ----------
    displacement
        Half the range of the displacement conjugate to the load, in its unit; NaN where no loop closes.
    dissipation
        Dissipation of friction and jumps per cycle [force × length]; 0 where it shakes down, NaN where no
        loop closes.
    outcome
        The long-term state.
    proved
        Whether it is proved that friction dissipates nothing.
    slides_away
        Whether it is undecided because the body slides away: gross slip, which nothing holds.
    share
        Share of the nodes that slip in every period.
    slip, open_nodes
        The state at the first load step of a period, where the next amplitude may begin.
    """

    displacement: float
    dissipation: float
    outcome: str
    proved: bool
    slides_away: bool
    share: float
    slip: FloatArray
    open_nodes: NDArray[np.int64]

    @property
    def closes(self) -> bool:
        """Whether the loop of the load closes, so that the joint may go on from it."""
        return not isnan(self.dissipation)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class DampingCurve(Result):
    """Result of :func:`damping`: one entry per amplitude; NaN where no loop of the load closes.

    Attributes
    ----------
    load
        Which load, by its number.
    load_name
        Its name; empty where the problem names none.
    unit
        The units of force, displacement and stiffness (:class:`~shakedown.joint.conjugate_loads.LoadUnit`).
    amplitude : (k,)
        Factors on the history of the load [–].
    force : (k,)
        Half the range of the load [force, where ``load_units`` says one; else units of ``load_history``].
    displacement : (k,)
        Half the range of the displacement conjugate to it [length; else work per unit of the load]; NaN
        without a ``load_compliance``.
    dissipation : (k,)
        What friction and jumps take per cycle [force × length]; exactly 0 where the joint shakes down.
    outcome : k times
        Long-term state (:class:`Outcome`).
    proved : (k,)
        Whether the absence of friction damping is proved, not only found by simulation.
    slides_away : (k,)
        Whether it is undecided because the body slides away: gross slip, which nothing holds.
    slipping_share : (k,)
        Share of the nodes that slip in every period.
    load_frequency
        Circular frequency of the mode that the load has the shape of; NaN where it is none.
    proved_limit
        λ_E: the amplitude below which there is no friction damping from the state given, proved; NaN where
        another load varies as well, and no amplitude is a load factor.
    simulated_limit
        λ_T: the largest amplitude found to shake down from the state given, to a thousandth, below the
        smallest one here that does not; infinite where all do, NaN as before.
    from_zero
        The same with every amplitude from the state given, where that was asked for.
    """

    DOCUMENT: ClassVar[str] = (
        "load load_name amplitude force displacement dissipation secant_stiffness loss_factor frequency "
        "damping_ratio outcome proved slides_away slipping_share load_frequency proved_limit simulated_limit"
    )
    TABLE: ClassVar[str] = (
        "amplitude force displacement dissipation secant_stiffness loss_factor frequency damping_ratio "
        "outcome proved slipping_share"
    )

    problem: Problem = field(repr=False, compare=False)
    load: int
    load_name: str
    unit: LoadUnit
    amplitude: FloatArray
    force: FloatArray
    displacement: FloatArray
    dissipation: FloatArray
    outcome: tuple[Outcome, ...]
    proved: NDArray[np.bool_]
    slides_away: NDArray[np.bool_]
    slipping_share: FloatArray
    load_frequency: float
    proved_limit: float
    simulated_limit: float
    from_zero: "DampingCurve | None" = None

    @property
    def secant_stiffness(self) -> FloatArray:
        """Load over displacement amplitude, (k,) [force/length]; NaN of a load that does not vary."""
        return _ratio(np.where(self.force > 0, self.force, np.nan), self.displacement)

    @property
    def loss_factor(self) -> FloatArray:
        """η = D / (2π · ½ · load amplitude · displacement amplitude), (k,)."""
        return _ratio(self.dissipation, np.pi * self.force * self.displacement)

    @property
    def frequency(self) -> FloatArray:
        """Circular frequency √(secant stiffness) of a load that is M φ of a mode of unit modal mass, (k,)."""
        return np.sqrt(self.secant_stiffness) * self._of_a_mode

    @property
    def damping_ratio(self) -> FloatArray:
        """ζ = D / (2π · load amplitude · displacement amplitude) of such a load, (k,)."""
        return 0.5 * self.loss_factor * self._of_a_mode

    @property
    def _of_a_mode(self) -> float:
        """1 for a load that has the shape of a mode, else NaN."""
        return np.nan if isnan(self.load_frequency) else 1.0

    @property
    def differs(self) -> NDArray[np.bool_]:
        """Where the start matters: the joint ends differently from the previous and the given one."""
        other = self.from_zero
        if other is None:
            return np.zeros(len(self.amplitude), dtype=bool)
        size = np.fmax(self.dissipation, other.dissipation)
        # of a dissipation: a smaller difference between two starts does not count
        apart = np.abs(self.dissipation - other.dissipation) > SIX_DIGITS * size
        return np.array([a != b for a, b in zip(self.outcome, other.outcome, strict=True)]) | apart

    def to_dict(self) -> dict[str, Any]:
        """The words of ``DOCUMENT``, units; where asked for, both from the state given, and what differs."""
        found = super().to_dict() | {"units": self.units}
        if self.from_zero is None:
            return found
        return found | {"from_zero": self.from_zero.to_dict(), "differs": plain(self.differs)}

    @property
    def units(self) -> dict[str, str]:
        """The units of columns, by their words; empty where the problem does not say them."""
        return {
            "force": self.unit.load,
            "displacement": self.unit.moved(self.problem),
            "dissipation": units_of(self.problem).work,
            "secant_stiffness": self.unit.stiffness,
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write one row per amplitude: CSV in full precision, or Parquet where the name ends in .parquet.

        Headings have the units in brackets where the problem says that of the load.

        Raises
        ------
        UsageError
            If the file cannot be written, or its name ends in neither.
        """
        columns = {word: plain(getattr(self, word)) for word in self.TABLE.split()}
        if self.from_zero is not None:
            columns |= {
                "dissipation_from_start": plain(self.from_zero.dissipation),
                "displacement_from_start": plain(self.from_zero.displacement),
                "differs": plain(self.differs),
            }
        units = self.units if self.unit.load else {}
        of = {word: units.get(word.removesuffix("_from_start"), "") for word in columns}
        filled = {word: [np.nan if x is None else x for x in column] for word, column in columns.items()}
        write_table(path, {with_unit(word, of[word]): column for word, column in filled.items()})


def columns_of(points: Sequence[AmplitudePoint]) -> dict[str, Any]:
    """Points as fields of a curve."""
    return {
        "displacement": np.array([point.displacement for point in points]),
        "dissipation": np.array([point.dissipation for point in points]),
        "outcome": tuple(Outcome(point.outcome) for point in points),
        "proved": np.array([point.proved for point in points]),
        "slides_away": np.array([point.slides_away for point in points]),
        "slipping_share": np.array([point.share for point in points]),
    }


def _ratio(one: FloatArray, other: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(other > 0, one / other, np.nan)
