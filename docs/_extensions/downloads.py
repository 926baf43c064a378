"""Tutorials in Python as scripts and notebooks, made from the pages; each page ends with links to both."""

import doctest
import json
import re
from pathlib import Path

from sphinx.application import Sphinx

FOLDER = "_scripts"  # beside the pages, written anew in every build
BLOCK = re.compile(r"^```pycon\n(.*?)^```\n", re.M | re.S)
COMMENT = re.compile(r"^<!--.*?-->\n", re.M | re.S)


def cells(page: str) -> list[tuple[str, str]]:
    """Prose and code in turn, as (kind, text)."""
    parts = BLOCK.split(COMMENT.sub("", page))
    found = [("markdown", part) for part in parts]
    found[1::2] = [("code", without_prompts(block)) for block in parts[1::2]]
    return [(kind, text.strip("\n")) for kind, text in found if text.strip()]


def without_prompts(block: str) -> str:
    """What is typed, without what is printed; what raises an error is a comment."""
    typed = doctest.DocTestParser().get_examples(block)
    return "".join(f"# raises an error: {each.source}" if each.exc_msg else each.source for each in typed)


def script(found: list[tuple[str, str]]) -> str:
    """A Python file, the prose in comments."""
    parts = [text if kind == "code" else re.sub(r"^", "# ", text, flags=re.M) for kind, text in found]
    return re.sub(r"[ \t]+$", "", "\n\n".join(parts), flags=re.M) + "\n"


def notebook(found: list[tuple[str, str]]) -> str:
    """A Jupyter notebook without outputs."""
    made = [
        {"cell_type": kind, "id": f"cell-{k}", "metadata": {}, "source": text.splitlines(keepends=True)}
        | ({"execution_count": None, "outputs": []} if kind == "code" else {})
        for k, (kind, text) in enumerate(found)
    ]
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return json.dumps({"cells": made, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}, indent=1)


def offer(app: Sphinx, page: str, source: list[str]) -> None:
    """Write both beside the pages of a tutorial with Python blocks, and name them at its end."""
    if not page.startswith("tutorials/") or "```pycon" not in source[0]:
        return
    found, name = cells(source[0]), page.rpartition("/")[2]
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(exist_ok=True)
    (folder / f"{name}.py").write_text(script(found), encoding="utf-8")
    (folder / f"{name}.ipynb").write_text(notebook(found), encoding="utf-8")
    links = " or ".join(
        f"{{download}}`{kind} </{FOLDER}/{name}.{ending}>`"
        for kind, ending in (("a Python script", "py"), ("a Jupyter notebook", "ipynb"))
    )
    source[0] += f"\n---\n\nDownload this page as {links}.\n"


def setup(app: Sphinx) -> dict[str, bool]:
    """Read by Sphinx."""
    app.connect("source-read", offer)
    return {"parallel_read_safe": True}
