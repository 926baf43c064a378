"""Programs over discs whose optima are built backwards, through Clarabel, cvxpy and the dense interior points."""

import sys

import numpy as np
import pytest

import shakedown
from shakedown.bounds.independent_solver import conic_upper_bound, solve_conic
from shakedown.ground.errors import UsageError
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.self_dual import solve_discs


def discs(seed, nodes=6, steps=3):
    """(program, x): some discs and rows are met on their surface with a multiplier there, others left alone."""
    rng = np.random.default_rng(seed)
    blocks, node = rng.normal(size=(nodes, 3, 4)), np.repeat(np.arange(nodes), steps)
    extra, rows = rng.normal(size=(len(node), 3, 1)), rng.normal(size=(6, 4))
    rows_extra, y, w = rng.normal(size=(6, 1)), rng.normal(size=4), rng.normal(size=1)
    slack, weight = rng.normal(size=(len(node), 3)), np.zeros((len(node), 3))
    slack[:, 0] = np.hypot(slack[:, 1], slack[:, 2])
    weight[:3] = slack[:3] * [0.5, -0.5, -0.5]
    slack[3:, 0] += 0.7
    balance = np.einsum("jk,jkx->x", weight, blocks[node])
    push = np.linalg.lstsq(rows[:4].T, -balance, rcond=None)[0]  # rows 0 to 3 balance the discs
    rows[:4] *= np.sign(push)[:, None]
    free = np.append(np.zeros(4), [0.3, 0.4])
    program = DiscProgram(
        blocks=blocks, node=node, extra=extra, right=slack + blocks[node] @ y + extra @ w,
        rows=rows, rows_extra=rows_extra, rows_right=rows @ y + rows_extra @ w + free,
        cost=-np.einsum("jk,jkx->x", weight, extra) - np.abs(push) @ rows_extra[:4],
    )  # fmt: skip
    return program, np.append(y, w)


def through_cvxpy(program):
    return solve_conic(program, "CLARABEL")


def by_own_points(program):
    end = solve_discs(program)
    return end.status, end.x, False


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("by", [solve_conic, through_cvxpy, by_own_points])
def test_every_method_ends_where_the_program_was_built(seed, by):
    program, x = discs(seed)
    status, found, reduced = by(program)
    assert (str(status), reduced) == ("optimal", False)
    np.testing.assert_allclose(found, x, atol=1e-6)
    assert program.cost @ found[-1:] == pytest.approx(program.cost @ x[-1:], rel=1e-8)


def test_statuses_without_an_optimum():
    row, none = np.zeros((1, 0)), np.zeros((1, 3, 0))
    both = {"blocks": none, "node": np.array([0]), "rows": row, "rows_extra": np.array([[-1.0]])}
    ball = np.array([[[0.0], [-1.0], [0.0]]])  # |w| ≤ 1
    unlike = DiscProgram(
        extra=ball, right=np.array([[1.0, 0, 0]]), rows_right=np.array([-2.0]), cost=np.ones(1), **both
    )
    assert solve_conic(unlike)[0] == "infeasible"
    ahead = np.array([[[-1.0], [0.0], [0.0]]])
    ray = DiscProgram(extra=ahead, right=np.zeros((1, 3)), rows_right=np.zeros(1), cost=-np.ones(1), **both)
    assert solve_conic(ray)[0] == "unbounded"


def test_without_cvxpy_its_solvers_are_refused_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "cvxpy", None)
    with pytest.raises(UsageError, match=r"^solver 'SCS': expected cvxpy.* pip install '\.\[solvers\]'$"):
        conic_upper_bound(shakedown.example("two-node"), solver="SCS")
