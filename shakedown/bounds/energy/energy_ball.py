"""The largest ball of slips, in the energy norm, from which every motion is proved to shake down."""

from collections.abc import Iterable
from dataclasses import replace

from numpy.typing import ArrayLike

from shakedown.bounds.energy.energy_results import EnergyBall as EnergyBall
from shakedown.bounds.plane_or_space import methods_of
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked, checked_initial_slip, require_problem
from shakedown.joint.contact_zone import Zone, contact_zone
from shakedown.joint.problem import Problem


@checked
def energy_ball(
    problem: Problem,
    load_factor: float,
    *,
    around: ArrayLike | None = None,
    transient: bool = True,
    open_nodes: Iterable[int] = (),
    split: bool = True,
    tolerances: Tolerances = DEFAULT,
) -> EnergyBall:
    """The largest ball from which shakedown is proved at one load factor, by a linear program.

    Maximise R over (v*, R) subject to f p ∓ q ≥ f_i γ_i R for every node, side and load
    step at the slip v*, with γ_i the energy norm of what pressure and slip of a node
    have to do with each other beyond the node itself. With a state given, maximise its
    margin R − ‖v − v*‖ instead, by a cone program: where no ball holds it, near the
    largest load factors, the largest ball is a small one in another place. With two tangential
    directions a_i |q| + f_i γ_i R ≤ f p at every load step (docs/energy.md, section 8), by cone programs.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    around : (n,), optional
        The state v that is to be as far inside as possible [length].
    transient
        Whether the transient load steps, where the problem has them, are still to come.
    open_nodes
        Nodes that are open through the whole period, all others closed; each adds the
        condition that its gap stays.
    split
        With two directions, whether the part c_i of a pressure that the node's own reaction determines is
        taken out of γ_i, in a few rounds; else c = 0. In the plane it always is.
    tolerances
        What counts as zero and as feasible (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If the load factor is negative or not finite, the state mis-shaped, or nothing
        holds the open nodes.
    ProblemError
        If nodes are open and the problem has no C.
    SolverError
        If the program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> ball = shakedown.energy_ball(shakedown.example("two-node"), 0.36957278)
    >>> round(ball.radius, 3), ball.status, ball.nodes
    (63.312, <Status.OPTIMAL: 'optimal'>, (0, 1))
    >>> ball.contains(ball.slip), ball.contains([[0.0, 0.0], [9.0, 9.0]])
    (np.True_, array([ True, False]))
    """
    require_problem(problem)
    check_load_factor(load_factor, problem)
    state = None if around is None else checked_initial_slip(problem, around)
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    return _in_zone(zone, load_factor, state, tolerances, transient=transient, split=split)


def holding_ball(
    problem: Problem,
    load_factor: float,
    state: FloatArray,
    open_nodes: tuple[int, ...],
    tolerances: Tolerances,
) -> EnergyBall:
    """A ball that holds a state after the transient: in space the first that is met, if any does.

    Raises as :func:`energy_ball`, which finds the one that holds it best.
    """
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    return _in_zone(zone, load_factor, state, tolerances, transient=False, split=True, best=False)


def no_ball_holds(
    problem: Problem,
    load_factor: float,
    state: FloatArray,
    open_nodes: tuple[int, ...],
    tolerances: Tolerances,
) -> bool:
    """Whether it is proved, sooner than λ_E is found, that no ball holds a state before the transient."""
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    held = state[problem.layout.slips_of(zone.closed_nodes)]
    return methods_of(problem).no_ball_holds(zone, load_factor, held, tolerances)


def _in_zone(
    zone: Zone,
    load_factor: float,
    state: FloatArray | None,
    tolerances: Tolerances,
    *,
    transient: bool,
    split: bool,
    best: bool = True,
) -> EnergyBall:
    """A ball of the closed nodes of a zone in terms of all nodes."""
    problem = zone.problem
    held = None if state is None else state[problem.layout.slips_of(zone.closed_nodes)]
    find = methods_of(problem).energy_ball
    ball = find(zone, load_factor, held, tolerances, transient=transient, split=split, best=best)
    return replace(ball, slip=zone.slips(ball.slip), zone=zone) if zone.open_nodes else ball
