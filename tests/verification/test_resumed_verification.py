"""A verification that was killed goes on with what is recorded, and ends as an undisturbed one."""

import numpy as np
import pytest

import shakedown
from shakedown import Problem
from shakedown.campaign import recorded_steps as room

PLANE = shakedown.example("two-node")
SPACE = Problem(A=[[2, 0], [0, 2]], B=[[0, 0]], f=0.4, q_w=[[0.4, 0], [0.4, 1]], p_w=[[1], [1]])


@pytest.fixture(autouse=True)
def every_step_alone(monkeypatch):
    monkeypatch.setattr(room, "EVERY", 0.0)


@pytest.fixture
def short_scan(monkeypatch):
    """No λ_T, which takes half a second in space."""
    monkeypatch.setattr("shakedown.assessment.transient_limit.transient_limit", lambda *_, **__: None)


def verified(joint, **words):
    return shakedown.verify(joint, load_factors=[0.3], random_states=0, **words)


def said(found):
    """All that a document says, but how long runs took."""
    document = found.to_dict()
    for run in document["runs"]:
        del run["seconds"]
    return document


@pytest.mark.parametrize(("joint", "kills"), [(PLANE, 3), (SPACE, 1)], ids=["plane", "space"])
@pytest.mark.usefixtures("short_scan")
def test_killed_at_any_instant_it_ends_as_an_undisturbed_one(tmp_path, joint, kills):
    path, whole, kept = tmp_path / "report.html.partial", said(verified(joint)), []
    found = verified(joint, partial=path, save=lambda _: kept.append(path.read_bytes()))
    assert said(found) == whole
    assert not path.exists()
    for place in np.random.default_rng(0).integers(kept[0].index(b"\x93piece"), len(kept[0]), kills):
        path.write_bytes(kept[0][:place])
        again = verified(joint, partial=path, resume=True)
        assert said(again) == whole
        assert again.problem is joint


def test_what_is_recorded_is_not_done_again(tmp_path, monkeypatch):
    path, runs = tmp_path / "report.html.partial", []

    def disk_is_full(found):
        runs.extend(found.runs)
        raise shakedown.UsageError("cannot be written")

    with pytest.raises(shakedown.UsageError, match="cannot be written"):
        verified(PLANE, partial=path, save=disk_is_full)
    for word in ("plan._At", "verify.second_road", "verify.critical_load_factors"):
        monkeypatch.setattr(f"shakedown.verification.{word}", None)
    again = verified(PLANE, partial=path, resume=True)
    assert [run.seconds for run in again.runs] == [run.seconds for run in runs]


def test_a_verification_asked_otherwise_is_refused(tmp_path):
    path = tmp_path / "report.html.partial"
    with pytest.raises(KeyboardInterrupt):
        verified(PLANE, partial=path, progress=lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(shakedown.UsageError, match="unfinished run is recorded there; resume it, or remove"):
        verified(PLANE, partial=path)
    with pytest.raises(shakedown.UsageError, match="recorded with cycles = 1000, not 999"):
        verified(PLANE, partial=path, resume=True, cycles=999)
    with pytest.raises(shakedown.UsageError, match="recorded with problem = "):
        verified(shakedown.example("three-node"), partial=path, resume=True)
