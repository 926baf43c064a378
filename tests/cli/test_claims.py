"""No file of a call is written over another one of the same call, however they are spelt."""

import os

import numpy as np
import pytest
from command import refused, run

import shakedown

CONFIG = """
[model]
stiffness = "K.mtx"
"""
MAP = ["map", "p.npz", "--load-factor", "0.7", "--states", "8"]
SWEEP = ["sweep", "p.npz", "--vary", "f=0.3,0.4", "--bounds", "upper"]
SIMULATE = ["simulate", "p.npz", "--load-factor", "0.5"]


@pytest.fixture
def folder(tmp_path):
    """A joint, a slip and a configuration, with other ways to spell them."""
    shakedown.save_problem(tmp_path / "p.npz", shakedown.example("two-node"))
    shakedown.save_problem(tmp_path / "p.npz.partial", shakedown.example("two-node"))
    shakedown.save_problem(tmp_path / "p.npz.parts", shakedown.example("two-node"))
    shakedown.save_problem(tmp_path / "s.html.partial", shakedown.example("two-node"))
    shakedown.save_problem(tmp_path / "r.json", shakedown.example("two-node"))
    np.save(tmp_path / "v.npy", np.zeros(2))
    (tmp_path / "joint.toml").write_text(CONFIG)
    (tmp_path / "link").symlink_to("p.npz")
    (tmp_path / "link.png").symlink_to("same.png")
    (tmp_path / "here").symlink_to(".")
    return tmp_path


def contents(folder):
    return {name: (folder / name).read_bytes() for name in os.listdir(folder) if (folder / name).is_file()}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([*MAP, "-o", "same.png", "--picture", "same.png"], "--picture: expected another file than -o"),
        ([*MAP, "-o", "same.png", "--picture", "link.png"], "--picture: expected another file than -o"),
        (["map", "-o", "link", *MAP[1:]], "-o: expected another file than FILE"),
        (["map", "p.npz.parts", *MAP[2:], "-o", "p.npz"], "the pieces of -o: expected another file than FILE"),
        (["map", "-o", "../{name}/p.npz", *MAP[1:]], "-o: expected another file than FILE"),
        ([*SWEEP, "-o", "v.csv", "--initial", "v.csv"], "-o: expected another file than --initial"),
        ([*SIMULATE, "--initial", "v.npy", "-o", "here/v.npy"], "-o: expected another file than --initial"),
        (["verify", "r.json", "-o", "r.html"], "r.json: the JSON of the report r.html goes there"),
        (["import", "joint.toml", "-o", "joint.toml"], "-o: expected another file than CONFIG.toml"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)  # fmt: skip
def test_a_file_has_one_part_in_a_call(folder, words, said):
    (folder / "v.csv").write_bytes((folder / "v.npy").read_bytes())
    before = contents(folder)
    refused(*[word.format(name=folder.name) for word in words], cwd=folder, message=said)
    assert contents(folder) == before


def test_files_that_an_import_reads_are_not_written_over(tmp_path, monkeypatch):
    """Not the configuration alone: every file that it names."""
    code, _, err = run("import", "--template", "example", "-o", "e", cwd=tmp_path)
    assert (code, err) == (0, "")
    config = next((tmp_path / "e").glob("*.toml"))
    sources = sorted(shakedown.import_model(config).sources)
    assert len(sources) > 1
    before = contents(tmp_path / "e")
    for source in sources:
        words = ("import", str(config), "-o", str(tmp_path / "e" / source))
        refused(*words, message="-o: expected another file than")
    assert contents(tmp_path / "e") == before


def test_two_files_are_two_files(folder):
    assert run(*MAP, "-o", "map.npz", "--picture", "map.png", cwd=folder)[0] == 0
    assert run(*MAP, "-o", "map.npz", "--resume", "--picture", "map.png", cwd=folder)[0] == 0
