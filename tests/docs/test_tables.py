"""Limits of built-in joints in tables of the documentation are those that the functions find."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import shakedown

DOCS = Path(__file__).parents[2] / "docs"
LIMITS = {
    "λ_E from slip zero": lambda joint: shakedown.energy_bound(joint).load_factor,
    "λ_max": lambda joint: shakedown.upper_bound(joint).load_factor,
    "λ_U = λ_1": lambda joint: shakedown.universal_bound(joint).load_factor,
    "λ_U, proved": lambda joint: shakedown.universal_bound(joint).load_factor,
}
JOINT = re.compile(r"`?([\w-]+)`?(?:, f = ([\d.]+))?")


def values():
    """(page, joint, friction, limit, number) of every number that such a table has."""
    for page in sorted(DOCS.glob("*.md")):
        for table in re.findall(r"^\|.*\n^\|-.*\n(?:^\|.*\n)+", page.read_text(encoding="utf-8"), re.M):
            head, _, *rows = ([cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines())
            for row in rows:
                found = JOINT.fullmatch(row[0])
                if found is None or found[1] not in shakedown.example_names():
                    continue
                friction = row[1] if head[1] == "f" else found[2]
                for name, cell in zip(head, row, strict=True):
                    if name in LIMITS and re.fullmatch(r"\d\.\d{4,}", cell):
                        yield pytest.param(found[1], friction, name, cell, id=f"{page.stem}-{row[0]}-{name}")


@cache
def joint(name, friction):
    found = shakedown.example(name)
    return found if friction is None else replace(found, f=np.full(found.n, float(friction)))


def test_tables_are_found():
    assert len(list(values())) > 15


@pytest.mark.parametrize(("name", "friction", "limit", "number"), list(values()))
def test_a_limit_in_a_table_is_what_the_function_finds(name, friction, limit, number):
    digits = len(number.partition(".")[2])
    assert abs(LIMITS[limit](joint(name, friction)) - float(number)) < 1.001 * 10.0**-digits
