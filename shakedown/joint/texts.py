"""The texts of a problem: one each, names, JSON, the word of the load path."""

import json
import sys
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.visible_text import LONGEST_NAME, shortened, visible
from shakedown.joint.numbers import kind

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


def origin(key: str, value: Any) -> str:
    """The text of a JSON object whose ``files`` are objects and ``warnings`` texts; else ``ProblemError``.

    Examples
    --------
    >>> origin("source", '{"warnings": 3}')
    Traceback (most recent call last):
    ...
    shakedown.ground.errors.ProblemError: key 'source': 'warnings': expected a list of texts, found 3
    """
    text = json_object(key, value)
    told = json.loads(text) if text else {}
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
