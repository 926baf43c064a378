"""Commands that were stopped: refused without ``--resume``, gone on with by it, to the output of an undisturbed run."""

from pathlib import Path

from command import run

from shakedown.files.atomic_write import pieces_beside


def test_the_pieces_of_an_output_have_a_folder_beside_it(tmp_path, caplog):
    words = ("sweep", "one-node", "--vary", "f=0.2:0.5:3", "--bounds", "upper", "-q")
    names = ["a.csv", "b.csv"]
    folders = {Path(pieces_beside(tmp_path / name)) for name in names}
    assert len(folders) == 2
    for name in names:
        assert run(*words, "-o", name, cwd=tmp_path)[0] == 0
    assert sorted(entry.name for entry in tmp_path.iterdir()) == names
    for folder in folders:
        folder.mkdir()
        (folder / f"{'0' * 16}-1.npz").touch()
    code, _, err = run(*words, "-o", names[0], cwd=tmp_path)
    assert code == 2
    assert "unfinished run is kept there" in err
    assert run(*words[:-1], "-o", names[0], "--resume", cwd=tmp_path)[0] == 0
    assert caplog.messages[0].startswith("goes on from 0 of 3 pieces in ")
    (tmp_path / "link.csv").symlink_to(tmp_path / names[1])
    assert Path(pieces_beside(tmp_path / "link.csv")) in folders
