"""The commands of the page on designs that draw, on a coarser grid."""

import re
import shlex
from pathlib import Path

from command import run

PAGE = (Path(__file__).parents[3] / "docs" / "designs.md").read_text()


def test_the_commands_that_draw_run(tmp_path):
    lines = [re.sub(r"\\\n", " ", block) for block in re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)]
    commands = [line for block in lines for line in block.splitlines() if line]
    assert len(commands) == 2
    for command in commands:
        coarse = re.sub(r":(27|29)\b", ":3", command)
        assert run(*shlex.split(coarse)[1:], cwd=tmp_path)[0] == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["friction.png", "mean-friction.png"]
