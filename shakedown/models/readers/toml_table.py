"""Tables of a TOML configuration, taken key by key: nothing unknown goes unnoticed; nodes that they name."""

import math
import os
import tomllib
from collections.abc import Callable
from difflib import get_close_matches
from typing import Any

import numpy as np

from shakedown.ground.constants import LARGEST_LABEL, READ_AT_ONCE, IntArray
from shakedown.ground.errors import ProblemError, found_in
from shakedown.ground.shown_values import visible
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.parsing import quoted, read_bytes, unfit


def read_toml(path: str | os.PathLike[str]) -> "TomlTable":
    """The root table of a TOML file.

    Raises
    ------
    ProblemError
        If the file is missing, unreadable or not TOML.
    """
    name, raw = os.fspath(path), read_bytes(path)
    if len(raw) > READ_AT_ONCE:
        raise unfit(name, f"a TOML file of at most {READ_AT_ONCE >> 20} MiB", "more")
    try:
        content = tomllib.loads(raw.decode("utf-8-sig"))
    except RecursionError:
        raise unfit(name, "a TOML file", "tables nested too deeply") from None
    except UnicodeDecodeError:
        raise unfit(name, "a TOML file", "bytes that are no text") from None
    except ValueError as error:  # not TOML, or a whole number of thousands of digits
        raise unfit(name, "a TOML file", visible(str(error))) from None
    return TomlTable(content, name)


def change_number(root: "TomlTable", key: str, value: float) -> None:
    """Put a number in the place of another one, or at a key that a table lacks.

    Parameters
    ----------
    root
        The root table, of which nothing has been taken.
    key
        A dotted key; a table of a list of tables, or an entry of a list, is named by its place
        from 1: ``"load.2.history.harmonics.1.sin"``.
    value
        The number.

    Raises
    ------
    ProblemError
        If there is no number at such a key.
    """
    *way, last = key.split(".")
    place, where = root.content, f"{root.where}: {key}"
    for part in way:
        place = _inside(place, part, where)
    old = place.get(last) if isinstance(place, dict) else _inside(place, last, where)
    if old is not None and not is_number(old):
        raise unfit(where, "the key of a number", shown(old))
    new = int(value) if isinstance(old, int) and float(value).is_integer() else float(value)
    place[last if isinstance(place, dict) else int(last) - 1] = new


def _inside(place: Any, part: str, where: str) -> Any:
    """What a table has at a key, or a list at a place from 1."""
    if isinstance(place, dict) and part in place:
        return place[part]
    if isinstance(place, list) and part.isascii() and part.isdigit() and 1 <= int(part[:9]) <= len(place):
        return place[int(part) - 1]
    if isinstance(place, dict):
        raise unfit(where, f"one of {', '.join(map(quoted, place))}", quoted(part))
    if isinstance(place, list):
        raise unfit(where, f"a number from 1 to {len(place)}", quoted(part))
    raise unfit(where, f"a table or a list before {quoted(part)}", shown(place))


class TomlTable:
    """One table; every key is taken once, and what is left over at the end is an error.

    Examples
    --------
    >>> table = TomlTable({"file": "k.mtx", "axis": [1, 2]}, "[stiffness]")
    >>> table.text("file"), table.array("axis", int, (2,))
    ('k.mtx', [1, 2])
    >>> table.done()
    """

    def __init__(self, content: dict[str, Any], where: str) -> None:
        self.content = dict(content)
        self.where = where
        self.known: list[str] = []

    def copy(self) -> "TomlTable":
        """The table as it stands now, to be taken apart by itself."""
        return TomlTable(self.content, self.where)

    def take(
        self, key: str, expected: str, *, required: bool = False, fits: Callable[[Any], bool] | None = None
    ) -> Any:
        """The value of a key, which must be as expected; None where it is absent and not required."""
        self.known.append(key)
        if key not in self.content:
            if required:
                raise self.missing(key, expected)
            return None
        value = self.content.pop(key)
        if fits is not None and not fits(value):
            raise self.wrong(key, expected, shown(value))
        return value

    def text(self, key: str, default: str | None = None, *, required: bool = True) -> str | None:
        """A string."""
        found = self.take(
            key, "text", required=required and default is None, fits=lambda value: isinstance(value, str)
        )
        return default if found is None else found

    def number(self, key: str, default: float | None = None) -> float | None:
        """A number; None where it is absent and has no default."""
        found = self.take(key, "a finite number", fits=is_number)
        return default if found is None else float(found)

    def integer(self, key: str) -> int | None:
        """A whole number; None where it is absent."""
        found: int | None = self.take(key, "a whole number", fits=_is_whole)
        return found

    def array(self, key: str, kind: type, shape: tuple[int | None, ...], *, required: bool = True) -> Any:
        """Nested lists of numbers of a shape, in which None stands for any length ≥ 1."""
        size = " x ".join("n" if s is None else str(s) for s in shape)
        what = f"a list of {size} {'whole numbers' if kind is int else 'numbers'}"
        return self.take(key, what, required=required, fits=lambda value: _fits(value, kind, shape))

    def key_of_column(self, key: str) -> str | int | None:
        """A column of a table file: its heading, or its number from 1; None where it is absent."""
        found: str | int | None = self.take(
            key,
            "a heading, or a number from 1",
            fits=lambda value: isinstance(value, str) or (_is_whole(value) and value >= 1),
        )
        return found

    def entries(self, key: str, width: int) -> list[list[Any]] | None:
        """A list of lists, each of ``width`` things; None where it is absent."""
        found: list[list[Any]] | None = self.take(
            key,
            f"a list of lists of {width} each",
            fits=lambda value: is_list_of(list, value) and all(len(entry) == width for entry in value),
        )
        return found

    def table(self, key: str, *, required: bool = True) -> "TomlTable":
        """A table; an empty one where it is absent and not required."""
        value = self.take(key, "a table", required=required, fits=lambda value: isinstance(value, dict))
        return TomlTable(value or {}, f"{self.where}: {key}")

    def tables(self, key: str, *, one: bool = False) -> list["TomlTable"]:
        """A list of tables; or ``one``."""
        if one and not (self.content.get(key) and isinstance(self.content[key], list)):
            return [self.table(key)]
        value = self.take(key, "a list of tables", required=True, fits=lambda value: is_list_of(dict, value))
        return [TomlTable(v, f"{self.where}: {key} {k}") for k, v in enumerate(value, start=1)]

    def has(self, key: str) -> bool:
        """Whether a key is there and has not been taken."""
        return key in self.content

    def missing(self, key: str, expected: str) -> ProblemError:
        """The refusal of a table that lacks a key; an unknown one that looks like it is named."""
        alike = get_close_matches(key, self.content, n=1)
        found = f"the unknown key {quoted(alike[0])}" if alike else "none"
        return ProblemError(f"{self.where}: expected the key '{key}' ({expected}), found {found}")

    def at(self, key: str) -> str:
        """Where a key stands, for messages."""
        return f"{self.where}: key '{key}'"

    def wrong(self, key: str, expected: str, found: object) -> ProblemError:
        """The refusal of the value of a key."""
        return unfit(self.at(key), expected, found)

    def unfit(self, expected: str, found: object) -> ProblemError:
        """The refusal of a table as a whole."""
        return unfit(self.where, expected, found)

    def one_of(self, first: str, second: str, expected: str) -> str:
        """Which of two keys is there; a table with both or neither is refused."""
        if self.has(first) == self.has(second):
            raise self.unfit(expected, "both" if self.has(first) else "neither")
        return first if self.has(first) else second

    def done(self) -> None:
        """Refuse keys that were never taken."""
        if self.content:
            unknown = ", ".join(quoted(key) for key in list(self.content)[:5])
            raise ProblemError(
                f"{self.where}: unknown key {unknown}; expected keys are {', '.join(sorted(set(self.known)))}"
            )


def shown(value: Any) -> str:
    """A value as a message shows it, short."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}…"


def is_list_of(kind: type, value: Any) -> bool:
    """Whether a value of a configuration is a list of such things."""
    return isinstance(value, list) and all(isinstance(item, kind) for item in value)


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and abs(value) < LARGEST_LABEL


def is_number(value: Any) -> bool:
    """Whether a value of a configuration is one finite number."""
    if isinstance(value, float):
        return math.isfinite(value)
    return _is_whole(value)


def _fits(value: Any, kind: type, shape: tuple[int | None, ...]) -> bool:
    if not shape:
        return _is_whole(value) if kind is int else is_number(value)
    if not isinstance(value, list) or not value or shape[0] not in (None, len(value)):
        return False
    return all(_fits(item, kind, shape[1:]) for item in value)


Values = dict[tuple[int, int], float]  # {(node, direction): value}


def nodes_of(mesh: Mesh, name: str, where: str) -> IntArray:
    """Labels of a node set or surface.

    Raises
    ------
    ProblemError
        If there is no model, or no such set.
    """
    if not mesh.is_known:
        expected = "node labels, or [model] with a deck that names sets"
        raise unfit(where, expected, f"{quoted(name)} and no [model]")
    with found_in(where):
        return mesh.nodes(name)


def labels_of(mesh: Mesh, node: Any, where: str) -> IntArray:
    """The labels that a node, or the name of a set, stands for; ``ProblemError`` if it is neither."""
    if isinstance(node, str):
        return nodes_of(mesh, node, where)
    if not _is_label(node):
        raise unfit(where, "a node (a whole number, or the name of a set)", shown(node))
    return np.array([node], dtype=np.intp)


def values_of(mesh: Mesh, table: TomlTable, key: str, *, valued: bool = True) -> Values | None:
    """Entries [node or set, direction, value] as {(node, direction): value}; None where they are absent.

    Raises
    ------
    ProblemError
        If an entry is malformed, or a (node, direction) occurs twice.
    """
    entries = table.entries(key, 3 if valued else 2)
    if entries is None:
        return None
    found: Values = {}
    where = table.at(key)
    for entry in entries:
        node, direction, value = entry if valued else (*entry, 0.0)
        if not _is_label(direction) or not is_number(value):
            raise unfit(where, "[node or set, whole direction, finite number]", shown(entry))
        for key_of_row in ((label, int(direction)) for label in labels_of(mesh, node, where).tolist()):
            if key_of_row in found:
                raise unfit(where, "every (node, direction) once", f"{key_of_row} twice")
            found[key_of_row] = float(value)
    return found


def _is_label(item: Any) -> bool:
    """Whether an item is a whole number in the range of labels; 21.0 counts as 21."""
    if isinstance(item, bool) or not isinstance(item, int | float):
        return False
    return abs(item) < LARGEST_LABEL and item == int(item)
