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


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["solve"], "proved from this state 0.7315 20 ± 14.63 kN −26.85 % zero slip"),
        (
            ["verify", "--random", "0", "--load-factor", "1"],
            "proved from this state 0.7315 20 ± 14.63 kN",
        ),
        (["solve"], "loads at λ = 1: axial load 20 ± 20 kN; bolt preload 12 kN, unchanged"),
        (
            ["simulate", "--load-factor", "0.7"],
            "loads axial load 20 ± 14 kN; bolt preload 12 kN, unchanged",
        ),
    ],
    ids=lambda value: value[0],
)
def test_load_factors_are_said_in_the_loads_of_the_user(tmp_path, words, shown):
    loads = {"load_mean": [12, 20], "load_amplitude": [0, 20], "load_units": ["kN", "kN"]}
    names = ["bolt preload", "axial load"]
    joint = dataclasses.replace(shakedown.example("two-node"), load_names=names, **loads)
    shakedown.save_problem(tmp_path / "loads.npz", joint)
    _, out, _ = run(words[0], str(tmp_path / "loads.npz"), *words[1:])
    assert shown in " ".join(out.split())
    if words[0] in ("solve", "simulate"):
        assert max(map(len, out.splitlines())) <= 80
    _, out, _ = run(words[0], "two-node", *words[1:])
    assert "loads at" not in out
    assert "kN" not in out


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
