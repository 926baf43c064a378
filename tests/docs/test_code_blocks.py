"""Every code block of the site is run: here what is quick, the rest where the site is built (``.ci/site``)."""

import re
from importlib.resources import files
from pathlib import Path

import brake_reuss
import pytest
from code_blocks import Page, blocks, not_run, same

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


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("```text\n  λ_U  0\n```\n", 1),
        ("```\n  λ_U  0\n```\n", 2),
        ("- so:\n\n  ```text\n  λ_U  0\n  ```\n", 2),
        ("Said:\n\n    λ_U  1.327687\n", 1),
        ("Said:\n\n    λ_U  =  min_i λ_1\n", 0),
        ("> It shakes down up to λ = 0.731.\n", 1),
        ("<!-- deck -->\n```text\n1, 2\n```\n", 0),
        ("```text\nshakes down\n```\n", 0),
        ("```pycon\n>>> 1 + 1\n2\n\n```\n", 0),
    ],
)
def test_output_that_is_not_run_is_found(tmp_path, text, found):
    (tmp_path / "page.md").write_text(text, encoding="utf-8")
    assert len(not_run(tmp_path / "page.md")) == found


def test_a_limit_next_to_a_step_may_be_rounded_to_either_side():
    assert same("λ_U = 0.3095999 (proved)", "λ_U  = 0.3096 (proved)")
    assert not same("λ_U = 0.3095999 (proved)", "λ_U = 0.3095989 (proved)")
    assert not same("λ_U = 0.3095999 (proved)", "λ_U = 0.3096 (evidence)")
    assert not same("λ_U = 0.3095999", "λ_U = 0.3096 0")


def test_blocks_are_found():
    languages = [block.language for page in PAGES for block in blocks(page)]
    assert languages.count("python") + languages.count("pycon") > 10
    assert languages.count("console") + languages.count("sh") > 10
