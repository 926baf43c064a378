"""Verification: what is planned, when the two methods agree, and what only limits the evidence.

Prediction against simulation with two tangential directions.
"""

import json
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from joints import creeping, safe_between, safe_later
from stated_limits import stated

import shakedown
from shakedown import Problem
from shakedown.assessment import assess as module
from shakedown.assessment import plan
from shakedown.assessment import verify as verify_module
from shakedown.assessment.plan import ABOVE, BELOW, BETWEEN, IN_ZONE, NO_ZONE, OUTSIDE, PROVED, UNSAFE
from shakedown.bounds.independent_solver import ConicBound, conic_lower_bound, conic_upper_bound
from shakedown.ground.errors import Missing
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT
from shakedown.ground.work_limit import limited_work
from shakedown.joint.constraints import constraints
from shakedown.motion.evolution import evolve
from shakedown.motion.space import space_events

TWO = shakedown.example("two-node")
SAFE_LATER = safe_later()
SAFE_BETWEEN = safe_between()


@pytest.mark.parametrize("problem", [SAFE_LATER, SAFE_BETWEEN])
def test_an_unsafe_mean_load_is_planned_from_the_least_safe_load_factor(problem: Problem) -> None:
    report = shakedown.verify(problem, random_states=1)
    assert report.agrees, report.disagreements
    judged = {run.region for run in report.runs if run.agrees}
    assert {UNSAFE, "between"} <= judged
    assert report.assessment.proved_from_this_state == 0.0  # from no load on


def second(status: Status, load_factor: float) -> ConicBound:
    return ConicBound(status, load_factor, -1, np.zeros(1), "A SOLVER")


@pytest.mark.parametrize(
    ("status", "load_factor", "agrees"),
    [
        (Status.OPTIMAL, 0.7391455673806329, "yes"),
        (Status.OPTIMAL, 0.7391, False),
        (Status.UNBOUNDED, np.inf, False),
        (Status.INFEASIBLE, np.nan, False),
        (Status.UNDECIDED, np.nan, None),
    ],
)
def test_a_second_method_that_contradicts_is_found(status, load_factor, agrees) -> None:
    bounds = shakedown.shakedown_bounds(TWO)
    good = second(Status.OPTIMAL, bounds.lower.load_factor)
    methods = module.SecondBounds(good, second(status, load_factor), 2)
    found = list(module.independent_findings(bounds, methods, DEFAULT))
    assert [verdict for verdict, _ in found] == ([] if agrees == "yes" else [agrees])


@pytest.mark.parametrize(
    "joint", [SAFE_LATER, SAFE_BETWEEN, shakedown.example("uncoupled"), creeping(), replace(TWO, f=2.5)]
)
def test_both_methods_say_the_same_where_no_node_collapses(joint: Problem) -> None:
    methods = module.SecondBounds(conic_lower_bound(joint), conic_upper_bound(joint), joint.n)
    assert not list(module.independent_findings(shakedown.shakedown_bounds(joint), methods, DEFAULT))


@pytest.mark.parametrize(("largest", "size"), [(2.0, 2.0), (inf, 1.0)])
@pytest.mark.parametrize(("share", "unit", "differ"), [(0.9, 1, []), (1.1, 1, [False]), (1.1, 1.2, [None])])
def test_bounds_differ_by_a_share_of_the_largest_or_of_the_nominal_load(largest, size, share, unit, differ):
    """Unless the other solver tells no smaller differences apart in the unit of its load factors."""
    limits = stated(lower={"load_factor": 0.0}, upper={"load_factor": largest})
    one = replace(second(Status.OPTIMAL, share * DEFAULT.agreement * size), unit=unit * size)
    bounds = module.ShakedownBounds(limits.lower, limits.upper)
    methods = module.SecondBounds(one, second(Status.OPTIMAL, largest), 2)
    found = list(module.independent_findings(bounds, methods, DEFAULT))
    assert [verdict for verdict, _ in found] == differ


def test_a_second_method_that_gives_up_is_a_note(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "conic_upper_bound", lambda *_, **__: second(Status.UNDECIDED, np.nan))
    report = shakedown.verify(shakedown.example("one-node"), random_states=0, budget=1)
    assert report.agrees
    assert report.critical.total == report.limits.subsets == 1
    assert report.open_questions == ()
    (note,) = report.notes
    said = "λ_max: the independent solver (A SOLVER) stopped without an answer; the value rests"
    assert note.startswith(said)


def test_every_piece_of_work_is_told_to_the_end() -> None:
    told: list[tuple[int, int]] = []
    shakedown.verify(TWO, random_states=0, progress=lambda *at: told.append(at))
    total = told[0][1]
    assert told == [(k, total) for k in range(2, total + 1)]  # the first run, before the others are planned


@pytest.mark.parametrize(
    "joint",
    [
        replace(shakedown.example("block-9"), f=np.full(9, 0.2)),
        replace(TWO, initial_slip=[[0.1, -0.2], [0.0, 0.0]]),
        replace(TWO, q_transient=[[100.0, -300.0]], p_transient=[[700.0, 1200.0]]),
    ],
    ids=["block-9", "given", "transient"],
)
def test_a_bound_of_total_slip_beyond_the_ball_is_simulated_just_below(joint: Problem) -> None:
    report = shakedown.verify(joint, random_states=0, budget=0)
    here = report.limits.from_state
    assert report.critical is None
    assert (here.symbol, here.load_factor) == ("λ_S", report.limits.accumulated.load_factor)
    assert here.load_factor > report.limits.energy.load_factor
    last = max((run for run in report.runs if run.bounded), key=lambda run: run.load_factor)
    assert 0 < 1.0 - last.load_factor / here.load_factor < 1e-5
    assert np.array_equal(last.start, report.limits.accumulated.initial_slip)
    assert (last.in_ball, last.predicted, last.simulation.outcome) == (False, "shakedown", "shakedown")
    assert report.agrees, report.disagreements


@pytest.mark.usefixtures("no_transient_limit")
def test_two_threads_find_what_one_does(monkeypatch: pytest.MonkeyPatch) -> None:
    def found() -> list:
        report = shakedown.verify(shakedown.example("one-node-3d"), load_factors=[0.3], random_states=2)
        return [run.to_dict() | {"seconds": 0} for run in report.runs]

    alone = found()
    monkeypatch.setattr(verify_module, "takes_long", lambda problem: True)
    monkeypatch.setattr(verify_module, "all_cores", lambda: 2)
    assert found() == alone


UNBOUNDED = {"load_factor": inf, "status": "unbounded"}
LATER = {"load_factor": 2.0, "least_load_factor": 0.5}
ZONE = {"load_factor": 2.0, "least_load_factor": 0.4, "open_nodes": (1,)}
AT_HALF = {"load_factor": 0.5}


@pytest.mark.parametrize(
    ("bounds", "followed"),
    [
        ({"lower": AT_HALF, "upper": {"load_factor": 2.0}}, {0.475: BELOW, 0.95: BETWEEN, 2.1: ABOVE}),
        ({"lower": AT_HALF, "upper": {"load_factor": 0.500045}}, {0.475: BELOW, 0.52504725: ABOVE}),  # alike
        ({"lower": AT_HALF, "upper": {"load_factor": 0.50006}}, {0.475: BELOW, 0.500018: BETWEEN, 0.525063: ABOVE}),
        ({"lower": AT_HALF, "upper": UNBOUNDED}, {0.475: BELOW, 0.75: BETWEEN}),
        ({"lower": {"load_factor": inf}, "upper": UNBOUNDED}, {1.0: BELOW, 10.0: BELOW}),
        ({"lower": {"load_factor": 0.0}, "upper": {"load_factor": 0.0}}, {1.0: ABOVE}),
        ({"lower": {"load_factor": nan}, "upper": LATER}, {0.475: UNSAFE, 0.95: BETWEEN, 2.1: ABOVE}),
        ({"lower": {"load_factor": nan}, "upper": LATER | UNBOUNDED}, {0.475: UNSAFE, 0.75: BETWEEN}),
        ({"lower": {"load_factor": nan}, "upper": {"status": "infeasible"}}, {1.0: NO_ZONE}),
        ({"lower": {"load_factor": nan}, "upper": {"status": "infeasible"}, "zone": ()}, {1.0: ABOVE}),
        ({"lower": {"load_factor": nan}, "upper": {"status": "undecided"}}, {1.0: OUTSIDE}),
        ({"lower": AT_HALF, "upper": ZONE}, {0.475: BELOW, 1.2: IN_ZONE, 1.9984: IN_ZONE, 2.1: OUTSIDE}),
        ({"lower": AT_HALF, "upper": ZONE | UNBOUNDED}, {0.475: BELOW, 0.6: IN_ZONE}),
        ({"lower": {"load_factor": nan}, "upper": ZONE | UNBOUNDED | {"least_load_factor": 0.0}}, {1.0: IN_ZONE}),
        ({"name": "two-node-3d", "universal": {"load_factor": 0.0}, "energy": AT_HALF, "upper": {"load_factor": 2.0}},
         {0.475: BETWEEN, 0.95: BETWEEN, 2.1: ABOVE}),
        ({"name": "two-node-3d", "universal": {"load_factor": 0.0}, "energy": {"load_factor": 0.0}, "upper": {"load_factor": 2.0}},
         {0.6: BETWEEN, 2.1: ABOVE}),
        ({"name": "two-node-3d", "universal": AT_HALF, "upper": {"load_factor": 2.0}},
         {0.475: PROVED, 0.95: BETWEEN, 2.1: ABOVE}),
    ],
)  # fmt: skip
def test_one_load_factor_is_followed_a_little_inside_of_every_region(bounds, followed):
    limits = stated(**bounds)
    factors = plan.default_load_factors(limits)
    assert factors == pytest.approx([*followed], rel=1e-12)
    assert [plan.region_of(factor, limits) for factor in factors] == [*followed.values()]


@pytest.mark.parametrize("open_nodes", [(0,), (1,)])
def test_below_the_first_collapse_a_zone_that_is_none_contradicts_nothing(open_nodes):
    """Whatever nodes are said to stay open: from closed states shakedown is predicted, and found."""
    report = shakedown.verify(TWO, open_nodes=open_nodes, load_factors=[0.3], random_states=0)
    assert not report.disagreements
    assert {(run.predicted, run.arrives_closed) for run in report.runs[1:]} == {("shakedown", True)}


@pytest.mark.parametrize("name", ["two-node", "two-node-3d"])
def test_states_in_a_ball_are_just_inside_its_surface_or_as_far_away_as_other_states(name):
    limits = shakedown.assess(shakedown.example(name)).details
    (step,) = plan.plan_steps(limits, [0.7], 1, 0)
    starts = {case.initial: case.start for case in step()}
    ball = limits.ball_at(0.7)
    drawn = [starts.pop(name) for name in list(starts) if name.startswith("ball")]
    assert len(drawn) == 2
    reach = max(np.abs(start - ball.slip).max() for start in starts.values())
    for start in drawn:
        assert ball.contains(start)
        outwards = ball.slip + 1.001 * (start - ball.slip)
        assert not ball.contains(outwards) or np.abs(start - ball.slip).max() == pytest.approx(reach)


@pytest.fixture(scope="module")
def found():
    return shakedown.verify(shakedown.example("two-node-3d"), random_states=1)


def test_bounds_and_simulations_agree(found):
    assert found.agrees
    assert not found.notes
    assert {"below λ_U", "between", "above λ_max"} <= {run.region for run in found.runs}
    for each in found.runs:
        assert each.simulation.residual < 1e-7
        if each.region == "below λ_U" or each.in_ball:
            assert each.simulation.outcome == "shakedown"
            assert each.agrees
            margin = found.limits.ball_at(each.load_factor).margin(each.simulation.final_slip)
            assert each.simulation.energy_margin == pytest.approx(float(margin), rel=1e-9)
        if each.initial == "safe" and each.region != "above λ_max":
            excess = constraints(each.simulation.problem).relative_excess(each.start, each.load_factor)
            assert excess.max() <= DEFAULT.feasibility
    transient = found.transient
    assert found.limits.energy.load_factor * (1 - 1e-9) <= transient.load_factor < transient.cycling
    assert transient.proved <= transient.load_factor <= found.limits.upper.load_factor
    assert (found.second.lower, found.second.nodes) == (None, 0)
    assert found.second.upper.load_factor == pytest.approx(found.limits.upper.load_factor, rel=1e-7)


def test_the_document_says_what_there_is(found):
    document = json.loads(json.dumps(found.to_dict()))
    assert document["lower"] is document["box"] is document["friction"] is document["critical"] is None
    assert document["universal"]["load_factor"] == found.limits.universal.load_factor
    assert len(document["runs"]) == len(found.runs)
    assert len(document["nodes"]["slip_range_x"]) == 2
    assert np.isfinite(document["upper"]["certified"]).all()


def test_a_ball_of_the_plan_holds_what_is_proved():
    limits = shakedown.assess(shakedown.example("four-node-3d")).details
    energy, upper = limits.energy.load_factor, limits.upper.load_factor
    for load_factor in (0.9 * energy, 0.5 * (energy + upper)):
        ball = limits.ball_at(load_factor)
        largest, below = shakedown.energy_ball(limits.problem, load_factor), load_factor < energy
        between = 0.5 * (limits.energy.slip + limits.upper.slip)  # safe halfway
        held = np.zeros(8) if below else between
        assert 0 < ball.radius <= largest.radius * (1 + 1e-9)
        assert ball.radius - ball.distance(held) > largest.radius - largest.distance(held)
        assert limits.ball_at(load_factor) is ball
        assert bool(ball.contains(np.zeros(8))) == below
    assert isinstance(limits.ball_at(1.01 * upper), Missing)


@pytest.mark.usefixtures("no_transient_limit")
def test_transient_load_steps_come_first():
    problem = shakedown.example("one-node-3d")
    before = replace(problem, q_transient=0.5 * problem.q_w[:2], p_transient=problem.p_w[:2])
    found = shakedown.verify(before, random_states=0, load_factors=[0.5])
    assert found.agrees
    assert found.transient is None  # the fixture does what it says
    assert found.runs[0].simulation.outcome == "shakedown"


def test_above_λ_max_other_starts_have_the_work_that_the_first_one_leaves(monkeypatch):
    """With as much as it takes a run comes to its end, with less it is cut, but not within a quarter of all."""
    problem = shakedown.example("two-node-3d")
    load_factor = 1.05 * shakedown.upper_bound(problem).load_factor
    monkeypatch.setattr(space_events, "CALL_OPERATIONS", 1)

    def beyond(limits, start):
        found, work = limits.slip_beyond(load_factor, start, 1000)
        return work, "the computation allowed for a run is spent" in found.reason

    path = evolve(problem, load_factor, cycles=15).cycles
    starts = np.zeros(4), path[8].end_slip, path[-1].end_slip
    first, near, last = (beyond(shakedown.assess(problem, start).details, start)[0] for start in starts)
    for more, start, cut in ((1.1 * near, 1, False), (0.5 * near, 1, True), (0.5 * last, 2, False)):
        monkeypatch.setattr("shakedown.assessment.every_limit.WORK_BEYOND", first + more)
        limits = shakedown.assess(problem).details
        assert [beyond(limits, each)[1] for each in (starts[0], starts[start])] == [False, cut]


def test_runs_that_take_too_much_work_are_said_to_be_open(monkeypatch):
    """Within their first cycle: nothing is claimed of them, and what is known without them stays."""
    monkeypatch.setattr(space_events, "CALL_OPERATIONS", 1)
    monkeypatch.setattr("shakedown.assessment.verify.limited_work", lambda _: limited_work(1e3))
    cut = shakedown.verify(shakedown.example("two-node-3d"), random_states=1)
    open_runs = [each for each in cut.runs if each.simulation.outcome == "undecided"]
    assert open_runs
    assert all(each.agrees is None for each in open_runs)
    assert not cut.disagreements
    said = [text for text in cut.open_questions if "the computation allowed for a run is spent" in text]
    assert len(said) == len(open_runs)
    assert all(text.endswith("; simulate, which has no such limit, goes on with it") for text in said)
    assert cut.limits.upper.load_factor > 0.0
    assert cut.to_dict()
