"""Nastran cards in small, large or free fields, and those of one superelement of a file with several."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.text import integers, listed, quoted

Card = tuple[int, str, list[str]]  # line number, name, data fields
_BEGIN = re.compile(r"BEGIN\b\s*(?:BULK\b\s*)?(?:SUPER\b\s*=?\s*(\d{1,18}))?", re.IGNORECASE)


def cards(lines: list[str]) -> Iterator[Card]:
    """Every card: its line, name and data fields, in small, large or free fields, continuations joined."""
    card: Card | None = None
    for k, line in enumerate(lines, start=1):
        text = line.split("$")[0].rstrip()
        if not text:
            continue
        first, fields = card_fields(text)
        if first[:1] in ("", "*", "+"):  # a continuation, named or not
            if card is not None:
                card[2].extend(fields)
            continue
        if card is not None:
            yield card
        card = k, first.rstrip("*").strip().upper(), fields
    if card is not None:
        yield card


def spans(lines: list[str]) -> Iterator[tuple[Card, int]]:
    """Every card, and the number of the last of its lines or of the remarks behind it."""
    for card, (after, _, _) in pairwise([*cards(lines), (len(lines) + 1, "", [])]):
        yield card, after - 1


def card_fields(text: str) -> tuple[str, list[str]]:
    """First field and data fields of one line, sliced by columns unless it has commas."""
    if "," in text:
        first, *rest = [field.strip() for field in text.split(",")]
        width = 4 if "*" in first else 8
        return first, [*rest, *[""] * (width - len(rest))][:width]
    text = text.expandtabs(8)
    first = text[:8].strip()
    width, count = (16, 4) if "*" in first else (8, 8)
    padded = text.ljust(8 + width * count)
    return first, [padded[8 + width * i : 8 + width * (i + 1)].strip() for i in range(count)]


def of_superelement(lines: list[str], superelement: int | None, name: str) -> list[str]:
    """The lines of one superelement; those of others are blank, so that the numbers of lines stay.

    A section begins with ``BEGIN SUPER n``; a file without sections (``.asm``) says
    by its SECONCT cards which points are those of which superelement.

    Parameters
    ----------
    lines, name
        The file, and what messages call it.
    superelement
        Which one; None where the file has one at most.

    Raises
    ------
    ProblemError
        If there are several and none is named, or there is none of that number.

    Examples
    --------
    >>> both = ["BEGIN SUPER 101", "EXTRN,3,12", "BEGIN SUPER=102", "EXTRN,5,12"]
    >>> of_superelement(both, 102, "both.pch")
    ['', '', 'BEGIN SUPER=102', 'EXTRN,5,12']
    """
    owner = _owners(lines, name)
    known = list(dict.fromkeys(number for number in owner if number))
    if superelement is None:
        if len(known) > 1:
            raise ProblemError(
                f"{name}: expected the key 'superelement' (one of {listed(map(str, known))}), found none"
            )
        return lines
    if superelement not in known:
        raise ProblemError(
            f"{name}: expected the superelement {superelement}, found {listed(map(str, known))}"
        )
    return [line if number in (superelement, None) else "" for line, number in zip(lines, owner, strict=True)]


def _owners(lines: list[str], name: str) -> list[int | None]:
    """The superelement of every line: 0 for the main part of a file with sections, None for all."""
    owner: list[int | None] = []
    section: int | None = None
    for line in lines:
        if match := _BEGIN.match(line.strip()):
            section = int(match[1] or 0)
        owner.append(section)
    if any(owner):
        return [number or 0 for number in owner]
    owner = [None] * len(lines)
    for (k, card, fields), last in spans(lines):
        if card == "SECONCT":
            owner[k - 1 : last] = [integers(fields[:1], f"{name}: line {k}")[0]] * (last - k + 1)
    return owner


def chosen_matrix(names: list[str], matrix: str | None, where: str, scalars: Sequence[int] = ()) -> int:
    """The place of a matrix among those of a file.

    Parameters
    ----------
    names
        Theirs, in upper case.
    matrix
        The name of the one to take, with ``(k)`` behind it for the k-th of that name; by default the only one
        whose name begins with K, or the only one at all.
    where
        The file, for messages.
    scalars
        Places of those that are no stiffness, being of size 1 × 1.

    Raises
    ------
    ProblemError
        If there is none, or several.

    Examples
    --------
    >>> chosen_matrix(["KAAX", "MAAX", "MAAX"], "maax(2)", "a file")
    2
    """
    wanted = (matrix or "").strip().upper()
    counted = re.fullmatch(r"(.+)\((\d{1,9})\)", wanted)
    if matrix is not None:
        places = [k for k, own in enumerate(names) if own == (counted[1] if counted else wanted)]
    else:
        stiff = [k for k, own in enumerate(names) if own.startswith("K") and k not in scalars]
        places = [0] if len(names) == 1 else stiff
    if counted and places:
        if not 1 <= int(counted[2]) <= len(places):
            known = f"{counted[1]}(1) to {counted[1]}({len(places)})"
            raise ProblemError(f"{where}: expected {known}, found {quoted(wanted)}")
        return places[int(counted[2]) - 1]
    (often, times), *_ = [*Counter(names[k] for k in places).most_common(1), ("", 0)]
    if times > 1:
        ways = " or ".join(f"'{often}({k})'" for k in range(1, min(times, 3) + 1))
        raise ProblemError(
            f"{where}: expected every matrix once, found {often} {times} times (several superelements?); "
            f"name the one to take: matrix = {ways}"
        )
    if len(places) != 1:
        what = "one stiffness matrix" if matrix is None else f"the matrix {quoted(matrix)}"
        raise ProblemError(f"{where}: expected {what}, found {listed(names)}; name the one to take")
    return places[0]
