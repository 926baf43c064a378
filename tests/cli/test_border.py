"""What crosses the border of the command: interruptions, full disks, terminals, odd files and odd names."""

import dataclasses
import json
import os
import pty
import signal
import subprocess
import sys
import termios
import time
import zipfile

import click
import numpy as np
import pytest
from command import CONTROL, refused, run

import shakedown
from shakedown.cli.command import QUIET, progress

COMMAND = [sys.executable, "-c", "from shakedown.cli.main import main; main()"]


# interruptions and full disks ------------------------------------------------------------------------


def interrupted(words, after, number):
    """The command, sent a signal ``after`` its first import: (exit code, stderr)."""
    code = (
        "import os, signal, sys, threading, time\n"
        "def interrupt():\n"
        "    while 'shakedown.cli.main' not in sys.modules: time.sleep(1e-4)\n"
        f"    time.sleep({after})\n"
        f"    os.kill(os.getpid(), {int(number)})\n"
        "threading.Thread(target=interrupt, daemon=True).start()\n"
        "from shakedown.cli.main import main\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


YEARS = ["critical", "block-33", "--budget", str(9 * 10**18), "-q"]  # of work


@pytest.mark.parametrize(
    ("after", "number", "end"),
    [
        (0.002, signal.SIGINT, (130, "shakedown-bounds: interrupted\n")),
        (0.4, signal.SIGINT, (130, "shakedown-bounds: interrupted\n")),
        (0.1, signal.SIGTERM, (143, "shakedown-bounds: terminated\n")),
    ],
)
def test_an_interruption_is_one_line_from_the_first_import_on(after, number, end):
    assert interrupted(YEARS, after, number) == end


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_after_the_last_output_is_a_line_or_too_late(number):
    """Never the signal's own end of the process, which would say nothing."""
    code = {signal.SIGINT: 130, signal.SIGTERM: 143}[number]
    word = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}[number]
    ends = {(0, ""), (code, f"shakedown-bounds: {word}\n")}
    late = f"import atexit, os\natexit.register(lambda: os.kill(os.getpid(), {int(number)}))\n"
    last = (
        "import os, sys\n"
        "class Last:\n"
        f"    def __del__(self, kill=os.kill, pid=os.getpid()): kill(pid, {int(number)})\n"
        "sys.last_of_all = Last()\n"
    )
    for before in (late, last):
        words = [sys.executable, "-c", f"{before}from shakedown.cli.main import main\nmain()\n", "example"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) in ends
        assert done.stdout == run("example")[1]


def test_an_interruption_that_a_shell_keeps_from_us_is_none():
    """As one does for a command in the background."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert run("example")[0] == 0
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("value", ["-1", "9" * 17])
def test_a_date_that_libraries_end_at_is_one_line(monkeypatch, value):
    """SciPy's import and matplotlib's files read the variable."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", value)
    line = "SOURCE_DATE_EPOCH: expected no such variable, or a whole number from 0 to 253402300799, found"
    refused("solve", "one-node", cwd=".", message=f"{line} '{value}'")


def test_threads_that_numba_ends_at_are_one_line(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "0")
    message = "a whole number from 1 to 2147483647, found '0'"
    refused("simulate", "one-node", "--load-factor", "1", cwd=".", message=message)


@pytest.mark.parametrize("words", [["--help"], ["example", "--json"]])
def test_a_full_disk_behind_stdout_is_one_line(words):
    with open("/dev/full", "wb") as full:
        done = subprocess.run([*COMMAND, *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "shakedown-bounds: output: cannot be written (No space left on device)\n"


def test_a_full_disk_behind_stderr_leaves_the_exit_code():
    with open("/dev/full", "wb") as full:
        done = subprocess.run([*COMMAND, "solve", "none"], stdout=subprocess.PIPE, stderr=full, check=False)
    assert (done.returncode, done.stdout) == (2, b"")


def test_no_streams_at_all():
    code = "import os, sys; os.close(1); os.close(2); from shakedown.cli.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code, "example"], check=False)
    assert done.returncode in (0, 2)


# the terminal ----------------------------------------------------------------------------------------


def on_a_terminal(columns, *words):
    """What the command writes to a terminal of that width."""
    main, side = pty.openpty()
    environment = {key: value for key, value in os.environ.items() if key not in ("COLUMNS", "LINES")}
    termios.tcsetwinsize(side, (24, columns))
    process = subprocess.Popen([*COMMAND, *words], stdin=side, stdout=side, stderr=side, env=environment)
    os.close(side)
    data = b""
    try:
        while chunk := os.read(main, 65536):
            data += chunk
    except OSError:  # the other side is closed
        pass
    os.close(main)
    assert process.wait() == 0
    return data.decode().replace("\r\n", "\n")


@pytest.mark.parametrize("columns", [60, 150])  # 80 is what every other test has
def test_text_is_as_wide_as_the_terminal(columns):
    lines = on_a_terminal(columns, "solve", "one-node", "-q").splitlines()
    assert max(map(len, lines)) <= columns
    if columns > 80:
        assert max(map(len, lines)) > 80


def test_quiet_says_nothing_beside_the_result():
    assert "subsets of" in run("critical", "two-node")[2]
    code, out, err = run("critical", "two-node", "-q")
    assert (code, err) == (0, "")
    assert out == run("critical", "two-node")[1]


def test_a_bar_is_only_where_somebody_watches(monkeypatch):
    with open("/dev/ptmx", "w") as terminal, click.Context(click.Command("any")) as context:
        for stream, quiet, bar in ((terminal, False, True), (terminal, True, False), (None, False, False)):
            monkeypatch.setattr(sys, "stderr", stream)
            context.meta[QUIET] = quiet
            with progress("points") as update:
                assert (update is not None) == bar


@pytest.mark.parametrize("option", ["-V", "--version"])
def test_version(option):
    assert run(option)[:2] == (0, f"shakedown-bounds, version {shakedown.__version__}\n")


def test_the_package_is_the_command():
    words = [sys.executable, "-m", "shakedown", "solve", "none.npz"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "shakedown-bounds: none.npz: no such file\n"


# names, units, keys and paths ------------------------------------------------------------------------

NASTY = "a\x1b]0;owned\x07 \x9b31m \x00 \u202egnp.exe $x <b>&\n" + "y" * 5000


def with_text(path, **texts):
    """The two-node problem with texts as they are, written by NumPy and not by the toolkit."""
    problem = shakedown.example("two-node")
    arrays = {key: getattr(problem, key) for key in ("A", "B", "C", "f", "q_w", "p_w")}
    np.savez(path, **arrays, **{key: np.array(text) for key, text in texts.items()})


@pytest.mark.parametrize("key", ["name", "units"])
def test_texts_reach_the_terminal_without_what_it_obeys(tmp_path, key):
    with_text(tmp_path / "p.npz", **{key: NASTY})
    code, out, err = run("solve", "p.npz", cwd=tmp_path)
    assert (code, err) == (0, "")
    assert not CONTROL.search(out)
    assert max(map(len, out.splitlines())) <= 80
    _, out, _ = run("solve", "p.npz", "--json", cwd=tmp_path)
    assert not CONTROL.search(out)
    assert json.loads(out)["problem"][key] == NASTY


def test_texts_reach_the_report_without_what_a_page_obeys(tmp_path):
    joint = dataclasses.replace(shakedown.example("one-node"), name=NASTY, units="N, $m")
    shakedown.save_problem(tmp_path / "p.npz", joint)
    code, out, err = run("verify", "p.npz", "-o", "r.html", "--random", "0", cwd=tmp_path)
    assert (code, err) == (0, "")
    for written in (out, (tmp_path / "r.html").read_text(), (tmp_path / "r.json").read_text()):
        assert not CONTROL.search(written)
    assert "<b>" not in (tmp_path / "r.html").read_text()


def test_keys_and_paths_in_messages_are_short_and_not_obeyed(tmp_path):
    with zipfile.ZipFile(tmp_path / "p.npz", "w") as archive:
        for k in range(2000):
            archive.writestr(f"key \x1b[2J {k}.npy", b"")
    refused("solve", "p.npz", cwd=tmp_path, message="unknown key")
    for name in ("a\x1b[2Jb", "x" * 5000, "a\nb", "\udce9", "é" * 200):
        for command in (["solve"], ["simulate", "--load-factor", "1"], ["import", "-o", "p"]):
            refused(*command, name + ".npz", cwd=tmp_path, message="shakedown-bounds")
        refused(
            "simulate", "one-node", "--load-factor", "1", "--initial", name, cwd=tmp_path, message="--initial"
        )
        refused("simulate", "one-node", f"--{name}", cwd=tmp_path, message="No such option")


# odd files -------------------------------------------------------------------------------------------


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    signal.alarm(20)
    try:
        refused("solve", "pipe", cwd=tmp_path, message="expected an NPZ file, found a pipe")
        refused("import", "pipe", "-o", "b.npz", cwd=tmp_path, message="expected a regular file")
        words = ("simulate", "one-node", "--load-factor", "1", "--initial", "pipe")
        refused(*words, cwd=tmp_path, message="expected an NPY file, found a pipe")
        for words in (
            ["example", "one-node"],
            ["verify", "one-node"],
            ["simulate", "one-node", "--load-factor", "1"],
        ):
            refused(*words, "-o", "pipe", cwd=tmp_path, message="expected a regular file, found a pipe")
    finally:
        signal.alarm(0)


@pytest.mark.parametrize("target", ["", "none/x", "/dev/null", "z" * 300])
@pytest.mark.parametrize("command", ["example", "verify", "simulate", "import"])
def test_targets_are_checked_before_the_work(tmp_path, command, target):
    words = {
        "example": ["example", "one-node"],
        "verify": ["verify", "no such file"],
        "simulate": ["simulate", "--load-factor", "1", "--cycles", "1"],
        "import": ["import", "none.toml"],
    }[command]
    before = time.process_time()
    refused(*words, "-o", target, cwd=tmp_path, message="")
    assert time.process_time() - before < 5
    assert list(tmp_path.iterdir()) == []


# the report and its JSON -----------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_only_a_reports_own_json_is_replaced(tmp_path):
    words = ("verify", "one-node", "--random", "0", "-o", "r.html")
    (tmp_path / "r.json").write_text('{"mine": 1}')
    refused(*words, cwd=tmp_path, message="r.json: the JSON of the report r.html goes there")
    assert (tmp_path / "r.json").read_text() == '{"mine": 1}'
    assert not (tmp_path / "r.html").exists()
    (tmp_path / "r.json").unlink()
    assert run(*words, cwd=tmp_path)[0] == 0
    first = json.loads((tmp_path / "r.json").read_text())
    assert first["agrees"] is True
    assert run(*words, cwd=tmp_path)[0] == 0
    os.mkdir(tmp_path / "s.json")
    refused(*words[:-1], "s.html", cwd=tmp_path, message="a directory")


# archives that are larger than they look -------------------------------------------------------------


def bomb(path, method, size):
    """Three members of ``size`` zeros that claim to be matrices, in a few kilobytes."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({size // 8},), }}".encode()
    head = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
    with zipfile.ZipFile(path, "w", method, compresslevel=1) as archive:
        for key in ("A", "B", "f", "q_w", "p_w"):
            with archive.open(f"{key}.npy", "w", force_zip64=True) as file:
                file.write(head)
                for _ in range(size >> 20):
                    file.write(bytes(1 << 20))


@pytest.mark.parametrize(
    ("method", "message"),
    [(zipfile.ZIP_BZIP2, "compression type 12"), (zipfile.ZIP_DEFLATED, "100 times the file's size")],
)
def test_a_bomb_is_refused_by_its_headers(tmp_path, method, message):
    bomb(tmp_path / "p.npz", method, 60 << 20 if method == zipfile.ZIP_DEFLATED else 1 << 20)
    before = time.process_time()
    refused("solve", "p.npz", cwd=tmp_path, message=message)
    assert time.process_time() - before < 2
