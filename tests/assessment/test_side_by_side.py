"""Pieces of work in threads: in order of urgency, none before a result is asked for, errors where asked for."""

from threading import Event

import pytest

from shakedown.assessment.recorded_work import SideBySide


def test_with_one_thread_each_piece_is_done_when_it_is_asked_for():
    done = []
    with SideBySide(1) as work:
        ends = [work.add(lambda number=number: done.append(number)) for number in range(3)]
        assert done == []
        ends[2]()
        ends[0]()
    assert done == [2, 0]


def test_the_most_urgent_piece_comes_first():
    done, ready = [], Event()
    with SideBySide(2) as work:
        alone = [work.add(ready.wait), work.add(ready.wait)]  # both threads are busy until all are there
        ends = [work.add(lambda k=k: done.append(k), urgency) for k, urgency in enumerate((3, 2, 1, 2))]
        ready.set()
        for end in alone + ends:
            end()
    assert done.index(0) >= 2  # one of two threads may have been quicker


def test_what_is_recorded_already_is_not_begun_again():
    """Who asks first for a later piece has the earlier ones; one asked for after all is done after all."""
    done = []
    with SideBySide(2) as work:
        ends = [work.add(lambda k=k: done.append(k) or k) for k in range(4)]
        assert [ends[k]() for k in (2, 3)] == [2, 3]
        assert sorted(done) == [2, 3]
        assert ends[0]() == 0
        assert work.add(lambda: 5)() == 5
    assert 1 not in done


def test_an_error_is_raised_where_the_result_is_asked_for():
    with SideBySide(2) as work:
        bad, good = work.add(lambda: 1 // 0), work.add(lambda: "good")
        assert good() == "good"
        with pytest.raises(ZeroDivisionError):
            bad()
        assert work.add(lambda: "later")() == "later"


def test_when_it_ends_nothing_more_begins():
    go, late = Event(), Event()
    with SideBySide(2) as work:
        first = work.add(lambda: 1)
        for _ in range(2):
            work.add(go.wait)
        work.add(late.set, 5)
        assert first() == 1
    go.set()
    assert not late.wait(0.05)
