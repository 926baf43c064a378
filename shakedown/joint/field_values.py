"""The fields of a problem: each by itself (numbers, text, names, JSON), shapes and magnitudes together."""

import json
from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.given_numbers import real_values
from shakedown.ground.visible_text import LONGEST_NAME, shortened, visible

# Axis names of every array field; `n` contact nodes, `m` load steps, `k` transient steps, `s` states,
# `c` load cases; numbers are directions x, y, z.
SHAPES: dict[str, tuple[str | int, ...]] = {
    "A": ("n", "n"),
    "B": ("n", "n"),
    "C": ("n", "n"),
    "f": ("n",),
    "q_w": ("m", "n"),
    "p_w": ("m", "n"),
    "q_mean": ("n",),
    "p_mean": ("n",),
    "q_transient": ("k", "n"),
    "p_transient": ("k", "n"),
    "initial_slip": ("s", "n"),
    "x": ("n",),
    "coordinates": ("n", 3),
    "normal": ("n", 3),
    "tangent": ("n", 3),
    "node_area": ("n",),
    "stiffness_accuracy": (),
    "label": ("n",),
    "load_names": ("c",),
    "load_mean": ("c",),
    "load_amplitude": ("c",),
    "load_units": ("c",),
}
NAMES = ("label", "load_names", "load_units")  # lists of text; all other arrays are of numbers
TEXTS = ("name", "units", "source", "load_path")
LOOP, DOMAIN = "loop", "domain"  # what the load steps are: followed in their order, or corners
TOGETHER = (  # where the one is given, the other is needed
    ("q_transient", "p_transient"),
    ("p_transient", "q_transient"),
    ("load_mean", "load_amplitude"),
    ("load_amplitude", "load_mean"),
    ("load_units", "load_mean"),
    ("load_mean", "load_names"),
)
FIRST_DIGIT = 5.0  # seven digits, an accuracy of 1e-7, leave an error of 5e-7 where the first of them is 1
LAST_CODE_POINT = 0x10FFFF

# Beyond these, products of three numbers are no numbers any more.
LARGEST = 1e100  # of a stiffness, force or length, in whatever units: its square is still a number
SMALLEST = 1e-100  # of the largest entry of an array that is not zero
NEGLIGIBLE = 1e-30  # entries so much smaller than the largest of their array are taken as zero
LARGEST_FRICTION = 1e12
LARGEST_LENGTH = 1e75  # of a slip, force over stiffness

STIFFNESS, FORCES = ("A", "B", "C"), ("q_w", "p_w", "q_mean", "p_mean", "q_transient", "p_transient")


def plain_text(key: str, value: Any) -> str:
    """One text of whole characters; raises ``ProblemError`` for anything else."""
    array = np.asarray(value)
    if array.dtype.kind != "U" or array.ndim != 0:
        raise ProblemError(f"key '{key}': expected one text string, found {_kind(array)}")
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
        raise ProblemError(f"key '{key}': expected one text each, found {_kind(array)}")
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


def json_object(key: str, value: Any) -> str:
    """The text of one JSON object, or no text at all; raises ``ProblemError`` for anything else.

    Examples
    --------
    >>> json_object("source", '{"files": []}')
    '{"files": []}'
    """
    text = plain_text(key, value)
    if not text:
        return text
    try:
        found = json.loads(text, parse_constant=_not_json)
    except (ValueError, RecursionError) as error:
        raise ProblemError(f"key '{key}': expected JSON text, found what is none ({error})") from None
    if not isinstance(found, dict):
        raise ProblemError(f"key '{key}': expected a JSON object, found {type(found).__name__}")
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


def real_numbers(key: str, value: ArrayLike) -> NDArray[np.float64]:
    """A private float64 copy of a real, finite array; raises ``ProblemError`` for anything else."""
    if np.ma.is_masked(value):
        raise ProblemError(f"key '{key}': expected every number, found masked ones")
    try:
        array = real_values(value)
    except ValueError:  # ragged nested lists
        raise ProblemError(f"key '{key}': expected a regular array of numbers, found ragged rows") from None
    if array.dtype.kind not in "fiu":
        raise ProblemError(f"key '{key}': expected real numbers, found {_kind(array)}")
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is reported as not finite below
        array = np.array(array, dtype=np.float64)
    bad = np.argwhere(~np.isfinite(array))
    if bad.size:
        place = "".join(f"[{i}]" for i in bad[0])
        raise ProblemError(
            f"key '{key}': expected finite numbers, found {array[tuple(bad[0])]} at {key}{place}"
        )
    return array


def _check_characters(key: str, array: NDArray[Any]) -> None:
    """Refuse what NumPy stores as text and is none: halves of characters, numbers beyond the last one."""
    native = np.ascontiguousarray(array.astype(array.dtype.newbyteorder("=")))
    codes = np.frombuffer(native.tobytes(), dtype=np.uint32)
    wrong = codes[(codes > LAST_CODE_POINT) | ((codes >= 0xD800) & (codes < 0xE000))]
    if wrong.size:
        raise ProblemError(f"key '{key}': expected text, found the character number 0x{wrong[0]:x}")


def _not_json(word: str) -> NoReturn:
    raise ValueError(f"the word {word}")


def _kind(array: NDArray[Any]) -> str:
    words = {"c": "complex numbers", "O": "Python objects", "U": "text", "S": "bytes", "b": "booleans"}
    what = words.get(array.dtype.kind, f"dtype {array.dtype}")
    return what if array.ndim == 0 else f"{what} of shape {array.shape}"


def check_shapes(shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Match the shapes of array fields, by key, against each other.

    Raises
    ------
    ProblemError
        If a field that every problem has is missing, or a shape does not fit.
    """
    for key in ("A", "B", "f", "q_w", "p_w"):
        if key not in shapes:
            raise ProblemError(f"key '{key}': required, found none")
    for given, needed in TOGETHER:
        if given in shapes and needed not in shapes:
            raise ProblemError(f"key '{needed}': required because '{given}' is given, found none")
    A = shapes["A"]
    if len(A) != 2 or A[0] != A[1]:
        raise ProblemError(f"key 'A': expected a square array (n, n), found shape {A}")
    sizes = {"n": A[0]}
    if sizes["n"] == 0:
        raise ProblemError("key 'A': expected at least one contact node, found shape (0, 0)")
    for key, shape in shapes.items():
        _check_shape(key, shape, sizes)
    if sizes["m"] == 0:
        raise ProblemError("key 'q_w': expected at least one load step, found m = 0")


def _check_shape(key: str, shape: tuple[int, ...], sizes: dict[str, int]) -> None:
    """Match one shape against its axis names, learning m, k and s where they first occur."""
    axes = SHAPES[key]
    if key == "f" and not shape:
        return
    if key == "initial_slip" and len(shape) == 1:
        axes = ("n",)
    expected = tuple(axis if isinstance(axis, int) else sizes.get(axis, axis) for axis in axes)
    fits = len(shape) == len(axes) and all(
        isinstance(want, str) or want == have for want, have in zip(expected, shape, strict=True)
    )
    if not fits:
        wanted = "(" + ", ".join(map(str, expected)) + ("," if len(expected) == 1 else "") + ")"
        hint = _transposition_hint(shape, expected)
        raise ProblemError(f"key '{key}': expected shape {wanted}, found {shape}{hint}")
    for axis, have in zip(axes, shape, strict=True):
        if isinstance(axis, str):
            sizes.setdefault(axis, have)


def _transposition_hint(shape: tuple[int, ...], expected: tuple[int | str, ...]) -> str:
    if len(shape) == 2 and len(expected) == 2 and shape[0] == expected[1]:
        first = expected[0]
        if isinstance(first, str) or shape[1] == first:
            return " (it looks transposed: one column per node)"
    return ""


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
    largest = float(sizes.max(initial=0.0))
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
    """Raise ``ProblemError`` where an initial slip is so large that its reactions are no numbers."""
    if slip > LARGEST or stiffness * slip > LARGEST:
        raise ProblemError(
            f"{what}: expected slips with reactions up to {LARGEST:g}, found the slip {slip:g}"
        )


def _largest(arrays: Mapping[str, NDArray[np.float64]], keys: tuple[str, ...]) -> float:
    return max((float(np.abs(arrays[key]).max(initial=0.0)) for key in keys if key in arrays), default=0.0)
