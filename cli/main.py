"""Entry point. Signals are handled before any import, so that they end in one line at any moment."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn

INTERRUPT = 2  # the number of SIGINT, before anything is imported


def main() -> NoReturn:
    """Run the command line and end the process; every failure is one line on stderr and an exit code.

    Signals end it in one line to the last; they are ignored once everything is written and closed.
    """
    try:
        import atexit
        import signal

        for number in (signal.SIGINT, signal.SIGTERM):
            if signal.getsignal(number) is not signal.SIG_IGN:  # as in the background of a shell
                signal.signal(number, _leave)
                atexit.register(signal.signal, number, signal.SIG_IGN)  # first in, so called last
        from .run import run

        code = run()
    except KeyboardInterrupt:
        _leave(INTERRUPT)
    raise SystemExit(code)


def _leave(number: int, *_: object) -> NoReturn:
    """Say so and leave at once: an exception would get lost in a compiler's callback or wait for threads."""
    import os

    word = b"interrupted" if number == INTERRUPT else b"terminated"
    try:
        os.write(2, b"\n" * os.isatty(2) + b"shakedown-bounds: " + word + b"\n")
    finally:
        os._exit(128 + number)
