"""The adversary: cycles that are there, none where there are none, exact ends of their patterns."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from benchmarks.adversary import difficult_joint
from benchmarks.problems import in_units, random_problem
from shakedown import fem
from shakedown.assessment import every_limit
from shakedown.bounds.collapse.single_node_cycle import single_node_cycle
from shakedown.ground.errors import UsageError
from shakedown.joint.constraints import constraints, step_loads
from shakedown.joint.loading import loading
from shakedown.studies.cycle_pattern import cycle_pattern, first_load_slip

TWO, THREE = shakedown.example("two-node"), shakedown.example("three-node")
QUICK = {"states": 16, "rounds": 3}


def with_friction(name, f):
    problem = shakedown.example(name)
    return replace(problem, f=np.full(problem.n, f))


@pytest.fixture(scope="module")
def clamped():
    """A clamped block whose outermost nodes open and close just above the first collapse."""
    block = fem.ElasticBody(
        fem.block_mesh(23.0, 8.0, 7, 3),
        fem.Material(young=210e3, poisson=0.3),
        loads=[
            fem.Pressure("top", 60.0, history=1.0),
            fem.Traction("top", (12.0, 0.0), history=lambda t: np.sin(2 * np.pi * t)),
        ],
        thickness=10.0,
    )
    return fem.contact_problem(block, "bottom", f=0.6, steps=24)


@pytest.fixture(scope="module")
def cycles():
    """(problem, load factor, long-term state) of cycles with all nodes closed."""
    found = []
    for problem in (TWO, THREE, with_friction("block-9", 0.2), with_friction("block-9", 0.5)):
        lower, upper = shakedown.lower_bound(problem), shakedown.upper_bound(problem)
        starts = [(1.01 * upper.load_factor, upper.slip)]
        starts += [(0.5 * (lower.load_factor + upper.load_factor), lower.slip)]
        starts += [(2.6, problem.initial_slip[0])] if problem is THREE else []
        for load_factor, slip in starts:
            state = shakedown.long_term_state(problem, load_factor, slip)
            if cycle_pattern(problem, state) is not None:
                found.append((problem, load_factor, state))
    assert len(found) >= 6
    return found


def test_the_end_of_a_pattern_is_no_higher_than_its_cycle_and_satisfies_every_row(cycles):
    for problem, load_factor, state in cycles:
        pattern = cycle_pattern(problem, state)
        least = pattern.least()
        assert 0.0 <= least.load_factor <= load_factor * (1 + 1e-9)
        rows = constraints(problem)
        loop = loading(problem)
        first = np.stack([loop.q1[0] - problem.f * loop.p1[0], -loop.q1[0] - problem.f * loop.p1[0]], axis=1)
        excess = rows.G @ least.slip + least.load_factor * first.ravel() - rows.g
        assert excess.max() <= 1e-9 * np.abs(rows.g).max()


def test_between_its_end_and_the_cycle_found_a_pattern_cycles_all_the_way(cycles):
    for problem, load_factor, state in cycles:
        least, start = cycle_pattern(problem, state).least(), first_load_slip(problem, state.history)
        for share in (1e-3, 0.1, 0.7):
            between = least.load_factor + share * (load_factor - least.load_factor)
            if between == load_factor:
                continue
            slip = least.slip + share * (start - least.slip)
            again = shakedown.long_term_state(problem, between, slip)
            assert again.outcome == "cyclic-slip"
            assert again.return_error < 1e-9
            assert first_load_slip(problem, again.history) == pytest.approx(slip, abs=1e-9 * np.ptp(start))


def test_a_cycle_of_one_node_ends_where_the_bound_for_one_node_says():
    state = shakedown.long_term_state(THREE, 2.6, THREE.initial_slip[0])
    least = cycle_pattern(THREE, state).least()
    assert least.load_factor == pytest.approx(single_node_cycle(THREE).load_factor, rel=1e-12)


def test_the_counter_example_is_found_and_said():
    found = shakedown.smallest_cycle(THREE, **QUICK)
    assert found.status == "found"
    assert found.load_factor == pytest.approx(2.4442105, rel=1e-6)
    assert (found.slipping_nodes, found.period, found.below_first_collapse) == ((0,), 1, True)
    again = shakedown.long_term_state(THREE, found.load_factor, found.initial_slip)
    assert again.outcome == "cyclic-slip"
    assert again.dissipation_per_cycle == found.dissipation_per_cycle > 0
    low, high = found.interval
    assert low == shakedown.universal_bound(THREE).load_factor < high == found.load_factor


def test_two_nodes_that_cycle_together_below_every_cycle_of_one_are_found():
    problem = shakedown.example("pair-cycle")
    lower = shakedown.lower_bound(problem)
    assert lower.load_factor == pytest.approx(3.096, rel=1e-12)
    assert lower.single_node_bound == pytest.approx(3.096, rel=1e-12)
    assert lower.guarantee == "single-node-excluded"
    assert "weak evidence" in lower.reason
    found = shakedown.smallest_cycle(problem, **QUICK)
    assert found.load_factor == pytest.approx(1.699024, abs=1e-6)
    assert found.slipping_nodes == (0, 1)


@pytest.mark.parametrize("problem", [TWO, shakedown.example("one-node"), shakedown.example("uncoupled")])
def test_where_the_first_collapse_is_proved_a_cycle_begins_just_above_it(problem):
    found = shakedown.smallest_cycle(problem, **QUICK)
    assert (found.status, found.contradiction) == ("found", "")
    assert found.load_factor == pytest.approx(found.limits.lower.load_factor, rel=1e-5)
    assert found.load_factor > found.limits.universal.load_factor * (1 - 1e-9)
    assert not found.below_first_collapse


def test_separation_just_above_the_first_collapse_is_no_cycle_but_ends_the_interval(clamped):
    found = shakedown.smallest_cycle(clamped, **QUICK)
    first, apart = found.limits.lower.load_factor, found.separation_load_factor
    assert first < apart == pytest.approx(first, rel=2e-6)
    assert apart < 0.9 * found.load_factor
    assert found.interval == (found.limits.universal.load_factor, apart)
    assert found.outcome == "cyclic-slip"
    assert shakedown.long_term_state(clamped, apart, found.separation_slip).outcome == "separation"
    document = found.to_dict()
    assert document["separation_load_factor"] == apart
    assert document["separation_slip"] == found.separation_slip.tolist()


def test_separation_found_on_the_way_is_followed_down_and_does_not_know_the_units():
    joint = with_friction("press-fit", 0.8)
    one = shakedown.smallest_cycle(joint, **QUICK, accuracy=1e-3)
    scaled = shakedown.smallest_cycle(in_units(joint, 2.0**10, 2.0**-5), **QUICK, accuracy=1e-3)
    assert one.limits.universal.load_factor < one.separation_load_factor < one.load_factor
    state = shakedown.long_term_state(joint, one.separation_load_factor, one.separation_slip)
    assert state.outcome == "separation"
    assert scaled.separation_load_factor == pytest.approx(one.separation_load_factor, rel=1e-9)
    rows, load = constraints(joint), step_loads(joint)[0]
    excess = rows.G @ one.separation_slip + one.separation_load_factor * load - rows.g
    assert excess.max() <= 1e-9 * np.abs(rows.g).max()


def test_separation_below_what_is_called_proved_is_a_contradiction(monkeypatch, clamped):
    real = every_limit.universal_bound

    def mistaken(*arguments, **options):
        return replace(real(*arguments, **options), load_factor=2.0)

    monkeypatch.setattr(every_limit, "universal_bound", mistaken)
    found = shakedown.smallest_cycle(clamped, **QUICK)
    assert found.load_factor > 2.0 > found.separation_load_factor
    assert found.status == "contradiction"
    assert "λ_U = 2 is called proved from every state" in found.contradiction


def test_a_first_collapse_of_zero_is_real():
    joint = with_friction("block-9", 0.5)
    found = shakedown.smallest_cycle(joint, states=4, rounds=1)
    assert found.limits.lower.load_factor == 0.0
    assert 0.0 < found.load_factor < 1e-4
    assert shakedown.long_term_state(joint, found.load_factor, found.initial_slip).outcome == "cyclic-slip"


@pytest.mark.parametrize("band", ["weak", "below one", "strong", "star"])
def test_nothing_cycles_below_what_is_proved(band):
    generator = np.random.default_rng(7)
    for _ in range(2):
        problem = difficult_joint(generator, 3, band)
        try:
            found = shakedown.smallest_cycle(problem, **QUICK, accuracy=1e-4)
        except UsageError:
            continue
        assert found.status != "contradiction", found.contradiction
        assert found.load_factor >= found.limits.universal.load_factor * (1 - 1e-7)


def test_the_answer_is_repeatable_and_does_not_know_the_units():
    problem = random_problem(4, 3)
    one, other = (shakedown.smallest_cycle(problem, **QUICK, seed=5) for _ in range(2))
    assert one == other
    scaled = shakedown.smallest_cycle(in_units(problem, 2.0**20, 2.0**-7), **QUICK, seed=5)
    assert scaled.load_factor == pytest.approx(one.load_factor, rel=1e-9)
    assert scaled.initial_slip == pytest.approx(one.initial_slip * 2.0**-7, rel=1e-6)
    assert (scaled.tries, scaled.slipping_nodes) == (one.tries, one.slipping_nodes)


def test_transient_load_steps_are_left_out():
    lifted = replace(TWO, q_transient=np.full((1, 2), 300.0), p_transient=np.full((1, 2), 3000.0))
    assert shakedown.smallest_cycle(lifted, **QUICK).load_factor == pytest.approx(0.6573735, rel=1e-5)


def test_a_cycle_below_what_is_called_proved_is_a_contradiction(monkeypatch):
    real = every_limit.universal_bound

    def mistaken(*arguments, **options):
        return replace(real(*arguments, **options), load_factor=3.0)

    monkeypatch.setattr(every_limit, "universal_bound", mistaken)
    found = shakedown.smallest_cycle(THREE, states=64, rounds=4)
    assert found.status == "contradiction"
    assert "λ_U = 3 is called proved from every state" in found.contradiction
    assert found.load_factor < 3.0


def test_where_nothing_cycles_nothing_is_made_up():
    found = shakedown.smallest_cycle(shakedown.example("jump"), **QUICK)
    assert (found.status, found.load_factor, found.state, found.period) == ("none found", np.inf, None, 0)
    assert np.isnan(found.initial_slip).all()
    assert found.to_dict()["load_factor"] == "inf"


def test_own_states_and_a_smaller_start_are_taken():
    found = shakedown.smallest_cycle(THREE, states=8, rounds=1, largest=2.6, initial_slips=THREE.initial_slip)
    assert found.load_factor == pytest.approx(2.4442105, rel=1e-6)
    assert found.tried_up_to == 2.6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"states": 0}, "states: expected at least 1"),
        ({"rounds": 0}, "rounds: expected at least 1"),
        ({"seed": -1}, "seed: expected a whole number >= 0"),
        ({"seed": 0.5}, "seed: expected a whole number, found 0.5"),
        ({"accuracy": 0.0}, "accuracy: expected a number between 0 and 1"),
        ({"largest": 0.0}, "largest: expected a positive load factor"),
        ({"largest": np.nan}, "largest: expected a positive load factor"),
        ({"initial_slips": [[0.0]]}, r"initial slips: expected shape \(s, 2\)"),
    ],
)
def test_bad_arguments_are_one_line(options, message):
    with pytest.raises(UsageError, match=message):
        shakedown.smallest_cycle(TWO, **options)


def grazing(force=1.0, length=1.0):
    """A node that the mean load holds with nothing to spare: any loop makes it slip, at hardly any pressure."""
    p, q = 1e-9 * np.array([1.0, 1.0, 1.0, 1.0]), np.array([0.0, 1.0, 0.0, -1.0])
    return shakedown.Problem(
        A=np.eye(2) * force / length, B=np.zeros((2, 2)), f=0.5,
        q_w=force * np.column_stack([q, 0 * q]), p_w=force * np.column_stack([p, np.ones(4)]),
    )  # fmt: skip


@pytest.mark.parametrize(("force", "length"), [(1.0, 1.0), (1e7, 1e-3)])
def test_what_takes_less_than_the_data_resolve_is_no_cycle(force, length):
    """Near its limit the cycle takes 4 f p A⁻¹ λ q at most: as small as one likes, and no cycle there."""
    near = shakedown.smallest_cycle(grazing(force, length), rounds=3, states=16)
    assert (near.status, near.dissipation_per_cycle) == ("none found", pytest.approx(np.nan, nan_ok=True))
    found = shakedown.smallest_cycle(grazing(force, length), rounds=3, states=16, largest=1.0)
    assert found.status == "found"
    assert found.dissipation_per_cycle > found.least_dissipation > 0
    assert found.least_dissipation == pytest.approx(16 * np.finfo(float).eps * force * length, rel=0.1)
    assert found.load_factor > 1e-6  # λ_max = 5e-10
    said = found.to_dict()
    assert said["least_dissipation"] == found.least_dissipation


def test_stiffness_of_seven_digits_resolves_less():
    coarse = replace(grazing(), stiffness_accuracy=1e-7)
    found = shakedown.smallest_cycle(coarse, rounds=3, states=16, largest=1.0)
    assert found.status == "none found"
    assert found.least_dissipation == pytest.approx(1.6e-6, rel=0.1)


def test_slip_without_friction_is_a_cycle_although_it_takes_nothing():
    free = replace(grazing(), f=[0.0, 0.5])
    found = shakedown.smallest_cycle(free, rounds=2, states=8)
    assert (found.status, found.slipping_nodes) == ("found", (0,))
    assert found.dissipation_per_cycle == pytest.approx(0.0, abs=1e-20)
