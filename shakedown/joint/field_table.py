"""Every field of a problem, once: the part of the joint that it belongs to, and its shape."""

from collections.abc import Mapping
from typing import NamedTuple

from shakedown.ground.errors import ProblemError

Axes = tuple[str | int, ...]


class Field(NamedTuple):
    """One field of a problem: numbers with axes, names where ``of_text``, or a single text.

    Axes are named: n contact nodes, dn their tangential directions, m load steps, k transient steps,
    s states, c load cases, L loads with unit reactions, e faces; numbers are components x, y, z.
    """

    part: str
    axes: Axes
    of_text: bool = False
    required: bool = False
    one: Axes | None = None  # alternative shape, with one value for all
    directions: int = 0  # number of tangential directions for which it has a meaning; 0: any


FIELDS = {
    "A": Field("stiffness", ("dn", "dn"), required=True),
    "B": Field("stiffness", ("n", "dn"), required=True),
    "C": Field("stiffness", ("n", "n")),
    "stiffness_accuracy": Field("stiffness", ()),
    "f": Field("friction", ("n",), required=True, one=()),
    "q_w": Field("loading", ("m", "dn"), required=True),
    "p_w": Field("loading", ("m", "n"), required=True),
    "q_mean": Field("loading", ("dn",)),
    "p_mean": Field("loading", ("n",)),
    "q_transient": Field("loading", ("k", "dn")),
    "p_transient": Field("loading", ("k", "n")),
    "load_path": Field("loading", (), of_text=True),
    "load_reactions": Field("loading", ("L", "(d+1)n")),
    "load_history": Field("loading", ("m", "L")),
    "load_compliance": Field("loading", ("L", "L")),
    "load_frequency": Field("loading", ("L",)),
    "load_names": Field("loading", ("c",), of_text=True),
    "load_mean": Field("loading", ("c",)),
    "load_amplitude": Field("loading", ("c",)),
    "load_units": Field("loading", ("c",), of_text=True),
    "initial_slip": Field("start", ("s", "dn"), one=("dn",)),
    "x": Field("origin", ("n",)),
    "coordinates": Field("origin", ("n", 3)),
    "normal": Field("origin", ("n", 3)),
    "tangent": Field("origin", ("n", 3), directions=1),
    "tangents": Field("origin", ("n", 2, 3), directions=2),
    "node_area": Field("origin", ("n",)),
    "faces": Field("origin", ("e", 4), directions=2),
    "label": Field("origin", ("n",), of_text=True),
    "name": Field("origin", (), of_text=True),
    "units": Field("origin", (), of_text=True),
    "source": Field("origin", (), of_text=True),
}
TEXTS = tuple(key for key, field in FIELDS.items() if field.of_text and not field.axes)
NAMES = tuple(key for key, field in FIELDS.items() if field.of_text and field.axes)
ARRAYS = tuple(key for key in FIELDS if key not in TEXTS)
REQUIRED = tuple(key for key, field in FIELDS.items() if field.required)
OF_NODES = tuple(  # fields of single nodes, independent of the others
    key for key, field in FIELDS.items() if field.axes[:1] == ("n",) and field.part in ("friction", "origin")
)
TOGETHER = (  # where one is given, the other is required
    ("q_transient", "p_transient"),
    ("p_transient", "q_transient"),
    ("load_mean", "load_amplitude"),
    ("load_amplitude", "load_mean"),
    ("load_reactions", "load_history"),
    ("load_history", "load_reactions"),
    ("load_compliance", "load_reactions"),
    ("load_frequency", "load_reactions"),
    ("load_units", "load_mean"),
    ("load_mean", "load_names"),
)
STIFFNESS = ("A", "B", "C")
MAY_BE_NAN = ("load_frequency",)  # for a load that is not a mode
FORCES = ("q_w", "p_w", "q_mean", "p_mean", "q_transient", "p_transient")


def check_shapes(shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Match the shapes of array fields, by key, against each other.

    Raises
    ------
    ProblemError
        If a field that every problem has is missing, or a shape does not fit.
    """
    for key in REQUIRED:
        if key not in shapes:
            raise ProblemError(f"key '{key}': required, found none")
    for given, needed in TOGETHER:
        if given in shapes and needed not in shapes:
            raise ProblemError(f"key '{needed}': required because '{given}' is given, found none")
    A = shapes["A"]
    if len(A) != 2 or A[0] != A[1]:
        raise ProblemError(f"key 'A': expected a square array (n, n), found shape {A}")
    if A[0] == 0:
        raise ProblemError("key 'A': expected at least one contact node, found shape (0, 0)")
    if len(shapes["B"]) == 2 and shapes["B"] == (A[0], A[0] // 2) and A[0] % 2 == 0:
        raise ProblemError(
            f"key 'B': expected shape {A} or, with two tangential directions, {(A[0] // 2, A[0])}, found "
            f"{shapes['B']} (it looks transposed: one row per node, p = p_w + B v)"
        )
    directions = directions_of(A, shapes["B"])
    sizes = {"dn": A[0], "n": A[0] // directions, "(d+1)n": A[0] + A[0] // directions}
    for key, shape in shapes.items():
        _check_shape(key, shape, sizes, directions)
    if sizes["m"] == 0:
        raise ProblemError("key 'q_w': expected at least one load step, found m = 0")


def directions_of(A: tuple[int, ...], B: tuple[int, ...]) -> int:
    """The tangential directions of a node that the shapes of A and B tell: two where B is (n, 2n).

    Examples
    --------
    >>> directions_of((4, 4), (4, 4)), directions_of((4, 4), (2, 4))
    (1, 2)
    """
    return 2 if len(B) == 2 and B[1] == A[0] == 2 * B[0] else 1


def _check_shape(key: str, shape: tuple[int, ...], sizes: dict[str, int], directions: int) -> None:
    """Match one shape against its axis names, learning m, k and s where they first occur."""
    field, in_space = FIELDS[key], directions > 1
    if field.directions not in (0, directions):
        wanted, found = (
            ("one tangential direction", "two") if in_space else ("two tangential directions", "one")
        )
        raise ProblemError(f"key '{key}': expected only with {wanted}, found {found}")
    axes = field.axes
    if field.one is not None and len(shape) == len(field.one):
        axes = field.one
    elif key == "x" and in_space and len(shape) == 2:  # in a plane or in space
        axes = ("n", 2 if shape[1] == 2 else 3)
    expected = tuple(axis if isinstance(axis, int) else sizes.get(axis, axis) for axis in axes)
    fits = len(shape) == len(axes) and all(
        isinstance(want, str) or want == have for want, have in zip(expected, shape, strict=True)
    )
    if not fits:
        wanted = "(" + ", ".join(map(str, expected)) + ("," if len(expected) == 1 else "") + ")"
        if key == "x" and in_space:
            wanted = "({0},), ({0}, 2) or ({0}, 3)".format(expected[0])
        hint = _in_space_hint(shape, expected) if in_space else _transposition_hint(shape, expected)
        raise ProblemError(f"key '{key}': expected shape {wanted}, found {shape}{hint}")
    for axis, have in zip(axes, shape, strict=True):
        if isinstance(axis, str):
            sizes.setdefault(axis, have)


def _in_space_hint(shape: tuple[int, ...], expected: tuple[int | str, ...]) -> str:
    """What a wrong shape of a joint with two tangential directions looks like."""
    size = expected[-1] if expected else None
    if (
        len(shape) > len(expected)
        and isinstance(size, int)
        and shape[-2:] in ((size // 2, 2), (2, size // 2))
    ):
        return " (two directions of all nodes in one row: x0, y0, x1, y1, …)"
    return " (it looks transposed)" if _transposition_hint(shape, expected) else ""


def _transposition_hint(shape: tuple[int, ...], expected: tuple[int | str, ...]) -> str:
    if len(shape) == 2 and len(expected) == 2 and shape[0] == expected[1]:
        first = expected[0]
        if isinstance(first, str) or shape[1] == first:
            return " (it looks transposed: one column per node)"
    return ""
