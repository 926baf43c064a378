"""The same on a dask cluster of this machine; workers may die."""

import inspect
import os
import signal
import sys

import pytest
from campaign_works import Squares, squares

from shakedown.campaign import worker_versions
from shakedown.campaign.crew import Crew
from shakedown.campaign.journal import journal_at
from shakedown.campaign.pieces import run_campaign
from shakedown.ground.errors import SolverError, UsageError

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


@pytest.mark.parametrize("name", ["the code of shakedown", "numpy"])
def test_workers_of_another_version_are_sent_nothing(cluster, monkeypatch, name):
    known = worker_versions.versions() | {name: "7.7"}
    monkeypatch.setattr(worker_versions, "versions", lambda: known)
    done, crew = [], Crew(scheduler=cluster.scheduler_address)
    said = rf"found at tcp://\S+ {name} \S+ for 7\.7$"
    with journal_at(None, HEADER) as journal, pytest.raises(UsageError, match=said):
        run_campaign(Squares(), 3, journal, crew, lambda *at: done.append(at))
    assert done == [(0, 3)]


def test_what_is_asked_needs_nothing_of_the_package():
    namespace = {"__name__": "worker_versions"}
    exec(inspect.getsource(worker_versions), namespace)
    namespace["find_spec"], namespace["version"] = lambda _: None, lambda name: f"{name} of a worker"
    assert namespace["versions"]()["the code of shakedown"] == "none"
    assert namespace["versions"]()["numpy"] == "numpy of a worker"


def test_a_scheduler_that_is_lost_is_one_line_and_the_record_stays(tmp_path):
    distributed = pytest.importorskip("distributed")
    options = {"processes": False, "dashboard_address": ":0", "silence_logs": 50, "n_workers": 1}
    with distributed.LocalCluster(**options, protocol="tcp") as lost:
        crew = Crew(scheduler=lost.scheduler_address)

        def lose(done, _):
            if done == 1:
                lost.close()

        with (
            pytest.raises(SolverError, match="was lost in the middle of the work"),
            journal_at(tmp_path / "record", HEADER) as journal,
        ):
            run_campaign(Squares(0.01), 50, journal, crew, lose)
    with journal_at(tmp_path / "record", HEADER, resume=True) as journal:
        assert len(journal.done()) >= 1


def test_nobody_there_is_said_in_one_line(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("shakedown.campaign.cluster.PATIENCE", 0.5)
    with journal_at(None, HEADER) as journal, pytest.raises(UsageError, match="dask scheduler at tcp://127"):
        run_campaign(Squares(), 1, journal, Crew(scheduler="tcp://127.0.0.1:9"))


def test_without_dask_there_is_a_clear_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with journal_at(None, HEADER) as journal, pytest.raises(UsageError, match=r"shakedown-bounds\[cluster\]"):
        run_campaign(Squares(), 1, journal, Crew(scheduler="tcp://127.0.0.1:9"))
