"""Tables of a TOML configuration, taken key by key so that nothing unknown goes unnoticed."""

import math
import os
import tomllib
from pathlib import Path
from typing import Any

from shakedown.errors import ProblemError


def read_toml(path: str | os.PathLike[str]) -> "Table":
    """The root table of a TOML file.

    Raises
    ------
    ProblemError
        If the file is missing, unreadable or not TOML.
    """
    name = os.fspath(path)
    try:
        return Table(tomllib.loads(Path(path).read_text(encoding="utf-8")), name)
    except FileNotFoundError:
        raise ProblemError(f"{name}: no such file") from None
    except OSError as error:
        raise ProblemError(f"{name}: cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ProblemError(f"{name}: expected a TOML file, found {error}") from None


class Table:
    """One table; every key is taken once, and what is left over at the end is an error.

    Examples
    --------
    >>> table = Table({"file": "k.mtx", "axis": [1, 2]}, "[stiffness]")
    >>> table.text("file"), table.array("axis", int, (2,))
    ('k.mtx', [1, 2])
    >>> table.done()
    """

    def __init__(self, content: dict[str, Any], where: str) -> None:
        self.content = dict(content)
        self.where = where
        self.known: list[str] = []

    def take(self, key: str, expected: str, *, required: bool) -> Any:
        """The raw value of a key, or None where it is absent and not required."""
        self.known.append(key)
        if key not in self.content and required:
            raise ProblemError(f"{self.where}: expected the key '{key}' ({expected}), found none")
        return self.content.pop(key, None)

    def text(self, key: str, default: str | None = None, *, required: bool = True) -> str | None:
        """A string."""
        value = self.take(key, "text", required=required and default is None)
        if value is None:
            return default
        if not isinstance(value, str):
            raise self._wrong(key, "text", value)
        return value

    def number(self, key: str, default: float | None = None) -> float | None:
        """A number; None where it is absent and has no default."""
        value = self.take(key, "a number", required=False)
        if value is None:
            return default
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self._wrong(key, "a finite number", value)
        return float(value)

    def integer(self, key: str) -> int | None:
        """A whole number; None where it is absent."""
        value = self.take(key, "a whole number", required=False)
        if value is not None and (isinstance(value, bool) or not isinstance(value, int)):
            raise self._wrong(key, "a whole number", value)
        return value

    def flag(self, key: str) -> bool:
        """True or false, false where it is absent."""
        value = self.take(key, "true or false", required=False)
        if value is not None and not isinstance(value, bool):
            raise self._wrong(key, "true or false", value)
        return bool(value)

    def array(self, key: str, kind: type, shape: tuple[int | None, ...], *, required: bool = True) -> Any:
        """Nested lists of numbers of a shape, in which None stands for any length ≥ 1."""
        what = "whole numbers" if kind is int else "numbers"
        size = " x ".join("n" if s is None else str(s) for s in shape)
        value = self.take(key, f"{size} {what}", required=required)
        if value is not None and not _fits(value, kind, shape):
            raise self._wrong(key, f"a list of {size} {what}", value)
        return value

    def table(self, key: str, *, required: bool = True) -> "Table":
        """A table; an empty one where it is absent and not required."""
        value = self.take(key, "a table", required=required)
        if value is not None and not isinstance(value, dict):
            raise self._wrong(key, "a table", value)
        return Table(value or {}, f"{self.where}: {key}")

    def tables(self, key: str, *, required: bool = True) -> list["Table"]:
        """A list of tables."""
        value = self.take(key, "one table or more", required=required)
        if value is not None and not (isinstance(value, list) and all(isinstance(v, dict) for v in value)):
            raise self._wrong(key, "a list of tables", value)
        return [Table(v, f"{self.where}: {key} {k}") for k, v in enumerate(value or [], start=1)]

    def has(self, key: str) -> bool:
        """Whether a key is there and has not been taken."""
        return key in self.content

    def done(self) -> None:
        """Refuse keys that were never taken."""
        if self.content:
            unknown = ", ".join(f"'{key}'" for key in self.content)
            raise ProblemError(
                f"{self.where}: unknown key {unknown}; expected keys are {', '.join(sorted(set(self.known)))}"
            )

    def _wrong(self, key: str, expected: str, value: Any) -> ProblemError:
        shown = repr(value)
        return ProblemError(f"{self.where}: key '{key}': expected {expected}, found {shown[:60]}")


def _fits(value: Any, kind: type, shape: tuple[int | None, ...]) -> bool:
    if not shape:
        allowed = int if kind is int else int | float
        return isinstance(value, allowed) and not isinstance(value, bool)
    if not isinstance(value, list) or not value or shape[0] not in (None, len(value)):
        return False
    return all(_fits(item, kind, shape[1:]) for item in value)
