"""Entry point: an interruption ends in one line at any moment, so nothing is imported before it is caught."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn

INTERRUPTED = 130


def main() -> NoReturn:
    """Run the command line; every failure ends in one line on stderr and an exit code."""
    try:
        from .run import run

        code = run()
    except KeyboardInterrupt:
        code = _interrupted()
    raise SystemExit(code)


def _interrupted() -> int:
    """Say so once; a further interruption changes nothing."""
    import signal
    import sys
    from contextlib import suppress

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(OSError, ValueError):  # nobody listens
        print("shakedown-bounds: interrupted", file=sys.stderr, flush=True)
    return INTERRUPTED
