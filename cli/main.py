"""Entry point. Signals are handled before any import, so that they end in one line at any moment."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn

INTERRUPTED, TERMINATED = 130, 143


def main() -> NoReturn:
    """Run the command line; every failure ends in one line on stderr and an exit code."""
    try:
        import signal

        ends = {signal.SIGINT: _interrupted, signal.SIGTERM: _terminated}
        before = {number: signal.getsignal(number) for number in ends}
        for number, end in ends.items():
            if before[number] is not signal.SIG_IGN:  # as in the background of a shell
                signal.signal(number, end)
        try:
            from .run import run

            code = run()
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
    except KeyboardInterrupt:
        _interrupted()
    raise SystemExit(code)


def _interrupted(*_: object) -> NoReturn:
    _leave(b"interrupted", INTERRUPTED)


def _terminated(*_: object) -> NoReturn:
    _leave(b"terminated", TERMINATED)


def _leave(word: bytes, code: int) -> NoReturn:
    """Say so and leave at once: an exception would get lost in a compiler's callback or wait for threads."""
    import os

    try:
        os.write(2, b"\n" * os.isatty(2) + b"shakedown-bounds: " + word + b"\n")
    finally:
        os._exit(code)
