"""Every file that the toolkit writes: the old one or the new one, never half, and only over regular files."""

import os
import signal
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import shakedown
from shakedown import UsageError
from shakedown.files.atomic_write import (
    atomic_write,
    atomic_write_together,
    check_target,
    write_csv,
)


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
    done = subprocess.run(
        [sys.executable, "-c", code, str(target)], capture_output=True, text=True, check=True
    )
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
