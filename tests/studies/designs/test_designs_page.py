"""What the page on designs shows is what the commands say."""

import re
import shlex
from pathlib import Path

import pytest
from command import run

PAGE = (Path(__file__).parents[3] / "docs" / "designs.md").read_text()
SHOWN = [block.split("\n", 1) for block in re.findall(r"```console\n\$ (.*?)\n```", PAGE, re.DOTALL)]


@pytest.mark.parametrize(("line", "shown"), SHOWN, ids=[line for line, _ in SHOWN])
def test_a_command_says_what_is_shown(tmp_path, line, shown):
    code, out, err = run(*shlex.split(line)[1:], cwd=tmp_path)
    assert (code, err) == (0, "")
    assert out.rstrip("\n") == shown


def test_the_commands_that_draw_run(tmp_path):
    lines = [re.sub(r"\\\n", " ", block) for block in re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)]
    commands = [line for block in lines for line in block.splitlines() if line]
    assert len(commands) == 2
    for command in commands:
        coarse = re.sub(r":(27|29)\b", ":3", command)
        assert run(*shlex.split(coarse)[1:], cwd=tmp_path)[0] == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["friction.png", "mean-friction.png"]
