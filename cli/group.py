"""The command group."""

from __future__ import annotations

import click

import shakedown

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
