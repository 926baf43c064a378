"""The tutorial as it is printed: its deck, its configuration, its commands."""

import re
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from calculix import ccx, needs_ccx
from command import run

import shakedown

TUTORIAL = (Path(__file__).parents[3] / "docs" / "tutorial-calculix.md").read_text(encoding="utf-8")
EXAMPLE = files("shakedown.models.importing") / "example"


def block(language, word):
    """The one fenced block of a language that holds a word."""
    found = [b for b in re.findall(rf"```{language}\n(.*?)```", TUTORIAL, re.DOTALL) if word in b]
    assert len(found) == 1, (language, word)
    return found[0]


@pytest.fixture
def folder(tmp_path):
    """What the reader of the tutorial has, but for what CalculiX writes."""
    (tmp_path / "punch.inp").write_text(EXAMPLE.joinpath("punch.inp").read_text())
    (tmp_path / "import.toml").write_text(block("toml", "[contact]"))
    return tmp_path


def test_the_deck_of_the_tutorial_is_the_shipped_one():
    shipped = iter(EXAMPLE.joinpath("punch.inp").read_text().splitlines())
    assert all(line in shipped for line in block("text", "*STEP").splitlines())  # in this order


@needs_ccx
@pytest.mark.usefixtures("undrawn")
def test_the_tutorial_with_calculix(folder):
    """Every command in its order, the simulations cut to a few; with the shipped output the site runs them."""
    ccx(folder, "punch")
    for line in re.findall(r"^(?:\$ )?shakedown-bounds (.*)$", TUTORIAL, re.MULTILINE):
        words = line.split()
        if words[0] == "verify":
            words += ["--random", "0", "--load-factor", "1.2"]
        code, _, err = run(*words, cwd=folder)
        assert (code, err) == (0, ""), (line, err)
    made = shakedown.load_problem(folder / "punch.npz")
    for name, found in (
        ("proved from every state", shakedown.lower_bound(made).load_factor),
        ("impossible above", shakedown.upper_bound(made).load_factor),
    ):
        shown = re.search(rf"{name} +([0-9.]+)", TUTORIAL)
        assert found == pytest.approx(float(shown[1]), rel=1e-3)
    assert (folder / "punch.html").stat().st_size > 10_000
    shipped = np.loadtxt(str(EXAMPLE.joinpath("punch.sti")))
    np.testing.assert_allclose(
        np.loadtxt(folder / "punch.sti"), shipped, rtol=1e-6, atol=1e-6 * shipped[:, 2].max()
    )


def printed(folder, digits, scale, more=""):
    """The matrix of the tutorial as a file with so many digits, and its configuration."""
    i, j, value = np.loadtxt(EXAMPLE / "punch.sti", unpack=True)
    rows = (EXAMPLE / "punch.dof").read_text().split()
    size = f"{len(rows)} {len(rows)} {len(value)}"
    low, high = np.minimum(i, j), np.maximum(i, j)
    entries = zip(high.astype(int), low.astype(int), scale * value, strict=True)
    lines = [f"{a} {b} {v:.{digits - 1}e}" for a, b, v in entries]
    text = "\n".join(["%%MatrixMarket matrix coordinate real symmetric", size, *lines, ""])
    (folder / "punch.mtx").write_text(text)
    for name in ("punch.inp", "punch.dof"):
        (folder / name).write_text((EXAMPLE / name).read_text())
    config = (EXAMPLE / "import.toml").read_text()
    assert 'file = "punch.sti"' in config
    config = config.replace('file = "punch.sti"', f'file = "punch.mtx"\nmap = "punch.dof"{more}')
    (folder / "import.toml").write_text(config)
    return folder / "import.toml"


@pytest.mark.parametrize(("digits", "scale"), [(8, 0.7), (6, 1 / 3)])
def test_a_floating_body_keeps_its_rigid_motions_in_few_digits(tmp_path, digits, scale):
    """Of its own rounding the printed matrix resists them; the limits would be others, or refused."""
    whole = shakedown.import_model(EXAMPLE / "import.toml").problem
    made = shakedown.import_model(printed(tmp_path, digits, scale))
    assert made.condensation.zero_modes == 3
    assert made.problem.stiffness_accuracy == pytest.approx(10.0**-digits)
    expected = shakedown.upper_bound(whole).load_factor
    assert shakedown.upper_bound(made.problem).load_factor == pytest.approx(
        expected, rel=10.0 ** (4 - digits)
    )
    eigenvalues = np.linalg.eigvalsh(made.problem.kappa)
    assert (np.abs(eigenvalues) < 1e-12 * eigenvalues[-1]).sum() == 3
