"""The kinds of limits of the load factor: what each is about, for which joints it exists, what computes it.

``BOUNDS`` is what assessments, verifications, sweeps, reports and the command iterate over. To add a kind,
write a module with its function and an :class:`~shakedown.bounds.bound_result.Evidence`, and one entry here.
"""

from dataclasses import dataclass
from enum import StrEnum
from pkgutil import resolve_name
from typing import Any

from shakedown.joint.arguments import NO_SIDES, in_the_plane_only
from shakedown.joint.problem import Problem


class Claim(StrEnum):
    """What holds for a joint below a limit, or above it.

    EVERY_STATE
        Below it shakedown is proved from every state.
    THIS_STATE
        Below it shakedown is proved from the state that is asked about.
    IMPOSSIBLE
        Above it shakedown is impossible.
    COLLAPSE
        Below it every node keeps a range of slips between its limits.
    FOLLOWED
        Up to it a simulation from the state that is asked about shakes down.
    CREEP
        From it on a simulation from the state that is asked about is seen to creep.
    """

    EVERY_STATE = "proved from every state"
    THIS_STATE = "proved from this state"
    IMPOSSIBLE = "impossible above"
    COLLAPSE = "first collapse"
    FOLLOWED = "simulated from this state"
    CREEP = "creeps from this state"


@dataclass(frozen=True)
class BoundKind:
    """A kind of limit of the load factor.

    Attributes
    ----------
    name
        Its name in documents, options and :class:`~shakedown.assessment.every_limit.JointLimits`.
    symbol
        λ with an index.
    title
        What it is, in a few words, where several kinds have one claim.
    claim
        What holds for the joint below or above it.
    function
        ``"module:function"`` that computes it from the limits of a joint; it is loaded when asked for.
    more_than
        The same of a function of these limits and a load factor that tells quickly whether the limit may be
        larger than that; empty where nothing does.
    directions
        The numbers of tangential directions for which it exists.
    absent
        Why it does not exist for other joints.
    of_ball
        Whether it is proved from every state in a ball, not only from the one that is asked about.
    """

    name: str
    symbol: str
    title: str
    claim: Claim
    function: str
    more_than: str = ""
    directions: tuple[int, ...] = (1, 2)
    absent: str = ""
    of_ball: bool = False

    @property
    def titled(self) -> str:
        """The symbol and the title, as tables and pictures show them."""
        return f"{self.symbol}, {self.title}"

    @property
    def simulated(self) -> bool:
        """Whether it is found by simulations."""
        return self.claim in (Claim.FOLLOWED, Claim.CREEP)

    def exists_for(self, problem: Problem) -> bool:
        """Whether joints of this kind have such a limit."""
        return problem.directions in self.directions

    def of(self, limits: Any) -> Any:
        """The limit of a joint, a :class:`~shakedown.bounds.bound_result.Bound`."""
        return resolve_name(self.function)(limits)

    def may_exceed(self, limits: Any, load_factor: float) -> bool:
        """Whether the limit may be larger than a load factor; True where only computing it tells."""
        return not self.more_than or bool(resolve_name(self.more_than)(limits, load_factor))


_ALL = "shakedown.bounds"
BOUNDS: dict[str, BoundKind] = {
    kind.name: kind
    for kind in (
        BoundKind(
            "lower",
            "λ_1",
            "first collapse",
            Claim.COLLAPSE,
            f"{_ALL}.lower:of_joint",
            directions=(1,),
            absent=in_the_plane_only("first collapse", NO_SIDES),
        ),
        BoundKind(
            "universal",
            "λ_U",
            "from every state",
            Claim.EVERY_STATE,
            f"{_ALL}.every_state.universal_bound:of_joint",
        ),
        BoundKind(
            "energy",
            "λ_E",
            "from this state, by energy",
            Claim.THIS_STATE,
            f"{_ALL}.energy.energy_bound:of_joint",
            of_ball=True,
        ),
        BoundKind(
            "accumulated",
            "λ_S",
            "from this state, by total slip",
            Claim.THIS_STATE,
            f"{_ALL}.accumulated_bound:of_joint",
            more_than=f"{_ALL}.accumulated_bound:may_exceed",
        ),
        BoundKind(
            "transient",
            "λ_T",
            "simulated from this state",
            Claim.FOLLOWED,
            "shakedown.assessment.transient_limit:of_joint",
        ),
        BoundKind(
            "creep",
            "λ_c",
            "least seen to creep from this state",
            Claim.CREEP,
            "shakedown.assessment.creep_limit:of_joint",
            directions=(1,),
            absent="in space nothing is proved of creep, and it takes long: creep_limit follows the motion",
        ),
        BoundKind("upper", "λ_max", "impossible above", Claim.IMPOSSIBLE, f"{_ALL}.upper:of_joint"),
    )
}


def kinds_of(claim: Claim) -> list[BoundKind]:
    """The kinds of limits that say the same of a joint.

    Examples
    --------
    >>> [kind.symbol for kind in kinds_of(Claim.THIS_STATE)]
    ['λ_E', 'λ_S']
    """
    return [kind for kind in BOUNDS.values() if kind.claim == claim]


FEW_NODES = 50  # nodes in space up to which runs take hundredths of a second


def takes_long(problem: Problem) -> bool:
    """Whether limits and runs of a joint take so long that fewer are made, less accurately, side by side."""
    return problem.directions > 1 and problem.n > FEW_NODES
