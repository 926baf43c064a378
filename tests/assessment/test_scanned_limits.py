"""Scanned limits, bisected from the state asked about: up to where a joint shakes down, or slips less than a length."""

from bisect import bisect_left
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from joints import any_joint

import shakedown
from shakedown import Problem
from shakedown.assessment import transient_limit as transient_module
from shakedown.assessment.transient_limit import BELOW, History, scanned_limit, slip_limit
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT

TWO = shakedown.example("two-node")


@pytest.mark.parametrize(("name", "below"), [("two-node", 0.1), ("press-fit", 1e-3), ("block-9", 1e-5)])
def test_slips_are_below_it_up_to_there_and_not_next_to_it(name, below):
    problem = shakedown.example(name)
    limit = slip_limit(problem, below)
    here, beyond = (
        shakedown.simulate(problem, x, slip_below=below) for x in (limit.load_factor, limit.exceeded_at)
    )
    assert here.slip_criterion.met
    assert here.slip_criterion.largest == limit.largest
    assert not beyond.slip_criterion.met
    assert beyond.load_factor - here.load_factor <= 1.1e-4 * limit.scanned[-1]
    met = limit.slip_range < below
    assert met[limit.scanned <= limit.load_factor].all()
    assert limit.monotone == (not met[limit.scanned > limit.load_factor].any())


def test_one_node_in_closed_form():
    """q = λ sin t + v, |q| ≤ f p = 1/2: the slip range is 2 λ − 1 beyond λ = 1/2, below 0.3 up to 0.65."""
    problem = Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_w=[[1.0], [-1.0]], p_w=[[1.0], [1.0]])
    limit = slip_limit(problem, 0.3, accuracy=1e-9)
    assert limit.load_factor == pytest.approx(0.65, rel=1e-8)
    assert limit.largest == pytest.approx(0.3, rel=1e-8)
    assert limit.slip_range == pytest.approx(np.maximum(2 * limit.scanned - 1, 0.0), abs=1e-12)


def test_slips_need_not_grow_with_the_load():
    joint = any_joint(np.random.default_rng(121))
    limit = slip_limit(joint, 0.05, largest=4.0, steps=20, accuracy=0.01)
    assert not limit.monotone
    met = limit.slip_range < 0.05
    assert met[limit.scanned < limit.exceeded_at].all()
    assert met[limit.scanned > limit.exceeded_at].any()
    assert limit.load_factor == limit.scanned[limit.scanned < limit.exceeded_at].max()


def test_a_joint_that_never_slips_has_no_end():
    quiet = Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_w=[[0.0], [0.0]], p_w=[[2.0], [2.0]])
    limit = slip_limit(quiet, 1e-6)
    assert (limit.exceeded_at, limit.largest) == (np.inf, 0.0)
    assert limit.load_factor == limit.scanned[-1] == 1024.0


@pytest.mark.parametrize("limit", [shakedown.transient_limit, partial(slip_limit, slip_below=1e-5)])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"largest": -1.0}, "largest: expected a positive load factor"),
        ({"accuracy": 0.0}, "accuracy: expected a number between 0 and 1"),
        ({"accuracy": 1.0}, "accuracy: expected a number between 0 and 1"),
        ({"steps": 0}, "steps: expected"),
    ],
)
def test_arguments_out_of_range_are_refused(limit, arguments, message):
    with pytest.raises(shakedown.UsageError, match=message):
        limit(TWO, **arguments)


def test_without_a_length_or_an_end_there_is_no_scan():
    with pytest.raises(shakedown.UsageError, match="slip_below: expected a positive length"):
        slip_limit(TWO, 0.0)
    with pytest.raises(shakedown.UsageError, match="largest: expected a load factor, as λ_max is not finite"):
        shakedown.transient_limit(shakedown.example("one-node-separation"))


def test_transient_limit_is_where_gauss_seidel_changes_its_mind():
    limit = shakedown.transient_limit(TWO, accuracy=1e-6)
    assert limit.high - limit.low <= 2e-6
    assert limit.at_low.outcome == "shakedown"
    assert limit.at_high.outcome == "cyclic-slip"
    for share, outcome in ((0.999, "shakedown"), (1.001, "cyclic-slip")):
        assert shakedown.simulate(TWO, share * limit.load_factor, method="gauss-seidel").outcome == outcome


def test_above_everything_that_is_scanned_the_transient_limit_is_open():
    far = shakedown.transient_limit(TWO, largest=0.3, steps=3)
    assert (far.low, far.high) == (0.3, np.inf)


class Stated(History):
    """A history that shakes down below a load factor, is proved to up to another one, and else cycles or is open."""

    def followed(self, load_factor):
        outcome = Outcome.SHAKEDOWN if load_factor < self.change else self.beyond
        proved = load_factor <= self.until
        return SimpleNamespace(load_factor=load_factor, outcome=outcome, proved=proved, slides_away=False)


@pytest.mark.parametrize("name", ["two-node", "two-node-3d"])
@pytest.mark.parametrize("beyond", [Outcome.CYCLIC_SLIP, Outcome.UNDECIDED])
@pytest.mark.parametrize("long", [False, True])
@pytest.mark.parametrize("until", [0.99957, 0.5])
def test_the_change_is_enclosed_and_a_proof_is_found_as_near_as_there_is_one(
    monkeypatch, name, beyond, long, until
):
    """To the accuracy asked for; to a thousandth of the scan where motions in space are undecided above it."""
    problem, top, accuracy = shakedown.example(name), 2.0, 1e-6
    monkeypatch.setattr(transient_module, "takes_long", lambda _: long)
    for change in np.random.default_rng(0).uniform(0.1, 1.9, 20):
        monkeypatch.setattr(transient_module, "_certain", lambda *_, at=0.9 * change: [at] * (until > 0.9))
        history = Stated(problem, np.zeros(2), (), DEFAULT)
        vars(history).update(change=change, until=until * change, beyond=beyond)
        found = scanned_limit(history, top, 6, accuracy)
        coarse = beyond == Outcome.UNDECIDED and problem.directions == 2
        assert found.low < change <= found.high
        width = top * (1e-3 if coarse else accuracy)
        assert (0.0 if long else 0.49) * width < found.high - found.low <= width
        if until > 0.9:  # in space the two shares next to it are bisected
            least = max(1.0 - until * change / found.low, 0.0)
            at = bisect_left(BELOW, least)
            apart = (0.3 if problem.directions == 2 else 1.0) * (BELOW[at] - BELOW[max(at - 1, 0)])
            assert least - 1e-12 <= 1.0 - found.proved / found.low <= min(BELOW[at], least + apart) + 1e-12
        assert np.isnan(found.proved) == (until == 0.5)
        assert found.monotone
        assert found.cycling == (np.inf if beyond == Outcome.UNDECIDED else found.high)
        assert len(found.scanned) < 60
