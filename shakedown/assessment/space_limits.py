"""Every limit of a joint with two tangential directions: what the plane alone has is missing, and why."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from shakedown.assessment.common_limits import CommonLimits
from shakedown.assessment.shakedown_bounds import SpaceBounds
from shakedown.ground.evidence import Missing
from shakedown.ground.float_array import FloatArray
from shakedown.joint.arguments import NO_SIDES, NO_SIGNS, in_the_plane_only


@dataclass(frozen=True, eq=False, repr=False)
class SpaceLimits(CommonLimits):
    """The limits of one joint with two tangential directions: λ_max, λ_E, λ_U.

    A disc has no sides, so that there is no first collapse λ_1 and nothing that rests on it, no box bound
    and no friction threshold by signs: these are ``Missing``, with the reason, and null in documents.
    """

    lower = SpaceBounds.lower
    box = Missing(in_the_plane_only("box bound", NO_SIDES))
    friction = Missing(in_the_plane_only("friction thresholds", NO_SIGNS))

    @cached_property
    def bounds(self) -> SpaceBounds:
        """λ_max by itself."""
        return SpaceBounds(self.upper, self.tolerances, self.through_transient)

    @property
    def sensitivities(self) -> dict[str, Missing]:
        """Missing, so far."""
        return dict.fromkeys(("upper", "energy"), Missing(in_the_plane_only("sensitivities")))

    @property
    def why_missing(self) -> dict[str, str]:
        """Why what joints in the plane have is null in documents, by its word there."""
        words = {"lower": self.lower, "box": self.box, "friction": self.friction}
        more = {"sensitivities": self.sensitivities["upper"], "guarantee_curve": self.curve(())}
        return {word: found.reason for word, found in (words | more).items()}

    def curve(self, radii: Sequence[float], centre: FloatArray | None = None) -> Missing:
        """Missing: the guarantee curve is one of λ_1."""
        return Missing(in_the_plane_only("guarantee curve", NO_SIDES))
