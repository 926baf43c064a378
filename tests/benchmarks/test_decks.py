"""Every deck of a folder: read, refused with its reason, or an error of the program."""

import pytest

from benchmarks import decks


@pytest.mark.parametrize("crash", [False, True])
def test_every_deck_of_a_folder_is_told(tmp_path, capsys, monkeypatch, crash):
    (tmp_path / "more").mkdir()
    (tmp_path / "good.inp").write_text("*NODE\n1, 0., 0.\n")
    (tmp_path / "more" / "bad.inp").write_text("*NODE\n1, x\n")
    if crash:
        monkeypatch.setattr(decks, "read_deck", lambda path: [][0])
    assert decks.main([str(tmp_path)]) == crash
    *reasons, last = capsys.readouterr().out.splitlines()
    assert last == ("0 read, 0 refused, 2 crashed" if crash else "1 read, 1 refused, 0 crashed")
    assert len(reasons) == 1 + crash
    assert "IndexError" in reasons[0] if crash else "line 2: expected a number, found 'x'" in reasons[0]


def test_without_a_folder_the_use_is_told(capsys):
    assert decks.main([]) == 2
    assert "usage" in capsys.readouterr().err
