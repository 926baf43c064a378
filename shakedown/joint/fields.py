"""The fields of a problem: their shapes, and the numbers, names and texts that they may hold."""

import json
from collections.abc import Mapping
from decimal import Decimal
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.argument_kinds import real_values
from shakedown.ground.constants import EPS, NEGLIGIBLE, THREE_DIGITS, FloatArray
from shakedown.ground.errors import ProblemError, ShakedownError, wrong_key
from shakedown.ground.shown_values import LONGEST_NAME, short, shortened, visible
from shakedown.ground.tolerances import DEFAULT, FIRST_DIGIT
from shakedown.joint.places import check_places, without_cancelled

# Axes by name: n contact nodes, dn their tangential directions, m load steps, k transient steps, s states,
# c load cases, L loads with unit reactions, e faces; a number of components, as of x, y, z.
Axes = tuple[str | int, ...]
TEXTS = ("load_path", "name", "units", "source")
NAMES = ("load_names", "load_units", "label")
OF_NODES = ("f", "x", "coordinates", "normal", "tangent", "tangents", "node_area", "label")  # of each alone
STIFFNESS = ("A", "B", "C")
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


def check_shapes(shapes: Mapping[str, tuple[int, ...]], axes: Mapping[str, Axes]) -> None:
    """Match the shapes of array fields, by key, against their axes and each other.

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
    A, B = shapes["A"], shapes["B"]
    if len(A) != 2 or A[0] != A[1] or not A[0]:
        raise wrong_key("A", "a square array (n, n) of at least one contact node", f"shape {A}")
    directions = 2 if len(B) == 2 and B[1] == A[0] == 2 * B[0] else 1
    n = A[0] // directions
    sizes: dict[str | int, int] = {"dn": A[0], "n": n, "(d+1)n": A[0] + n}
    other: dict[str, tuple[Axes, ...]] = {"f": ((),), "initial_slip": (("dn",),)}
    if A[0] % 2 == 0:  # of two directions
        other["B"] = ((A[0] // 2, A[0]),)
    if directions > 1:  # in a plane or in space
        other["x"] = ("n", 2), ("n", 3)
    for key, shape in shapes.items():
        _check_shape(key, shape, (axes[key], *other.get(key, ())), sizes)
    for key, only in (("tangent", 1), ("tangents", 2), ("faces", 2)):
        if key in shapes and only != directions:
            words = "one tangential direction", "two tangential directions"
            raise wrong_key(key, f"only with {words[only - 1]}", directions)
    if sizes["m"] == 0:
        raise wrong_key("q_w", "at least one load step", "m = 0")


def _check_shape(
    key: str, shape: tuple[int, ...], allowed: tuple[Axes, ...], sizes: dict[str | int, int]
) -> None:
    """Match one shape against its axis names, learning m, k and s where they first occur."""
    expected = [tuple(sizes.get(axis, axis) for axis in axes) for axes in allowed]
    for axes, known in zip(allowed, expected, strict=True):
        if len(known) == len(shape) and all(
            isinstance(want, str) or want == have for want, have in zip(known, shape, strict=True)
        ):
            sizes |= zip(axes, shape, strict=True)
            return
    raise wrong_key(key, f"shape {' or '.join(map(str, expected))}".replace("'", ""), shape)


# Beyond these, products of three numbers are no numbers any more.
LARGEST = 1e100  # largest stiffness, force or length, in any units: its square is still finite


def real_numbers(key: str, value: ArrayLike) -> NDArray[np.float64]:
    """A private float64 copy of the real, finite array of a key; raises ``ProblemError`` for anything else.

    The frequency of a load that is no mode is NaN.
    """
    return finite_array(f"key '{key}'", key, value, ProblemError, nan=key == "load_frequency")


def finite_array(
    what: str, name: str, value: ArrayLike, error: type[ShakedownError], *, nan: bool = False
) -> NDArray[np.float64]:
    """A private float64 copy of a real, finite array; raises an error for anything else."""
    if np.ma.is_masked(value):
        raise error(f"{what}: expected every number, found masked ones")
    try:
        array = real_values(value)
    except ValueError:  # ragged nested lists
        raise error(f"{what}: expected a regular array of numbers, found ragged rows") from None
    if array.dtype.kind not in "fiu":
        raise error(f"{what}: expected real numbers, found {short(value)}")
    with np.errstate(over="ignore", invalid="ignore"):  # overflow is reported as not finite below
        array = np.array(array, dtype=np.float64)
    bad = ~np.isfinite(array)
    if nan:
        bad &= ~np.isnan(array)
    if bad.any():
        first = np.unravel_index(int(bad.argmax()), bad.shape)
        place = name + "".join(f"[{i}]" for i in first)
        raise error(f"{what}: expected finite numbers, found {array[first]} at {place}")
    return array


COARSEST = np.float64(THREE_DIGITS)  # relative accuracy that a stiffness needs at least


def check_values(arrays: dict[str, FloatArray]) -> None:
    """Check the arrays of a problem, and round off in place what is only nearly as it has to be."""
    f = arrays["f"]
    if np.any(f < 0):
        j = int(np.argmax(f < 0))
        raise wrong_key("f", "friction coefficients >= 0", f"{f[j]} at node {j}")
    for key, array in arrays.items():
        arrays[key] = in_range(key, array)
    check_ratios(arrays)
    accuracy = arrays.get("stiffness_accuracy", COARSEST)
    if not 0.0 < accuracy <= COARSEST:
        expected = f"a number above 0 and up to {COARSEST:g} (three digits)"
        raise wrong_key("stiffness_accuracy", expected, f"{accuracy:g}")
    if "node_area" in arrays:
        arrays["node_area"] = without_cancelled(arrays["node_area"])
    check_places(arrays)
    rounding = FIRST_DIGIT * float(accuracy) if "stiffness_accuracy" in arrays else 0.0
    largest = max(float(np.abs(arrays[key]).max()) for key in STIFFNESS if key in arrays)
    for key in ("A", "C"):
        if key in arrays:
            arrays[key] = symmetrised(key, arrays[key], rounding, largest)
    check_definiteness(arrays, rounding)
    check_unit_loads(arrays)


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
    negligible = 1e-30  # entries so much smaller than the largest of their array are taken as zero
    sizes = np.abs(array)
    largest = float(np.fmax.reduce(sizes, axis=None, initial=0.0))  # NaN is ignored here
    if largest and not 1 / LARGEST <= largest <= LARGEST:
        expected = f"the largest magnitude to be 0 or between {1 / LARGEST:g} and {LARGEST:g}"
        raise wrong_key(key, expected, f"{largest:g} (choose other units)")
    return np.where(sizes < negligible * largest, 0.0, array)


def check_ratios(arrays: Mapping[str, NDArray[np.float64]]) -> None:
    """Check what the arrays of a problem, by key, mean for each other.

    Raises
    ------
    ProblemError
        If a friction coefficient exceeds 1e12, forces over stiffness are no lengths between 1e-75 and
        1e75, or stiffness times the initial slip no forces below 1e100.
    """
    largest_length = 1e75  # largest slip, force over stiffness
    largest_friction = 1e12
    if (friction := arrays["f"].max()) > largest_friction:
        raise wrong_key("f", f"friction coefficients up to {largest_friction:g}", f"{friction:g}")
    forces = ("q_w", "p_w", "q_mean", "p_mean", "q_transient", "p_transient")
    stiffness, force, slip = (
        max((float(np.abs(arrays[key]).max(initial=0.0)) for key in keys if key in arrays), default=0.0)
        for keys in (STIFFNESS, forces, ("initial_slip",))
    )
    length = force / stiffness if stiffness else 0.0
    if length and not 1 / largest_length <= length <= largest_length:
        raise ProblemError(
            f"keys 'A', 'q_w', …: expected forces over stiffness between {1 / largest_length:g} and "
            f"{largest_length:g}, found {length:g}"
        )
    check_slip("key 'initial_slip'", stiffness, slip)


def check_slip(what: str, stiffness: float, slip: float, error: type[ShakedownError] = ProblemError) -> None:
    """Raise an error where an initial slip is so large that its reactions overflow."""
    if slip > LARGEST or stiffness * slip > LARGEST:
        raise error(f"{what}: expected slips with reactions up to {LARGEST:g}, found the slip {slip:g}")


def check_definiteness(arrays: Mapping[str, FloatArray], rounding: float) -> None:
    """Raise ``ProblemError`` unless κ, or A where there is no C, is positive semi-definite.

    Entries off by ``rounding`` of themselves move an eigenvalue by as much of the largest row sum.
    """
    if "C" in arrays:
        matrix = np.block([[arrays["A"], arrays["B"].T], [arrays["B"], arrays["C"]]])
        expected = "keys 'A', 'B', 'C': expected [[A, B^T], [B, C]] positive semi-definite, in one unit"
    else:
        matrix, expected = arrays["A"], "key 'A': expected a positive semi-definite matrix"
    scale = np.abs(matrix).max()
    if scale == 0.0:
        return
    scaled = matrix / scale
    if is_definite(scaled, -0.5 * DEFAULT.definiteness * float(np.diagonal(scaled).max())):
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
    >>> exact = np.outer(10.0 ** -np.arange(5), [30 / 7, 10 / 9])
    >>> printed_error(exact), printed_error(np.round(exact, 8)) < 2e-9, printed_error(np.eye(3))
    (0.0, True, 0.0)
    """
    least, most = 5, 12  # digits: numbers of fewer are as good as exact, of more as round-off
    entries = np.concatenate([each[each != 0.0] for each in matrices])
    digits, decimals = list[int](), list[int]()
    for entry in entries[:: len(entries) // 4096 + 1].tolist():  # some show whether they are short
        number = Decimal(repr(entry)).normalize().as_tuple()
        digits.append(len(number.digits))
        decimals.append(-int(number.exponent))
        if digits[-1] > most:
            return 0.0
    if not digits or max(digits) < least:
        return 0.0
    of_digits, of_decimals = (  # whether half of them, at least, have the most or one less
        2 * sum(count >= max(counts) - 1 for count in counts) >= len(counts) for counts in (digits, decimals)
    )
    if of_digits or not of_decimals:
        return 5.0 * 10.0 ** -max(digits)
    return float(0.5 * 10.0 ** -max(decimals) / np.abs(entries).max() * np.sqrt(matrices[0].shape[1]))


def is_definite(matrix: FloatArray, least: float) -> bool:
    """Whether no eigenvalue of a symmetric matrix lies below a number: there is a factor, found sooner."""
    try:
        np.linalg.cholesky(matrix - least * np.eye(len(matrix)))
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
    cancelled = 2**12 * EPS * largest  # what is left where larger ones cancel each other
    if error.max() > max(max(DEFAULT.symmetry, 2 * rounding) * np.abs(matrix).max(), cancelled):
        i, j = np.unravel_index(int(np.argmax(error)), error.shape)
        entries = (f"{key}[{i},{j}] = {matrix[i, j]:.9g}", f"{key}[{j},{i}] = {matrix[j, i]:.9g}")
        raise wrong_key(key, "a symmetric matrix", " but ".join(entries))
    return 0.5 * matrix + 0.5 * matrix.T


def check_unit_loads(arrays: dict[str, FloatArray]) -> None:
    """Hold the loads of a problem, by key, against its welded reactions; make the compliance symmetric.

    Raises
    ------
    ProblemError
        If the welded reactions less those of the loads differ from load step to load step, the compliance
        is not symmetric (Maxwell and Betti) or lets loads store less than no energy, or a frequency is not
        above 0.
    """
    if "load_reactions" not in arrays:
        return
    unit, history = arrays["load_reactions"], arrays["load_history"]
    welded = np.hstack([arrays["q_w"], arrays["p_w"]])
    left = welded - history @ unit
    off = np.abs(left - left[0])
    size = np.abs(welded).max() + (np.abs(history) @ np.abs(unit)).max()
    if off.max() > DEFAULT.printed_digits * size:
        raise ProblemError(
            "keys 'q_w', 'p_w': expected a constant and load_history @ load_reactions, found load step "
            f"{off.max(axis=1).argmax()} off by {off.max():.6g} (other loads take these keys along)"
        )
    if "load_compliance" in arrays:
        largest = float(np.abs(arrays["load_compliance"]).max(initial=0.0))
        S = arrays["load_compliance"] = symmetrised(
            "load_compliance", arrays["load_compliance"], 0.0, largest
        )
        for sign in (1.0, -1.0):  # forces; prescribed displacements, conjugate to minus the holding force
            own = np.flatnonzero(sign * np.diag(S) > NEGLIGIBLE * largest)
            sizes = np.sqrt(np.abs(np.diag(S)[own]))
            if not is_definite(sign * S[np.ix_(own, own)] / np.outer(sizes, sizes), -DEFAULT.printed_digits):
                raise wrong_key("load_compliance", "stored energy >= 0", f"less for some sums of loads {own}")
    frequency = arrays.get("load_frequency", np.ones(0))
    for j in np.flatnonzero(frequency <= 0):
        raise wrong_key("load_frequency", "frequencies > 0 or NaN", f"{frequency[j]:g} of load {j}")


LOOP, DOMAIN = "loop", "domain"  # the meaning of load steps: a loop followed in order, or corners of a domain


def plain_text(key: str, value: Any) -> str:
    """One text of whole characters; raises ``ProblemError`` for anything else."""
    array = np.asarray(value) if isinstance(value, str | np.ndarray) else None
    if array is None or array.dtype.kind != "U" or array.ndim != 0:
        raise wrong_key(key, "one text string", short(value))
    try:
        text = str(array)
        text.encode()
    except (ValueError, SystemError) as error:  # halves of characters, or numbers beyond the last one
        raise wrong_key(key, "text", error) from None
    return text


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
        found = tuple(map(str, array.tolist())) if array.ndim == 1 and array.dtype.kind in "Uiu" else None
    except (ValueError, SystemError):  # ragged rows, or no characters
        found = None
    if found is None:
        raise wrong_key(key, "one text each", short(value))
    for k, name in enumerate(found):
        if len(name) > LONGEST_NAME or visible(name) != name:
            expected = f"text of at most {LONGEST_NAME} characters that can be shown"
            raise wrong_key(key, expected, f"'{shortened(visible(name), 60)}' at {key}[{k}]")
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
    shakedown.ground.errors.ProblemError: key 'source': expected JSON text, an object with lists ...
    """
    text = plain_text(key, value)
    try:
        found = json.loads(text or "{}", parse_constant=_not_json)
    except (ValueError, RecursionError):
        found = None
    lists = (
        ((found.get("files", []), dict), (found.get("warnings", []), str)) if isinstance(found, dict) else ()
    )
    if lists and all(
        isinstance(listed, list) and all(isinstance(each, kind) for each in listed) for listed, kind in lists
    ):
        return text
    expected = "JSON text, an object with lists of objects as 'files' and of texts as 'warnings'"
    raise wrong_key(key, expected, f"'{shortened(visible(text), 60)}'")


def load_path(key: str, value: Any) -> str:
    """``"loop"`` or ``"domain"``; raises ``ProblemError`` for anything else.

    Examples
    --------
    >>> load_path("load_path", "domain")
    'domain'
    """
    text = plain_text(key, value)
    if text not in (LOOP, DOMAIN):
        raise wrong_key(key, f"'{LOOP}' or '{DOMAIN}'", f"'{shortened(visible(text), 40)}'")
    return text


def _not_json(word: str) -> NoReturn:
    raise ValueError(f"the word {word}")
