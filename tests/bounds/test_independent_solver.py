"""The bounds by solvers of others: through Clarabel, and any solver of cvxpy."""

import sys

import numpy as np
import pytest

import shakedown
from shakedown.bounds.independent_solver import conic_lower_bound, conic_upper_bound, solve_conic
from shakedown.ground.errors import UsageError
from shakedown.joint.constraints import constraints
from shakedown.programs.disc_program import DiscProgram


@pytest.mark.parametrize("solver", ["CLARABEL", "HIGHS"])
def test_any_solver_of_the_modelling_layer(solver: str) -> None:
    problem = shakedown.example("two-node")
    upper = conic_upper_bound(problem, solver=solver)
    lower = conic_lower_bound(problem, solver=solver)
    assert upper.solver == lower.solver == solver
    assert upper.load_factor == pytest.approx(0.7391455673806329, rel=1e-8)
    assert lower.load_factor == pytest.approx(0.6573734697246544, rel=1e-8)


NOTHING_TO_SPARE = {  # slip zero is safe under the mean load, and rests on limits where every term vanishes
    "no friction": {"A": [[2.0]], "B": [[1.0]], "f": 0.0, "q_w": [[1.0], [-1.0]], "p_w": [[3.0], [3.0]]},
    "no load": {"A": [[1.0]], "B": [[0.3]], "f": 0.5, "q_w": [[0.0]], "p_w": [[0.0]], "C": [[1.0]]},
    "one node without friction": {
        "A": np.diag([2.0, 1.0]),
        "B": np.zeros((2, 2)),
        "f": [0.0, 0.5],
        "q_w": [[1.0, 3.0], [-1.0, 2.0]],
        "p_w": [[3.0, 2.0], [3.0, 2.0]],
    },
}


@pytest.mark.parametrize("name", NOTHING_TO_SPARE)
@pytest.mark.parametrize("unit", [1.0, 2.0**60, 2.0**-60])
def test_limits_without_any_force_are_no_contradiction(name: str, unit: float) -> None:
    data = {
        key: np.array(value) * (1.0 if key == "f" else unit) for key, value in NOTHING_TO_SPARE[name].items()
    }
    problem = shakedown.Problem(**data)
    lower = shakedown.lower_bound(problem)
    assert (lower.status, lower.load_factor) == ("optimal", 0.0)
    assert conic_lower_bound(problem).load_factor == pytest.approx(0.0, abs=1e-9)
    if unit == 1.0:
        assert shakedown.verify(problem, random_states=1).disagreements == ()


def test_a_small_force_too_much_is_seen() -> None:
    data = {"A": [[2.0]], "B": [[2.0]], "f": 1.0, "q_w": [[1.0], [1.0]], "p_w": [[1.0], [1.0]], "C": [[2.0]]}
    for excess, status in ((-1e-5, "unbounded"), (1e-5, "infeasible")):
        # v enters neither limit: (A − f B) v = 0 in the backward one, where q⁰ alone decides
        problem = shakedown.Problem(**{**data, "q_w": [[1.0 + excess], [1.0 + excess]]})
        assert conic_lower_bound(problem).status == shakedown.lower_bound(problem).status == status


def test_discs_are_as_sharp_where_friction_alone_holds_a_body() -> None:
    """In slips, whose rigid part nothing tells, Clarabel left 9e-8 of λ_max."""
    flange = shakedown.example("bolted-flange")
    first, second = shakedown.upper_bound(flange, certify=False), conic_upper_bound(flange)
    assert second.load_factor == pytest.approx(first.load_factor, rel=1e-8)
    limits = constraints(flange)
    assert limits.relative_excess(second.slip, second.load_factor).max() < 1e-8  # of every load step


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
