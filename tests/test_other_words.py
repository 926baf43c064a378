"""The same joint in other words – units, numbers of nodes, tangents, order of the loads – has the same answers.

Every question is asked of joints in the plane and in space and of the same joints in other words: in units of a
power of two to the last bit.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from difficult_joints import floating_joint
from hostile.laws import EXACT, SAME_BOUNDS, SAME_EVOLUTION, SAME_IN_SPACE, other_tangents
from joints_in_space import of_verdicts, random_joint
from partly_open import SOME, partly_open

import shakedown
from benchmarks.problems import random_problem
from shakedown import BOUNDS, Problem
from shakedown.assessment.plan import plan_steps
from shakedown.bounds.coupling import coupling
from shakedown.bounds.onset import first_opening, first_slip
from shakedown.motion.evolution import evolve
from shakedown.motion.fixed_steps import FixedSteps
from shakedown.motion.method import CycleRecord

pytestmark = pytest.mark.usefixtures("no_transient_limit")


@dataclass(frozen=True)
class Answers:
    """Words and numbers that stay, and quantities in the units and the node order of the joint."""

    words: tuple = ()
    numbers: tuple = ()  # without unit
    of_nodes: tuple = ()  # (…, n), without unit
    slips: tuple = ()  # (…, dn)
    lengths: tuple = ()  # (…, n)
    works: tuple = ()  # (…, n)
    energies: tuple = ()  # of the whole joint
    radii: tuple = ()  # roots of energies, which an odd power of two rounds
    nodes: tuple = ()
    round_off: tuple = ()  # without unit, and the same in other units alone


class Translated:
    """A joint in other words, and what is said of the joint in these words."""

    def __init__(self, problem: Problem, law: str, seed: int) -> None:
        self.law = lambda one: LAWS[law](one, np.random.default_rng(seed))
        self.own, self.problem = problem, self.law(problem)
        self.order = np.rint(self.law(replace(problem, f=0.5 + np.arange(problem.n))).f - 0.5).astype(int)
        self.force, stiffness = (
            2.0
            ** np.rint(
                np.log2(np.abs(getattr(self.problem, key)).sum() / np.abs(getattr(problem, key)).sum())
            )
            for key in ("p_w", "A")
        )
        self.length = self.force / stiffness

    def slip(self, slip):
        slips = np.reshape(slip, (-1, self.own.layout.slip_size))
        known = [
            self.law(replace(self.own, initial_slip=np.nan_to_num(each))).initial_slip[0] for each in slips
        ]
        return np.reshape(known, np.shape(slip))

    def of(self, said: Answers) -> Answers:
        at, work = self.order, self.force * self.length
        places = tuple(int(np.flatnonzero(at == node)[0]) if node >= 0 else node for node in said.nodes)
        return replace(
            said,
            of_nodes=tuple(np.asarray(each)[..., at] for each in said.of_nodes),
            slips=tuple(self.slip(each) for each in said.slips),
            lengths=tuple(self.length * np.asarray(each)[..., at] for each in said.lengths),
            works=tuple(work * np.asarray(each)[..., at] for each in said.works),
            energies=tuple(work * each for each in said.energies),
            radii=tuple(np.sqrt(work) * each for each in said.radii),
            nodes=places,
        )


LAWS = {**SAME_BOUNDS, **SAME_IN_SPACE, other_tangents.__name__: other_tangents}


def limits(problem: Problem) -> Answers:
    """Every kind of bound that is computed, from a state that is not zero."""
    details = shakedown.assess(problem, problem.initial_slip[0]).details
    found = [
        getattr(details, kind.name)
        for kind in BOUNDS.values()
        if kind.name != "transient" and kind.exists_for(problem)
    ]
    radii = [each.radius for each in found if each.kind == "energy"]
    total = [each.total_slip for each in found if each.kind == "accumulated"]
    return Answers(
        words=tuple(
            (each.kind, each.status, len(each.pinned), getattr(each, "guarantee", "")) for each in found
        ),
        numbers=tuple(np.append(each.load_factor, getattr(each, "certified", None) or ()) for each in found),
        slips=tuple(each.slip for each in found if each.kind in ("lower", "upper", "energy")),
        lengths=tuple(total),
        radii=tuple(radii),
        round_off=tuple(getattr(each, "residual", 0.0) for each in found),
    )


def assessment(problem: Problem) -> Answers:
    found = shakedown.assess(problem, problem.initial_slip[0])
    names = ("proved_from_every_state", "proved_from_this_state", "impossible_above")
    return Answers((found.verdict,), tuple(getattr(found, name) for name in names))


def planned(problem: Problem) -> Answers:
    """What a verification simulates at a load factor with an energy ball."""
    limits = shakedown.assess(problem, problem.initial_slip[0]).details
    (step,) = plan_steps(limits, [0.3], 1, 0)
    return Answers(tuple((case.region, case.initial) for case in step()))


def safe(problem: Problem) -> Answers:
    found = shakedown.safe_slip(problem, 0.5)
    return Answers((found.status,), slips=(found.slip,))


def ball(problem: Problem) -> Answers:
    found = shakedown.energy_ball(problem, 0.3)
    return Answers((found.status,), slips=(found.slip,), radii=(found.radius,))


def from_start(problem: Problem) -> Answers:
    """What is proved from the initial slip, also where it is not known well or is far from every safe one."""
    slip, largest = problem.initial_slip[0], shakedown.energy_ball(problem, 0.3)
    around = shakedown.energy_ball(problem, 0.3, around=slip)
    near = shakedown.energy_bound(problem, slip, 0.1 * largest.radius)
    far = shakedown.energy_bound(problem, 1e4 * (slip - largest.slip))
    error = 0.1 * float(np.linalg.norm(largest.slip - slip))
    uncertain = shakedown.accumulated_bound(problem, slip, start_error=error)
    return Answers(
        tuple(each.status for each in (around, near, far, uncertain)),
        numbers=(uncertain.load_factor,),
        slips=(around.slip,),
        radii=(around.radius, near.radius, near.load_factor * largest.radius),
        round_off=(far.residual, *far.active),
    )


def onset(problem: Problem) -> Answers:
    slip = problem.initial_slip[0]
    found = first_slip(problem, slip), first_opening(problem, slip)
    return Answers(
        tuple(each.status for each in found),
        tuple(each.load_factor for each in found),
        nodes=tuple(each.node for each in found),
    )


def zone(problem: Problem) -> Answers:
    """Limits with the nodes open that the mean load opens, and the motion from there."""
    upper = shakedown.upper_bound(problem, open_nodes="auto")
    proved = shakedown.energy_bound(problem, upper.slip, open_nodes=upper.open_nodes)
    held = shakedown.energy_ball(problem, 0.5 * upper.load_factor, open_nodes=upper.open_nodes)
    run = evolve(problem, 1.02 * upper.load_factor, upper.slip, open_nodes=upper.open_nodes, cycles=2)
    is_open = np.isin(np.arange(problem.n), upper.open_nodes)
    return Answers(
        (upper.status, proved.status, held.status, held.open_nodes == upper.open_nodes),
        (upper.load_factor, proved.load_factor),
        of_nodes=(is_open,),
        slips=(upper.slip, proved.slip, held.slip, run.cycles[-1].end_slip),
        works=tuple(each.work for each in run.cycles),
        radii=(held.radius,),
    )


def critical(problem: Problem) -> Answers:
    found = shakedown.critical_load_factors(problem, values=True)
    first = found.smallest_feasible
    return Answers(
        (found.regular, found.degenerate), (*found.load_factors, first.load_factor), slips=(first.slip,)
    )


def friction(problem: Problem) -> Answers:
    found = shakedown.friction_thresholds(problem)
    sets = found.uniqueness_in_contact, found.uniqueness, found.wedging
    numbers = tuple(value for each in sets for value in (each.low, each.high))
    return Answers(numbers=(*numbers, coupling(problem).ratio), of_nodes=(found.single_node,))


def above(problem: Problem) -> float:
    """A load factor at which the joint slips in every cycle."""
    return 1.2 * shakedown.upper_bound(problem, certify=False).load_factor


def followed(problem: Problem) -> Answers:
    return cycles_of(evolve(problem, above(problem), problem.initial_slip[0], cycles=2).cycles)


def jumped(problem: Problem) -> Answers:
    found = cycles_of(evolve(problem, 0.93, cycles=2).cycles)
    assert found.energies
    return found


def cycles_of(cycles: list[CycleRecord]) -> Answers:
    return Answers(
        (len(cycles), *((each.opened.sum(), each.closed.sum()) for each in cycles)),
        slips=tuple(each.end_slip for each in cycles),
        lengths=tuple(each.slip for each in cycles),
        works=tuple(each.work for each in cycles),
        energies=tuple(jump.energy_released for each in cycles for jump in each.jumps),
    )


def stepped(problem: Problem) -> Answers:
    steps = FixedSteps(problem, above(problem), problem.initial_slip[0])
    cycles = [steps.cycle() for _ in range(2)]
    return Answers(
        slips=tuple(each.end_slip for each in cycles),
        energies=tuple(each.dissipation for each in cycles),
    )


def state(problem: Problem) -> Answers:
    return known(shakedown.long_term_state(problem, above(problem), problem.initial_slip[0], max_cycles=40))


def proved(problem: Problem) -> Answers:
    """A state at rest whose slip to come is bounded from some cycle on."""
    found = shakedown.long_term_state(problem, 1.07)
    proof = found.proof_found
    return Answers((proof.by, proof.cycles), round_off=(proof.further / np.abs(found.final_slip).max(),))


def slow(problem: Problem) -> Answers:
    """A state that is approached over hundreds of cycles, most of which are leapt over."""
    return known(shakedown.long_term_state(problem, 1.24963))


def known(found: shakedown.LongTermState) -> Answers:
    return Answers(
        (found.outcome, found.period, found.cycles_simulated),
        slips=(found.final_slip,),
        lengths=(found.slip_per_cycle,),
        energies=(found.dissipation_per_cycle,),
        round_off=(found.return_error, found.residual, found.error / np.max(found.slip_per_cycle)),
    )


def started(problem: Problem, seed: int = 0) -> Problem:
    """The joint with an initial slip of a hundredth of what its loads would move it."""
    size = 0.01 * np.abs(problem.q_w).max() / np.abs(problem.A).max()
    slip = size * np.random.default_rng(seed).normal(size=problem.layout.slip_size)
    return replace(problem, initial_slip=slip)


PLANE = {
    "four nodes": started(random_problem(4, 1)),
    "floating": started(floating_joint(np.random.default_rng(1), 4, "plane", "smooth")),
    "partly open": partly_open(SOME[1]),
}
SPACE = {
    "two nodes": started(random_joint(np.random.default_rng(2), 2)),
    "four-node-3d": started(shakedown.example("four-node-3d")),
    "floating in space": started(floating_joint(np.random.default_rng([1, 7]), 3, "translations", "smooth")),
    "one-node-3d": started(shakedown.example("one-node-3d")),
    "jumping": started(of_verdicts("floating", 35, 3)),
}
BOUNDS_OF = (limits, assessment, safe, ball, onset)
MOTIONS = (followed, stepped, state)
QUESTIONS = [
    *((ask, "four nodes", law) for ask in (*BOUNDS_OF, critical, friction) for law in SAME_BOUNDS),
    (planned, "four nodes", EXACT),
    *((ask, "floating", law) for ask in (limits, safe, ball) for law in SAME_EVOLUTION),
    *((zone, "partly open", law) for law in SAME_EVOLUTION),
    *((ask, "four nodes", law) for ask in MOTIONS for law in SAME_EVOLUTION),
    *((ask, "two nodes", law) for ask in BOUNDS_OF for law in SAME_IN_SPACE),
    *((ask, "floating in space", EXACT) for ask in (limits, from_start)),
    *((from_start, name, law) for name in ("four nodes", "two nodes") for law in (EXACT, "other_origin")),
    (slow, "one-node-3d", EXACT),
    (proved, "four-node-3d", EXACT),
    (jumped, "jumping", EXACT),
    *((ask, "four-node-3d", law) for ask in MOTIONS for law in SAME_IN_SPACE if law != "backwards"),
]


@cache
def asked(ask: Callable[[Problem], Answers], name: str) -> Answers:
    """The answers of a joint in its own words."""
    return ask((PLANE | SPACE)[name])


def same(one: Answers, other: Answers, law: str, accuracy: float) -> None:
    assert (other.words, other.nodes) == (one.words, one.nodes)
    for field in ("numbers", "of_nodes", "slips", "lengths", "works", "energies", "radii", "round_off"):
        for expected, found in zip(getattr(one, field), getattr(other, field), strict=True):
            if law == EXACT and field != "radii":
                np.testing.assert_array_equal(np.nan_to_num(found), np.nan_to_num(expected))
            elif field != "round_off":
                size = np.abs(np.nan_to_num(expected, posinf=0.0)).max(initial=0.0)
                np.testing.assert_allclose(found, expected, rtol=accuracy, atol=accuracy * size)


@pytest.mark.parametrize(
    ("ask", "name", "law"),
    [pytest.param(*each, marks=pytest.mark.slow if each[0] is stepped else ()) for each in QUESTIONS],
    ids=lambda x: x if isinstance(x, str) else x.__name__,
)
def test_a_joint_in_other_words_has_the_same_answers(ask, name, law):
    problem = (PLANE | SPACE)[name]
    there = Translated(problem, law, seed=len(name))
    # paths in space, arcs in space and those from far away are known to an accuracy
    accuracy = 1e-11 if name in PLANE and law != "other_origin" else 1e-8
    same(there.of(asked(ask, name)), ask(there.problem), law, accuracy)
