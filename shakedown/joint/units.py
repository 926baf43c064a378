"""The units of a problem, as far as its text names them, and its loads in units of their own."""

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from typing import Literal, NamedTuple

from shakedown.ground.shown_values import FEW_DIGITS
from shakedown.joint.arguments import checked
from shakedown.joint.problem import NamedLoad, Problem

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
PASCALS = {
    ("N", "m"): "Pa",
    ("kN", "m"): "kPa",
    ("MN", "m"): "MPa",
    ("GN", "m"): "GPa",
    ("N", "mm"): "MPa",
    ("kN", "mm"): "GPa",
}
ROUNDINGS = {
    "down": (ROUND_FLOOR, FEW_DIGITS),
    "up": (ROUND_CEILING, FEW_DIGITS),
    "nearest": (ROUND_HALF_EVEN, 6),
}  # digits
_EXACT = Context(prec=60)  # exact for a product of two floats


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
        return PASCALS.get(self, self._joined("{}/{}²"))

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
    problem: Problem, load_factor: float = 1.0, rounding: Literal["down", "up", "nearest"] = "nearest"
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
    varying = varying_loads_in_words(problem, load_factor, rounding)
    return "; ".join(filter(None, [varying, constant_loads_in_words(problem)]))


def varying_loads_in_words(
    problem: Problem, load_factor: float = 1.0, rounding: Literal["down", "up", "nearest"] = "nearest"
) -> str:
    """The loads that a load factor scales, as in :func:`loads_in_words`; empty where none is said to vary."""
    if math.isnan(load_factor):
        return ""
    varying = [load for load in problem.loads if load.amplitude != 0]
    return "; ".join(_load_in_words(load, load_factor, rounding) for load in varying)


def constant_loads_in_words(problem: Problem) -> str:
    """The loads that no load factor changes; empty where none is said to be constant."""
    constant = [load for load in problem.loads if load.amplitude == 0]
    return "; ".join(_load_in_words(load, 1.0, "nearest") for load in constant)


def _load_in_words(load: NamedLoad, load_factor: float, rounding: str) -> str:
    mean, unit = _decimal_text(_decimal(load.mean), "nearest"), load.unit
    if load.amplitude == 0:
        return f"{' '.join(filter(None, [load.name, mean, unit]))}, unchanged"
    if math.isinf(load_factor):
        return f"{' '.join(filter(None, [load.name, mean, unit]))} with any amplitude"
    product = _EXACT.multiply(_decimal(load_factor), _decimal(load.amplitude))
    varying = f"± {_decimal_text(product, rounding)}"
    return " ".join(filter(None, [load.name, mean if load.mean else "", varying, unit]))


def _decimal(value: float) -> Decimal:
    """The shortest decimal number that stands for a float, so that 1.27 times 20 is 25.4."""
    return Decimal(repr(float(value)))


def _decimal_text(value: Decimal, rounding: str) -> str:
    """Rounded to so many digits, and written without an exponent where that takes few zeros."""
    way, digits = ROUNDINGS[rounding]
    rounded = Context(prec=digits, rounding=way).plus(value)
    if not rounded:
        return "0"
    return f"{rounded.normalize():f}" if -4 <= rounded.adjusted() <= 6 else f"{float(rounded):.{digits}g}"
