"""Pieces of work of a verification beside each other: the same answers, errors where they are asked for."""

import pytest

import shakedown
from shakedown import Problem
from shakedown.assessment import verify as module

SPACE = Problem(A=[[2, 0], [0, 2]], B=[[0, 0]], f=0.4, q_w=[[0.4, 0], [0.4, 1]], p_w=[[1], [1]])


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
