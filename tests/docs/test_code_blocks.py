"""Every code block of the site is run: here what is quick, the rest where the site is built (``.ci/site``)."""

import re
from importlib.resources import files
from pathlib import Path

import brake_reuss
import pytest
from code_blocks import Page, not_run

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
    """The deck of the example, and what `ccx punch` writes, as they are shipped."""
    for name in ("punch.inp", "punch.sti", "punch.dof"):
        (folder / name).write_bytes((files("shakedown.models.importing") / "example" / name).read_bytes())


FOLDERS = {"joint": joint, "block": block, "calculix": calculix, "brake_reuss": brake_reuss.write}


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=named)
def test_the_blocks_of_a_page_run(page, tmp_path, request):
    whole = request.config.getoption("--whole-site")
    if not whole:
        request.getfixturevalue("undrawn")
    for maker in re.findall(r"^<!-- folder: (\w+) -->$", page.read_text(encoding="utf-8"), re.M):
        FOLDERS[maker](tmp_path)
    Page(page, tmp_path).run(slow=whole)


@pytest.mark.parametrize(
    "page", [*PAGES, DOCS.parent / "README.md", DOCS.parent / "CONTRIBUTING.md"], ids=lambda p: p.stem
)
def test_output_with_numbers_is_run(page):
    assert not_run(page) == []
