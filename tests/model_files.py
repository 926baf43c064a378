"""Finite-element output that comes with the tests, and configurations with something changed in them."""

from pathlib import Path

import pytest

from shakedown import ProblemError, import_model

DATA = Path(__file__).parent / "data"
BLOCK = DATA / "calculix_9"
RING = DATA / "calculix_ring"  # axisymmetric
HEAT = DATA / "calculix_heat"  # heated, with the contact held and open
FIT = DATA / "calculix_fit"  # axisymmetric, with contact of CalculiX's own


def changed(folder, *pairs, extra=""):
    """The configuration ``import.toml`` of a folder, some things in it replaced and more at its end."""
    text = (folder / "import.toml").read_text()
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new, 1)
    (folder / "changed.toml").write_text(text + extra)
    return folder / "changed.toml"


def refused_with(path, old, new, message):
    """With something replaced in its configuration an import is refused, and the message says why."""
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ProblemError, match=message):
        import_model(path)
