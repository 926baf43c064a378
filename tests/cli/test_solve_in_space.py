"""`shakedown-bounds solve` for joints with two tangential directions."""

import numpy as np
import pytest
from command import refused, run

import shakedown

BLOCK = "block-3x3"


def test_text_begins_with_the_three_numbers_and_ends_with_both_slips_of_every_node():
    code, out, err = run("solve", BLOCK, "--details")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert max(map(len, lines)) <= 80
    assert lines[0] == "elastic block in space: 9 nodes (3-D), 40 load steps, f = 0.4"
    assert "λ_1, sensitivities and friction thresholds exist for plane joints" in " ".join(out.split())
    (head,) = (k for k, line in enumerate(lines) if "safe slip x  safe slip y  reached at λ_max" in line)
    safe = shakedown.upper_bound(shakedown.example(BLOCK)).slip
    for node, line in enumerate(lines[head + 1 : head + 10]):
        number, x, y, *steps = line.split()
        assert int(number) == node
        np.testing.assert_allclose([float(x), float(y)], safe[2 * node : 2 * node + 2], rtol=1e-6)
        assert all(0 <= int(step) < 40 for run in steps if run != "–" for step in run.rstrip(",").split("–"))
    assert "x, y: the two tangential directions of a node" in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("critical", "one-node-3d"), "critical load factors: expected one tangential direction, found two"),
        (("solve", "one-node-3d", "--initial", "given"), "found given, of a problem with 0 given states"),
        (("solve", "one-node-3d", "--open", "0"), "open"),
    ],
)
def test_what_does_not_exist_is_one_line(words, said):
    refused(*words, message=said)
