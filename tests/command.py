"""The command line, run in this process."""

import atexit
import json
import os
import re
import signal
import sys
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from unittest.mock import patch

import pytest

from shakedown.cli import main as entry

CONTROL = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
ONE_LINE = re.compile(r"shakedown-bounds: [^\n]*\n")


@contextmanager
def signals_kept():
    """The signals as they were, which the command handles to the end of its process."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        atexit.unregister(signal.signal)
        for number, handler in before.items():
            signal.signal(number, handler)


def run(*words, cwd=None):
    """The command in this process: (exit code, stdout, stderr)."""
    out, err = StringIO(), StringIO()
    with (
        redirect_stdout(out),
        redirect_stderr(err),
        patch.object(sys, "argv", ["shakedown-bounds", *words]),
        chdir(cwd or "."),
        signals_kept(),
        pytest.raises(SystemExit) as stop,
    ):
        entry.main()
    return stop.value.code or 0, out.getvalue(), err.getvalue()


def document(*words, code=0, cwd=None):
    found, out, err = run(*words, "--json", cwd=cwd)
    assert found == code, err
    return json.loads(out, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))


def refused(*words, message, cwd=None):
    """The command ends with exit code 2 and one short line that says why, and has written nothing."""
    before = cwd and sorted(os.listdir(cwd))
    code, out, err = run(*words, cwd=cwd)
    assert (code, out) == (2, "")
    assert ONE_LINE.fullmatch(err), err
    assert not CONTROL.search(err[:-1])
    assert len(err) < 1200
    assert message in err
    assert before == (cwd and sorted(os.listdir(cwd)))
    return err
