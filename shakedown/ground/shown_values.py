"""Text and values as results, messages and pages show them."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from typing import Any

import numpy as np
from numpy.typing import NDArray

LONGEST_NAME = 200  # characters of one name, unit or path inside a message

# A symbol and its subscript: λ_E, p_w; not the name of a file, p_w.mtx.
SUBSCRIPT = re.compile(r"(λ|(?<![\w.])[pq](?=_w))_(max|lo|[cw]|[A-Z0-9])(?![\w=]|\.\w)")

# Characters that terminals or pages interpret instead of showing: C0, DEL and C1 controls, line and paragraph
# separators, bidirectional controls, zero-width and tag characters, halves of characters, the end of BMP.
_OBEYED = re.compile(
    "[\x00-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff0-\uffff"
    "\ud800-\udfff\U000e0000-\U000e007f]"
)


def escaped(character: str) -> str:
    """A character as Python would write it in a string."""
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def visible(text: str, keep: str = "", escape: Callable[[str], str] = escaped) -> str:
    r"""A text with every character that a terminal or a page would interpret written as its escape.

    Parameters
    ----------
    text
        Any string, also one with unpaired surrogates.
    keep
        Characters that stay as they are: ``"\n"`` for a text of several lines.
    escape
        How such a character is written.

    Examples
    --------
    >>> print(visible("joint\x1b[2J \u202e λ_1"))
    joint\x1b[2J \u202e λ_1
    """
    return _OBEYED.sub(lambda match: match[0] if match[0] in keep else escape(match[0]), text)


def shortened(text: str, longest: int = LONGEST_NAME) -> str:
    """A text with its middle omitted where it is too long.

    Examples
    --------
    >>> shortened("the name of a joint", 11)
    'the n…joint'
    """
    if len(text) <= longest:
        return text
    half = (longest - 1) // 2
    return f"{text[:half]}…{text[len(text) - half :]}"


def one_line(text: str, longest: int = 1000) -> str:
    r"""A message of one line: white space runs become one blank, the rest is visible and short.

    Examples
    --------
    >>> one_line("no such\n  file: \x00")
    'no such file: \\x00'
    """
    return shortened(visible(" ".join(shortened(text, 4 * longest).split())), longest)


def with_unit(name: str, unit: str) -> str:
    """A heading or an axis label with its unit, where that is known.

    Examples
    --------
    >>> with_unit("slip", "mm"), with_unit("slip", "")
    ('slip [mm]', 'slip')
    """
    return f"{name} [{unit}]" if unit else name


DIGITS = 7  # digits of a load factor or a limit known that accurately
FEW_DIGITS = 4  # digits of simulated values and margins, and at least of a limit
SHORT_DIGITS = 3  # digits of differences, and in titles of pictures
LONGEST_VALUE = 56  # characters of one value
WIDTH = 79  # characters of a line shown


def plain(value: Any) -> Any:
    """A value as JSON knows it: arrays as lists, infinities as "inf"/"-inf", undefined numbers as None.

    Examples
    --------
    >>> plain({"slip": np.array([1.0, np.nan]), "load_factor": math.inf})
    {'slip': [1.0, None], 'load_factor': 'inf'}
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        return int(value)
    if isinstance(value, str):  # an enumeration member becomes its text
        return str(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None if math.isnan(value) else str(value)
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if is_dataclass(value):
        value = {name: getattr(value, name) for name in field_names(value)}
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    return one_line(str(value))


def down(value: float, digits: int = DIGITS) -> str:
    """A limit rounded down, for what holds below it.

    What is rounded is the shortest decimal number that stands for the float, so that 1.9 stays 1.9.

    Examples
    --------
    >>> down(0.65737347), up(0.73914551), down(1.9)
    ('0.6573734', '0.7391456', '1.9')
    """
    return _rounded(value, digits, ROUND_FLOOR)


def up(value: float, digits: int = DIGITS) -> str:
    """A limit rounded up, for what holds above it."""
    return _rounded(value, digits, ROUND_CEILING)


def few(value: float, digits: int = FEW_DIGITS) -> str:
    """A simulated value, rounded to nearest, as it is no bound.

    Examples
    --------
    >>> few(1.5234567), few(123456.0), few(12345678.0)
    ('1.523', '123500', '1.235e+07')
    """
    return _without_exponent(f"{value:.{digits}g}")


def sized(value: float, unit: str, digits: int = FEW_DIGITS) -> str:
    """A simulated value with its unit, where that is known.

    Examples
    --------
    >>> sized(1.5234567, "mm"), sized(1.5234567, "", 3)
    ('1.523 mm', '1.52')
    """
    return f"{few(value, digits)} {unit}".rstrip()


def at_lambda(load_factor: float) -> str:
    """The load factor of a simulation, in as many digits as limits have.

    Examples
    --------
    >>> at_lambda(1.59599370)
    'λ = 1.595994'
    """
    return f"λ = {load_factor:.{DIGITS}g}"


def certain_digits(low: float, high: float) -> int:
    """The number of certain digits of a limit between two numbers, at least four.

    Examples
    --------
    >>> certain_digits(1.679928, 1.680101), certain_digits(1.25, 1.25 + 1e-9), certain_digits(1.25, np.inf)
    (4, 7, 7)
    """
    size = max(abs(low), abs(high))
    if not (math.isfinite(size) and abs(high - low) > 0):
        return DIGITS
    return min(max(math.floor(-math.log10(abs(high - low) / size)), FEW_DIGITS), DIGITS)


def _rounded(value: float, digits: int, rounding: str) -> str:
    if not math.isfinite(value):
        return f"{value:g}"
    shortest = Decimal(repr(float(value)))
    return _without_exponent(
        f"{float(Context(prec=digits, rounding=rounding).create_decimal(shortest)):.{digits}g}"
    )


def _without_exponent(text: str) -> str:
    return f"{float(text):.{DIGITS}g}" if "e+0" in text else text


def same(one: Any, other: Any) -> bool:
    """Whether two values of fields are equal: arrays by value, NaN as equal to NaN; never raises.

    Examples
    --------
    >>> same((np.array([1.0, np.nan]), "a"), (np.array([1.0, np.nan]), "a"))
    True
    """
    if one is other:
        return True
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        if type(one) is not type(other):
            return False
        floats = one.dtype.kind in "fc" and other.dtype.kind in "fc"
        return np.array_equal(one, other, equal_nan=floats)
    if isinstance(one, float) and isinstance(other, float):
        return one == other or (math.isnan(one) and math.isnan(other))
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        pairs = zip(one, other, strict=False)
        return type(one) is type(other) and len(one) == len(other) and all(same(a, b) for a, b in pairs)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if type(one) is type(other) and is_dataclass(one) and not hasattr(one, "to_dict"):  # no result
        return all(same(getattr(one, d.name), getattr(other, d.name)) for d in fields(one) if d.compare)
    if hasattr(one, "tocsr") and hasattr(other, "tocsr"):  # sparse matrices
        return one.shape == other.shape and abs(one - other).nnz == 0
    return bool(one == other)


def short(value: Any) -> str:
    """A value in a few words: long arrays by their shape and range, results by their first numbers.

    Examples
    --------
    >>> short(np.linspace(0.0, 1.0, 33)), short(2 / 3)
    ('33 numbers from 0 to 1', '0.6666666667')
    """
    if isinstance(value, bool | np.bool_) or value is None:
        return str(value)
    if isinstance(value, str):
        return repr(one_line(str(value), LONGEST_VALUE))
    if isinstance(value, float | np.floating):
        return f"{value:.10g}"
    if isinstance(value, int) and abs(value) >= 10**20:  # Python refuses to write the longest ones
        return f"{'-' * (value < 0)}10^{int(value.bit_length() * math.log10(2))}"
    if isinstance(value, np.ndarray):
        return _short_array(value)
    if hasattr(value, "in_one_line"):
        return str(value.in_one_line(LONGEST_VALUE))
    if isinstance(value, tuple | list) and not hasattr(value, "_asdict"):
        return _short_sequence(value)
    if isinstance(value, Mapping):
        return f"{len(value)} entries"
    text = str(value)
    shown: object = type(value).__repr__
    own = shown is object.__repr__ or len(text) > 2 * LONGEST_VALUE or "\n" in text
    return f"<{type(value).__name__}>" if own else text


def _short_array(array: NDArray[Any]) -> str:
    if array.ndim <= 1 and array.size <= 6 and array.dtype.kind in "fiub":
        text = str(array.item()) if array.ndim == 0 else f"[{', '.join(map(_cell_text, array.tolist()))}]"
        if len(text) <= LONGEST_VALUE:
            return text
    size = " × ".join(map(str, array.shape)) or "one"
    if array.dtype.kind == "b":
        return f"{size} flags, {int(array.sum())} set"
    if array.dtype.kind not in "fiu" or not array.size:
        return f"{size} of {array.dtype}"
    known = array[np.isfinite(array)]
    if not known.size:
        return f"{size} numbers, none finite"
    if known.min() == known.max() and known.size == array.size:
        return f"{size} times {known.min():.6g}"
    return f"{size} numbers from {known.min():.6g} to {known.max():.6g}"


def _short_sequence(value: Sequence[Any]) -> str:
    texts = [short(item) for item in value[:LONGEST_VALUE]]
    open_, close = "[]" if isinstance(value, list) else "()"
    text = f"{open_}{', '.join(texts)}{',' * (close == ')' and len(value) == 1)}{close}"
    if len(text) <= LONGEST_VALUE and len(texts) == len(value):
        return text
    kinds = {type(item).__name__ for item in value}
    return f"{len(value)} × {kinds.pop() if len(kinds) == 1 else 'various'}"


def _cell_text(value: float) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def field_names(value: Any) -> list[str]:
    """Fields of a dataclass that are shown."""
    return [d.name for d in fields(value) if d.repr]


def nodes_in_words(nodes: Sequence[int] | NDArray[np.intp], most: int = 8) -> str:
    """Nodes by number, the first few of them.

    Examples
    --------
    >>> nodes_in_words((3,)), nodes_in_words(tuple(range(20)), most=2)
    ('node 3', 'nodes 0, 1, …')
    """
    listed = ", ".join(map(str, nodes[:most])) + (", …" if len(nodes) > most else "")
    return f"node{'s' * (len(nodes) > 1)} {listed}"


def count(number: int, noun: str) -> str:
    """A number with its noun, in the plural where needed.

    Examples
    --------
    >>> count(1, "node"), count(2, "node")
    ('1 node', '2 nodes')
    """
    return f"{number} {noun}{'s' * (number != 1)}"


def cycles_in_words(period: int) -> str:
    """A period after the word "every"."""
    return "cycle" if period == 1 else f"{period} cycles"
