"""What the README shows is run: library example, commands, and the line that CI calls."""

import doctest
import re
import shlex
from pathlib import Path

import pytest
from command import run

from benchmarks import claims

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_the_library_example_gives_what_it_shows():
    result = doctest.testfile(str(ROOT / "README.md"), module_relative=False)
    assert result.attempted > 0
    assert result.failed == 0


def commands():
    lines = [line for block in blocks("sh") for line in block.splitlines()]
    return [line.partition("#")[0].strip() for line in lines if line.startswith("shakedown-bounds")]


def test_the_commands_run_one_after_the_other(tmp_path):
    assert len(commands()) >= 5
    for command in commands():
        code, out, err = run(*shlex.split(command)[1:], cwd=tmp_path)
        assert code == 0, (command, err)
        assert max(map(len, out.splitlines())) <= 80, command


@pytest.mark.parametrize("marker", ["run command", "test command"])
def test_each_line_stands_by_itself(marker):
    block = re.search(rf"<!-- {marker} -->\n```sh\n(.*?)```", README, re.DOTALL)
    assert block is not None
    lines = block.group(1).splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("python3 -m venv ")


def test_ci_calls_the_test_command_of_the_readme():
    script = (ROOT / ".ci" / "run").read_text()
    assert "<!-- test command -->" in script
    assert "pytest" not in script


def test_it_is_read_in_five_minutes():
    assert len(README.split()) <= 1200


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


def test_the_figures_are_those_of_the_stored_results():
    assert claims.current() == claims.section()
