"""Text of unknown origin as it may be shown: no control characters, no half characters, not too long."""

import re
from collections.abc import Callable

LONGEST = 1000  # characters of one message
LONGEST_NAME = 200  # characters of one name, unit or path inside a message

# A symbol and its subscript: λ_E, p_w; not the name of a file, p_w.mtx.
SUBSCRIPT = re.compile(r"(λ|(?<![\w.])[pq](?=_w))_(max|lo|w|[A-Z0-9])(?![\w=]|\.\w)")

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


def one_line(text: str, longest: int = LONGEST) -> str:
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
