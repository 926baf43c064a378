"""Whether the evolution with all nodes closed is unique for the given friction, and the proof."""

from dataclasses import dataclass

from shakedown.bounds.uniqueness.coupling import energy_limit, weakly_coupled
from shakedown.bounds.uniqueness.moving_sets import (
    LARGEST_SET,
    MovingSet,
    every_set,
    few_nodes,
    first_to_lose,
)
from shakedown.bounds.uniqueness.scaled_stiffness import ScaledStiffness, held, scaled_stiffness
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIGNS, checked, require_plane
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class Uniqueness(Result):
    """Result of :func:`unique_in_contact`; true as a condition where uniqueness is proved.

    Attributes
    ----------
    unique
        True: every evolution with all nodes closed is unique. False: a set of slipping
        nodes loses its uniqueness. None: neither is known.
    argument
        What proves it, in words.
    slipping, sides
        Where uniqueness is lost: a set of slipping nodes, and the sides (+1 backward,
        −1 forward) for which their determinant vanishes at this friction or below.
    """

    unique: bool | None
    argument: str
    slipping: tuple[int, ...] = ()
    sides: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        return self.unique is True


@checked
def unique_in_contact(problem: Problem, *, tolerances: Tolerances = DEFAULT) -> Uniqueness:
    """Whether every principal minor of A + S f B is positive for every diagonal S of signs ±1.

    Then the quasi-static evolution with all nodes closed is unique, for any loading and
    from any state (thesis (4.23), (6.4)–(6.10)). Exact up to eight nodes; beyond, the
    coupling ratio or the energy may prove it, a single node or a pair disprove it.
    Friction at a threshold, to the tolerance ``feasibility``, counts as above it.

    Parameters
    ----------
    problem
        The joint; its loading plays no part.
    tolerances
        What counts as zero.

    Examples
    --------
    >>> import shakedown
    >>> unique_in_contact(shakedown.example("two-node")).argument
    'coupling ratio below 1'
    >>> lost = unique_in_contact(shakedown.example("jump"))
    >>> lost.unique, lost.slipping
    (False, (0, 1))
    """
    require_plane("uniqueness", problem, NO_SIGNS)
    stiffness = scaled_stiffness(problem, problem.f, tolerances)
    friction = stiffness.friction_unit * (1 + tolerances.feasibility)  # the factor that f is on the weights
    if not held(stiffness.A, stiffness.tolerances):
        return Uniqueness(
            False, "only friction holds the body: if all its nodes slip, nothing determines how fast"
        )
    if not stiffness.weighted.any():
        return Uniqueness(True, "slip changes no friction limit (f B = 0)")
    if weakly_coupled(stiffness, friction):
        return Uniqueness(True, "coupling ratio below 1")
    n = stiffness.n
    if n <= LARGEST_SET:
        return _judged(stiffness, every_set(n, separation=False), friction, every=True)
    few = _judged(stiffness, few_nodes(stiffness, separation=False), friction)
    if few.unique is False:
        return few
    if energy_limit(stiffness, separation=False) > friction:
        return Uniqueness(True, "every motion stores more energy than friction can feed it")
    return few


def _judged(
    stiffness: ScaledStiffness, sets: list[MovingSet], friction: float, *, every: bool = False
) -> Uniqueness:
    """What these moving sets tell."""
    lost = first_to_lose(stiffness, sets)
    if lost.factor > friction:
        if every:
            return Uniqueness(True, f"every set of slipping nodes tried ({len(sets)})")
        return Uniqueness(None, f"too many sets of slipping nodes to try all ({stiffness.n} nodes)")
    nodes = ", ".join(str(i) for i in lost.moving.slipping)
    word = "node" if len(lost.moving.slipping) == 1 else "nodes"
    at = lost.factor / stiffness.friction_unit
    return Uniqueness(
        False,
        f"slip of {word} {nodes} loses uniqueness at {at:.5g} times the given friction",
        lost.moving.slipping,
        lost.sides,
    )
