"""Entry point: an interruption ends in one line at any moment, so that is seen to before any import."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn

INTERRUPTED = 130


def main() -> NoReturn:
    """Run the command line; every failure ends in one line on stderr and an exit code."""
    try:
        import signal

        before = signal.signal(signal.SIGINT, _interrupted)
        try:
            from .run import run

            code = run()
        finally:
            signal.signal(signal.SIGINT, before)
    except KeyboardInterrupt:
        _interrupted()
    raise SystemExit(code)


def _interrupted(*_: object) -> NoReturn:
    """Say so and leave at once: an exception would get lost in a compiler's callback or wait for threads."""
    import os

    try:
        os.write(2, b"\n" * os.isatty(2) + b"shakedown-bounds: interrupted\n")
    finally:
        os._exit(INTERRUPTED)
