"""The command group, and one run of it: what an error looks like to the user."""

from __future__ import annotations

import errno
import gc
import os
import sys
from contextlib import suppress
from typing import TextIO

import click

import shakedown
from shakedown.ground.shown_values import one_line

from .problems import example, import_command
from .runs import nodes, simulate, verify
from .solve import critical, solve
from .studies import damping, map_command, refine, sweep

NAME = "shakedown-bounds"


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 80})
@click.version_option(shakedown.__version__, "-V", "--version", prog_name=NAME)
def shakedown_bounds() -> None:
    """Shakedown analysis of elastic contacts with Coulomb friction.

    FILE is a problem file (NPZ) or the name of a built-in problem; `example`
    lists those. Exit codes: 0 done; 1 done, but the answer is negative (verification
    disagrees, a requirement is not met) or open (undecided); 2 bad usage or
    bad input.
    """


for each in (
    *(solve, critical, simulate, nodes, verify, map_command),
    *(sweep, damping, refine, import_command, example),
):
    shakedown_bounds.add_command(each)


OPEN, BAD_INPUT = 1, 2
# How many new objects Python waits for before it searches for garbage: after every 700, its default, these
# searches take a sixth of the time.
COLLECTED = 50_000, 20, 20
WHOLE_NUMBERS = (  # variables of NumPy, SciPy and matplotlib (a date, to the year 9999), and of numba
    ("SOURCE_DATE_EPOCH", 0, 253_402_300_799),
    ("NUMBA_NUM_THREADS", 1, 2**31 - 1),
)


def run() -> int:
    """The exit code of the command; an error has been reported in one line on stderr."""
    gc.set_threshold(*COLLECTED)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a terminal without Greek letters gets "?"
            with suppress(OSError):  # a closed one: noticed when something is written
                stream.reconfigure(errors="replace")
    try:
        code = _outcome()
        if sys.stdout is not None:
            sys.stdout.flush()  # a full disk is to be noticed here, not at the interpreter's end
    except OSError as error:
        _give_up(sys.stdout)
        if error.errno == errno.EPIPE:
            return OPEN  # nobody reads on: not worth a word
        where = error.filename or "output"
        return _said(f"{where}: cannot be written ({error.strerror or error})", BAD_INPUT)
    return code


def _check_environment() -> None:
    """Raise ``UsageError`` for a variable on which a library that we import would end in a traceback."""
    for name, lowest, highest in WHOLE_NUMBERS:
        given = os.environ.get(name)
        whole = given is not None and given.isdecimal() and len(given) <= len(str(highest))
        if given is not None and not (whole and lowest <= int(given) <= highest):
            raise shakedown.UsageError(
                f"{name}: expected no such variable, or a whole number from {lowest} to {highest}, "
                f"found '{given}'"
            )


def _outcome() -> int:
    try:
        if "_SHAKEDOWN_BOUNDS_COMPLETE" in os.environ:  # a shell asks for completions
            shakedown_bounds.main(prog_name=NAME)
        with shakedown_bounds.make_context(NAME, sys.argv[1:]) as context:
            _check_environment()
            shakedown_bounds.invoke(context)
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return BAD_INPUT
    except click.ClickException as error:
        return _said(error.format_message(), BAD_INPUT)
    except (shakedown.BudgetExceeded, shakedown.SolverError) as error:
        return _said(str(error), OPEN)
    except shakedown.ShakedownError as error:
        return _said(str(error), BAD_INPUT)
    except MemoryError:
        return _said("more work than this machine's memory can hold", OPEN)
    return 0


def _said(message: str, code: int) -> int:
    try:
        click.echo(f"{NAME}: {one_line(message)}", err=True)
    except (OSError, ValueError):  # stderr is full too: the exit code has to do
        _give_up(sys.stderr)
    return code


def _give_up(stream: TextIO) -> None:
    """Discard what is still buffered, so that the interpreter does not complain again when it ends."""
    with suppress(AttributeError, OSError, ValueError):
        nowhere, at = os.open(os.devnull, os.O_WRONLY), stream.fileno()
        if nowhere != at:  # they are equal where the stream was closed before the start
            os.dup2(nowhere, at)
            os.close(nowhere)
