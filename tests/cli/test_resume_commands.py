"""Commands that were stopped: refused without ``--resume``, gone on with by it, to the output of an undisturbed run."""

import os
from pathlib import Path

from command import run

import shakedown
from shakedown.campaign import recorded_steps
from shakedown.files.atomic_write import record_beside

SIMULATE = ("simulate", "two-node", "--load-factor", "0.9", "--initial", "zero")


def test_the_record_of_the_longest_name_has_a_name(tmp_path, monkeypatch):
    """255 bytes are the most: what ``.partial`` leaves no room for is cut short, and told apart."""
    monkeypatch.setattr(recorded_steps, "EVERY", 0.0)
    words = ("sweep", "one-node", "--vary", "f=0.2:0.5:3", "--bounds", "upper", "-q")
    names = ["é" * 125 + end for end in ["a.csv", "b.csv"]]
    records = {record_beside(tmp_path / name) for name in names}
    assert len(records) == 2
    for name in names:
        assert run(*words, "-o", name, cwd=tmp_path)[0] == 0
    assert sorted(entry.name for entry in tmp_path.iterdir()) == names
    for record in records:
        Path(record).touch()
    code, _, err = run(*words, "-o", names[0], cwd=tmp_path)
    assert code == 2
    assert "unfinished run is recorded there" in err
    code, _, err = run(*words[:-1], "-o", names[0], "--resume", cwd=tmp_path)
    assert (code, err.splitlines()[0]) == (0, f"goes on from {os.path.basename(min(records))}")
    (tmp_path / "link.csv").symlink_to(tmp_path / names[1])
    assert record_beside(tmp_path / "link.csv") in records


def test_a_stopped_command_goes_on(tmp_path, monkeypatch):
    words, output = SIMULATE, "h.npz"
    code, whole, _ = run(*words, "-o", output, cwd=tmp_path)
    assert code == 0
    content = (tmp_path / output).read_bytes()
    (tmp_path / output).unlink()
    monkeypatch.setattr(recorded_steps, "EVERY", 0.0)

    def disk_is_full(*_):
        raise shakedown.UsageError(f"{output}: cannot be written (No space left on device)")

    with monkeypatch.context() as patch:
        patch.setattr(shakedown, "save_history", disk_is_full)
        code, out, err = run(*words, "-o", output, "--resume", cwd=tmp_path)
    assert (code, out) == (2, "")
    assert err == f"shakedown-bounds: {output}: cannot be written (No space left on device)\n"
    assert [entry.name for entry in tmp_path.iterdir()] == [f"{output}.partial"]
    code, _, err = run(*words, "-o", output, cwd=tmp_path)
    assert code == 2
    assert err.endswith("an unfinished run is recorded there; resume it, or remove that file\n")
    code, _, err = run(*words, "--cycles=7", "-o", output, "--resume", cwd=tmp_path)
    assert code == 2
    assert "found it recorded with" in err
    code, out, err = run(*words, "-o", output, "--resume", cwd=tmp_path)
    assert (code, out, err) == (0, whole, f"goes on from {output}.partial\n")
    assert [entry.name for entry in tmp_path.iterdir()] == [output]
    assert (tmp_path / output).read_bytes() == content
