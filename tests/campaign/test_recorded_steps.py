"""Steps that follow from each other: each is done once, whenever the run is stopped and whatever is damaged."""

import pickle
import signal
import subprocess
import sys
import time
from fractions import Fraction

import numpy as np
import pytest

import shakedown
from shakedown.campaign import recorded_steps as module
from shakedown.campaign.journal import journal_at
from shakedown.campaign.recorded_steps import recorded_steps
from shakedown.campaign.stored_result import packed, restored, stored
from shakedown.ground.errors import ProblemError, UsageError

JOINT = shakedown.example("two-node")
HEADER = {"run": "walk"}


class Killed(BaseException):
    """What ends a run from outside."""


@pytest.fixture(autouse=True)
def every_step_alone(monkeypatch):
    monkeypatch.setattr(module, "EVERY", 0.0)
    monkeypatch.setattr(module.os, "fsync", lambda _: None)


def walked(path, most=10**9, resume=True):
    """A walk of three times two steps, each of which follows from the one before, and the steps done now."""
    done = []

    def step(x):
        if len(done) == most:
            raise Killed
        done.append(x)
        return np.sqrt(x + 1.0)

    def stretch(x):
        for _ in range(2):
            x = steps.done(lambda x=x: step(x))
        return x

    with recorded_steps(path, HEADER, JOINT, resume=resume) as steps:
        x = 0.5
        for _ in range(3):
            x = steps.done(lambda x=x: stretch(x))
        steps.record()
        kept = b"" if path is None else path.read_bytes()
        steps.remove()
    return x, len(done), kept


def test_killed_after_every_step_it_ends_as_an_undisturbed_one(tmp_path):
    path, whole = tmp_path / "walk.partial", walked(None)[0]
    for _ in range(5):
        with pytest.raises(Killed):
            walked(path, most=1)
    assert walked(path)[:2] == (whole, 1)
    assert not list(tmp_path.iterdir())


SLOW_WALK = """
import sys, time
import shakedown
from shakedown.campaign import recorded_steps as module

module.EVERY = 0.0
joint, x = shakedown.example("two-node"), 0.5
with module.recorded_steps(sys.argv[1], {"run": "walk"}, joint, resume=True) as steps:
    while True:
        x = steps.done(lambda: (time.sleep(0.01), 0.5 * x + 1.0)[1])
"""


def test_a_process_that_is_killed_leaves_what_it_had_done(tmp_path):
    path = tmp_path / "walk.partial"
    process = subprocess.Popen([sys.executable, "-c", SLOW_WALK, path])
    while process.poll() is None and not (path.exists() and path.stat().st_size > 4000):
        time.sleep(0.01)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    done, x = [], 0.5
    with recorded_steps(path, HEADER, JOINT, resume=True) as steps:
        for number in range(1000):
            x = steps.done(lambda x=x, number=number: done.append(number) or 0.5 * x + 1.0)
            if done:
                break
    assert 1 < done[0] < 900
    assert x == 2.0 - 1.5 * 0.5 ** (done[0] + 1)


def test_cut_off_or_altered_anywhere_it_ends_so_too(tmp_path):
    path = tmp_path / "walk.partial"
    whole, _, kept = walked(path)
    generator = np.random.default_rng(0)
    for place in generator.integers(kept.index(b"\x93piece"), len(kept), 25):
        path.write_bytes(kept[:place])
        assert walked(path)[0] == whole
        altered = bytearray(kept)
        altered[place] ^= 1 << place % 8
        path.write_bytes(altered)
        again, done, _ = walked(path)
        assert again == whole
        assert done <= 2, place


def test_records_that_hold_something_else_are_done_again(tmp_path):
    path, whole = tmp_path / "walk.partial", walked(None)[0]
    evil = pickle.dumps(print)
    others = [b"", b"no archive", packed({"names": np.array(["0"])})]
    for content in (evil, evil[:-3], b"\x80\x05."):
        size, results = np.array([len(content)]), np.frombuffer(content, dtype=np.uint8)
        others.append(packed({"names": np.array(["0"]), "ends": size, "results": results}))
    for other in others:
        with journal_at(path, HEADER, resume=True) as journal:
            journal.add(0, other)
        assert walked(path)[:2] == (whole, 6)


def test_what_is_within_a_step_goes_with_it(tmp_path):
    path = tmp_path / "walk.partial"
    with journal_at(path, HEADER) as journal:
        steps = module.RecordedSteps(JOINT, journal)
        steps.done(lambda: [steps.done(float) for _ in range(5)])
        assert len(journal.done()) == 1
        steps.done(lambda: [steps.done(float) for _ in range(3)])
        assert len(journal.done()) == 2


def test_another_run_is_refused_in_one_line(tmp_path):
    path = tmp_path / "walk.partial"
    with pytest.raises(Killed):
        walked(path, most=1)
    before = path.read_bytes()
    with pytest.raises(UsageError, match="resume it, or remove that file"):
        walked(path, resume=False)
    with pytest.raises(UsageError, match="found it recorded with run = walk, not run"):
        recorded_steps(path, {"run": "run"}, JOINT, resume=True).__enter__()
    assert path.read_bytes() == before


def test_where_a_step_stands_takes_the_place_of_where_it_stood(tmp_path, monkeypatch):
    for name, value in {"EVERY": 0.0, "LEISURE": 0.0, "SIZE": np.inf, "WASTE": 3000}.items():
        monkeypatch.setattr(module, name, value)
    path, sizes = tmp_path / "walk.partial", []

    def long_step(most):
        progress = steps.progress()
        for stood in range(0 if progress.found is None else progress.found[0], most):
            progress.note(lambda stood=stood: (stood + 1, np.full(100, float(stood))))
            sizes.append(path.stat().st_size)
        return progress.found

    with recorded_steps(path, HEADER, JOINT) as steps:
        first = steps.done(lambda: "first")
        with pytest.raises(Killed):
            steps.done(lambda: long_step(20) or (_ for _ in ()).throw(Killed))
    assert len(sizes) == 20
    assert 2000 < max(sizes) < 12_000
    with recorded_steps(path, HEADER, JOINT, resume=True) as steps:
        with pytest.raises(UsageError, match="another run is writing it"):
            recorded_steps(path, HEADER, JOINT, resume=True).__enter__()
        assert steps.done(lambda: None) == first
        count, state = steps.done(lambda: long_step(20))
        assert (count, state.tolist()) == (20, [19.0] * 100)
        steps.remove()
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_done_leaves_nothing_to_go_on_with(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "EVERY", 1e9)

    def tried(error):
        with recorded_steps(tmp_path / "walk.partial", HEADER, JOINT) as steps:
            steps.done(lambda: 3)
            raise error("no such method")

    for error, left in ((UsageError, 0), (Killed, 1)):
        with pytest.raises(error):
            tried(error)
        assert len(list(tmp_path.iterdir())) == left


def test_a_result_comes_back_as_it_was():
    run = shakedown.simulate(JOINT, 0.9, [0.3, -0.0], cycles=20, record=True)
    columns = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    things = [
        run,
        columns,
        np.float64(np.pi),
        Fraction(1, 3),
        None,
        {"a": (1, -0.0)},
        shakedown.Outcome.SHAKEDOWN,
    ]
    again = restored(stored(things, JOINT), JOINT)
    assert again[0] == run
    assert again[0].problem is JOINT
    assert again[0].to_dict() == run.to_dict()
    assert again[1].flags.f_contiguous
    assert not again[1].flags.c_contiguous
    assert str(again[2:]) == str(things[2:])


def test_members_of_enumerations_come_back_however_this_python_pickles_them(monkeypatch):
    by_name = lambda member, _: (getattr, (type(member), member.name))  # noqa: E731  # as Python 3.11.2 does
    monkeypatch.setattr(shakedown.Outcome, "__reduce_ex__", by_name)
    found = restored(stored({shakedown.Outcome.SHAKEDOWN: shakedown.Status.OPTIMAL}, JOINT), JOINT)
    ((outcome, status),) = found.items()
    assert outcome is shakedown.Outcome.SHAKEDOWN
    assert status is shakedown.Status.OPTIMAL


@pytest.mark.parametrize(
    "called", [print, pickle.loads, np.save, shakedown.save_problem, JOINT.fingerprint.format]
)
def test_what_is_read_calls_nothing(called):
    for content in (pickle.dumps(called), b"cos\nsystem\n(S'true'\ntR."):
        with pytest.raises(ProblemError, match="damaged"):
            restored(content, JOINT)
