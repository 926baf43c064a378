"""The same on a dask cluster of this machine; workers may die."""

import os
import signal
import sys

import pytest
from campaign_works import Squares, squares

from shakedown.campaign.crew import Crew
from shakedown.campaign.journal import journal_at
from shakedown.campaign.pieces import run_campaign
from shakedown.ground.errors import UsageError

HEADER = {"what": "squares"}


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50
    ) as cluster:
        yield cluster


def test_a_killed_worker_costs_its_pieces_only(cluster):
    killed = []

    def kill_one(done, _):
        if done == 2 and not killed:
            killed.append(next(iter(cluster.workers.values())).process.pid)
            os.kill(killed[0], signal.SIGKILL)

    with journal_at(None, HEADER) as journal:
        run_campaign(Squares(0.02), 10, journal, Crew(scheduler=cluster.scheduler_address), progress=kill_one)
        assert killed
        assert squares(journal).tolist() == [k**2 for k in range(100)]


def test_nobody_there_is_said_in_one_line(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("shakedown.campaign.cluster.PATIENCE", 0.5)
    with journal_at(None, HEADER) as journal, pytest.raises(UsageError, match="dask scheduler at tcp://127"):
        run_campaign(Squares(), 1, journal, Crew(scheduler="tcp://127.0.0.1:9"))


def test_without_dask_there_is_a_clear_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with journal_at(None, HEADER) as journal, pytest.raises(UsageError, match=r"shakedown-bounds\[cluster\]"):
        run_campaign(Squares(), 1, journal, Crew(scheduler="tcp://127.0.0.1:9"))
