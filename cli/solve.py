"""`shakedown-bounds solve`: both bounds, the safe slip and the status of the guarantee."""

from __future__ import annotations

import click
from shakedown.cli.options import json_option, problem_argument
from shakedown.cli.output import echo_json, headline, number, paragraph, table

import shakedown
from shakedown.bounds import ShakedownBounds, UpperBound
from shakedown.documents import bounds_document, friction_document
from shakedown.meaning import bounds_in_words
from shakedown.problem import Problem


@click.command(short_help="Bounds, safe slip, friction thresholds.")
@problem_argument
@json_option
def solve(problem: Problem, as_json: bool) -> None:
    """Bounds on the load factor of FILE, safe slip, friction thresholds."""
    bounds = shakedown.shakedown_bounds(problem)
    if as_json:
        echo_json(bounds_document(problem, bounds) | {"friction": friction_document(problem)})
    else:
        click.echo(_text(problem, bounds))


def _text(problem: Problem, bounds: ShakedownBounds) -> str:
    lower, upper = bounds.lower, bounds.upper
    first = f"first collapse, at node {lower.node}" if lower.node >= 0 else "no node ever collapses"
    lines = [
        headline(problem),
        "",
        f"  lower bound  λ_1    {number(lower.load_factor, 10):<14}  {first}",
        f"               {'':19}  guarantee: {lower.guarantee}",
        f"  upper bound  λ_max  {number(upper.load_factor, 10):<14}  {upper.status}",
        "",
    ]
    lines += [paragraph(sentence) for sentence in bounds_in_words(bounds)]
    thresholds = friction_document(problem)["single_node"]
    rows = [
        [
            str(j),
            number(upper.slip[j]),
            number(lower.slip[j]),
            _sides(upper, j),
            number(float(thresholds[j]), 5),
        ]
        for j in range(problem.n)
    ]
    headers = ["node", "safe slip", "witness", "active at λ_max", "f threshold"]
    return "\n".join([*lines, "", table(headers, rows)])


def _sides(upper: UpperBound, node: int) -> str:
    """Which limits of a node are reached at λ_max."""
    names = {+1: "backward", -1: "forward"}
    return "+".join(names[side] for at, side in upper.active if at == node) or "-"
