"""λ_1 and λ_max against cited values and closed forms, by the cheap method and in full; safe slips far from every row.

Both by solvers of others: through Clarabel, and any solver of cvxpy.
"""

import sys
from dataclasses import replace

import numpy as np
import pytest
from bounds.energy.joints import space_joint, strong_joint
from joints import creeping, safe_between, safe_later

import shakedown
from benchmarks.problems import joint, random_problem
from shakedown import Problem
from shakedown.bounds.independent_solver import conic_lower_bound, conic_upper_bound, solve_conic
from shakedown.bounds.proof_status import GuaranteeEvidence, guarantee_status
from shakedown.bounds.registry import FEW_NODES, takes_long
from shakedown.ground.errors import UsageError
from shakedown.joint.constraints import constraints, loading
from shakedown.programs.disc_program import DiscProgram


def test_two_node_system_has_the_thesis_bounds() -> None:
    bounds = shakedown.shakedown_bounds(shakedown.example("two-node"))
    assert bounds.lower.load_factor == pytest.approx(0.6573734697246544, rel=1e-12)
    assert bounds.upper.load_factor == pytest.approx(0.7391455673806329, rel=1e-12)
    np.testing.assert_allclose(bounds.lower.slip, [1.53656435, 1.59365716], atol=1e-8)
    np.testing.assert_allclose(bounds.upper.slip, [-0.15634934, 1.28772669], atol=1e-8)


def test_only_joints_of_many_nodes_in_space_take_long() -> None:
    few, many = (space_joint(0, n, m=1) for n in (FEW_NODES, FEW_NODES + 1))
    assert [takes_long(each) for each in (random_problem(60, 0), few, many)] == [False, False, True]


@pytest.mark.parametrize(
    ("name", "f", "lower", "upper"),
    [("block-9", 0.5, 0.0, 4.715032), ("block-9", 0.2, 1.219830, 1.730955), ("three-node", 0.5, 3.096, 10 / 3)],
)  # fmt: skip
def test_known_systems(name: str, f: float, lower: float, upper: float) -> None:
    bounds = shakedown.shakedown_bounds(replace(shakedown.example(name), f=f))
    assert bounds.lower.load_factor == pytest.approx(lower, abs=5e-7)
    assert bounds.upper.load_factor == pytest.approx(upper, abs=5e-7)
    if lower == 0:
        assert f"some locked-in slip lifts node {bounds.lower.node} off" in bounds.lower.reason


@pytest.mark.parametrize("joint", [strong_joint(0, 3), space_joint(1, 3), random_problem(3, 1)])
def test_only_the_load_factor_times_the_amplitude_counts(joint: Problem) -> None:
    """Down to amplitudes of 1e-9, which these numbers tell from the mean to the last bit."""
    loop, found = loading(joint), []
    q0, p0 = np.round(8 * loop.q0) / 8, np.round(8 * loop.p0) / 8
    q1, p1 = np.round(1024 * loop.q1) / 1024, np.round(1024 * loop.p1) / 1024
    for size in (1.0, 2.0**-30):
        loads = {"q_w": q0 + size * q1, "p_w": p0 + size * p1, "q_mean": q0, "p_mean": p0}
        given = Problem(A=joint.A, B=joint.B, f=joint.f, **loads)
        upper = shakedown.upper_bound(given)
        assert not upper.reduced_accuracy
        bounds = [upper, shakedown.energy_bound(given), shakedown.universal_bound(given)]
        bounds += [shakedown.lower_bound(given)] if joint.directions == 1 else []
        bounds += [shakedown.accumulated_bound(given)]  # sought to four digits
        found.append([size * bound.load_factor for bound in bounds])
    large = shakedown.upper_bound(replace(given, q_w=q0 + q1 / size, p_w=p0 + p1 / size))
    assert np.divide(large.certified, size) == pytest.approx([found[0][0]] * 2, rel=1e-9)
    assert found[1][:-1] == pytest.approx(found[0][:-1], rel=1e-9, nan_ok=True)
    assert found[1][-1] == pytest.approx(found[0][-1], rel=3e-4, nan_ok=True)


def test_zero_amplitude_is_told_from_wedging() -> None:
    problem = shakedown.example("two-node")
    point = replace(problem, q_w=problem.q_w[:1], p_w=problem.p_w[:1])
    upper = shakedown.upper_bound(point)
    assert upper.status == "unbounded"
    assert upper.reason.startswith("zero-amplitude loop")
    uncoupled = shakedown.lower_bound(replace(point, B=np.zeros((2, 2))))
    assert (uncoupled.status, uncoupled.load_factor, uncoupled.node) == ("unbounded", np.inf, -1)
    A = problem.A
    assert uncoupled.coupling_ratio == pytest.approx(abs(A[0, 1]) / np.sqrt(A[0, 0] * A[1, 1]))
    assert uncoupled.guarantee == "proved"


def test_a_floating_body_without_coupling_shakes_down_below_the_upper_bound() -> None:
    """Its safe slips vanish all together: no single node collapses, and λ_1 is λ_max (Melan)."""
    bounds = shakedown.shakedown_bounds(creeping())
    assert bounds.upper.load_factor == pytest.approx(5 / 9, rel=1e-12)
    assert bounds.lower.load_factor == bounds.upper.load_factor
    assert (bounds.lower.node, bounds.lower.guarantee) == (-1, "proved")
    assert "vanish together" in bounds.lower.reason
    assert bounds.lower.coupling_ratio == pytest.approx(1.0)


def test_the_round_off_of_a_rigid_motion_is_no_answer() -> None:
    """The stored stiffness of a floating block resists rigid motion by 1e-15; no bound may build on that."""
    bounds = shakedown.shakedown_bounds(shakedown.example("receding-block"))
    assert bounds.upper.status == bounds.lower.status == "infeasible"
    assert bounds.upper.certified is None


def test_margin_is_the_distance_from_the_nearest_row() -> None:
    problem = shakedown.example("block-9")
    safe, rows = shakedown.safe_slip(problem, 2.0), constraints(problem)
    distance = -rows.excess(safe.slip, 2.0) / np.linalg.norm(rows.G, axis=1)
    assert safe.status == "optimal"
    assert distance.min() == pytest.approx(safe.margin, rel=1e-9)
    assert len(safe.active) == problem.n + 1


def test_margin_vanishes_at_the_upper_bound_and_is_infinite_without_one() -> None:
    problem = shakedown.example("two-node")
    upper = shakedown.upper_bound(problem)
    safe = shakedown.safe_slip(problem, upper.load_factor)
    assert safe.status == "optimal"
    assert abs(safe.margin) < 1e-12
    np.testing.assert_allclose(safe.slip, upper.slip, atol=1e-9)
    beyond = shakedown.safe_slip(problem, 1.01 * upper.load_factor)
    assert beyond.status == "infeasible"
    assert beyond.margin < 0
    assert np.all(np.isnan(beyond.slip))
    rough = replace(problem, f=2.5)
    safe = shakedown.safe_slip(rough, 1.0)
    assert (safe.status, safe.margin) == ("unbounded", np.inf)
    assert constraints(rough).excess(safe.slip, 1.0).max() < 0


@pytest.mark.parametrize("n", [1, 2, 5, 12])
def test_both_methods_for_the_lower_bound_agree(n: int) -> None:
    for seed in range(2):
        problem = joint(seed, n)
        cheap, full = shakedown.lower_bound(problem), shakedown.lower_bound(problem, guarantee=True)
        assert cheap.certified is None
        assert cheap.uncertified == ""
        low, high = full.certified
        assert low <= full.load_factor <= high
        assert cheap.node == full.node
        assert cheap.load_factor == pytest.approx(full.load_factor, rel=1e-12)
        assert cheap.per_node[cheap.node] == cheap.load_factor == cheap.per_node.min()
        np.testing.assert_allclose(cheap.per_node, full.per_node, rtol=1e-8)


def test_loads_safe_from_some_load_factor_on() -> None:
    """One node that the mean load opens: safe exactly from λ = 1/2.4 on."""
    problem = safe_later()
    upper, lower = shakedown.upper_bound(problem), shakedown.lower_bound(problem)
    assert upper.least_load_factor == pytest.approx(1 / 2.4, rel=1e-12)
    assert shakedown.safe_slip(problem, 0.4167).status == "optimal"
    assert shakedown.safe_slip(problem, 0.4166).status == "infeasible"
    assert (lower.status, lower.guarantee) == ("infeasible", "evidence")


def test_a_safe_interval_that_ends() -> None:
    problem = safe_between()
    upper = shakedown.upper_bound(problem)
    assert (upper.status, upper.load_factor) == ("optimal", pytest.approx(1.5))
    assert upper.least_load_factor == pytest.approx(1 / 2.4)
    second = conic_upper_bound(problem), conic_lower_bound(problem)
    assert second[0].load_factor == pytest.approx(1.5, rel=1e-9)
    assert (second[1].status, second[1].node) == ("infeasible", -1)


def test_the_guarantee_does_not_hang_on_the_last_bit() -> None:
    """λ_1 and the lift-off bound are the same number here, computed by two methods."""
    loads = {"q_w": [[0.9, 0.0], [-0.9, 0.0]], "p_w": [[2.0, 4.0], [4.0, 4.0]]}
    base = Problem(A=np.eye(2), B=[[0.0, 0.05], [0.05, 0.0]], f=0.3, **loads)
    near = shakedown.lower_bound(base).load_factor * (1 + np.arange(-8, 9) * np.finfo(float).eps)
    assert len({guarantee_status(GuaranteeEvidence(base, at)).guarantee for at in near.tolist()}) == 1


@pytest.mark.parametrize("solver", ["CLARABEL", "HIGHS"])
def test_any_solver_of_the_modelling_layer(solver: str) -> None:
    problem = shakedown.example("two-node")
    upper = conic_upper_bound(problem, solver=solver)
    lower = conic_lower_bound(problem, solver=solver)
    assert upper.solver == lower.solver == solver
    assert upper.load_factor == pytest.approx(0.7391455673806329, rel=1e-8)
    assert lower.load_factor == pytest.approx(0.6573734697246544, rel=1e-8)


APART = {"A": np.diag([2.0, 1.0]), "B": np.zeros((2, 2))}
NOTHING_TO_SPARE = {  # slip zero is safe under the mean load, and rests on limits where every term vanishes
    "no friction": {"A": [[2.0]], "B": [[1.0]], "f": 0.0, "q_w": [[1.0], [-1.0]], "p_w": [[3.0], [3.0]]},
    "no load": {"A": [[1.0]], "B": [[0.3]], "f": 0.5, "q_w": [[0.0]], "p_w": [[0.0]], "C": [[1.0]]},
    "a node without friction": APART
    | {"f": [0.0, 0.5], "q_w": [[1.0, 3.0], [-1.0, 2.0]], "p_w": [[3.0, 2.0]] * 2},
    "a node without load": APART | {"f": 0.5, "q_w": [[0.0, 8.0], [0.0, -8.0]], "p_w": [[0.0, 4.0]] * 2},
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
