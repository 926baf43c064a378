"""Checks of the numbers of a problem: real, finite, of a usable size, and consistent."""

from collections.abc import Mapping
from decimal import Decimal
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.argument_kinds import real_values
from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.field_table import FORCES, MAY_BE_NAN, STIFFNESS

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
