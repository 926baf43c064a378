"""Every key that the package reads is a key that the reference explains."""

import ast
import inspect
import re
import runpy
from pathlib import Path

import pytest

from shakedown.files.npz import KEYS
from shakedown.models.readers.toml_table import TomlTable

ROOT = Path(__file__).parents[2]
TAKING = {
    name
    for name, method in inspect.getmembers(TomlTable, inspect.isfunction)
    if "key" in inspect.signature(method).parameters
}


def keys_of_import_files():
    """The keys that the sections of an import file take, read from their sources."""
    found = set()
    for module in (ROOT / "shakedown" / "models" / "importing").rglob("*.py"):
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            taken = (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Attribute)
                and node.func.attr in TAKING
            )
            if (
                taken
                and node.args
                and isinstance(node.args[0], ast.Constant)
                and isinstance(node.args[0].value, str)
            ):
                found.add(node.args[0].value)
    return found


def code(page):
    """What stands in backticks on a page, its blocks included."""
    return " ".join(re.findall(r"`+([^`]+)`+", (ROOT / "docs" / page).read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    ("page", "keys"), [("import.md", keys_of_import_files()), ("reference/problem-file.md", set(KEYS))]
)
def test_every_key_is_explained(page, keys):
    assert len(keys) > 20
    assert [key for key in sorted(keys) if not re.search(rf"\b{key}\b", code(page))] == []


@pytest.mark.parametrize("page", ["library.md", "pictures-and-bodies.md"])
def test_the_lists_of_names_are_those_of_the_package(page):
    """Written by python docs/_extensions/api_pages.py."""
    written = runpy.run_path(str(ROOT / "docs" / "_extensions" / "api_pages.py"))["written"](page)
    assert written == (ROOT / "docs" / "reference" / page).read_text(encoding="utf-8")
