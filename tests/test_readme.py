"""What the README shows is run: library example, commands, and the line that CI calls."""

import doctest
import json
import os
import re
import shutil
import subprocess
import sys
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


STAND_IN = """#!{python}
import sys, venv
from pathlib import Path
venv.create(sys.argv[3])
for name, script in {programs!r}.items():
    program = Path(sys.argv[3], "bin", name)
    program.write_text("#!/bin/sh\\n" + script)
    program.chmod(0o755)
"""  # for python3 -m venv FOLDER: the environment is a real one, what pip would install into it is not


def printed():
    """What the README has its reader type, but for the tests."""
    found = re.findall(r"^```(sh|console)\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    for kind, line in ((kind, line) for kind, block in found for line in block.splitlines()):
        if kind == "sh" and "pytest" not in line:
            yield line
        elif kind == "console" and line.startswith("$ "):
            yield line[2:]


@pytest.mark.usefixtures("undrawn")
def test_every_command_works_as_printed_one_after_the_other_in_one_fresh_shell(tmp_path):
    called = {"pip": "", "shakedown-bounds": f"printf '%s\\n' \"$@\" '' >> '{tmp_path}/called'"}
    (tmp_path / "python3").write_text(STAND_IN.format(python=sys.executable, programs=called))
    (tmp_path / "python3").chmod(0o755)
    for tool in ("bash", "uname"):
        (tmp_path / tool).symlink_to(shutil.which(tool))
    shell = ["bash", "-ec", "\n".join(printed())]
    done = subprocess.run(shell, cwd=tmp_path, env={"PATH": str(tmp_path)}, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    commands = [words.splitlines() for words in (tmp_path / "called").read_text().split("\n\n")[:-1]]
    assert len(commands) >= 8
    for command in commands:
        code, out, err = run(*command, cwd=tmp_path)
        assert code == 0, (command, err)
        assert max(map(len, out.splitlines())) <= 80, command


def test_the_first_line_installs_what_the_library_example_imports():
    assert "from shakedown.fem import" in blocks("pycon")[0]
    assert "pip install -q --no-compile '.[fem]'" in blocks("sh")[0]


@pytest.mark.parametrize("marker", ["run command", "test command"])
def test_each_line_stands_by_itself(marker):
    block = re.search(rf"<!-- {marker} -->\n```sh\n(.*?)```", README, re.DOTALL)
    assert block is not None
    lines = block.group(1).splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("python3 -m venv ")


def test_ci_runs_the_test_command_where_nothing_is_beside_one_python(tmp_path):
    """Copied beside another README, whose command says where it is."""
    seen = "import json, os, shutil, sys; print(json.dumps([dict(os.environ), shutil.which('ccx'), sys.executable]))"
    (tmp_path / "README.md").write_text(f'<!-- test command -->\n```sh\npython3 -c "{seen}" && exit 3\n```\n')
    for name in (".ci/bare", "tools/ccx"):
        (tmp_path / name).parent.mkdir()
        shutil.copy(ROOT / ".ci" / "bare", tmp_path / name)
    settings = {
        "HOME": str(tmp_path),
        "PIP_RETRIES": "7",
        "SHAKEDOWN_EXTRA": "1",
        "OPENBLAS_CORETYPE": "Haswell",
    }
    done = subprocess.run(
        ["bash", ".ci/bare", "test", sys.executable, "OPENBLAS_CORETYPE=Nehalem"],
        cwd=tmp_path, env=settings | {"PATH": f"{tmp_path / 'tools'}:{os.environ['PATH']}"},
        capture_output=True, text=True,
    )  # fmt: skip
    environment, ccx, python = json.loads(done.stdout.splitlines()[-1])
    assert done.returncode == 3
    assert (ccx, python) == (None, sys.executable)
    assert environment["HOME"] != str(tmp_path)
    of_bash = {"PWD", "OLDPWD", "SHLVL", "_", "LC_CTYPE"}
    assert set(environment) - of_bash == {"HOME", "PATH", "PIP_CACHE_DIR", "PIP_RETRIES", "OPENBLAS_CORETYPE"}
    assert environment["OPENBLAS_CORETYPE"] == "Nehalem"


def test_all_scripts_of_ci_take_the_command_from_there():
    for name in ("run", "pythons"):
        script = (ROOT / ".ci" / name).read_text()
        assert ".ci/bare test" in script
        assert "pip install" not in script


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
