"""The end of a contact: can a corner that is pressed on a rigid plane stick?"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray


@dataclass(frozen=True)
class WeldedCorner:
    """Asymptotic tractions at a corner that is welded to a rigid plane (Williams 1952).

    Attributes
    ----------
    exponent
        Both tractions go with distance^(exponent − 1); below 1 they are singular.
    shear_ratio
        Tangential over normal traction as the corner is approached, |q|/p [–].
        With less friction than this the corner slips at any load: λ_max then
        keeps falling as the mesh is refined, by a power of the element size.
    """

    exponent: float
    shear_ratio: float


@checked
def welded_corner(angle: float, poisson: float, plane: str = "strain") -> WeldedCorner:
    """Tractions near the end of a contact, for a body that meets the plane at an angle.

    The strongest field φ = r^(e+1) F(θ) of a wedge with one face welded and one
    free, 0 < e < 1.

    Parameters
    ----------
    angle
        Angle between the contact and the free face, through the body [rad], 0 < angle < π.
    poisson
        Poisson's ratio [–].
    plane
        ``"strain"`` or ``"stress"``.

    Raises
    ------
    UsageError
        If the angle is out of range, or no singular field exists (a sharp wedge).

    Examples
    --------
    >>> corner = welded_corner(np.pi / 2, 0.3)
    >>> round(corner.exponent, 4), round(corner.shear_ratio, 4)
    (0.7112, 0.3023)
    """
    if not 0 < angle < np.pi:
        raise UsageError(f"angle: expected 0 < angle < pi, found {angle}")
    strain_ratio = poisson if plane == "strain" else poisson / (1 + poisson)

    def determinant(exponent: float) -> float:
        return float(np.linalg.det(_conditions(exponent, angle, strain_ratio)))

    grid = np.linspace(0.02, 0.999, 400)
    values = [determinant(e) for e in grid]
    for k in range(len(grid) - 1):
        if values[k] * values[k + 1] < 0:
            exponent = brentq(determinant, grid[k], grid[k + 1], xtol=1e-14)
            field = np.linalg.svd(_conditions(exponent, angle, strain_ratio))[2][-1]
            shear, normal = _tractions(exponent, 0.0) @ field
            return WeldedCorner(float(exponent), float(abs(shear / normal)))
    raise UsageError(f"angle: no singular field at a corner of {np.degrees(angle):g} degrees")


def _conditions(e: float, angle: float, poisson: float) -> FloatArray:
    """No displacement on θ = 0, no traction on θ = angle, (4, 4), in the coefficients of F.

    F = (cos(e+1)θ, sin(e+1)θ, cos(e−1)θ, sin(e−1)θ).
    """
    radial = [-(e + 1), 0.0, -(e + 1) + 4 * (1 - poisson), 0.0]
    circumferential = [0.0, -(e + 1), 0.0, -(e - 1) - 4 * (1 - poisson)]
    return np.array([radial, circumferential, *_tractions(e, angle)])


def _tractions(e: float, angle: float) -> FloatArray:
    """(σ_rθ, σ_θθ) at r = 1 on the ray θ = angle, (2, 4), in the coefficients of F."""
    up, down = (e + 1) * angle, (e - 1) * angle
    F = np.array([np.cos(up), np.sin(up), np.cos(down), np.sin(down)])
    slope = np.array(
        [-(e + 1) * np.sin(up), (e + 1) * np.cos(up), -(e - 1) * np.sin(down), (e - 1) * np.cos(down)]
    )
    return np.array([-e * slope, e * (e + 1) * F])
