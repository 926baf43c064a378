"""Campaigns: whoever does the work, and however often it is interrupted, the result is the same."""

import multiprocessing
import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import campaign_works
import numpy as np
import pytest
from campaign_works import Deadly, Squares, mistaken, squares

from shakedown.campaign.crew import Crew
from shakedown.campaign.journal import journal_at
from shakedown.campaign.pieces import run_campaign
from shakedown.files.examples import example
from shakedown.ground.blas_threads import all_cores
from shakedown.ground.errors import SolverError, UsageError

HEADER = {"what": "squares"}
WORKS = Path(campaign_works.__file__)


def started(path, *arguments):
    words = [sys.executable, WORKS, path, *map(str, arguments)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.parametrize("workers", [1, 2])
def test_every_piece_is_done_once_and_read_in_order(workers):
    calls = []
    with journal_at(None, HEADER) as journal:
        crew = Crew(workers=workers)
        run_campaign(Squares(), 7, journal, crew, progress=lambda done, of: calls.append((done, of)))
        assert squares(journal).tolist() == [k**2 for k in range(70)]
    assert calls == [(done, 7) for done in range(8)]


def test_what_is_recorded_is_not_done_again(tmp_path):
    path = tmp_path / "map.npz.partial"
    with journal_at(path, HEADER) as journal:
        run_campaign(Squares(), 3, journal)
    with journal_at(path, HEADER, resume=True) as journal:
        asked = []
        run_campaign(lambda number: asked.append(number) or Squares()(number), 6, journal)
        assert asked == [3, 4, 5]
        assert squares(journal).tolist() == [k**2 for k in range(60)]
        journal.remove()
    assert not list(tmp_path.iterdir())


def test_a_run_killed_at_random_instants_ends_as_an_undisturbed_one(tmp_path):
    path, generator, counts = tmp_path / "journal", np.random.default_rng(0), [0]
    while counts[-1] < 12 and len(counts) < 30:
        run = started(path, 12, 1, 0.05)
        assert run.stdout.readline() == "begun\n"
        time.sleep(generator.uniform(0.05, 0.3))
        run.kill()
        run.communicate()
        with journal_at(path, HEADER, resume=True) as journal:
            counts.append(len(journal.done()))
    assert counts == sorted(counts)
    assert len(set(counts)) >= 3
    run = started(path, 12, 1, 0.0)
    assert run.communicate(timeout=60) == (f"begun\n{sum(k**2 for k in range(120))}\n", "")


def test_a_killed_process_of_the_pool_costs_its_pieces_only():
    with journal_at(None, HEADER) as journal:
        killed = []

        def kill_one(done, _):
            if done == 2 and not killed:
                killed.append(multiprocessing.active_children()[0].pid)
                os.kill(killed[0], signal.SIGKILL)

        run_campaign(Squares(0.02), 8, journal, Crew(workers=2), progress=kill_one)
        assert killed
        assert squares(journal).tolist() == [k**2 for k in range(80)]


def test_work_that_kills_its_workers_is_given_up_in_words():
    with journal_at(None, HEADER) as journal, pytest.raises(SolverError, match="3 workers died one after"):
        run_campaign(Deadly(), 3, journal, Crew(workers=2))


UNGUARDED = """
import sys
from campaign_works import Crew, Squares, journal_at, run_campaign
crew = Crew(workers=2)
with journal_at(sys.argv[1], {}) as journal:
    run_campaign(Squares(weight=bytes(1 << 17)), 3, journal, crew)
"""


def test_a_script_without_a_guard_ends_with_a_line_that_names_it(tmp_path):
    """Its workers end while they start; what a pipe does not hold, 64 KiB, must not wait for them to read it."""
    (tmp_path / "script.py").write_text(UNGUARDED)
    words = [sys.executable, "script.py", "journal"]
    path = {"PYTHONPATH": str(WORKS.parent)}
    run = subprocess.run(
        words, cwd=tmp_path, env=os.environ | path, capture_output=True, text=True, timeout=60
    )
    assert run.stderr.count("Traceback") == 1
    assert 'a script has to keep what it does under if __name__ == "__main__":' in run.stderr.splitlines()[-1]
    assert [file.name for file in tmp_path.iterdir()] == ["script.py"]


def test_the_workers_of_a_killed_run_go_with_it(tmp_path):
    run = started(tmp_path / "journal", 100, 2, 0.3)
    children = Path(f"/proc/{run.pid}/task/{run.pid}/children")
    if not children.exists():
        run.kill()
        run.communicate()
        pytest.skip("needs /proc")
    deadline = time.monotonic() + 30
    while len(workers := children.read_text().split()) < 3 and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(0.5)
    run.kill()
    run.communicate()
    while any(Path(f"/proc/{pid}").exists() for pid in workers) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not [pid for pid in workers if Path(f"/proc/{pid}").exists()]


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_in_the_work_comes_through(workers):
    with journal_at(None, HEADER) as journal, pytest.raises(ValueError, match="piece 0"):
        run_campaign(mistaken, 1, journal, Crew(workers=workers))


def test_another_run_is_not_mixed_in(tmp_path):
    path = tmp_path / "journal"
    with journal_at(path, HEADER | {"seed": "0"}) as journal:
        run_campaign(Squares(), 1, journal)
        with pytest.raises(UsageError, match="another run is writing it"):
            journal_at(path, HEADER, resume=True).__enter__()
    with pytest.raises(UsageError, match="unfinished run is recorded there; resume it, or remove"):
        journal_at(path, HEADER).__enter__()
    with pytest.raises(UsageError, match="found it recorded with seed = 0, not 1"):
        journal_at(path, HEADER | {"seed": "1"}, resume=True).__enter__()


@pytest.mark.parametrize("content", [b"something else entirely" * 100, "database"])
def test_other_peoples_files_are_left_alone(tmp_path, content):
    path = tmp_path / "file"
    if content == "database":
        with sqlite3.connect(path) as connection:
            connection.execute("CREATE TABLE theirs (a)")
        connection.close()
    else:
        path.write_bytes(content)
    before = path.read_bytes()
    with pytest.raises(UsageError, match="found another"):
        journal_at(path, HEADER, resume=True).__enter__()
    assert path.read_bytes() == before


def test_a_journal_that_cannot_be_written_is_said_in_one_line(tmp_path):
    with pytest.raises(UsageError, match="cannot be written"):
        journal_at(tmp_path / "missing" / "journal", HEADER).__enter__()


@pytest.mark.parametrize(("words", "said"), [({"workers": 0}, "at least 1"), ({"scheduler": ""}, "address")])
def test_a_crew_has_to_exist(words, said):
    with pytest.raises(UsageError, match=said):
        Crew(**words)


def test_the_fingerprint_tells_problems_apart():
    joints = [example(name) for name in ("two-node", "uncoupled", "three-node", "jump")]
    assert len({joint.fingerprint for joint in joints}) == 4
    assert 1 <= all_cores() <= os.cpu_count()
