"""What the commands call a node, in which units they show numbers, and what they do not show."""

import dataclasses

import pytest
from command import document, run

import shakedown


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("labels") / "named.npz"
    joint = dataclasses.replace(shakedown.example("two-node"), label=["4711/12", "4712/13"], units="N, mm")
    shakedown.save_problem(path, joint)
    return str(path)


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["solve", "--details"], ["4712/13", "safe slip [mm]", "critical slip [mm]", "node 1 (FE 4712/13)"]),
        (["critical"], ["1 (FE 4712/13) backward", "slip there [mm]"]),
        (["simulate", "--load-factor", "0.9"], ["4712/13", "final [mm]", "N mm"]),
        (["verify", "--random", "0", "--details"], ["node 1 (FE 4712/13)", "Σ|Δv| [mm]"]),
    ],
    ids=lambda value: value[0],
)
def test_nodes_have_their_labels_and_numbers_their_units(file, words, shown):
    _, out, _ = run(words[0], file, *words[1:])
    unwrapped = " ".join(out.split())
    for text in shown:
        assert text in unwrapped
    assert max(map(len, out.splitlines())) <= 80


def test_round_off_is_shown_as_zero_and_kept_in_the_json():
    _, out, _ = run("simulate", "jump", "--load-factor", "1")
    lines = out.splitlines()
    assert [line.split()[-1] for line in lines if "dissipation per cycle" in line] == ["0"]
    assert "e-15" not in out
    assert document("simulate", "jump", "--load-factor", "1")["dissipation_per_cycle"] < 1e-12


@pytest.mark.parametrize("command", ["solve", "critical", "simulate", "verify", "import", "example"])
def test_every_command_says_what_its_exit_codes_mean(command):
    _, out, _ = run(command, "--help")
    assert "Exit codes: 0 " in out
