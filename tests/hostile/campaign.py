"""How long an attack lasts, and how it is judged.

In the test suite an attack has a fixed number of cases, each made from its number
alone. ``HOSTILE_SECONDS=600 python -m pytest tests/hostile`` goes on for ten minutes
per attack, with further numbers. A failing case names its number.
"""

import os
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from command import CONTROL, run

SECONDS = float(os.environ.get("HOSTILE_SECONDS", "0"))
START = int(os.environ.get("HOSTILE_START", "0"))
LONGEST_LINE = 1100


def numbers(few: int) -> Iterator[int]:
    """The numbers of the cases: ``few`` in the suite, or as many as ``HOSTILE_SECONDS`` allow."""
    end = time.monotonic() + SECONDS
    number = START
    while number < START + few or time.monotonic() < end:
        yield number
        number += 1


@contextmanager
def named(number: int, what: object) -> Iterator[None]:
    """Name the case in whatever goes wrong in it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            yield
    except (Exception, SystemExit) as error:
        raise AssertionError(f"case {number} ({what!r}): {type(error).__name__}: {error}") from error


def judge(number: int, words: list[str], folder: str) -> int:
    """Run the command; an answer, a status or one line, and no character that a terminal obeys."""
    with named(number, words):
        code, out, err = run(*words, cwd=folder)
    assert code in (0, 1, 2), (number, words, code)
    assert not CONTROL.search(out), (number, words, out[:300])
    assert not CONTROL.search(err), (number, words, err[:300])
    lines = err.splitlines()
    assert len(lines) <= 1 or code != 2, (number, words, err[:2000])
    assert all(len(line) <= LONGEST_LINE for line in lines), (number, words, err[:300])
    if code == 2:
        assert out == "", (number, words)
        assert err.startswith("shakedown-bounds: "), (number, words, err[:300])
    return code
