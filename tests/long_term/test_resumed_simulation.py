"""A simulation that was killed goes on with what is recorded, and ends as an undisturbed one, to the last bit."""

import re
from dataclasses import fields

import numpy as np
import pytest
from joints_in_space import random_joint

import shakedown
from shakedown.campaign import recorded_steps
from shakedown.campaign.stored_result import folded, restored, stored
from shakedown.long_term import limit_search
from shakedown.motion.evolution import Evolution
from shakedown.motion.fixed_steps import FixedSteps

PLANE = shakedown.example("receding-block")  # nodes open and close
SPACE = random_joint(np.random.default_rng(1), 3, pressure=1.5)
CASES = {
    "event-plane": (PLANE, {"method": "event"}),
    "gauss-seidel-plane": (PLANE, {"method": "gauss-seidel"}),
    "event-space": (SPACE, {"method": "event"}),
    "newton": (SPACE, {"method": "newton"}),
    "gauss-seidel-space": (SPACE, {"method": "gauss-seidel"}),
}


@pytest.fixture(autouse=True)
def recorded_after_every_cycle(monkeypatch):
    for name in ("EVERY", "LEISURE"):
        monkeypatch.setattr(recorded_steps, name, 0.0)
    monkeypatch.setattr(recorded_steps, "SIZE", np.inf)
    monkeypatch.setattr(recorded_steps.os, "fsync", lambda _: None)
    monkeypatch.setattr(limit_search, "EFFORT", 1000)


def simulated(joint, **words):
    start = 0.1 * np.random.default_rng(0).normal(size=joint.layout.slip_size)
    return shakedown.simulate(joint, 0.7, start, cycles=8, record=True, **words)


def assert_same(one, other):
    """Every number of two simulations, and of their paths."""
    assert one == other
    assert one.to_dict() == other.to_dict()
    assert one.cycles.records
    for field in fields(one.history):
        np.testing.assert_array_equal(getattr(one.history, field.name), getattr(other.history, field.name))
    if one.long_term is not None:
        assert one.long_term.history == other.long_term.history


@pytest.fixture(params=CASES)
def case(request):
    return CASES[request.param]


def test_killed_at_any_instant_it_ends_as_an_undisturbed_one(tmp_path, case):
    (joint, words), path, kept = case, tmp_path / "history.npz.partial", []
    whole = simulated(joint, **words)
    again = simulated(joint, partial=path, save=lambda _: kept.append(path.read_bytes()), **words)
    assert_same(again, whole)
    assert kept[0].count(b"\x93piece") > 4
    assert not path.exists()
    starts = [found.start() for found in re.finditer(b"\x93piece", kept[0])]
    within = np.random.default_rng(2).integers(starts[0], len(kept[0]))
    for place in (starts[3], within):  # the first is in the search, where there is one
        path.write_bytes(kept[0][:place])
        assert_same(simulated(joint, partial=path, resume=True, **words), whole)


def test_the_file_has_the_whole_path(tmp_path, case):
    (joint, words), path = case, tmp_path / "history.npz"
    run = simulated(
        joint, partial=f"{path}.partial", save=lambda run: shakedown.save_history(path, run), **words
    )
    with np.load(path, allow_pickle=False) as file:
        assert {"cycle", "kind", "node", "v", "w", "q", "p", "state", "load_factor", "initial_slip"} <= set(
            file
        )
        for field in fields(run.history):
            if field.name != "reaction_curve":
                np.testing.assert_array_equal(file[field.name], getattr(run.history, field.name))
        assert "reaction_curve" not in file
        assert path.stat().st_size < 0.6 * sum(file[name].nbytes for name in file)
    assert [entry.name for entry in tmp_path.iterdir()] == ["history.npz"]


MOTIONS = {
    "fixed": (PLANE, FixedSteps),
    "implicit": (SPACE, FixedSteps),
    "plane": (PLANE, Evolution),
    "space": (SPACE, Evolution),
    "many-open": (random_joint(np.random.default_rng(6), 12, pressure=0.7), Evolution),
}


@pytest.mark.parametrize("kind", MOTIONS)
def test_a_motion_goes_on_where_another_stood(kind):
    joint, method = MOTIONS[kind]
    one, other = method(joint, 1.5), method(joint, 1.5)
    for _ in range(3):
        one.cycle()
    other.restore(restored(stored(one.checkpoint(), joint), joint))
    if hasattr(one, "last"):
        assert other.last(2)[0] == one.last(2)[0]
        np.testing.assert_array_equal(other.last(2)[1], one.last(2)[1])
    assert (
        restored(stored(folded([one.cycle()]), joint), joint).columns[1][0].tobytes()
        == other.cycle().slip.tobytes()
    )
    assert one.state.u.tobytes() == other.state.u.tobytes()
    assert one.done == other.done == 4


def test_damage_costs_no_more_than_what_it_hits(tmp_path):
    (joint, words), path, kept = CASES["newton"], tmp_path / "history.npz.partial", []
    whole = simulated(joint, partial=path, save=lambda _: kept.append(bytearray(path.read_bytes())), **words)
    for place in np.random.default_rng(3).integers(kept[0].index(b"\x93piece"), len(kept[0]), 2):
        kept[0][place] ^= 1
        path.write_bytes(kept[0])
        assert_same(simulated(joint, partial=path, resume=True, **words), whole)


def test_what_is_recorded_is_not_followed_again(tmp_path, monkeypatch, case):
    (joint, words), path = case, tmp_path / "history.npz.partial"

    def disk_is_full(_):
        raise shakedown.UsageError("cannot be written")

    with pytest.raises(shakedown.UsageError, match="cannot be written"):
        simulated(joint, partial=path, save=disk_is_full, **words)
    followed = []

    def counted(motion, most, **other):
        followed.append(most)
        return iter(())

    monkeypatch.setattr("shakedown.long_term.recorded_walk.cycles_of", counted)
    simulated(joint, partial=path, resume=True, **words)
    assert len(followed) <= 1
    assert sum(followed) <= 2  # the last cycle is not recorded by itself, nor one in which the motion stops


def test_a_simulation_asked_otherwise_is_refused(tmp_path):
    path = tmp_path / "history.npz.partial"
    with pytest.raises(shakedown.UsageError, match="full"):
        simulated(SPACE, partial=path, save=lambda _: (_ for _ in ()).throw(shakedown.UsageError("full")))
    with pytest.raises(shakedown.UsageError, match="unfinished run is recorded there; resume it, or remove"):
        simulated(SPACE, partial=path)
    with pytest.raises(shakedown.UsageError, match="recorded with method = 'event', not 'newton'"):
        simulated(SPACE, partial=path, resume=True, method="newton")
    with pytest.raises(shakedown.UsageError, match="recorded with initial_slip"):
        shakedown.simulate(SPACE, 0.7, cycles=8, record=True, partial=path, resume=True)
