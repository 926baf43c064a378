"""Commands that were stopped: refused without ``--resume``, gone on with by it, to the output of an undisturbed run."""

import pytest
from command import run

import shakedown
from shakedown.campaign import recorded_steps as room

SIMULATE = ("simulate", "two-node", "--load-factor", "0.9", "--initial", "zero")
ADVERSARY = ("adversary", "three-node", "--states", "4", "--rounds", "1")
COMMANDS = {"h.npz": (SIMULATE, "save_history"), "slip.npy": (ADVERSARY, "save_initial_slip")}


@pytest.mark.parametrize("output", COMMANDS)
def test_a_stopped_command_goes_on(tmp_path, monkeypatch, output):
    words, saver = COMMANDS[output]
    code, whole, _ = run(*words, "-o", output, cwd=tmp_path)
    assert code == 0
    content = (tmp_path / output).read_bytes()
    (tmp_path / output).unlink()
    monkeypatch.setattr(room, "EVERY", 0.0)

    def disk_is_full(*_):
        raise shakedown.UsageError(f"{output}: cannot be written (No space left on device)")

    with monkeypatch.context() as patch:
        patch.setattr(shakedown, saver, disk_is_full)
        code, out, err = run(*words, "-o", output, "--resume", cwd=tmp_path)
    assert (code, out) == (2, "")
    assert err == f"shakedown-bounds: {output}: cannot be written (No space left on device)\n"
    assert [entry.name for entry in tmp_path.iterdir()] == [f"{output}.partial"]
    code, _, err = run(*words, "-o", output, cwd=tmp_path)
    assert code == 2
    assert err.endswith("an unfinished run is recorded there; resume it, or remove that file\n")
    code, _, err = run(
        *words, "--seed=7" if words is ADVERSARY else "--cycles=7", "-o", output, "--resume", cwd=tmp_path
    )
    assert code == 2
    assert "found it recorded with" in err
    code, out, err = run(*words, "-o", output, "--resume", cwd=tmp_path)
    assert (code, out, err) == (0, whole, f"goes on from {output}.partial\n")
    assert [entry.name for entry in tmp_path.iterdir()] == [output]
    assert (tmp_path / output).read_bytes() == content
