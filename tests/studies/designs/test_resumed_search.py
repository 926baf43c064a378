"""A search for the smallest cycle that was killed goes on with what is recorded, to the same answer."""

import numpy as np
import pytest

import shakedown
from shakedown import Problem
from shakedown.campaign import recorded_steps
from shakedown.studies import descent

PLANE = shakedown.example("three-node")
SPACE = Problem(A=[[2, 0], [0, 2]], B=[[0, 0]], f=0.4, q_w=[[0.4, 0], [0.4, 1]], p_w=[[1], [1]])


@pytest.fixture(autouse=True)
def small_steps(monkeypatch):
    monkeypatch.setattr(recorded_steps, "EVERY", 0.0)
    monkeypatch.setattr(descent, "BLOCK", 3)


def searched(joint, **words):
    size = {"states": 4, "rounds": 2} if joint is PLANE else {"states": 2, "rounds": 1}
    return shakedown.smallest_cycle(joint, **size, seed=1, **words)


@pytest.mark.parametrize(("joint", "kills"), [(PLANE, 3), (SPACE, 1)], ids=["plane", "space"])
def test_killed_at_any_instant_it_ends_as_an_undisturbed_one(tmp_path, monkeypatch, joint, kills):
    path, kept, tried = tmp_path / "slip.npy.partial", [], []
    simulated = descent.long_term_states

    def noted(problem, load_factor, slips, **words):
        tried.append((load_factor, slips.tobytes()))
        return simulated(problem, load_factor, slips, **words)

    monkeypatch.setattr(descent, "long_term_states", noted)
    whole = searched(joint)
    drawn = set(tried)
    assert whole.status == "found"
    assert searched(joint, partial=path, save=lambda _: kept.append(path.read_bytes())) == whole
    assert not path.exists()
    for place in np.random.default_rng(0).integers(kept[0].index(b"\x93piece"), len(kept[0]), kills):
        path.write_bytes(kept[0][:place])
        again = searched(joint, partial=path, resume=True)
        assert again == whole
        assert again.to_dict() == whole.to_dict()
        assert set(tried) == drawn


def test_a_search_asked_otherwise_is_refused(tmp_path):
    path = tmp_path / "slip.npy.partial"
    with pytest.raises(KeyboardInterrupt):
        searched(PLANE, partial=path, progress=lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(shakedown.UsageError, match="unfinished run is recorded there; resume it, or remove"):
        searched(PLANE, partial=path)
    with pytest.raises(shakedown.UsageError, match="expected the same run to resume, found it recorded with"):
        searched(PLANE, partial=path, resume=True, initial_slips=np.zeros((1, 3)))
    with pytest.raises(shakedown.UsageError, match="recorded with run = adversary, not verify"):
        shakedown.verify(PLANE, partial=path, resume=True)
