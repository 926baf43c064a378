"""`shakedown-bounds import`: the file it writes, its JSON, one line for every error."""

import numpy as np
import pytest
from command import document, run
from model_files import BLOCK

import shakedown


def test_import_writes_the_problem_and_says_where_it_came_from(tmp_path):
    code, out, err = run("import", str(BLOCK / "import.toml"), "-o", str(tmp_path / "b.npz"))
    assert (code, err) == (0, "")
    assert "9 nodes, 48 load steps" in out
    assert "from reactions to unit displacements: 0 rows condensed, 0 held" in out
    assert "agrees with the static run" in out
    made, reference = shakedown.load_problem(tmp_path / "b.npz"), shakedown.load_problem(BLOCK / "block.npz")
    np.testing.assert_allclose(made.p_w, reference.p_w, rtol=1e-14)


def test_import_has_every_json_field(tmp_path):
    result = document("import", str(BLOCK / "import.toml"), "-o", str(tmp_path / "b.npz"))
    assert result["problem"] == {"name": "CalculiX block, 9 contact nodes", "n": 9, "m": 48}
    assert result["rows"] == {"contact": 18, "condensed": 0, "held": 0}
    assert result["zero_modes"] == 0
    assert result["static_run"] < 2e-6
    assert result["notes"] == []


def test_a_missing_static_run_is_null(tmp_path):
    for file in BLOCK.glob("*.dat"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    config = tmp_path / "c.toml"
    config.write_text((BLOCK / "import.toml").read_text().split("[check]")[0])
    result = document("import", str(config), "-o", str(tmp_path / "b.npz"))
    assert result["static_run"] is None


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["absent.toml", "-o", "b.npz"], "absent.toml: no such file"),
        ([str(BLOCK / "block.npz"), "-o", "b.npz"], "expected a TOML file"),
        ([str(BLOCK / "import.toml")], "Missing option '-o'"),
        ([str(BLOCK / "import.toml"), "-o", "no/such/folder/b.npz"], "cannot be written"),
    ],
)
def test_errors_are_one_line_with_exit_code_2(tmp_path, words, message):
    code, out, err = run("import", *words, cwd=tmp_path)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
