"""The command line, run in this process."""

import atexit
import json
import signal
import sys
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from unittest.mock import patch

import pytest

from shakedown.cli import main as entry


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
