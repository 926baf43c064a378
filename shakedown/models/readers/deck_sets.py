"""Sets and equations of an input deck, resolved once all its nodes and elements are known."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.text import integers, number, quoted

Members = tuple[str, list[str], bool]  # where it stands, its fields, whether they are first, last, step


def resolved(
    lists: dict[str, list[Members]],
    known: NDArray[np.intp],
    others: dict[str, NDArray[np.intp]] | None = None,
) -> dict[str, NDArray[np.intp]]:
    """Members of every set; a set may name earlier ones."""
    found: dict[str, NDArray[np.intp]] = dict(others or {})
    there = set(known.tolist())
    for name, entries in lists.items():
        members: list[int] = []
        for where, fields, generate in entries:
            if generate:
                members += _generated(fields, known, where)
                continue
            for text in fields:
                if text.upper() in found and not text.isdigit():  # a number is a label, not a name
                    members += found[text.upper()].tolist()
                    continue
                own = text.split(".")[-1]  # 'instance.label'
                if not own.isdigit():
                    raise ProblemError(
                        f"{where}: expected labels or earlier sets as members of {quoted(name)}, found "
                        f"{quoted(text)}"
                    )
                label = integers([own], where)[0]
                if label not in there:
                    raise ProblemError(
                        f"{where}: expected a member of {quoted(name)}, found {label}, which is none"
                    )
                members.append(label)
        found[name] = np.array(members, dtype=np.intp)
    return found


def _generated(fields: list[str], known: NDArray[np.intp], where: str) -> list[int]:
    """The existing labels among those that 'first, last, step' stands for."""
    first, last, stride = [*integers(fields[:3], where), 1][:3] if len(fields) > 1 else (0, -1, 1)
    if stride < 1 or last < first:
        raise ProblemError(
            f"{where}: expected 'first, last, step' of a set, found {quoted(','.join(fields))}"
        )
    inside = known[(known >= first) & (known <= last) & ((known - first) % stride == 0)]
    return [int(label) for label in np.sort(inside)]


def relative_displacements(
    equations: list[tuple[str, list[str]]], node_sets: Mapping[str, NDArray[np.intp]]
) -> dict[tuple[int, int], tuple[int, int]]:
    """Which two nodes an equation of three terms subtracts, by (node, direction) of the result."""
    relative: dict[tuple[int, int], tuple[int, int]] = {}
    for where, fields in equations:
        found = [_term(fields[k : k + 3], where, node_sets) for k in range(0, len(fields), 3)]
        terms = [term for term in found if term is not None]
        if len(found) != 3 or len(terms) != 3 or len({direction for _, direction, _ in terms}) != 1:
            continue
        for k, (node, direction, factor) in enumerate(terms):
            others = terms[:k] + terms[k + 1 :]
            minus = [own for own, _, weight in others if weight == factor]
            plus = [own for own, _, weight in others if weight == -factor]
            if len(minus) == len(plus) == 1:
                relative[node, direction] = (plus[0], minus[0])
    return relative


def _term(
    fields: list[str], where: str, node_sets: Mapping[str, NDArray[np.intp]]
) -> tuple[int, int, float] | None:
    """Node, direction and factor of one term; None for a term of several nodes."""
    name = fields[0].split(".")[-1]
    own = node_sets.get(name.upper())
    if len(fields) != 3 or (own is None and not name.isdigit()) or (own is not None and len(own) != 1):
        return None
    node = integers([name], where)[0] if own is None else int(own[0])
    return node, integers(fields[1:2], where)[0], number(fields[2], where)
