"""Nastran cards in small, large or free fields, and those of one superelement of a file with several."""

import re
from collections.abc import Iterator
from itertools import pairwise

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.text import integers, listed

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
    found = [*cards(lines), (len(lines) + 1, "", [])]
    for (k, card, fields), (after, _, _) in pairwise(found):
        if card == "SECONCT":
            owner[k - 1 : after - 1] = [integers(fields[:1], f"{name}: line {k}")[0]] * (after - k)
    return owner
