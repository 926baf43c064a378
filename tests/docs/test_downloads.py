"""Tutorials as scripts and notebooks: what is offered is the code of the page."""

import json
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = [page for page in sorted((DOCS / "tutorials").glob("*.md")) if "```pycon" in page.read_text("utf-8")]


@pytest.fixture
def downloads(monkeypatch):
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(DOCS / "_extensions"))
    import downloads

    yield downloads
    sys.modules.pop("downloads")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_script_and_the_notebook_hold_the_code_of_the_page(downloads, page):
    cells = downloads.cells(page.read_text("utf-8"))
    code = [text for kind, text in cells if kind == "code"]
    assert len(code) == page.read_text("utf-8").count("```pycon")
    script = downloads.script(cells)
    compile(script, page.stem, "exec")
    assert all(text in script for text in code)
    made = json.loads(downloads.notebook(cells))
    assert ["".join(cell["source"]) for cell in made["cells"] if cell["cell_type"] == "code"] == code


def test_an_example_that_raises_an_error_does_not_end_the_script(downloads):
    block = ">>> 1 / 0\nTraceback (most recent call last):\n    ...\nZeroDivisionError: division by zero\n>>> x = 2\n"
    exec(downloads.without_prompts(block), scope := {})
    assert scope["x"] == 2
