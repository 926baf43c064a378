"""The fields of a problem: their shapes, and the numbers, names and texts that they may hold."""

import json
import sys
from collections.abc import Mapping
from decimal import Decimal
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.argument_kinds import real_values
from shakedown.ground.constants import EPS, FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.ground.shown_values import LONGEST_NAME, shortened, visible
from shakedown.ground.tolerances import DEFAULT

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
        hint = _shape_hint(shape, expected)
        raise ProblemError(f"key '{key}': expected shape {wanted}, found {shape}{hint}")
    for axis, have in zip(axes, shape, strict=True):
        if isinstance(axis, str):
            sizes.setdefault(axis, have)


def _shape_hint(shape: tuple[int, ...], expected: tuple[int | str, ...]) -> str:
    """What a wrong shape looks like."""
    if len(shape) == len(expected) == 2 and shape[0] == expected[1]:
        return " (it looks transposed)" if isinstance(expected[0], str) or shape[1] == expected[0] else ""
    size = expected[-1] if len(shape) > len(expected) > 0 else None
    if isinstance(size, int) and shape[-2:] in ((size // 2, 2), (2, size // 2)):
        return " (two directions of all nodes in one row: x0, y0, x1, y1, …)"
    return ""


# Beyond these, products of three numbers are no numbers any more.
LARGEST = 1e100  # largest stiffness, force or length, in any units: its square is still finite
SMALLEST = 1 / LARGEST  # smallest admissible value of the largest nonzero entry of an array
NEGLIGIBLE = 1e-30  # entries so much smaller than the largest of their array are taken as zero
LARGEST_FRICTION = 1e12
LARGEST_LENGTH = 1e75  # largest slip, force over stiffness
LEAST_PRINTED, MOST_PRINTED = 5, 12  # digits: numbers of fewer are as good as exact, of more as round-off
SAMPLED = 4096  # entries looked at, whether they are short
CANCELLED = 2**12 * EPS  # relative to the largest stiffness: the rest where larger ones cancel each other


def real_numbers(key: str, value: ArrayLike) -> NDArray[np.float64]:
    """A private float64 copy of a real, finite array; raises ``ProblemError`` for anything else."""
    if np.ma.is_masked(value):
        raise ProblemError(f"key '{key}': expected every number, found masked ones")
    try:
        array = real_values(value)
    except ValueError:  # ragged nested lists
        raise ProblemError(f"key '{key}': expected a regular array of numbers, found ragged rows") from None
    if array.dtype.kind not in "fiu":
        raise ProblemError(f"key '{key}': expected real numbers, found {kind(array)}")
    with np.errstate(over="ignore", invalid="ignore"):  # overflow is reported as not finite below
        array = np.array(array, dtype=np.float64)
    bad = ~(np.isfinite(array) | (np.isnan(array) & (key in MAY_BE_NAN)))
    if bad.any():
        first = np.unravel_index(int(bad.argmax()), bad.shape)
        place = "".join(f"[{i}]" for i in first)
        raise ProblemError(f"key '{key}': expected finite numbers, found {array[first]} at {key}{place}")
    return array


def kind(array: NDArray[Any]) -> str:
    """The actual contents of an array, in words, for error messages."""
    words = {"c": "complex numbers", "O": "Python objects", "U": "text", "S": "bytes", "b": "booleans"}
    what = words.get(array.dtype.kind, f"dtype {array.dtype}")
    return what if array.ndim == 0 else f"{what} of shape {array.shape}"


def in_range(key: str, array: NDArray[np.float64]) -> NDArray[np.float64]:
    """A finite array whose size can be calculated with; what is negligible in it becomes zero.

    Raises
    ------
    ProblemError
        If its largest magnitude is neither 0 nor between 1e-100 and 1e100.

    Examples
    --------
    >>> in_range("A", np.array([2.0, 5e-324]))
    array([2., 0.])
    """
    sizes = np.abs(array)
    largest = float(np.fmax.reduce(sizes, axis=None, initial=0.0))  # NaN is ignored here
    if largest and not SMALLEST <= largest <= LARGEST:
        raise ProblemError(
            f"key '{key}': expected the largest magnitude to be 0 or between {SMALLEST:g} and {LARGEST:g}, "
            f"found {largest:g} (choose other units)"
        )
    return np.where(sizes < NEGLIGIBLE * largest, 0.0, array)


def check_ratios(arrays: Mapping[str, NDArray[np.float64]]) -> None:
    """Check what the arrays of a problem, by key, mean for each other.

    Raises
    ------
    ProblemError
        If a friction coefficient exceeds 1e12, forces over stiffness are no
        lengths between 1e-75 and 1e75, or stiffness times the initial slip no
        forces below 1e100.
    """
    friction = _largest(arrays, ("f",))
    if friction > LARGEST_FRICTION:
        raise ProblemError(
            f"key 'f': expected friction coefficients up to {LARGEST_FRICTION:g}, found {friction:g}"
        )
    stiffness, force = _largest(arrays, STIFFNESS), _largest(arrays, FORCES)
    length = force / stiffness if stiffness else 0.0
    if length and not 1 / LARGEST_LENGTH <= length <= LARGEST_LENGTH:
        raise ProblemError(
            f"keys 'A', 'q_w', …: expected forces over stiffness between {1 / LARGEST_LENGTH:g} and "
            f"{LARGEST_LENGTH:g}, found {length:g}"
        )
    check_slip("key 'initial_slip'", stiffness, _largest(arrays, ("initial_slip",)))


def check_slip(what: str, stiffness: float, slip: float) -> None:
    """Raise ``ProblemError`` where an initial slip is so large that its reactions overflow."""
    if slip > LARGEST or stiffness * slip > LARGEST:
        raise ProblemError(
            f"{what}: expected slips with reactions up to {LARGEST:g}, found the slip {slip:g}"
        )


def _largest(arrays: Mapping[str, NDArray[np.float64]], keys: tuple[str, ...]) -> float:
    return max((float(np.abs(arrays[key]).max(initial=0.0)) for key in keys if key in arrays), default=0.0)


def check_definiteness(arrays: Mapping[str, FloatArray], rounding: float) -> None:
    """Raise ``ProblemError`` unless κ, or A where there is no C, is positive semi-definite.

    Entries off by ``rounding`` of themselves move an eigenvalue by as much of the largest row sum.
    """
    if "C" in arrays:
        matrix = np.block([[arrays["A"], arrays["B"].T], [arrays["B"], arrays["C"]]])
        expected = "keys 'A', 'B', 'C': expected kappa = [[A, B^T], [B, C]] positive semi-definite"
    else:
        matrix, expected = arrays["A"], "key 'A': expected a positive semi-definite matrix"
    scale = np.abs(matrix).max()
    if scale == 0.0:
        return
    scaled = matrix / scale
    if _clearly_definite(scaled):
        return
    eigenvalues = np.linalg.eigvalsh(scaled)
    rounding = rounding or printed_error(matrix)
    printed = rounding * float(np.abs(scaled).sum(axis=0).max())
    if eigenvalues[0] < -max(DEFAULT.definiteness * max(eigenvalues[-1], -eigenvalues[0]), printed):
        raise ProblemError(f"{expected}, found the eigenvalue {eigenvalues[0] * scale:.6g}")


def printed_error(*matrices: FloatArray) -> float:
    """Relative error of entries that seem to be printed with 5 to 12 digits; 0 where they do not.

    None needs more digits. Where most need as many decimals as any, but not as many digits, the error is
    relative to the largest, and grows with the number of columns.

    Examples
    --------
    >>> exact = np.outer([1.0, 3.0], [1 / 7, 1 / 9])
    >>> printed_error(exact), printed_error(np.round(exact, 8)) < 1e-7, printed_error(np.eye(3))
    (0.0, True, 0.0)
    """
    entries = np.concatenate([each[each != 0.0] for each in matrices])
    digits, decimals = list[int](), list[int]()
    for entry in entries[:: len(entries) // SAMPLED + 1].tolist():
        number = Decimal(repr(entry)).normalize().as_tuple()
        digits.append(len(number.digits))
        decimals.append(-int(number.exponent))
        if digits[-1] > MOST_PRINTED:
            return 0.0
    if not digits or max(digits) < LEAST_PRINTED:
        return 0.0
    if _mostly(digits) or not _mostly(decimals):
        return 5.0 * 10.0 ** -max(digits)
    return float(0.5 * 10.0 ** -max(decimals) / np.abs(entries).max() * np.sqrt(matrices[0].shape[1]))


def _mostly(counts: list[int]) -> bool:
    """Whether half of some counts, at least, are the largest one or one less."""
    return 2 * sum(count >= max(counts) - 1 for count in counts) >= len(counts)


def _clearly_definite(matrix: FloatArray) -> bool:
    """Whether no eigenvalue lies below half of what counts as zero: there is a factor, found sooner."""
    shift = 0.5 * DEFAULT.definiteness * float(np.diagonal(matrix).max())
    try:
        np.linalg.cholesky(matrix + shift * np.eye(len(matrix)))
    except np.linalg.LinAlgError:
        return False
    return True


def symmetrised(key: str, matrix: FloatArray, rounding: float, largest: float) -> FloatArray:
    """A block of κ, exactly symmetric; raises ``ProblemError`` where it is not so but for its rounding.

    Its entries may be off by ``rounding`` of themselves, and by the round-off of the ``largest`` stiffness.

    Examples
    --------
    >>> symmetrised("C", np.array([[1e-14, 2e-14], [0.0, 0.0]]), 0.0, largest=1.0)
    array([[1.e-14, 1.e-14],
           [1.e-14, 0.e+00]])
    """
    error = np.abs(matrix - matrix.T)
    if error.max() > max(max(DEFAULT.symmetry, 2 * rounding) * np.abs(matrix).max(), CANCELLED * largest):
        i, j = np.unravel_index(int(np.argmax(error)), error.shape)
        raise ProblemError(
            f"key '{key}': expected a symmetric matrix, found {key}[{i},{j}] = {matrix[i, j]:.9g} "
            f"but {key}[{j},{i}] = {matrix[j, i]:.9g}"
        )
    return 0.5 * matrix + 0.5 * matrix.T


def check_unit_loads(arrays: dict[str, FloatArray]) -> None:
    """Hold the loads of a problem, by key, against its welded reactions; make the compliance symmetric.

    Raises
    ------
    ProblemError
        If the welded reactions less those of the loads differ from load step to load step, the compliance
        is not symmetric, or a frequency not above 0.
    """
    if "load_reactions" not in arrays:
        return
    unit, history = arrays["load_reactions"], arrays["load_history"]
    welded = np.hstack([arrays["q_w"], arrays["p_w"]])
    left = welded - history @ unit
    off = np.abs(left - left[0])
    size = np.abs(welded).max() + (np.abs(history) @ np.abs(unit)).max()
    if off.max() > DEFAULT.printed_digits * size:
        k, j = np.unravel_index(int(off.argmax()), off.shape)
        n = arrays["q_w"].shape[1]
        what = f"q_w[{k},{j}]" if j < n else f"p_w[{k},{j - n}]"
        raise ProblemError(
            "keys 'q_w', 'p_w': expected a constant and load_history @ load_reactions, found "
            f"{what} off by {off.max():.6g} (other loads take the keys load_reactions, load_history along)"
        )
    if "load_compliance" in arrays:
        S = arrays["load_compliance"]
        arrays["load_compliance"] = symmetrised("load_compliance", S, 0.0, float(np.abs(S).max(initial=0.0)))
    for j in np.flatnonzero(arrays.get("load_frequency", np.ones(0)) <= 0):
        raise ProblemError(
            f"key 'load_frequency': expected frequencies > 0 or NaN, found {arrays['load_frequency'][j]:g} "
            f"of load {j}"
        )


LOOP, DOMAIN = "loop", "domain"  # the meaning of load steps: a loop followed in order, or corners of a domain
SOURCE_LISTS = {"files": (dict, "objects"), "warnings": (str, "texts")}


def plain_text(key: str, value: Any) -> str:
    """One text of whole characters; raises ``ProblemError`` for anything else."""
    array = np.asarray(value)
    if array.dtype.kind != "U" or array.ndim != 0:
        raise ProblemError(f"key '{key}': expected one text string, found {kind(array)}")
    _check_characters(key, array)
    return str(array)


def names(key: str, value: ArrayLike) -> tuple[str, ...]:
    """Names of things, one line each; whole numbers are names too.

    Raises
    ------
    ProblemError
        If they are not one text each, or one is longer than 200 characters or holds
        a character that a terminal or a page would obey instead of showing it.

    Examples
    --------
    >>> names("label", [4711, 4712]), names("label", ["12/34"])
    (('4711', '4712'), ('12/34',))
    """
    try:
        array = np.asarray(value)
    except ValueError:  # ragged nested lists
        raise ProblemError(f"key '{key}': expected one text each, found ragged rows") from None
    if array.ndim != 1 or array.dtype.kind not in "Uiu":
        raise ProblemError(f"key '{key}': expected one text each, found {kind(array)}")
    if array.dtype.kind == "U":
        _check_characters(key, array)
    found = tuple(map(str, array.tolist()))
    for k, name in enumerate(found):
        if len(name) > LONGEST_NAME:
            raise ProblemError(
                f"key '{key}': expected at most {LONGEST_NAME} characters, found {len(name)} at {key}[{k}]"
            )
        if visible(name) != name:
            raise ProblemError(
                f"key '{key}': expected text that can be shown, found '{shortened(visible(name), 60)}' "
                f"at {key}[{k}]"
            )
    return found


def origin(key: str, value: Any) -> str:
    """The text of a JSON object whose ``files`` are objects and ``warnings`` texts, or no text at all.

    Raises ``ProblemError`` for anything else.

    Examples
    --------
    >>> origin("source", '{"files": []}')
    '{"files": []}'
    >>> origin("source", '{"warnings": 3}')
    Traceback (most recent call last):
    ...
    shakedown.ground.errors.ProblemError: key 'source': 'warnings': expected a list of texts, found 3
    """
    text = plain_text(key, value)
    try:
        told = json.loads(text or "{}", parse_constant=_not_json)
    except (ValueError, RecursionError) as error:
        raise ProblemError(f"key '{key}': expected JSON text, found what is none ({error})") from None
    if not isinstance(told, dict):
        raise ProblemError(f"key '{key}': expected a JSON object, found {type(told).__name__}")
    for entry, (kind_of, words) in SOURCE_LISTS.items():
        found = told.get(entry, [])
        if not (isinstance(found, list) and all(isinstance(each, kind_of) for each in found)):
            shown = shortened(visible(json.dumps(found, ensure_ascii=False)), 60)
            raise ProblemError(f"key '{key}': '{entry}': expected a list of {words}, found {shown}")
    return text


def load_path(key: str, value: Any) -> str:
    """``"loop"`` or ``"domain"``; raises ``ProblemError`` for anything else.

    Examples
    --------
    >>> load_path("load_path", "domain")
    'domain'
    """
    text = plain_text(key, value)
    if text not in (LOOP, DOMAIN):
        raise ProblemError(
            f"key '{key}': expected '{LOOP}' or '{DOMAIN}', found '{shortened(visible(text), 40)}'"
        )
    return text


def _check_characters(key: str, array: NDArray[Any]) -> None:
    """Refuse what NumPy stores as text and is none: halves of characters, numbers beyond the last one."""
    native = np.ascontiguousarray(array.astype(array.dtype.newbyteorder("=")))
    codes = np.frombuffer(native.tobytes(), dtype=np.uint32)
    wrong = codes[(codes > sys.maxunicode) | ((codes >= 0xD800) & (codes < 0xE000))]
    if wrong.size:
        raise ProblemError(f"key '{key}': expected text, found the character number 0x{wrong[0]:x}")


def _not_json(word: str) -> NoReturn:
    raise ValueError(f"the word {word}")
