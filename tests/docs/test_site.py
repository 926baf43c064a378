"""What holds of the pages without building them: links lead somewhere, every page is listed, questions are answered.

Every key that the package reads is a key that the reference explains.
"""

import ast
import inspect
import re
import runpy
from pathlib import Path

import pytest

from shakedown.files.npz import KEYS
from shakedown.models.readers.toml_table import TomlTable

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if not {"_build", "paper"} & set(page.parts))
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)")
MADE = "_gallery"  # by sphinx-gallery, from docs/gallery
TAKING = {
    name
    for name, method in inspect.getmembers(TomlTable, inspect.isfunction)
    if "key" in inspect.signature(method).parameters
}


def prose(page):
    """A page without its code."""
    return re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def anchors(page):
    """The anchors of its headings, as GitHub and MyST make them."""
    headings = re.findall(r"^#+ (.+)$", prose(page), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def source(page, link):
    """The file that a link leads to: of a page of the gallery, its script."""
    path = (page.parent / link).resolve()
    if MADE not in path.parts:
        return path
    gallery = DOCS / "gallery"
    return gallery / ("GALLERY_HEADER.rst" if path.stem == "index" else f"{path.stem}.py")


@pytest.mark.parametrize(
    "page",
    [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md"],
    ids=lambda p: p.relative_to(ROOT).as_posix(),
)
def test_links_within_the_documentation_lead_somewhere(page):
    for link in LINK.findall(prose(page)):
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = source(page, path) if path else page
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link


def test_every_page_is_listed_once():
    listed = []
    for page in PAGES:
        for tree in re.findall(r"^```\{toctree\}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S):
            names = [line for line in tree.splitlines() if line and not line.startswith(":")]
            listed += [(page.parent / f"{name}.md").resolve() for name in names if MADE not in name]
    assert sorted(listed) == sorted(page for page in PAGES if page.name != "index.md" or page.parent != DOCS)


def test_twenty_questions_are_answered_in_two_clicks():
    """The front page leads to the list, the list to the answers; that these exist says the test of links."""
    assert "questions.md" in LINK.findall(prose(DOCS / "index.md"))
    questions = re.findall(r"^(\d+)\. (.+(?:\n   .+)*)", prose(DOCS / "questions.md"), re.M)
    assert [int(number) for number, _ in questions] == list(range(1, len(questions) + 1))
    assert len(questions) >= 20
    assert all(LINK.search(question) for _, question in questions)


def test_the_page_on_architecture_names_every_subpackage():
    named = code("explanation/architecture.md").split()
    assert {path.parent.name for path in (ROOT / "shakedown").glob("*/__init__.py")} <= set(named)


def keys_of_import_files():
    """The keys that the sections of an import file take, read from their sources."""
    found = set()
    for module in (ROOT / "shakedown" / "models" / "importing").rglob("*.py"):
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            match node:
                case ast.Call(func=ast.Attribute(attr=name), args=[ast.Constant(value=str(key)), *_]) if (
                    name in TAKING
                ):
                    found.add(key)
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
