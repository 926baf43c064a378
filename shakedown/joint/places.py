"""Where the nodes of a problem are: their areas, and directions in the model that it was made from."""

from collections.abc import Mapping, Sequence

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.tolerances import DEFAULT

NOT_NEGATIVE = {"node_area": ("areas", "node"), "load_amplitude": ("amplitudes", "load")}
DIRECTIONS = ("normal", "tangent", "tangents")


def without_cancelled(area: FloatArray) -> FloatArray:
    """Areas of nodes, (n,): 0 where shares of faces cancel and leave round-off, as at quadratic triangles.

    Examples
    --------
    >>> without_cancelled(np.array([-2e-18, 0.5, 1e-17])).tolist()
    [0.0, 0.5, 0.0]
    """
    # shares of a face that cancel leave round-off
    return np.where(np.abs(area) <= NEGLIGIBLE * np.abs(area).max(initial=0.0), 0.0, area)


def bearing_no_pressure(area: FloatArray, names: Sequence[str]) -> tuple[str, ...]:
    """A warning where nodes have no positive share of a pressure: corners of quadratic faces of solids.

    Examples
    --------
    >>> bearing_no_pressure(np.array([0.5, 0.5]), ["7", "8"])
    ()
    """
    without = np.flatnonzero(area <= 0)
    if not without.size:
        return ()
    return (
        f"quadratic faces at the contact give {without.size} of {len(area)} nodes, first "
        f"{names[without[0]]}, no or a negative share of a pressure, so that these open or slide at once: "
        "use linear elements there",
    )


def check_places(arrays: Mapping[str, FloatArray]) -> None:
    """Raise ``ProblemError`` unless areas and amplitudes are >= 0, directions perpendicular unit vectors."""
    for key in filter(arrays.__contains__, NOT_NEGATIVE):
        what, where = NOT_NEGATIVE[key]
        if np.any(arrays[key] < 0):
            j = int(np.argmax(arrays[key] < 0))
            raise ProblemError(
                f"key '{key}': expected {what} >= 0, found {arrays[key][j]:.9g} at {where} {j}"
            )
    for key in filter(arrays.__contains__, DIRECTIONS):
        length = np.linalg.norm(arrays[key], axis=-1)
        wrong = np.abs(length - 1) > DEFAULT.printed_digits
        if np.any(wrong):
            place = tuple(np.argwhere(wrong)[0])
            raise ProblemError(
                f"key '{key}': expected vectors of length 1, found the length {length[place]:.9g} "
                f"at node {place[0]}"
            )
    if "tangent" in arrays and "normal" in arrays:
        slanted = np.abs(np.einsum("ij,ij->i", arrays["tangent"], arrays["normal"]))
        if np.any(slanted > DEFAULT.printed_digits):
            j = int(np.argmax(slanted > DEFAULT.printed_digits))
            raise ProblemError(
                "key 'tangent': expected a direction at a right angle to 'normal', found the scalar product "
                f"{slanted[j]:.9g} at node {j}"
            )
    if "tangents" in arrays:
        first, second = np.moveaxis(arrays["tangents"], 1, 0)
        normal = arrays.get("normal", np.zeros_like(first))
        products = [
            np.einsum("ij,ij->i", a, b) for a, b in ((first, second), (first, normal), (second, normal))
        ]
        slanted = np.abs(products).max(axis=0)
        if np.any(slanted > DEFAULT.printed_digits):
            j = int(np.argmax(slanted > DEFAULT.printed_digits))
            raise ProblemError(
                "key 'tangents': expected two directions at right angles to each other and to 'normal', "
                f"found the scalar product {slanted[j]:.9g} at node {j}"
            )
