"""Every code block of the site is run: here what is quick, the rest where the site is built (``.ci/site``)."""

import re
from importlib.resources import files
from pathlib import Path

import pytest
from code_blocks import Page, blocks

import shakedown

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if not {"_build", "paper"} & set(page.parts))


def named(page):
    return page.relative_to(DOCS).as_posix()


def joint(folder):
    """What a page calls joint.npz, without showing where it comes from."""
    shakedown.save_problem(folder / "joint.npz", shakedown.example("two-node"))


def block(folder):
    """The same, of a joint for which shakedown is proved."""
    shakedown.save_problem(folder / "joint.npz", shakedown.example("block-9"))


def calculix(folder):
    """What `ccx punch` writes, as it is shipped."""
    for name in ("punch.sti", "punch.dof"):
        (folder / name).write_bytes((files("shakedown.importing") / "example" / name).read_bytes())


FOLDERS = {"joint": joint, "block": block, "calculix": calculix}


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_the_blocks_of_a_page_run(page, tmp_path, request):
    whole = request.config.getoption("--whole-site")
    if not whole:
        request.getfixturevalue("undrawn")
    for maker in re.findall(r"^<!-- folder: (\w+) -->$", page.read_text(encoding="utf-8"), re.M):
        FOLDERS[maker](tmp_path)
    Page(page, tmp_path).run(slow=whole)


def test_blocks_are_found():
    languages = [block.language for page in PAGES for block in blocks(page)]
    assert languages.count("python") + languages.count("pycon") > 10
    assert languages.count("console") + languages.count("sh") > 10
