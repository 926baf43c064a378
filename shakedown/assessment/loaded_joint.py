"""A joint under one of its loads, of any amplitude."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shakedown.ground.errors import UsageError
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.visible_text import shortened
from shakedown.joint.conjugate_loads import require_loads
from shakedown.joint.problem import Problem

UNSTATED: dict[str, Any] = dict.fromkeys(
    ("load_mean", "load_amplitude", "load_units")
)  # of another amplitude


@dataclass(frozen=True)
class LoadedJoint:
    """A joint under one load of any amplitude.

    Attributes
    ----------
    problem
        The joint as it was given.
    load
        The number of the load.
    alone
        The same joint with all but this load in its constant part, so that a load factor is an amplitude, and
        loads in units of their histories; None where another load varies, too.
    """

    problem: Problem
    load: int
    alone: Problem | None

    @classmethod
    def of(cls, problem: Problem, called: int | str) -> "LoadedJoint":
        """The joint under a load that is called by its number or name.

        Raises ``ProblemError`` where it does not know its loads, ``UsageError`` where there is no such load
        or the load steps are a load domain's.
        """
        unit, history = require_loads(problem)
        if problem.is_domain:
            raise UsageError("problem: expected load steps in their order, found corners of a load domain")
        load = load_number(problem, called)
        welded = problem.layout.joined(problem.q_w, problem.p_w)
        rest = welded - np.outer(history[:, load], unit[load])
        others = np.delete(history, load, axis=1)
        if (np.ptp(others, axis=0) > NEGLIGIBLE * np.abs(others).max(axis=0, initial=0.0)).any():
            return cls(problem, load, None)
        q_mean, p_mean = problem.layout.split(rest[0])
        return cls(problem, load, replace(problem, q_mean=q_mean, p_mean=p_mean, **UNSTATED))

    def past_transient(self) -> "LoadedJoint":
        """The joint after its transient load steps."""
        if self.problem.q_transient is None:
            return self
        return self.of(replace(self.problem, q_transient=None, p_transient=None), self.load)

    def at(self, amplitude: float) -> tuple[Problem, float]:
        """The joint and the load factor at an amplitude."""
        if self.alone is not None:
            return self.alone, amplitude
        unit, history = require_loads(self.problem)
        more = (amplitude - 1.0) * np.outer(history[:, self.load], unit[self.load])
        q, p = self.problem.layout.split(more)
        scaled = history.copy()
        scaled[:, self.load] *= amplitude
        q_w, p_w = self.problem.q_w + q, self.problem.p_w + p
        changed = UNSTATED | {"q_w": q_w, "p_w": p_w, "load_history": scaled, "q_mean": None, "p_mean": None}
        return replace(self.problem, **changed), 1.0  # the mean does not matter then


def load_number(problem: Problem, load: int | str) -> int:
    """The number of a load that is called by number or name; ``UsageError`` where there is none."""
    count = len(require_loads(problem)[0])
    names = problem.load_names or ()
    named = names if len(names) == count else count * ("",)
    found = [k for k, own in enumerate(named) if own == load != ""]
    found = found or [k for k in range(count) if load in (k, str(k))]
    if len(found) == 1:
        return found[0]
    known = f"0 to {count - 1}" + "".join(f", '{name}'" for name in dict.fromkeys(named) if name)
    many = f", which names {len(found)} loads" if found else ""
    raise UsageError(f"load: expected one of {shortened(known, 200)}, found {shortened(repr(load))}{many}")
