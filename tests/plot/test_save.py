"""Pictures reach their files whole or not at all."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import shakedown
from shakedown import plot


@pytest.mark.parametrize(("ending", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_the_ending_decides_the_format_and_the_same_picture_has_the_same_bytes(tmp_path, ending, start):
    paths = [tmp_path / f"{k}.{ending}" for k in range(2)]
    for path in paths:
        plot.save(plot.load_loop(shakedown.example("two-node"), 0), path)
    first, second = (path.read_bytes() for path in paths)
    assert first == second
    assert first.startswith(start)
    assert b"Date" not in first
    assert b"dc:date" not in first


def test_an_unknown_ending_is_refused(tmp_path):
    axes = plot.load_loop(shakedown.example("two-node"), 0)
    with pytest.raises(shakedown.UsageError, match=r"loop\.doc: expected a name that ends in"):
        plot.save(axes, tmp_path / "loop.doc")


def test_a_picture_that_fails_leaves_the_old_file(tmp_path):
    path = tmp_path / "old.png"
    path.write_bytes(b"old")
    axes = Figure().subplots()
    axes.plot(np.arange(3.0), label="$\\notamacro{$")
    axes.legend()
    with pytest.raises(ValueError, match="notamacro"):
        plot.save(axes, path)
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["old.png"]
