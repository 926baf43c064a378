"""Why states are undecided, and whether more cycles could decide them."""

from joints import sliding

import shakedown

JOINT = shakedown.example("two-node")


def test_gross_slip_is_said_and_more_cycles_cannot_help():
    problem = sliding()
    found = shakedown.initial_state_map(problem, 1.0, states=16)
    assert found.undecided == 16
    (reason,) = found.undecided_reasons
    alone = shakedown.long_term_state(problem, 1.0, found.initial_slip[reason.example])
    assert reason.reason == "the body slides away: friction and stiffness do not hold it"
    what, _, why = reason.reason.partition(":")
    assert alone.reason.startswith(what)
    assert alone.reason.endswith(why)
    assert "at time" in alone.reason
    assert not reason.more_cycles
    assert reason.count == 8
    assert found.unique is None
    assert "no state is decided" in found.evidence
    assert found.to_dict()["undecided_reasons"][0]["reason"] == reason.reason


def test_where_cycles_ran_out_more_may_help():
    found = shakedown.initial_state_map(JOINT, 0.7, states=16, max_cycles=1)
    assert found.undecided
    assert any(reason.more_cycles for reason in found.undecided_reasons)
    counts = [reason.count for reason in found.undecided_reasons]
    assert counts == sorted(counts, reverse=True)
    assert sum(counts) == min(found.undecided, 8)
