"""Entry point: the command group, and what an error looks like to the user."""

from __future__ import annotations

import sys
from typing import NoReturn

import click

import shakedown

from .critical import critical
from .example import example
from .import_problem import import_problem_command
from .simulate import simulate
from .solve import solve
from .verify import verify

OPEN, BAD_INPUT, INTERRUPTED = 1, 2, 130


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 80})
@click.version_option(shakedown.__version__, prog_name="shakedown-bounds")
def shakedown_bounds() -> None:
    """Shakedown analysis of elastic contacts with Coulomb friction.

    FILE is a problem file (NPZ) or the name of a built-in problem; `example`
    lists those. Exit codes: 0 done; 1 done, but the answer is negative or open;
    2 bad usage or bad input.
    """


for command in (solve, critical, simulate, verify, import_problem_command, example):
    shakedown_bounds.add_command(command)


def main() -> NoReturn:
    """Run the command line; every failure ends in one line on stderr and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a terminal without Greek letters gets "?"
            stream.reconfigure(errors="replace")
    try:
        sys.exit(shakedown_bounds(standalone_mode=False))
    except click.exceptions.Exit as stop:
        sys.exit(stop.exit_code)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        sys.exit(BAD_INPUT)
    except click.ClickException as error:
        _fail(error.format_message(), BAD_INPUT)
    except (click.Abort, KeyboardInterrupt):
        _fail("interrupted", INTERRUPTED)
    except (shakedown.BudgetExceeded, shakedown.SolverError) as error:
        _fail(str(error), OPEN)
    except shakedown.ShakedownError as error:
        _fail(str(error), BAD_INPUT)


def _fail(message: str, code: int) -> NoReturn:
    click.echo("shakedown-bounds: " + " ".join(message.split()), err=True)
    sys.exit(code)
