"""The rows about a given slip, in units of energy and without dimension."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.energy.energy_rows import EnergyRows
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.programs.scaling import power_of_two


@dataclass(frozen=True)
class ConeRows:
    """H y + λ d + (‖y‖ + δ) s ≤ g: the rows about an initial slip, y in units of energy.

    Dimensionless, by powers of two. The last row is the sign of λ.

    Attributes
    ----------
    H : (k, r)
        Coefficients of y.
    d, g, s : (k,)
        Coefficients of λ, right-hand sides, coefficients of the radius.
    offset
        δ.
    sizes : (k,)
        Largest term on the right-hand side of every row.
    length
        Unit of y and δ.
    """

    H: FloatArray
    d: FloatArray
    g: FloatArray
    s: FloatArray
    offset: float
    sizes: FloatArray
    length: float

    def among(self, chosen: NDArray[np.intp]) -> "ConeRows":
        """Some of the rows."""
        H, d, g, s, sizes = (part[chosen] for part in (self.H, self.d, self.g, self.s, self.sizes))
        return replace(self, H=H, d=d, g=g, s=s, sizes=sizes)

    def reversed(self) -> "ConeRows":
        """The same rows in −λ."""
        return replace(self, d=-self.d)

    def excess(self, y: FloatArray, load_factor: float) -> FloatArray:
        """Violation of every row (k,), relative to its largest term."""
        reach = float(np.linalg.norm(y)) + self.offset
        terms = np.maximum(np.abs(self.H) @ np.abs(y), np.abs(load_factor * self.d))
        terms = np.maximum(np.maximum(terms, self.sizes), reach * self.s)
        value = self.H @ y + load_factor * self.d + reach * self.s - self.g
        return value / np.where(terms > 0, terms, 1.0)

    def largest_load_factor(self, y: FloatArray) -> float:
        """The largest λ that the rows with d > 0 allow at y."""
        reach = float(np.linalg.norm(y)) + self.offset
        slack = self.g - self.H @ y - reach * self.s
        return float(np.min(slack[self.d > 0] / self.d[self.d > 0], initial=np.inf))

    def proved(self, multipliers: FloatArray) -> float:
        """The load factor that multipliers with ‖Hᵀμ‖ ≤ sᵀμ prove not to be exceeded.

        Inf where they prove none: dᵀμ is not positive.
        """
        pull = float(self.d @ multipliers)
        return float(multipliers @ (self.g - self.offset * self.s)) / pull if pull > 0 else np.inf

    def carrying(self, multipliers: FloatArray) -> NDArray[np.intp]:
        """The rows that multipliers rest on, without the sign of λ."""
        share = (multipliers * np.maximum(np.linalg.norm(self.H, axis=1), self.sizes))[:-1]
        return np.flatnonzero(share > NEGLIGIBLE * share.max(initial=0.0))


def cone_rows(rows: EnergyRows, initial_slip: FloatArray, distance: float) -> ConeRows:
    """The rows about an initial slip, from which the energy distance is to be kept."""
    H = rows.G @ rows.metric.inverse
    sizes = np.maximum(np.abs(rows.g), np.abs(rows.G) @ np.abs(initial_slip))
    force = power_of_two(float(sizes.max()))
    stiffness = power_of_two(float(np.abs(H).max(initial=0.0)))
    return ConeRows(
        H=np.vstack([H, np.zeros(H.shape[1])]) / stiffness,
        d=np.append(rows.d / force, -1.0),
        g=np.append(rows.g - rows.G @ initial_slip, 0.0) / force,
        s=np.append(rows.spread, 0.0) / stiffness,
        offset=distance / rows.metric.unit * (stiffness / force),
        sizes=np.append(sizes, 0.0) / force,
        length=force / stiffness,
    )


def margin_rows(rows: EnergyRows, load_factor: float, slip: FloatArray) -> ConeRows:
    """The rows at a load factor with the margin of a slip as the unknown δ, in the place of λ."""
    right = rows.g - load_factor * rows.d
    about = cone_rows(replace(rows, g=right, d=np.zeros_like(right)), slip, 0.0)
    return replace(about, d=np.append(about.s[:-1], -1.0))
