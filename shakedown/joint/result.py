"""What every result can do: show itself in short, compare itself, and be written as JSON or as a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import UsageError, not_installed
from shakedown.ground.shown_values import WIDTH, field_names, one_line, plain, same, short
from shakedown.joint.problem import Problem, ReadOnly

if TYPE_CHECKING:
    from pandas import DataFrame


class Result(ReadOnly):
    """Base of the frozen dataclasses that functions return.

    A result class derives from it and leaves comparing and showing to it::

        @dataclass(frozen=True, eq=False, repr=False)
        class SafeSlip(Result):
            DOCUMENT: ClassVar[str] = "status load_factor slip"
            ...

    - ``repr`` fits one screen, however many nodes there are.
    - ``==`` compares type and fields, arrays by value and NaN as equal; it never
      raises. Fields declared with ``field(compare=False)`` are left out: how long
      something took. Results are not hashable, as the arrays in them are not.
    - Arrays are read-only, those of copies too.
    - ``to_dict()`` has the words of ``DOCUMENT``, names of fields and properties: those
      of the JSON that the command line writes. By default all fields.
    - ``to_frame()`` has the columns of ``TABLE``, by default every one of these words
      with as many rows as the first array has.
    """

    DOCUMENT: ClassVar[str] = ""
    TABLE: ClassVar[str] = ""

    def to_dict(self) -> dict[str, Any]:
        """The result as JSON knows it: lists, infinities as "inf", undefined numbers as None."""
        return {word: plain(getattr(self, word)) for word in self._words()}

    def to_frame(self, problem: Problem | None = None) -> DataFrame:
        """The result as a table of pandas: one row per node, or per load factor, state or event.

        A result of single numbers is a table of one row.

        Parameters
        ----------
        problem
            The joint, for the labels of its nodes; not needed where the result holds it.

        Raises
        ------
        UsageError
            If pandas is not installed.
        """
        joint = getattr(self, "problem", None) if problem is None else problem
        return frame(self.columns(), joint)

    def in_one_line(self, width: int) -> str:
        """Its name and as many of its first values as fit."""
        # fields shown of a result inside another one, if it has them
        first = ("load_factor", "status", "outcome")
        available, text, shown = width - len(type(self).__name__) - 3, "", dict(self._shown())
        for word in (*(word for word in first if word in shown), *(w for w in shown if w not in first)):
            if len(longer := f"{text}{word}={shown[word]}, ") <= available:
                text = longer
        return f"{type(self).__name__}({text}…)"

    def __repr__(self) -> str:
        shown = [f"{name}={text}" for name, text in self._shown()]
        line = f"{type(self).__name__}({', '.join(shown)})"
        if len(line) <= WIDTH:
            return line
        cut = [one_line(text, WIDTH - 5) for text in shown]
        if len(cut) > 22:  # one screen, with the name and the bracket
            cut[21:] = [f"… {len(cut) - 21} more"]
        return "\n".join([f"{type(self).__name__}(", *(f"    {text}," for text in cut), ")"])

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        names = [d.name for d in fields(self) if d.compare]  # type: ignore[arg-type]  # of a dataclass
        return all(same(getattr(self, name), getattr(other, name)) for name in names)

    __hash__ = None  # type: ignore[assignment]

    def _words(self) -> list[str]:
        return self.DOCUMENT.split() or [name for name in field_names(self) if not name.startswith("_")]

    def _table_words(self) -> list[str]:
        return self.TABLE.split()

    def _shown(self) -> Iterator[tuple[str, str]]:
        for name in field_names(self):
            yield name, short(getattr(self, name))

    def columns(self) -> dict[str, Any]:
        """The columns of the table by name, all of one length."""
        lists = {word: _listed(getattr(self, word)) for word in self._table_words() or self._words()}
        found = {word: array for word, array in lists.items() if array is not None}
        if not found:
            return {word: [_cell(getattr(self, word))] for word in self._words()}
        rows = len(next(iter(found.values())))
        columns: dict[str, Any] = {}
        for word, array in found.items():
            if len(array) == rows and array.ndim == 1:
                columns[word] = array
            elif len(array) == rows and array.ndim == 2:
                columns |= {f"{word}[{k}]": array[:, k] for k in range(array.shape[1])}
        return columns


def frame(columns: Mapping[str, Any], problem: Problem | None = None) -> DataFrame:
    """A table of pandas; with a problem that has as many nodes as rows, of its nodes with their labels.

    Raises
    ------
    UsageError
        If pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise UsageError(not_installed("to_frame", "pandas", "frames")) from None
    table = pandas.DataFrame(dict(columns))
    if problem is not None and len(table) == problem.n:
        table.index.name = "node"
        if problem.label is not None:
            table.insert(0, "label", list(problem.label))
    return table


def _listed(value: Any) -> NDArray[Any] | None:
    """A field that is a column of a table, or several, as an array; None where it is none."""
    if isinstance(value, np.ndarray):
        return value if value.ndim in (1, 2) else None
    if not isinstance(value, list | tuple) or hasattr(value, "_asdict") or not value:
        return None
    if all(isinstance(item, str) for item in value):
        return np.array(list(map(str, value)), dtype=object)
    if all(isinstance(item, bool | int | float | np.number) for item in value):
        return np.array(value)
    return None


def _cell(value: Any) -> Any:
    """A single value as a cell of a table."""
    if isinstance(value, str):
        return str(value)
    return value if value is None or isinstance(value, bool | int | float | np.generic) else short(value)
