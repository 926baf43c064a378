"""Bounds of partly open joints: what a zone promises the exact evolution keeps, also begun with nodes open."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

import shakedown
from benchmarks.bodies.lap_joint import lap_joint
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from shakedown import UsageError, long_term_state, safe_slip, simulate, upper_bound
from shakedown.bounds.independent_solver import conic_upper_bound
from shakedown.bounds.largest_load_factor import best_zone, opened_by_mean_load
from shakedown.joint.constraints import loading
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.units import without_loads
from shakedown.motion.evolution import evolve
from shakedown.report.limit_facts import claims, solve_sheet
from tests.partly_open import SOME, partly_open, zone_bound
from tests.uncoupled_parts import joined, with_mean

# without its transient: that begins without load, where the safe slip is not admissible
RECEDING = replace(without_loads(shakedown.example("receding-block")), q_transient=None, p_transient=None)
UPPER = upper_bound(RECEDING, open_nodes="auto")


@pytest.mark.parametrize("seed", SOME[:3])
def test_the_search_finds_the_best_of_all_zones(seed):
    problem = partly_open(seed, n=4)
    found = best_zone(problem)
    every = [
        upper_bound(problem, open_nodes=nodes, certify=False)
        for count in range(problem.n)
        for nodes in combinations(range(problem.n), count)
    ]
    values = [bound.load_factor for bound in every if bound.status != "infeasible"]
    best = max(values, default=-np.inf)
    assert found.load_factor == pytest.approx(best, rel=1e-9)


def test_the_best_zone_of_uncoupled_parts_is_that_of_each():
    parts = [with_mean(partly_open(seed, n=4)) for seed in (8, 9)]
    first, second = (best_zone(part).zone.open_nodes for part in parts)
    assert upper_bound(joined(parts), open_nodes="auto").open_nodes == (*first, *(4 + k for k in second))


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_of_zones_that_are_equally_good_the_first_is_taken(way):
    """Node 2 alone decides; slip of node 0 presses node 1 or draws it off, and both are safe."""
    B, p = 0.5 * np.eye(3, k=-1) * [[1.0], [1.0], [0.0]], [10.0, -0.1 * way, 1.0]
    loads = {"q_w": [[-way, 0.0, 0.6], [-way, 0.0, -0.6]], "p_w": [p, p]}
    search = best_zone(shakedown.Problem(A=np.eye(3), B=B, C=np.eye(3), f=0.3, **loads))
    assert (search.load_factor, search.visited) == (pytest.approx(0.5), 7)
    assert search.zone.open_nodes == search.opened == (() if way > 0 else (1,))


def test_a_closed_node_that_moves_with_open_ones_alone_is_pinned():
    """A part held by friction alone, of which one node stays closed: its stiffness is round-off."""
    generator, open_nodes, free, held, unit = np.random.default_rng(3), [0, 2], [0, 2, 3, 5], [1, 4], 1e6
    for _ in range(10):
        factor = generator.normal(size=(7, 6))
        factor[:, :2] -= factor[:, :2].mean(axis=1, keepdims=True)  # the motion (1, 1, 0 | 0, 0, 0)
        kappa = unit * factor.T @ factor
        flexibility = np.linalg.inv(kappa[np.ix_(free, free)])
        swing = generator.uniform(-0.5, 0.5, (4, 6))
        load = swing - swing.mean(axis=0)
        load[:, free] -= kappa[np.ix_(free, free)] @ [0.0, 0.0, 1e3 / unit, 1e3 / unit]  # the mean gaps
        left = kappa[np.ix_(held, free)] @ flexibility
        load[:, held] += load[:, free].mean(axis=0) @ left.T + [0.0, 10.0]
        blocks = {"A": kappa[:3, :3], "B": kappa[3:, :3], "C": kappa[3:, 3:]}
        joint = shakedown.Problem(**blocks, f=0.5, q_w=load[:, :3], p_w=load[:, 3:])
        q, p = (load[:, held] - load[:, free] @ left.T - [0.0, 10.0]).T
        exact = 5.0 / np.maximum(q - 0.5 * p, -q - 0.5 * p).max()  # Coulomb's law of one node, no slip in it
        upper, energy = (each(joint, open_nodes=open_nodes) for each in (upper_bound, shakedown.energy_bound))
        assert upper.pinned == (1,)
        assert [upper.load_factor, energy.load_factor] == pytest.approx([exact, exact], rel=1e-8)


def test_of_many_nodes_in_space_those_next_to_opening_or_closing_are_tried():
    joint = partly_open(1, 24, d=2)
    start = upper_bound(joint, open_nodes=opened_by_mean_load(joint, friction=False), certify=False)
    search = best_zone(joint)
    assert search.load_factor > 1.3 * start.load_factor
    assert search.visited <= 25


@pytest.mark.parametrize("d", [1, 2])
@pytest.mark.parametrize("seed", range(6))
def test_without_friction_the_mean_load_opens_what_pulls_and_nothing_else(seed, d):
    """The complementarity that has one solution; nodes of six and more, and their gaps in both directions of slip."""
    joint = partly_open(seed, 6 + seed % 7, d=d)
    is_open = np.isin(np.arange(joint.n), opened_by_mean_load(joint, friction=False))
    loop = loading(joint)
    at_rest = np.append(np.zeros(d * joint.n, dtype=bool), ~is_open)
    r_w, kappa = np.append(loop.q0, loop.p0), joint.kappa
    u = np.zeros(len(r_w))
    u[~at_rest] = np.linalg.solve(kappa[np.ix_(~at_rest, ~at_rest)], -r_w[~at_rest])
    w, p = u[-joint.n :], (r_w + kappa @ u)[-joint.n :]
    assert (w[is_open] >= 0).all()
    assert (p[~is_open] >= 0).all()


def test_a_node_on_which_open_ones_press_and_pull_alike_is_not_opened_by_round_off():
    C, p_w = np.array([[2.0, 1.0, -1.0], [1.0, 2.0, 0.0], [-1.0, 0.0, 2.0]]), [[0.0, -2.0, -2.0]]
    joint = shakedown.Problem(A=np.eye(3), B=np.zeros((3, 3)), C=C, f=0.3, q_w=np.zeros((1, 3)), p_w=p_w)
    assert opened_by_mean_load(joint) == opened_by_mean_load(joint, friction=False) == (1, 2)


def test_a_mean_load_that_opens_a_node_asks_for_its_zone_though_closed_nodes_have_a_safe_slip():
    joint = partly_open(21, 3, d=2)
    closed, found = upper_bound(joint), upper_bound(joint, open_nodes="auto")
    assert 0 < closed.load_factor < 0.5 * found.load_factor
    assert found.open_nodes == (0,)
    proved = shakedown.energy_bound(joint, open_nodes="auto").load_factor
    assert shakedown.energy_bound(joint).status == "infeasible"
    assert 0 < proved <= found.load_factor
    state = shakedown.long_term_state(joint, 0.99 * proved)
    assert (state.outcome, state.open_nodes) == ("shakedown", (0,))


def test_a_long_lap_is_answered_from_the_nodes_that_its_bolts_open():
    """Of 105 nodes gaps knew the rigid motions by round-off: slips of 8e7 mm bought 5 % of λ_max. Here are 63."""
    lap = lap_joint((20, 2, 2), reach=np.inf, steps=4)
    opened = opened_by_mean_load(lap, friction=False)
    upper = upper_bound(lap, open_nodes=opened)
    assert len(opened) == 18
    assert upper.load_factor == pytest.approx(1.5538002, rel=1e-5)
    assert upper.residual <= 1e-9
    assert np.abs(upper.slip).max() < 0.05
    assert len(upper.pinned) == 3
    assert not {slip // 2 for slip in upper.pinned} & set(opened)
    energy = shakedown.energy_bound(lap, open_nodes=opened, certify=False)
    assert energy.load_factor == pytest.approx(1.5482704, rel=1e-5)


def test_of_the_safe_slips_of_a_zone_the_least_is_given():
    """Without coupling each closed node has a range of safe slips; the one that decides has a single one."""
    q = np.array([[0.62, 5.2, 0.0], [-0.58, 4.8, 0.0]])
    p = np.array([[1.0, 10.0, -1.0], [1.0, 10.0, -1.0]])
    for plane in (True, False):
        A, tangential = (np.eye(3), q) if plane else (np.eye(6), np.kron(q, [1.0, 0.0]))
        joint = shakedown.Problem(A=A, B=np.zeros((3, len(A))), C=np.eye(3), f=0.3, q_w=tangential, p_w=p)
        found = upper_bound(joint, open_nodes=[2])
        assert found.load_factor == pytest.approx(0.5)
        assert found.slip.reshape(3, -1)[:, 0] == pytest.approx([-0.02, -2.1, 0.0], abs=1e-8)
        overlapping = replace(joint, p_w=p * [1.0, 1.0, -1.0])  # whatever the closed nodes do
        safe = safe_slip(overlapping, 0.25, open_nodes=[2])
        assert (safe.status, safe.margin) == ("infeasible", -np.inf)


def slides_away(n):
    """A chain of nodes that only friction holds, pulled along with more than that."""
    A = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    A[0, 0] = A[-1, -1] = 1.0
    q_w = np.outer([1.1, 0.9], np.ones(n))
    return shakedown.Problem(A=A, B=np.zeros((n, n)), C=np.eye(n), f=0.3, q_w=q_w, p_w=np.ones((2, n)))


def test_impossible_is_said_only_where_every_zone_was_tried():
    few, many = (shakedown.assess(slides_away(n)) for n in (3, 7))
    assert few.details.upper.status == "infeasible"
    assert few.impossible_above == 0.0
    assert not best_zone(slides_away(3)).left_out
    assert many.details.upper.status == "undecided"
    assert "not all were" in many.details.upper.reason
    assert np.isnan(many.impossible_above)
    assert many.verdict == "open"
    assert claims(many)[2].value == "unknown"
    assert solve_sheet(many).claims.rows[2][1] == "unknown"
    assert [each.shown for each in solve_sheet(many).facts if each.label == "no safe slip"]
    document = many.details.upper.to_dict()
    assert (document["status"], document["load_factor"]) == ("undecided", None)
    assert upper_bound(slides_away(7)).status == "infeasible"  # with all nodes closed


def test_the_safe_slip_of_a_zone_has_slack_at_every_row():
    safe = safe_slip(RECEDING, 0.5 * UPPER.load_factor, open_nodes=UPPER.open_nodes)
    assert safe.open_nodes == UPPER.open_nodes
    assert safe.margin > 0
    zone = contact_zone(RECEDING, UPPER.open_nodes)
    inside = safe.slip[list(zone.closed_nodes)]
    assert (zone.constraints.excess(inside, 0.5 * UPPER.load_factor) < 0).all()


def test_a_wrong_zone_is_reported_not_believed():
    assert upper_bound(RECEDING, open_nodes=[16]).status == "infeasible"
    with pytest.raises(UsageError, match="whole numbers or 'auto', found 'all'"):
        upper_bound(RECEDING, open_nodes="all")
    with pytest.raises(UsageError, match="node 16 would overlap by"):
        evolve(RECEDING, 0.5 * UPPER.load_factor, UPPER.slip, open_nodes=[16])


@pytest.mark.parametrize("power", [-40, 25])
@pytest.mark.parametrize(
    ("draw", "seed", "index", "zone"),
    [(drawn_joint_in_space, 503, 6, (0, 1)), (drawn_joint_in_space, 516, 2, (0,)), (drawn_joint, 902, 9, (0,))],
)  # fmt: skip
def test_rows_that_no_slip_changes_do_not_set_the_units_of_the_others(power, draw, seed, index, zone):
    """Gaps of a zone that no slip opens have lengths, friction limits have forces."""
    problem = replace(draw(seed, index), initial_slip=None)
    stiffer = replace(problem, **{key: getattr(problem, key) * 2.0**power for key in "ABC"})
    here, there = (upper_bound(each, open_nodes=zone) for each in (problem, stiffer))
    assert there.status == here.status == "optimal"
    assert there.load_factor == pytest.approx(here.load_factor, rel=1e-9)
    there = conic_upper_bound(stiffer, open_nodes=zone)
    assert there.load_factor == pytest.approx(here.load_factor, rel=1e-7)


@pytest.mark.parametrize("transient", [False, True])
@pytest.mark.parametrize("seed", [*SOME[:3], *SOME[12:18]])
def test_below_the_bound_of_the_zone_nothing_slips(seed, transient):
    """Between the ends of its bound, started at rest in it."""
    problem, upper = partly_open(seed), zone_bound(seed)
    if upper.status != "optimal":
        assert np.isnan(upper.load_factor) or upper.load_factor == np.inf
        return
    assert upper.residual < 1e-9
    for share in (0.5, 0.999):
        load_factor = upper.least_load_factor + share * (upper.load_factor - upper.least_load_factor)
        if transient:  # load steps in between those of the loop
            weights = np.random.default_rng(seed).dirichlet(np.ones(problem.m), size=3)
            q_w, p_w = (weights @ load for load in loading(problem).at(load_factor))
            problem = replace(problem, q_transient=q_w, p_transient=p_w)
        run = evolve(problem, load_factor, upper.slip, open_nodes=upper.open_nodes, cycles=3)
        size = np.abs(upper.slip).max()
        assert run.stop is None
        assert max(cycle.slip.max() for cycle in run.cycles) < 1e-9 * size
        state = long_term_state(problem, load_factor, upper.slip, open_nodes=upper.open_nodes)
        assert state.outcome == "shakedown"
        assert state.open_nodes == upper.open_nodes


@pytest.mark.parametrize("method", ["event", "gauss-seidel"])
def test_the_receding_block_rests_in_its_zone_and_slips_above(method):
    closed = list(contact_zone(RECEDING, UPPER.open_nodes).closed_nodes)
    for share, rests in ((0.99, True), (1.02, False)):
        load_factor = share * UPPER.load_factor
        run = simulate(
            RECEDING, load_factor, UPPER.slip, open_nodes=UPPER.open_nodes, method=method, cycles=3
        )
        assert (run.cycles.slip[0][closed].max() < 1e-12) == rests
        assert not rests or (run.outcome, run.open_nodes) == ("shakedown", UPPER.open_nodes)


def test_slips_given_for_open_nodes_do_not_matter():
    other = UPPER.slip.copy()
    other[list(UPPER.open_nodes)] = 17.0
    one, two = (
        evolve(RECEDING, 0.9 * UPPER.load_factor, slip, open_nodes=UPPER.open_nodes, cycles=2)
        for slip in (UPPER.slip, other)
    )
    assert (one.initial_slip == two.initial_slip).all()
    assert (one.cycles[-1].end_slip == two.cycles[-1].end_slip).all()
