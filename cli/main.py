"""Entry point. Signals are handled before any import, so that they end in one line at any moment."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn


def main() -> NoReturn:
    """Run the command line and end the process; every failure is one line on stderr and an exit code.

    Signals end it in one line to the last; they are ignored once everything is written and closed.
    """
    try:
        import atexit
        import signal

        for number, end in ((signal.SIGINT, _interrupted), (signal.SIGTERM, _terminated)):
            if signal.getsignal(number) is not signal.SIG_IGN:  # as in the background of a shell
                signal.signal(number, end)
                atexit.register(signal.signal, number, signal.SIG_IGN)  # first in, so called last
        from .run import run

        code = run()
    except KeyboardInterrupt:
        _interrupted()
    raise SystemExit(code)


def _interrupted(*_: object) -> NoReturn:
    _leave(b"interrupted", 130)


def _terminated(*_: object) -> NoReturn:
    _leave(b"terminated", 143)


def _leave(word: bytes, code: int) -> NoReturn:
    """Say so and leave at once: an exception would get lost in a compiler's callback or wait for threads."""
    import os

    try:
        os.write(2, b"\n" * os.isatty(2) + b"shakedown-bounds: " + word + b"\n")
    finally:
        os._exit(code)
