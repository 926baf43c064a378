"""The load factor up to which shakedown from every initial state is proved."""

from dataclasses import replace

import pytest

import shakedown


def joint(name: str, f: float | None = None) -> shakedown.Problem:
    problem = shakedown.example(name)
    return problem if f is None else replace(problem, f=f)


@pytest.mark.parametrize(
    ("name", "f", "swing"),
    [
        ("one-node", None, 0.9305240),
        ("two-node", None, 0.6035788),
        ("uncoupled", None, 0.6465540),
        ("three-node", None, 0.3096),
        ("block-9", 0.1, 0.5722084),
        ("block-9", 0.2, 0.8491080),
        ("block-9", 0.3, 0.8428534),
        ("block-33", 0.2, 0.3209723),
    ],
)
def test_swing_bound_of_built_in_joints(name, f, swing):
    found = shakedown.swing_bound(joint(name, f))
    assert found.load_factor == pytest.approx(swing, abs=6e-8)


@pytest.mark.parametrize(
    ("name", "f", "closing"),
    [
        ("one-node", None, 0.9305240),
        ("two-node", None, 0.6543765),
        ("uncoupled", None, 0.6255632),
        ("block-9", 0.1, 0.0),
        ("block-9", 0.2, 0.0),
        ("block-9", 0.3, 0.0),
    ],
)
def test_closing_box_of_built_in_joints(name, f, closing):
    assert shakedown.closing_box(joint(name, f)).load_factor == pytest.approx(closing, abs=6e-8)


@pytest.mark.parametrize(
    ("name", "f", "share"), [("block-9", 0.1, 0.98), ("block-9", 0.2, 0.98), ("block-9", 0.3, 0.98)]
)
def test_blocks_are_proved_nearly_to_the_first_collapse(name, f, share):
    bound = shakedown.universal_bound(joint(name, f))
    assert bound.argument == "swing with box"
    assert share * bound.first_collapse < bound.load_factor <= bound.first_collapse
