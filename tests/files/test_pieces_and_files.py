"""Pieces of work: whoever does, damages or interrupts them, the result is the same; every file: the old one or the new one, never half."""

import io
import os
import signal
import stat
import subprocess
import sys
import threading
import time
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pieces_works
import pytest
from hostile.damaged_npz import BYTES, HEADERS, npy, with_header
from pieces_works import Deadly, Mistaken, Squares, done, squares

import shakedown
from shakedown.files.atomic_write import atomic_write, atomic_write_together, check_target, write_csv
from shakedown.files.npz import example
from shakedown.files.pieces import read_arrays, run_pieces
from shakedown.ground.errors import ProblemError, SolverError, UsageError
from shakedown.ground.work_limit import all_cores

WORKS = Path(pieces_works.__file__)


class Stopped(Exception):
    """The run ends here."""


def started(path, *arguments):
    words = [sys.executable, WORKS, path, *map(str, arguments)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(**words):
    """Do three pieces and end after them."""
    with run_pieces(Squares(), 3, **words):
        raise Stopped


@pytest.fixture
def stopped(tmp_path):
    """The output of a run that ended when three pieces were done."""
    with pytest.raises(Stopped):
        ended(output=tmp_path / "map.npz")
    return tmp_path / "map.npz"


class Counting(ThreadPoolExecutor):
    """An executor of two threads that counts the pieces it was sent and has not begun."""

    most = 0

    def submit(self, *words):
        future = super().submit(*words)
        self.most = max(self.most, self._work_queue.qsize())
        return future


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("kept", [False, True])
def test_every_piece_is_done_once_and_read_in_order(tmp_path, workers, kept):
    calls, output = [], tmp_path / "map.npz" if kept else None
    progress = lambda *at: calls.append(at)  # noqa: E731
    with run_pieces(Squares(), 7, output=output, workers=workers, progress=progress) as pieces:
        assert squares(pieces).tolist() == [k**2 for k in range(70)]
        assert kept == bool(list(tmp_path.iterdir()))
    assert calls == [(number, 7) for number in range(8)]
    assert not list(tmp_path.iterdir())


def test_any_executor_does_the_work_a_few_pieces_at_a_time_and_goes_on_living():
    executor = Counting(2)
    with run_pieces(Squares(), 600, executor=executor) as pieces:
        assert squares(pieces).tolist() == [k**2 for k in range(6000)]
    assert executor.most <= 256
    assert executor.submit(int).result() == 0
    with ThreadPoolExecutor(3) as threads, run_pieces(Squares(0.001), 30, executor=threads) as pieces:
        assert squares(pieces).tolist() == [k**2 for k in range(300)]


def test_what_is_kept_is_not_done_again(stopped, caplog):
    calls = []
    with run_pieces(
        Squares(), 6, output=stopped, resume=True, progress=lambda *at: calls.append(at)
    ) as pieces:
        assert squares(pieces).tolist() == [k**2 for k in range(60)]
    assert calls == [(number, 6) for number in range(3, 7)]
    assert caplog.messages == [f"goes on from 3 of 6 pieces in {stopped}.parts"]
    assert not list(stopped.parent.iterdir())


@pytest.mark.slow
def test_a_run_killed_at_random_instants_ends_as_an_undisturbed_one(tmp_path):
    path, generator, counts = tmp_path / "map.npz", np.random.default_rng(0), [0]
    for _ in range(5):
        run = started(path, 40, 1, 0.05)
        assert run.stdout.readline() == "begun\n"
        time.sleep(generator.uniform(0.05, 0.3))
        run.kill()
        run.communicate()
        counts.append(len(done(path)))
    assert counts == sorted(counts)
    assert len(set(counts)) >= 3
    run = started(path, 40, 1, 0.0)
    out, err = run.communicate(timeout=60)
    assert out == f"begun\n{sum(k**2 for k in range(400))}\n"
    assert err == f"goes on from {counts[-1]} of 40 pieces in {path}.parts\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_work_that_kills_its_workers_is_given_up_in_words_and_what_is_done_stays(tmp_path):
    path = tmp_path / "map.npz"
    with (
        pytest.raises(SolverError, match=r"one died .*; what is done is kept"),
        run_pieces(Deadly(output=str(path)), 9, output=path, workers=2),
    ):
        pass
    kept = set(done(path))
    assert kept
    assert 2 not in kept


UNGUARDED = """
import sys
from pieces_works import Squares, run_pieces
with run_pieces(Squares(weight=bytes(1 << 17)), 3, output=sys.argv[1], workers=2):
    pass
"""


@pytest.mark.slow
def test_a_script_without_a_guard_ends_with_a_line_that_names_it(tmp_path):
    """Its workers end while they start; what a pipe does not hold, 64 KiB, must not wait for them to read it."""
    (tmp_path / "script.py").write_text(UNGUARDED)
    words = [sys.executable, "script.py", "map.npz"]
    env = os.environ | {"PYTHONPATH": str(WORKS.parent)}
    run = subprocess.run(words, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=60)
    assert run.stderr.count("Traceback") == 1
    assert 'a script has to keep what it does under if __name__ == "__main__":' in run.stderr.splitlines()[-1]
    assert [file.name for file in tmp_path.iterdir()] == ["script.py"]


def test_work_that_cannot_be_sent_is_one_line():
    local = type("Local", (Squares,), {})
    with pytest.raises(UsageError, match="functions that other processes can import"):
        run_pieces(local(), 3, workers=2).__enter__()


@pytest.mark.slow
def test_the_workers_of_a_killed_run_go_with_it(tmp_path):
    run = started(tmp_path / "map.npz", 100, 2, 0.3)
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
def test_an_error_in_the_work_comes_through_and_leaves_nothing(tmp_path, workers):
    with (
        pytest.raises(ValueError, match=r"piece [01]"),
        run_pieces(Mistaken(), 2, output=tmp_path / "map.npz", workers=workers),
    ):
        pass
    assert not list(tmp_path.iterdir())


def test_another_run_is_not_mixed_in(stopped, caplog):
    with pytest.raises(UsageError, match="unfinished run is kept there; resume it, or remove that folder"):
        ended(output=stopped)
    with run_pieces(Squares(), 3, settings="others", output=stopped, resume=True):
        assert done(stopped) == [0, 0, 1, 1, 2, 2]
        with pytest.raises(UsageError, match="another run is writing there"):
            ended(output=stopped, resume=True)
    assert caplog.messages == [f"goes on from 0 of 3 pieces in {stopped}.parts; 3 others there do not fit"]
    assert done(stopped) == [0, 1, 2]
    with run_pieces(Squares(), 3, output=stopped, resume=True):
        assert caplog.messages[1:] == [f"goes on from 3 of 3 pieces in {stopped}.parts"]
    assert not list(stopped.parent.iterdir())


def test_other_peoples_files_are_left_alone(tmp_path):
    for name in ("notes.txt", "0123456789abcdef-1.npy"):
        (tmp_path / "map.npz.parts").mkdir(exist_ok=True)
        (tmp_path / "map.npz.parts" / name).write_text("theirs")
    with run_pieces(Squares(), 3, output=tmp_path / "map.npz"):
        pass
    assert len(list((tmp_path / "map.npz.parts").iterdir())) == 2
    (tmp_path / "other.npz.parts").write_text("theirs")
    with pytest.raises(UsageError, match="cannot be written"):
        ended(output=tmp_path / "other.npz")
    assert (tmp_path / "other.npz.parts").read_text() == "theirs"


def test_a_full_disk_is_said_in_one_line_and_what_is_done_stays(stopped, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(UsageError, match=r"cannot be written \(No space left on device\)"):
        run_pieces(Squares(), 6, output=stopped, resume=True).__enter__()
    assert done(stopped) == [0, 1, 2]


def test_a_termination_while_workers_begin_ends_the_run(tmp_path):
    run = started(tmp_path / "map.npz", 100, 2, 0.3)
    assert run.stdout.readline() == "begun\n"
    run.send_signal(signal.SIGTERM)
    assert run.communicate(timeout=60)[0] == ""
    assert run.returncode == -signal.SIGTERM


def test_the_fingerprint_tells_problems_apart():
    joints = [example(name) for name in ("two-node", "uncoupled", "three-node", "jump")]
    assert len({joint.fingerprint for joint in joints}) == 4
    assert 1 <= all_cores() <= os.cpu_count()


WORK = Squares()
LIES = [each for each in HEADERS if "'a'" not in each and not each.startswith(" ")]  # NumPy reads the others


def kept(tmp_path):
    """The path of one piece of a run that has ended, and its bytes."""
    with pytest.raises(KeyError), run_pieces(WORK, 1, output=tmp_path / "map.npz"):
        raise KeyError
    (path,) = (tmp_path / "map.npz.parts").iterdir()
    return path, path.read_bytes()


def resumed(tmp_path):
    """Whether the piece was done again."""
    calls = []
    with run_pieces(
        WORK, 1, output=tmp_path / "map.npz", resume=True, progress=lambda *at: calls.append(at)
    ) as pieces:
        assert squares(pieces).tolist() == [k**2 for k in range(10)]
    return len(calls) == 2


def archive(*members):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as file:
        for member in members:
            file.writestr("square.npy", member)
    return buffer.getvalue()


def test_a_flipped_byte_a_cut_or_bytes_put_in_cost_the_piece_at_most(tmp_path):
    path, whole = kept(tmp_path)
    for place in range(0, len(whole), 11):
        for damaged in (
            whole[:place] + bytes([whole[place] ^ 1 << place % 8]) + whole[place + 1 :],
            whole[:place],
            whole[:place] + BYTES[place % len(BYTES)] + whole[place:],
        ):
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(damaged)
            resumed(tmp_path)


@pytest.mark.parametrize(
    "content",
    [
        b"", b"PK", b"text", npy(np.arange(10)), *(archive(with_header(header, bytes(80))) for header in LIES),
        bytes(1 << 20),
    ],
    ids=lambda content: content[:4].hex(),
)  # fmt: skip
def test_a_piece_that_cannot_be_is_done_again(tmp_path, content):
    path, _ = kept(tmp_path)
    path.write_bytes(content)
    assert resumed(tmp_path)


@pytest.mark.parametrize("make", [os.mkdir, os.mkfifo, lambda path: os.symlink("/dev/zero", path)])
def test_what_is_no_file_is_one_line_or_done_again(tmp_path, make):
    path, _ = kept(tmp_path)
    path.unlink()
    make(path)
    with pytest.raises(ProblemError):
        read_arrays(path)


def test_pickles_are_not_read(tmp_path):
    path = tmp_path / "0.npz"
    np.savez(path, square=np.array([print], dtype=object))
    with pytest.raises(ProblemError, match="allow_pickle=False"):
        read_arrays(path)


def write(path, data=b"new"):
    with atomic_write(path) as file:
        file.write(data)


def broken_off(paths):
    with atomic_write_together(paths) as files:
        files[0].write(b"half" * 10_000)
        raise ZeroDivisionError


def names(folder):
    return sorted(each.name for each in folder.iterdir())


def test_nothing_is_seen_of_it_before_the_end(tmp_path):
    target = tmp_path / "f"
    target.write_bytes(b"old")
    with atomic_write(target) as file:
        file.write(b"new")
        file.flush()
        assert target.read_bytes() == b"old"
    assert target.read_bytes() == b"new"
    assert names(tmp_path) == ["f"]


def test_a_new_file_has_the_mode_that_the_umask_leaves(tmp_path):
    umask = 0o027
    code = (
        f"import os, sys; os.umask({umask})\n"
        "from shakedown.files.atomic_write import atomic_write\n"
        "with atomic_write(sys.argv[1]) as file: pass\n"
        "open(sys.argv[1] + '.plain', 'w').close()\n"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "f")], check=True)
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("f", "f.plain")]
    assert modes == [0o666 & ~umask] * 2


def test_an_old_files_mode_is_kept(tmp_path):
    target, mode = tmp_path / "f", 0o640
    target.touch()
    target.chmod(mode)
    with atomic_write(target) as file:
        assert stat.S_IMODE(os.fstat(file.fileno()).st_mode) & ~mode == 0, "readable to more than the old one"
    assert stat.S_IMODE(target.stat().st_mode) == mode


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "there" / "f")
    for data in (b"created", b"replaced"):
        write(tmp_path / "link", data)
        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "there" / "f").read_bytes() == data
    assert names(tmp_path / "there") == ["f"]


def fifo(folder):
    os.mkfifo(folder / "f")
    return folder / "f"


def link_to_a_device(folder):
    (folder / "f").symlink_to("/dev/null")
    return folder / "f"


def loop_of_links(folder):
    (folder / "f").symlink_to(folder / "f")
    return folder / "f"


REFUSED = {
    "empty": (lambda folder: "", "expected the path"),
    "a number": (lambda folder: 3, "expected text or a path"),
    "a folder": (lambda folder: folder, "a directory"),
    "a pipe": (fifo, "a pipe"),
    "a device": (lambda folder: "/dev/null", "a device"),
    "a link to a device": (link_to_a_device, "a device"),
    "a loop of links": (loop_of_links, "cannot be written"),
    "no folder": (lambda folder: folder / "none" / "f", "cannot be written"),
    "a file as folder": (lambda folder: Path(__file__) / "f", "cannot be written"),
    "NUL": (lambda folder: f"{folder}/a\0b", "null"),
    "half a character": (lambda folder: f"{folder}/a\ud800b", "cannot be written"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_refused_before_and_while_writing(tmp_path, kind):
    make, message = REFUSED[kind]
    path = make(tmp_path)
    before = names(tmp_path)
    for attempt in (check_target, write):
        with pytest.raises(UsageError) as caught:
            attempt(path)
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)
    assert names(tmp_path) == before


def test_no_spreadsheet_runs_what_a_table_says(tmp_path):
    """Neither in a cell nor in a heading."""
    columns = {"node": ["7", "=1+1"], "@SUM(A1)": ["-12", "+x"], "p [N]": [0.1, float("nan")]}
    write_csv(tmp_path / "t.csv", columns)
    text = (tmp_path / "t.csv").read_text()
    assert text == "node,'@SUM(A1),p [N]\n7,-12,0.1\n'=1+1,'+x,\n"


def test_two_files_come_together_or_not_at_all(tmp_path):
    pair = [tmp_path / "r.html", tmp_path / "r.json"]
    for path in pair:
        path.write_bytes(b"old")
    with pytest.raises(ZeroDivisionError):
        broken_off(pair)
    assert [path.read_bytes() for path in pair] == [b"old", b"old"]
    (tmp_path / "pipe").mkdir()
    with pytest.raises(UsageError), atomic_write_together([pair[0], tmp_path / "pipe"]):
        pytest.fail("the second target was not checked before the work")
    with atomic_write_together(pair) as (page, document):
        page.write(b"page")
        document.write(b"document")
    assert [path.read_bytes() for path in pair] == [b"page", b"document"]


def test_a_full_disk_is_one_line_and_keeps_the_old_file(tmp_path):
    code = (
        "import resource, sys, numpy as np, shakedown\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))\n"
        "try: shakedown.save_problem(sys.argv[1], shakedown.example('block-33'))\n"
        "except shakedown.ShakedownError as error: print(error)\n"
    )
    target = tmp_path / "p.npz"
    shakedown.save_problem(target, shakedown.example("one-node"))
    words = [sys.executable, "-c", code, str(target)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert done.stdout == f"{target}: cannot be written (File too large)\n"
    assert shakedown.load_problem(target) == shakedown.example("one-node")
    assert names(tmp_path) == ["p.npz"]


def test_many_threads_write_one_file(tmp_path):
    target, errors = tmp_path / "f", []

    def work(letter):
        try:
            for _ in range(20):
                write(target, letter * 5000)
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=work, args=(letter,)) for letter in (b"a", b"b", b"c")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    assert target.read_bytes() in (b"a" * 5000, b"b" * 5000, b"c" * 5000)
    assert names(tmp_path) == ["f"]


KILLED = """
import os, signal, sys
from shakedown.files.atomic_write import atomic_write_together
name, moment = sys.argv[1], int(sys.argv[2])
calls, real = [], getattr(os, name)

def fatal(*words):
    if len(calls) == moment:
        os.kill(os.getpid(), signal.SIGKILL)
    calls.append(words)
    return real(*words)

setattr(os, name, fatal)
with atomic_write_together(sys.argv[3:]) as files:
    for file in files:
        file.write(b"n" * 200_000)
"""


@pytest.mark.parametrize(
    ("call", "moment", "expected"),
    [("fsync", 0, "oo"), ("fsync", 1, "oo"), ("replace", 0, "oo"), ("replace", 1, "no")],
)
def test_killed_at_each_step_of_a_writing(tmp_path, call, moment, expected):
    """Whatever the step, each file is whole."""
    pair = [tmp_path / "a", tmp_path / "b"]
    for path in pair:
        path.write_bytes(b"o" * 100_000)
    words = [sys.executable, "-c", KILLED, call, str(moment), *map(str, pair)]
    done = subprocess.run(words, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (-signal.SIGKILL, b"")
    sizes = {"o": 100_000, "n": 200_000}
    for path, letter in zip(pair, expected, strict=True):
        assert path.read_bytes() == letter.encode() * sizes[letter]
