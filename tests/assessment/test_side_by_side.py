"""Pieces of work of a verification beside each other: the same answers, errors where they are asked for."""

from threading import Event

import pytest

import shakedown
from shakedown import Problem
from shakedown.assessment import verify as module
from shakedown.assessment.verify import side_by_side

SPACE = Problem(A=[[2, 0], [0, 2]], B=[[0, 0]], f=0.4, q_w=[[0.4, 0], [0.4, 1]], p_w=[[1], [1]])


def test_with_one_thread_each_piece_is_done_when_it_is_asked_for() -> None:
    done: list[int] = []
    with side_by_side(1) as begin:
        ends = [begin(lambda number=number: done.append(number)) for number in range(3)]
        assert done == []
        ends[2]()
        ends[0]()
    assert done == [2, 0]


def test_an_error_is_raised_where_the_result_is_asked_for() -> None:
    with side_by_side(2) as begin:
        bad, good = begin(lambda: 1 // 0), begin(lambda: "good")
        assert good() == "good"
        with pytest.raises(ZeroDivisionError):
            bad()
        assert begin(lambda: "later")() == "later"


def test_when_it_ends_nothing_more_begins() -> None:
    go, late = Event(), Event()
    with side_by_side(2) as begin:
        for _ in range(2):
            begin(go.wait)
        begin(late.set)
    go.set()
    assert not late.wait(0.05)


@pytest.mark.usefixtures("no_transient_limit")
def test_two_threads_find_what_one_does(monkeypatch: pytest.MonkeyPatch) -> None:
    def found() -> dict:
        document = shakedown.verify(SPACE, load_factors=[0.3], random_states=2).to_dict()
        for run in document["runs"]:
            del run["seconds"]
        return document

    alone = found()
    monkeypatch.setattr(module, "takes_long", lambda problem: True)
    monkeypatch.setattr(module, "all_cores", lambda: 2)
    assert found() == alone
