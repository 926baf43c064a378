"""A corner at the end of a contact: can it stick, and if not, how does λ_max fall with the element size?"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from shakedown import UsageError
from shakedown.fem import Material
from shakedown.ground.constants import SIX_DIGITS, FloatArray

EXPONENTS = np.linspace(0.02, 0.999, 400)  # exponents e between which roots are sought
SLIP_EXPONENTS = np.linspace(EXPONENTS[0], 3.0, 1201)  # exponents s between which the least is sought


@dataclass(frozen=True)
class CornerField:
    """What friction does at a corner of a contact (:func:`corner_field`).

    Attributes
    ----------
    exponent
        e: while all nodes stick, tractions go as distance^(e − 1); they are singular for e < 1.
    shear_ratio
        ρ₀ = |q|/p of these tractions: the critical friction coefficient [–]. With more friction the
        corner sticks, and does not limit λ_max.
    slip_exponent
        s*: the least s for which slip ~ distance^s can be locked in, as its own tractions keep |q| ≤ f p.
        At most e where f ≥ ρ₀; NaN where it is above 3.
    slope
        s* − e, at least 0: λ_max falls with that power of the element size for any cyclic load that changes
        the tractions at the corner; 0 where it converges.
    """

    exponent: float
    shear_ratio: float
    slip_exponent: float
    slope: float


def corner_field(
    angle: float,
    material: Material,
    f: float,
    *,
    against: Material | None = None,
    against_angle: float = np.pi,
) -> CornerField:
    """The critical friction of a corner in plane strain; with less also how fast λ_max falls with refinement.

    Williams's (1952) stress functions φ = r^(s+1) F(θ) describe the fields in wedges whose outer faces are
    free. If the contact is welded, s has to be the exponent e. If it slips without opening, there is a field
    for every s, and the ratio |q|/p of its tractions tells whether friction can lock that slip in
    (docs/mesh.md). Of several exponents the least real one is taken: tractions that oscillate towards the
    corner are not looked for.

    Parameters
    ----------
    angle
        Angle between the contact and the free face, through the body [rad], 0 < angle < π.
    material
        Material of the body with the corner.
    f
        Friction coefficient ≥ 0 [–].
    against
        Material of the other body; None: it is rigid.
    against_angle
        The angle of the other body there: π, where it is flat, to below 2π [rad].

    Raises
    ------
    UsageError
        If a number is out of range, or no singular field exists (a sharp wedge).

    Examples
    --------
    A square block on a half-plane of its material: critical is 0.543 (Mugadu, Hills, Limmer 2002).

    >>> found = corner_field(np.pi / 2, Material(200e3, 0.3), 0.3, against=Material(200e3, 0.3))
    >>> round(found.exponent, 4), round(found.shear_ratio, 4), round(found.slope, 4)
    (0.5445, 0.5431, 0.0935)
    """
    if not 0 < angle < np.pi:
        raise UsageError(f"angle: expected 0 < angle < pi, found {angle}")
    if not 0 < against_angle < 2 * np.pi:
        raise UsageError(f"against_angle: expected 0 < angle < 2 pi, found {against_angle}")
    if not 0 <= f < np.inf:
        raise UsageError(f"f: expected a friction coefficient >= 0, found {f}")
    pair = _Pair(angle, material.poisson)
    if against is not None:
        softer = _modulus(material) / _modulus(against)
        pair = _Pair(*pair[:2], against_angle, against.poisson, softer)
    exponent, shear_ratio = _welded(pair)
    s = _least_slip(pair, f)
    slope = 0.0 if f >= shear_ratio else max(0.0, s - exponent)
    return CornerField(exponent, shear_ratio, s, slope)


class _Pair(NamedTuple):
    """The wedge above the contact, θ > 0, and the one below: angles, Poisson's ratios.

    ``softer`` is the ratio G₁/G₂ of their shear moduli, 0 where the one below is rigid.
    """

    angle: float
    poisson: float
    other_angle: float = np.pi
    other_poisson: float = 0.0
    softer: float = 0.0


def _modulus(material: Material) -> float:
    return material.young / (2 * (1 + material.poisson))


def _welded(pair: _Pair) -> tuple[float, float]:
    """Exponent of the strongest field with neither slip nor gap, and |q|/p of its tractions."""

    def determinant(exponent: float) -> float:
        return float(np.linalg.det(_conditions(exponent, pair, welded=True)))

    values = [determinant(e) for e in EXPONENTS]
    changes = np.flatnonzero(np.diff(np.sign(values)))
    if not changes.size:
        raise UsageError(
            f"angle: no singular field with a real exponent at a corner of {np.degrees(pair.angle):g} degrees"
        )
    exponent = float(brentq(determinant, *EXPONENTS[changes[0] : changes[0] + 2], xtol=1e-14))
    shear, normal = _contact_tractions(exponent, pair, welded=True)
    return exponent, float(abs(shear / normal))


def _least_slip(pair: _Pair, f: float) -> float:
    """The least s of a slip r^s whose tractions keep |q| ≤ f p; NaN where there is none up to 3."""
    side = np.sign(np.prod(_contact_tractions(SLIP_EXPONENTS[0], pair, welded=False)))

    def excess(s: float) -> float:
        """By how much ±q exceeds f p, relative to their size; it jumps where p changes its sign."""
        shear, normal = _contact_tractions(s, pair, welded=False)
        return float((side * shear * np.sign(normal) - f * abs(normal)) / np.hypot(shear, normal))

    if excess(SLIP_EXPONENTS[0]) <= 0.0:
        return float(SLIP_EXPONENTS[0])
    for left, right in pairwise(SLIP_EXPONENTS):
        if excess(right) < 0.0:
            found = float(brentq(excess, left, right, xtol=1e-14))
            if abs(excess(found)) < SIX_DIGITS:
                return found
            side = -side  # p has changed its sign
    return np.nan


def _contact_tractions(s: float, pair: _Pair, *, welded: bool) -> tuple[float, float]:
    """(σ_rθ, σ_θθ) on θ = 0 of the field that keeps all conditions."""
    field = np.linalg.svd(_conditions(s, pair, welded=welded))[2][-1]
    shear, normal = _tractions(s, 0.0) @ field[:4]
    return float(shear), float(normal)


def _conditions(s: float, pair: _Pair, *, welded: bool) -> FloatArray:
    """The matrix of all conditions: its product with the coefficients of a field has to vanish.

    The outer faces are free; on θ = 0 the tractions and u_θ, if welded also u_r, are continuous. The
    coefficients are those of F = (cos(s+1)θ, sin(s+1)θ, cos(s−1)θ, sin(s−1)θ) in the wedge above, then in the
    one below: (4, 4) for a wedge on a rigid plane, (8, 8) for two; with slip there is one row less.
    """
    own = _displacements(s, pair.poisson)[0 if welded else 1 :]
    if not pair.softer:
        return np.vstack([own, _tractions(s, pair.angle)])
    other = _displacements(s, pair.other_poisson)[0 if welded else 1 :]
    across, none = _tractions(s, 0.0), np.zeros((2, 4))
    return np.block(
        [
            [own, -pair.softer * other],
            [across, -across],
            [_tractions(s, pair.angle), none],
            [none, _tractions(s, -pair.other_angle)],
        ]
    )


def _displacements(s: float, poisson: float) -> FloatArray:
    """2 G (u_r, u_θ) at r = 1 on θ = 0, (2, 4), in the coefficients of F."""
    radial = [-(s + 1), 0.0, -(s + 1) + 4 * (1 - poisson), 0.0]
    circumferential = [0.0, -(s + 1), 0.0, -(s - 1) - 4 * (1 - poisson)]
    return np.array([radial, circumferential])


def _tractions(e: float, angle: float) -> FloatArray:
    """(σ_rθ, σ_θθ) at r = 1 on the ray θ = angle, (2, 4), in the coefficients of F."""
    up, down = (e + 1) * angle, (e - 1) * angle
    F = np.array([np.cos(up), np.sin(up), np.cos(down), np.sin(down)])
    slope = np.array(
        [-(e + 1) * np.sin(up), (e + 1) * np.cos(up), -(e - 1) * np.sin(down), (e - 1) * np.cos(down)]
    )
    return np.array([-e * slope, e * (e + 1) * F])
