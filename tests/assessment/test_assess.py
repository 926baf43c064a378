"""The three numbers of a joint: those of its bounds, each computed once, and what follows from them.

With two tangential directions some limits do not exist. One mesh tells whether its edge decides them: where they
fall with the mesh, and only there.
"""

from dataclasses import replace

import numpy as np
import pytest
from command import document, run
from joints_in_space import random_joint

import shakedown
from benchmarks.bodies.classical import press_fit
from benchmarks.bodies.sphere import sphere_on_flat
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from benchmarks.problems import random_problem
from benchmarks.refinement import block_on_plane, similar_blocks
from shakedown.assessment.every_limit import admitted_up_to
from shakedown.bounds import accumulated_bound as accumulated_module
from shakedown.bounds import upper as upper_module
from shakedown.ground.errors import Missing
from shakedown.ground.status import LimitsVerdict
from shakedown.joint.constraints import loading
from tests.joints import any_joint

TWO, THREE, BLOCK = (shakedown.example(name) for name in ("two-node", "three-node", "block-9"))
RECEDING, IN_SPACE = (shakedown.example(name) for name in ("receding-block", "two-node-3d"))


def random_joint_of_two(_, seed):
    return random_joint(np.random.default_rng(seed), 2)


@pytest.mark.parametrize("problem", [TWO, THREE, BLOCK])
def test_the_numbers_are_those_of_the_bounds(problem):
    found = shakedown.assess(problem)
    lower, energy = shakedown.lower_bound(problem, certify=True), shakedown.energy_bound(problem)
    every = shakedown.universal_bound(problem, first_collapse=lower)
    upper = shakedown.upper_bound(problem)
    assert found.proved_from_every_state == every.load_factor
    slip = shakedown.accumulated_bound(problem)
    assert found.proved_from_this_state == np.fmax(energy.load_factor, slip.load_factor)
    above = upper.load_factor if upper.certified is None else upper.certified[1]
    assert found.impossible_above == max(above, upper.load_factor)
    assert found.details.lower == lower


def test_a_state_known_to_a_distance_has_what_its_ball_proves():
    found = shakedown.assess(shakedown.example("pair-cycle"), distance=1.0)
    assert "distance=1" in repr(found.details)
    assert "zone" not in repr(found.details)
    assert found.proved_from_this_state == found.details.energy.load_factor < found.proved_from_every_state


@pytest.mark.parametrize("seed", range(3))
def test_what_is_proved_and_what_is_impossible_is_so(seed):
    rng = np.random.default_rng(seed)
    problem = any_joint(rng)
    slip = rng.normal(size=problem.n) * (seed % 2)
    found = shakedown.assess(problem, slip, open_nodes=())
    every, here, above = found.proved_from_every_state, found.proved_from_this_state, found.impossible_above
    assert max(every, here) <= above * (1 + 1e-9)
    if 0 < here < np.inf:
        for share in (0.5, 0.999):
            state = shakedown.long_term_state(problem, share * here, slip)
            assert (state.outcome, state.open_nodes) == (shakedown.Outcome.SHAKEDOWN, ())
    if above < np.inf:
        state = shakedown.long_term_state(problem, 1.01 * above + 1e-3, slip)
        assert state.outcome != shakedown.Outcome.SHAKEDOWN or state.open_nodes
    assert found.verdict != LimitsVerdict.SHAKEDOWN or found.as_given == shakedown.Outcome.SHAKEDOWN


@pytest.mark.parametrize("exponent", [3, 9, 30])
@pytest.mark.parametrize("number", range(4))
def test_no_claim_refutes_another_however_small_friction_is(number, exponent):
    """What is proved at any friction is not above what is proved to be impossible there, by not one bit."""
    makers = (drawn_joint, drawn_joint_in_space, lambda _, seed: random_problem(2, seed), random_joint_of_two)
    problem = makers[number](5, exponent % 3)
    problem = replace(problem, f=10.0**-exponent * np.broadcast_to(problem.f, problem.n))
    found = shakedown.assess(problem, open_nodes=())
    limits, above = found.details, found.impossible_above
    proved = [found.proved_from_every_state, found.proved_from_this_state]
    proved += [limits.energy.load_factor, limits.accumulated.load_factor]
    assert not any(each > above for each in proved)
    assert above > 0.0 or limits.upper.status == "infeasible" or not problem.f.any()


def test_a_proof_that_certified_numbers_refute_is_withdrawn(monkeypatch):
    """As round-off may leave it: λ_S 1e-6 above the exact λ_max."""
    above = (1.0 + 1e-6) * shakedown.upper_bound(TWO).load_factor
    wrong = replace(shakedown.accumulated_bound(TWO), load_factor=above)
    monkeypatch.setattr(accumulated_module, "accumulated_bound", lambda *_: wrong)
    found = shakedown.assess(TWO, open_nodes=())
    withdrawn = found.details.accumulated
    assert (withdrawn.status, np.isnan(withdrawn.load_factor)) == ("undecided", True)
    assert "round-off decides" in withdrawn.reason
    assert not found.proved_from_this_state > found.impossible_above


def test_a_bound_in_floats_that_a_proof_refutes_is_withdrawn(monkeypatch):
    every, upper = shakedown.universal_bound(IN_SPACE), shakedown.upper_bound(IN_SPACE)
    for factor, status in ((1.0 - 1e-9, "optimal"), (0.99, "undecided")):
        wrong = replace(upper, load_factor=factor * every.load_factor, certified=None, uncertified="too soft")
        monkeypatch.setattr(upper_module, "upper_bound", lambda *_, wrong=wrong, **__: wrong)
        found = shakedown.assess(IN_SPACE)
        assert found.details.upper.status == status
        assert not found.proved_from_every_state > found.impossible_above
    assert np.isnan(found.impossible_above)
    assert "shakedown is proved up to" in found.details.upper.reason


def test_every_state_is_one_that_the_first_load_admits_after_the_transient():
    far = 100.0 * np.ones(3)
    assert admitted_up_to(THREE, far) == 0.0
    moved = shakedown.assess(THREE, far)
    assert moved.proved_from_this_state < moved.proved_from_every_state
    before = replace(TWO, q_transient=[[15.8, -400.0]], p_transient=[[588.5, 1300.0]])
    limits = shakedown.assess(before).details
    known = [getattr(limits, name).load_factor for name in ("energy", "accumulated")]
    assert shakedown.assess(before).proved_from_this_state == np.fmax.reduce(known)


def test_of_open_nodes_nothing_is_excluded_and_the_bounds_do_not_decide():
    found = shakedown.assess(RECEDING)
    assert found.details.open_nodes
    assert (found.impossible_above, found.verdict) == (np.inf, LimitsVerdict.OPEN)
    closed = shakedown.assess(RECEDING, open_nodes=())
    assert (closed.impossible_above, closed.verdict) == (0.0, LimitsVerdict.IMPOSSIBLE)
    assert np.isnan(closed.details.mesh.edge_share)


def test_one_joint_has_one_transient_limit():
    limits = shakedown.assess(TWO).details
    verified = shakedown.verify(TWO, load_factors=[1.0], random_states=0).transient
    swept = shakedown.sweep(TWO, {"f": [0.35]}, bounds=["transient"])
    finer = shakedown.transient_limit(TWO)
    assert limits.transient == verified
    assert swept.transient[0] == pytest.approx(verified.load_factor, rel=1e-14)
    assert verified.low <= finer.low * (1 + 1e-14)
    assert finer.high <= verified.high * (1 + 1e-14)


def test_what_the_plane_alone_has_is_missing_with_the_reason():
    limits = shakedown.assess(IN_SPACE).details
    for found in (limits.lower, limits.friction):
        assert isinstance(found, Missing)
        assert not found
        assert "expected one tangential direction, found two (" in found.reason
    assert set(limits.sensitivities) == {"upper", "energy"}
    with pytest.raises(shakedown.UsageError) as refused:
        shakedown.lower_bound(IN_SPACE)
    assert str(refused.value) == limits.lower.reason


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("space", [True, False])
def test_the_first_load_step_admits_a_slip_up_to_where_it_is_on_its_cone(seed, space):
    rng = np.random.default_rng(seed)
    m = int(rng.integers(1, 6))
    problem = random_joint(rng, 3, pressure=3.0, m=m) if space else random_problem(3, seed)
    slip, loop = 0.03 * rng.normal(size=problem.layout.slip_size), loading(problem)

    def outside(load_factor):
        q = loop.q0 + load_factor * loop.q1[0] + problem.A @ slip
        p = loop.p0 + load_factor * loop.p1[0] + problem.B @ slip
        return (np.linalg.norm(q.reshape(3, -1), axis=1) - problem.f * p).max()

    limit = admitted_up_to(problem, slip)
    if limit == 0.0:
        assert outside(0.0) > 0
    elif np.isfinite(limit):
        assert outside(limit) == pytest.approx(0.0, abs=1e-9 * (1 + limit))
        assert outside(0.999 * limit) < 0 < outside(1.001 * limit)
    else:
        assert outside(1e6) <= 1e-6


def test_a_load_factor_within_the_enclosure_of_the_largest_is_not_said_to_be_impossible():
    """Node 1 has no friction, and its pressure 1 + λ cos t ends at λ = 1: λ_max is 1 but for round-off."""
    turn = 2 * np.pi * np.arange(8) / 8
    B = np.zeros((2, 4))
    B[[0, 1], [0, 2]] = 0.3
    q_w, p_w = np.outer(np.cos(turn), [0.04, 0, 0, 0]), np.stack([np.ones(8), 1 + np.cos(turn)], 1)
    joint = shakedown.Problem(A=2 * np.eye(4), B=B, C=2 * np.eye(2), f=[0.5, 0.0], q_w=q_w, p_w=p_w)
    found = shakedown.assess(joint)
    low, high = found.details.upper.certified
    assert low <= 1.0 <= high
    assert found.impossible_above == max(high, found.details.upper.load_factor) >= 1.0
    assert found.verdict == "open"


def test_where_a_body_begins_to_slide_away_is_found_to_all_digits():
    one, t = np.eye(2), 2 * np.pi * np.arange(8) / 8
    q = np.zeros((8, 4))
    q[:, 0], q[:, 2] = 0.4 + 0.1 * np.cos(t), 0.3 + 0.2 * np.cos(t)
    free = np.block([[one, -one], [-one, one]])
    joint = shakedown.Problem(A=free, B=np.zeros((2, 4)), C=one, f=0.5, q_w=q, p_w=np.ones((8, 2)))
    limit = shakedown.transient_limit(joint)  # friction 0.5 · 2 holds 0.7 + 0.3 λ
    assert limit.at_high.slides_away
    assert limit.low <= 1.0 <= limit.high <= limit.low + 1e-8


@pytest.mark.parametrize("joint", [block_on_plane(8, 0.2), block_on_plane(8, 0.3)])
def test_it_warns_where_the_corner_slips_at_any_load(joint):
    mesh = shakedown.assess(joint).details.mesh
    assert mesh.edge_share > 0.7
    assert sorted(mesh.edge_nodes) == [0, joint.n - 1]
    assert mesh.coarser["impossible_above"] > 0.1
    assert mesh.warning.startswith("The edge determines λ_max (node 0, 8). ")
    change = f"{100 * mesh.coarser['impossible_above']:.0f} % higher"
    assert f"On the coarser mesh (every second node) impossible above is {change}, " in mesh.warning
    assert mesh.warning.endswith("; a finer mesh may lower them.")


@pytest.mark.slow
def test_a_round_rim_decides_although_no_node_of_it_does_alone():
    mesh = shakedown.assess(sphere_on_flat(3)).details.mesh
    assert mesh.edge_share > 0.99
    assert mesh.edge_nodes == ()
    assert mesh.warning.startswith("The edge determines λ_max. ")


def test_what_is_zero_already_does_not_get_lower():
    mesh = shakedown.assess(shakedown.example("block-9")).details.mesh
    assert mesh.coarser["proved_from_every_state"] == np.inf
    assert "proved from every state is positive, here 0." in mesh.warning


@pytest.mark.parametrize("joint", [press_fit(1), similar_blocks(8, 0.3)])
def test_it_says_nothing_where_limits_converge(joint):
    mesh = shakedown.assess(joint).details.mesh
    assert mesh.edge_share < 0.01
    assert set(mesh.coarser) == {"impossible_above", "proved_from_this_state", "proved_from_every_state"}
    assert max(map(abs, mesh.coarser.values())) < 0.1
    assert mesh.warning is None


def test_it_is_silent_where_nodes_are_few_or_nowhere():
    for joint in (shakedown.example("two-node"), block_on_plane(4, 0.2), replace(press_fit(1), x=None)):
        mesh = shakedown.assess(joint).details.mesh
        assert np.isnan(mesh.edge_share)
        assert (mesh.coarser, mesh.warning) == ({}, None)


@pytest.mark.parametrize(("side", "tells"), [(3, False), (4, True)])
def test_of_a_patch_sixteen_nodes_make_a_coarser_mesh(side, tells):
    x = np.stack(np.meshgrid(*[np.arange(float(side))] * 2), axis=-1).reshape(-1, 2)
    joint = replace(random_joint(np.random.default_rng(0), side**2), x=x)
    assert np.isfinite(shakedown.assess(joint).details.mesh.edge_share) == tells


def test_the_command_tells_it(tmp_path):
    path = str(tmp_path / "block.npz")
    shakedown.save_problem(path, block_on_plane(8, 0.2))
    said = document("solve", path, "--average", "0.5")
    assert set(said["mesh"]) == {"edge_share", "coarser", "warning"}
    assert said["averaged"]["nodes"] == 5
    twice = said["averaged"]["impossible_above"] / said["assessment"]["impossible_above"] - 1
    assert said["mesh"]["coarser"]["impossible_above"] == pytest.approx(twice, rel=1e-9)
    out = " ".join(run("solve", path, "--average", "0.5")[1].split())
    assert said["mesh"]["warning"] in out
    assert "Averaged over 0.5: 5 knots" in out


def test_the_three_numbers_of_an_averaged_joint_are_about_the_averaged_state():
    joint = block_on_plane(8, 0.3)
    rough = 1e-5 * np.random.default_rng(0).normal(size=9)
    found = shakedown.assess(joint, rough).averaged(0.5)
    between = shakedown.averaged(replace(joint, initial_slip=rough), 0.5)
    again = shakedown.assess(between, between.initial_slip[0])
    assert found.proved_from_this_state == pytest.approx(again.proved_from_this_state, rel=1e-9)
