"""Load steps without events: one solution for the end of the step, and its conditions.

While the contact states stay as they are, displacements and reactions are linear
in the load, so that a condition that holds at both ends of a load step holds
within it. A whole load step is passed at once where

    stuck nodes      |q| ≤ f p       at its end,
    slipping nodes   p ≥ 0           at its end, and Δv in their direction,
    open nodes       w ≥ 0           at its end,

and the motion is stable (positive determinant). No event lies within it then,
and the states hold at its beginning: the event loop would have found the same.
Everything else is left to the event loop, untouched.

With all nodes stuck nothing moves, and a load step costs the comparison of its
reactions with the limits.
"""

import numpy as np

from shakedown.ground.named_state import inner
from shakedown.ground.status import OPEN, STICK
from shakedown.motion.course import Course
from shakedown.motion.plane.active_set import ActiveSet, add_product, correct, largest, largest_residual
from shakedown.motion.plane.moving_state import PlaneMotion, Record
from shakedown.motion.plane.rate_problem import Rates

MOST_FOLLOWED = 64  # load steps after which κ u is recomputed, so that round-off does not accumulate


@inner
def quiet_steps(act: ActiveSet, rate: Rates, mo: PlaneMotion, rec: Record, course: Course) -> None:
    """Pass load steps as long as nothing happens in them, or until there is no capacity to record more."""
    n, path, elastic, friction, small = act.n, course.path, mo.elastic, act.f, course.force
    while mo.step < course.steps and has_capacity(rec) and act.sign > 0 and act.effort <= act.allowed:
        if act.size > 0:
            if not moving_step(act, rate, mo, rec, course):
                return
        else:
            end = (mo.step + 1) * 2 * n
            for i in range(n):
                q, p = path[end + i] + elastic[i], path[end + n + i] + elastic[n + i]
                if not abs(q) <= friction[i] * p + small:
                    return
            pass_step(act, mo, rec, course)
            act.effort += n


@inner
def moving_step(act: ActiveSet, rate: Rates, mo: PlaneMotion, rec: Record, course: Course) -> bool:
    """Pass one load step in the present states; False, and nothing changed, where a condition breaks."""
    m, path, u, elastic = 2 * act.n, course.path, mo.u, mo.elastic
    change, reaction, correction, end = rate.change, rate.reaction, rate.motion, (mo.step + 1) * m
    for j in range(m):
        reaction[j] = path[end + j] + elastic[j]
    correct(act, reaction, change)
    add_product(act, change, reaction)
    if largest_residual(act, reaction) > course.settled:
        correct(act, reaction, correction)
        for j in range(m):
            change[j] += correction[j]
        add_product(act, correction, reaction)
        if not largest_residual(act, reaction) <= course.settled:
            return False
    if not states_hold(act, rate, mo, course):
        return False
    pass_step(act, mo, rec, course)
    count_slip(act, rate, mo, course)
    for j in range(m):
        u[j] += change[j]
        elastic[j] = reaction[j] - path[end + j]
    mo.followed += 1
    if mo.followed > MOST_FOLLOWED:
        compute_elastic(act, mo)
    return True


@inner
def states_hold(act: ActiveSet, rate: Rates, mo: PlaneMotion, course: Course) -> bool:
    """Whether all nodes keep their states over a load step with these changes and final reactions."""
    n, states, friction, path, start = act.n, act.state, act.f, course.path, mo.step * 2 * act.n
    change, reaction, small = rate.change, rate.reaction, course.force
    zero_motion = course.rate * largest(change, 2 * n)
    for i in range(n):
        if states[i] == STICK:
            if not abs(reaction[i]) <= friction[i] * reaction[n + i] + small:
                return False
        elif states[i] == OPEN:
            gap = mo.u[n + i]
            if gap <= course.length or not gap + change[n + i] >= -course.length:
                return False
        else:
            if path[start + n + i] + mo.elastic[n + i] <= small or not reaction[n + i] >= -small:
                return False
            if friction[i] > 0.0 and not states[i] * change[i] <= zero_motion:
                return False
    return True


@inner
def count_slip(act: ActiveSet, rate: Rates, mo: PlaneMotion, course: Course) -> None:
    """Add up slip in contact, dissipation, and which nodes are open over the load step just passed."""
    states, change, reaction, start = act.state, rate.change, rate.reaction, (mo.step - 1) * 2 * act.n
    for i in range(act.n):
        if states[i] == OPEN:
            mo.opened[i] = 1
        elif states[i] != STICK:
            taken = 0.5 * change[i] * (course.path[start + i] + mo.elastic[i] + reaction[i])
            mo.slip[i] += abs(change[i])
            mo.work[i] -= taken
            mo.dissipation -= taken


@inner
def pass_step(act: ActiveSet, mo: PlaneMotion, rec: Record, course: Course) -> None:
    """Record the state at the beginning of a load step, and count the step."""
    if not mo.signed:
        sign(act, mo, course.first + mo.step)
    if rec.capacity > 0:
        start = mo.step * 2 * act.n
        for j in range(2 * act.n):
            mo.r[j] = course.path[start + j] + mo.elastic[j]
        note(act, mo, rec, course.first)
    mo.step += 1


@inner
def compute_elastic(act: ActiveSet, mo: PlaneMotion) -> None:
    """κ u afresh."""
    elastic = mo.elastic
    for j in range(2 * act.n):
        elastic[j] = 0.0
    add_product(act, mo.u, elastic)
    mo.followed = 0


@inner
def has_capacity(rec: Record) -> bool:
    """Whether a state can be recorded, or none is to be."""
    return rec.capacity == 0 or rec.rows < rec.capacity


@inner
def note(act: ActiveSet, mo: PlaneMotion, rec: Record, first: int) -> None:
    """Record the present state and what led to it, where there is capacity."""
    if rec.capacity > 0:
        row, n, u, r, states = rec.rows, act.n, rec.u, rec.r, rec.state
        for j in range(2 * n):
            u[row * 2 * n + j], r[row * 2 * n + j] = mo.u[j], mo.r[j]
        for i in range(n):
            states[row * n + i] = act.state[i]
        rec.time[row], rec.node[row], rec.kind[row] = first + mo.step + mo.time, mo.node, mo.kind
        rec.rows = row + 1


@inner
def sign(act: ActiveSet, mo: PlaneMotion, step: int) -> None:
    """Enter the present states and the load step that they begin in into the signature."""
    prime, code, states = np.uint64(1099511628211), np.uint64(14695981039346656037), act.state
    for i in range(act.n):
        code = (code ^ np.uint64(states[i] + 2)) * prime
        if states[i] != OPEN:
            mo.closed[i] = 1
    if code != mo.last_states:
        mo.signature = ((mo.signature ^ code) * prime ^ np.uint64(step + 2)) * prime
        mo.last_states = code
    mo.signed = True
