"""What the README shows is run: the library example here, its commands by `.ci/bare rest`, in one fresh shell."""

import doctest
import re
from pathlib import Path

import pytest

from benchmarks import claims

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_the_library_example_gives_what_it_shows():
    result = doctest.testfile(str(ROOT / "README.md"), module_relative=False)
    assert result.attempted > 0
    assert result.failed == 0


def test_it_is_read_in_five_minutes():
    assert len(README.split()) <= 800


def test_the_answer_is_the_one_on_the_front_page():
    """Where it is run (tests/docs)."""
    assert blocks("console")[0] in (ROOT / "docs" / "index.md").read_text(encoding="utf-8")


def test_windows_has_the_same_two_lines():
    lines = blocks("bat")[0].splitlines()
    posix = [
        re.search(rf"<!-- {m} command -->\n```sh\n(.*?)\n```", README, re.DOTALL)[1] for m in ("run", "test")
    ]
    for windows, line in zip(lines, posix, strict=True):
        words = line.replace("python3", "py").replace("/bin/", "/Scripts/").replace("'", '"')
        assert windows.replace("\\", "/") == words


@pytest.mark.parametrize("word", claims.WRITTEN)
def test_the_figures_are_those_of_the_stored_results(word):
    assert claims.split(word)[1] == claims.WRITTEN[word][1]()
