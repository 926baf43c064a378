"""Whether runs of a joint take long, and which energy ball is found soonest."""

from shakedown.joint.problem import Problem

FEW_NODES = 50  # nodes in space up to which runs take hundredths of a second


def takes_long(problem: Problem) -> bool:
    """Whether runs of a joint take so long that fewer are made, less accurately, in several threads."""
    return problem.directions > 1 and problem.n > FEW_NODES


def holding_ball_sooner(problem: Problem) -> bool:
    """Whether an energy ball that holds a slip is found sooner than the largest one."""
    return problem.directions > 1
