"""Local coordinate systems of a deck (``*ORIENTATION``, ``*TRANSFORM``): rectangular or cylindrical."""

from dataclasses import dataclass

import numpy as np

from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.models.readers.text import number, quoted

Line = tuple[str, list[str]]  # where it stands in a deck, its fields


@dataclass(frozen=True, eq=False)
class CoordinateSystem:
    """Three perpendicular axes at every place.

    Attributes
    ----------
    name : str
        What the deck calls it, with the file, for messages.
    cylindrical : bool
        Whether the axes are radial, circumferential and axial.
    first, second : (3,)
        Rectangular: a vector along the first axis, and one in the plane of the first and the second axis.
        Cylindrical: two points on the axis [length].
    """

    name: str
    cylindrical: bool
    first: FloatArray
    second: FloatArray

    def axes_at(self, places: FloatArray) -> FloatArray:
        """The axes at places (n, 3), one per row, (n, 3, 3).

        Raises
        ------
        ProblemError
            If the points of the system do not say its axes, or a place lies on the axis of a cylinder.

        Examples
        --------
        >>> pin = CoordinateSystem("pin", True, np.zeros(3), np.array([0.0, 0.0, 1.0]))
        >>> pin.axes_at(np.array([[0.0, 2.0, 5.0]])).tolist()
        [[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]]
        """
        if not self.cylindrical:
            third = np.cross(self.first, self.second)
            size = np.linalg.norm(self.first) * np.linalg.norm(self.second)
            self._check(bool(np.linalg.norm(third) > NEGLIGIBLE * size), "two directions that span a plane")
            axes = np.array([self.first, np.cross(third, self.first), third])
            return np.tile(axes / np.linalg.norm(axes, axis=1)[:, None], (len(places), 1, 1))
        axis = self.second - self.first
        length = float(np.linalg.norm(axis))
        self._check(length > 0, "two points on the axis")
        axis = axis / length
        arm = places - self.first
        radial = arm - np.outer(arm @ axis, axis)
        radius = np.linalg.norm(radial, axis=1)
        self._check(bool((radius > NEGLIGIBLE * length).all()), "nodes beside its axis")
        radial = radial / radius[:, None]
        along = np.broadcast_to(axis, radial.shape)
        return np.stack([radial, np.cross(axis, radial), along], axis=1) + 0.0

    def _check(self, right: bool, expected: str) -> None:
        if not right:
            raise ProblemError(f"{self.name}: expected {expected}, found others")


def coordinate_system(name: str, parameters: dict[str, str], data: list[Line]) -> CoordinateSystem:
    """Read the data lines of ``*ORIENTATION``: two points, or three, the last the origin.

    Raises
    ------
    ProblemError
        If it is of another kind (a table of directions, spherical), or turned once more.
    """
    kind = parameters.get("SYSTEM", "RECTANGULAR").upper()
    plain = parameters.get("DEFINITION", "COORDINATES").upper() == "COORDINATES"
    expected = "*ORIENTATION of SYSTEM=RECTANGULAR or CYLINDRICAL with two points (or three)"
    known = ("RECTANGULAR", "CYLINDRICAL") if plain else ()
    where, points = _points(data[:1], kind, known, (6, 9), expected, name)
    for place, turned in data[1:2]:
        if any(number(text, place) for text in turned[1:] if text):
            raise ProblemError(
                f"{place}: expected no further turn of *ORIENTATION, found {quoted(', '.join(turned))}"
            )
    origin = points[2] if len(points) == 3 and kind == "RECTANGULAR" else np.zeros(3)
    return CoordinateSystem(
        f"{where}: *ORIENTATION {quoted(name)}", kind == "CYLINDRICAL", points[0] - origin, points[1] - origin
    )


def nodal_system(parameters: dict[str, str], data: list[Line], name: str) -> CoordinateSystem:
    """Read the data line of ``*TRANSFORM`` in a file: the directions of the nodes of a set.

    The line has two points. With ``TYPE=R`` they lie along the first axis, and in the plane of the first and
    the second one. With ``TYPE=C`` they lie on the axis, and the directions are radial, circumferential and
    axial.

    Raises
    ------
    ProblemError
        If it is of another kind, or there are not six numbers.
    """
    kind = parameters.get("TYPE", "R").strip().upper()
    expected = "*TRANSFORM of TYPE=R or C with two points"
    where, (first, second) = _points(data, kind, ("R", "C"), (6,), expected, name)
    return CoordinateSystem(f"{where}: *TRANSFORM", kind == "C", first, second)


def _points(
    data: list[Line], kind: str, known: tuple[str, ...], counts: tuple[int, ...], expected: str, name: str
) -> tuple[str, FloatArray]:
    """Where the points of a system stand, and the points, (k, 3)."""
    where = data[0][0] if data else name
    fields = [text for _, own in data for text in own if text]
    if kind not in known or len(fields) not in counts:
        found = quoted(", ".join([kind, *fields]))
        raise ProblemError(f"{where}: expected {expected}, found {found}")
    return where, np.array([number(text, where) for text in fields]).reshape(-1, 3)
