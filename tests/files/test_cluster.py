"""The same on a dask cluster of this machine; workers may die."""

import os
import signal
import sys
from importlib import import_module

import pytest
from pieces_works import Deadly, Squares, done, squares

from shakedown.files import pieces as module
from shakedown.files.pieces import cluster_executor, run_pieces
from shakedown.ground import code_cache
from shakedown.ground.errors import SolverError, UsageError

pytestmark = pytest.mark.slow


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

    with (
        cluster_executor(cluster.scheduler_address) as executor,
        run_pieces(Squares(0.02), 10, executor=executor, progress=kill_one) as pieces,
    ):
        assert killed
        assert squares(pieces).tolist() == [k**2 for k in range(100)]


def test_the_executor_of_a_client_of_ones_own(cluster):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.Client(cluster.scheduler_address, set_as_default=False) as client,
        run_pieces(Squares(), 10, executor=client.get_executor()) as pieces,
    ):
        assert squares(pieces).tolist() == [k**2 for k in range(100)]


def opened(address):
    with cluster_executor(address):
        raise AssertionError("it is sent work")


@pytest.fixture
def another_version(monkeypatch):
    """Versions of this process other than those of the workers."""
    monkeypatch.setattr(code_cache, "hash_of_sources", lambda _: "7.7")
    monkeypatch.setattr(module, "version", {"shakedown-bounds": "0", "numpy": "1"}.get)
    module.versions.cache_clear()
    yield
    module.versions.cache_clear()


@pytest.mark.usefixtures("another_version")
def test_workers_of_another_version_are_sent_nothing(cluster):
    said = (
        r"workers with \{'the code of shakedown': '7\.7', 'shakedown-bounds': '0', .* found at tcp://\S+ \{"
    )
    with pytest.raises(UsageError, match=said):
        opened(cluster.scheduler_address)


def test_workers_without_the_package_are_named(cluster, tmp_path, monkeypatch):
    """What asks for the versions stands in a module that only this process has, as the package may."""
    (tmp_path / "only_here.py").write_text("def versions():\n    return {}\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(module, "versions", import_module("only_here").versions)
    with pytest.raises(UsageError, match=r"found at tcp://\S+ .*ModuleNotFoundError"):
        opened(cluster.scheduler_address)


def test_a_scheduler_that_is_lost_is_one_line_and_what_is_done_stays(tmp_path):
    distributed = pytest.importorskip("distributed")
    options = {"processes": False, "dashboard_address": ":0", "silence_logs": 50, "n_workers": 1}
    with distributed.LocalCluster(**options, protocol="tcp") as lost:

        def lose(done, _):
            if done == 1:
                lost.close()

        with (
            pytest.raises(SolverError, match="was lost in the middle of the work"),
            cluster_executor(lost.scheduler_address) as executor,
            run_pieces(Squares(0.01), 50, output=tmp_path / "map.npz", executor=executor, progress=lose),
        ):
            pass
    assert len(done(tmp_path / "map.npz")) >= 1


def test_work_that_kills_its_workers_is_given_up_in_words(cluster, monkeypatch):
    monkeypatch.setattr(cluster.scheduler, "allowed_failures", 0)  # times that dask tries it again
    with (
        pytest.raises(SolverError, match="workers died one after the other"),
        cluster_executor(cluster.scheduler_address) as executor,
        run_pieces(Deadly(), 3, executor=executor),
    ):
        pass


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense"])
def test_nobody_there_is_said_in_one_line(monkeypatch, address):
    pytest.importorskip("distributed")
    monkeypatch.setattr(module, "TIMEOUT", 0.5)
    with pytest.raises(UsageError, match=f"dask scheduler at {address}"):
        opened(address)


def test_without_dask_there_is_a_clear_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed.scheduler", None)
    with pytest.raises(UsageError, match=r"pip install .\.\[cluster\]"):
        opened("tcp://127.0.0.1:9")
