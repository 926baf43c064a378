"""`shakedown-bounds import`: the file it writes, its JSON, one line for every error."""

import numpy as np
from command import document, run
from model_files import BLOCK

import shakedown
from shakedown.models.importing.templates import import_template


def test_import_writes_the_problem_and_says_where_it_came_from(tmp_path):
    code, out, err = run("import", str(BLOCK / "import.toml"), "-o", str(tmp_path / "b.npz"))
    assert (code, err) == (0, "")
    assert "9 nodes, 48 load steps" in out
    assert "read from reactions to unit displacements 0 rows condensed, 0 held" in " ".join(out.split())
    assert "agrees with static run" in out
    made, reference = shakedown.load_problem(tmp_path / "b.npz"), shakedown.load_problem(BLOCK / "block.npz")
    np.testing.assert_allclose(made.p_w, reference.p_w, rtol=1e-14)
    result = document("import", str(BLOCK / "import.toml"), "-o", str(tmp_path / "b.npz"))
    labels = [str(k) for k in range(1, 10)]
    known = {"name": "CalculiX block, 9 contact nodes", "n": 9, "m": 48, "labels": labels, "units": "N, mm"}
    assert result["problem"] == known
    assert result["rows"] == {"contact": 18, "condensed": 0, "held": 0}
    assert (result["zero_modes"], result["notes"]) == (0, [])
    assert result["static_run"] < 2e-6


def test_a_template_is_shown_or_written_once(tmp_path):
    code, out, err = run("import", "--template", "abaqus")
    assert (code, err) == (0, "")
    assert out == import_template("abaqus")
    assert run("import", "--template", "abaqus", "-o", str(tmp_path / "c.toml"))[0] == 0
    assert (tmp_path / "c.toml").read_text() == out
    code, _, err = run("import", "--template", "ansys", "-o", str(tmp_path / "c.toml"))
    assert (code, err.count("\n")) == (2, 1)
    assert "expected no such file, found one" in err
    assert (tmp_path / "c.toml").read_text() == out


def test_check_shows_what_is_read_and_writes_nothing(tmp_path):
    assert run("import", "--template", "example", "-o", str(tmp_path / "punch"))[0] == 0
    before = sorted(tmp_path.rglob("*"))
    config = str(tmp_path / "punch" / "import.toml")
    code, out, err = run("import", config, "--check", "-o", str(tmp_path / "p.npz"))
    assert (code, err) == (0, "")
    assert sorted(tmp_path.rglob("*")) == before
    assert out.splitlines()[1].startswith("GO ON: no warnings.")
    for words in (
        "5/1077",
        "first body 45 nodes 9 in contact; free but for the contact: along x, along y,",
        "second body 68 nodes 9 in contact; held by supports",
        "asymmetry",
        "rigid motions 3 of the contact nodes, without resistance",
        "read punch.sti",
    ):
        assert words in " ".join(out.split())
    lines = [line.split() for line in out.splitlines()]
    for words in (
        "applied, first body 70 0 -70",  # about the middle of the contact, 1 mm below
        "contact, first body -70 0 70",
        "supports, second body -70 0 70",
    ):
        assert words.split() in lines
    assert all(len(line) <= 80 for line in out.splitlines())
    found = document("import", config, "--check")
    assert found["file"] is None
    assert found["nodes"][4] == "5/1077"
    assert found["loads"][0]["applied"] == [0.0, -700.0]
    assert found["normals"] == [[0.0, 1.0]] * 9
    assert len(found["sources"]["punch.sti"]) == 64


def test_a_picture_is_drawn(tmp_path):
    assert run("import", "--template", "example", "-o", str(tmp_path / "punch"))[0] == 0
    config = str(tmp_path / "punch" / "import.toml")
    assert run("import", config, "--check", "--picture", str(tmp_path / "p.png"))[0] == 0
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    code, _, err = run("import", config, "--check", "--picture", str(tmp_path / "p.nonsense"))
    assert (code, err.count("\n")) == (2, 1)
    assert "expected a name that ends in .png" in err
