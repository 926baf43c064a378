"""Rates of slip and gap at one instant: which nodes at their limits move, and how.

Between samples the loading is linear in time, so that the evolution is
piecewise linear and is known as soon as the rates after every event are. Given
the rates ṙ_w of the welded reactions, each node has, by its *place* at the
instant, these choices (s = +1 backward, −1 forward):

    inside its limits        stick
    on one limit, s q = f p  stick, with s q̇ ≤ f ṗ; or slip, with s v̇ ≤ 0, s q̇ = f ṗ
    apex, p = q = 0, w = 0   stick, |q̇| ≤ f ṗ; slip, s v̇ ≤ 0, s q̇ = f ṗ ≥ 0; open, ẇ ≥ 0, q̇ = ṗ = 0
    frictionless, p > 0      slip, q̇ = 0
    in the air, w > 0        open

**The rule for events.** Whatever happens at an instant, one event or several,
a corner, a load reversal, an apex, is decided by this one problem for all nodes
at their limits together. It starts from the states held before. Every node that
breaks its conditions takes the next state by the sign of what is broken, all of
them at once as long as their number falls (block pivoting), else the one of
lowest index alone (Murty's least-index rule, finite where every principal minor
of A ± f B is positive). Should this not end, or end in a motion that is
unstable (determinant of the moving nodes' equations negative), the problem is
handed to complete enumeration (:mod:`shakedown.motion.plane.rate_search`). If that too
finds nothing, or is too large, there are no rates: the state must jump.

A node counts as being at a limit from round-off on (relative to the
largest reaction), so that simultaneous events are one event, and a rate counts
as zero up to round-off (relative to the largest rate), so that a limit
touched tangentially is no slip.
"""

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import Integers, NamedState, Reals, inner
from shakedown.ground.round_off import ROUND_OFF
from shakedown.ground.status import BACKWARD_SLIP, FORWARD_SLIP, OPEN, STICK
from shakedown.motion.plane.active_set import (
    ActiveSet,
    add_product,
    change_states,
    correct,
    factorize,
    larger,
    largest,
    largest_residual,
)

WORN = -1  # instead of a number of nodes: the inverse must be set up again
# Where a node stands: inside its limits or on one, numbered as the state that this allows; elsewhere.
INSIDE, ON_BACKWARD, ON_FORWARD = STICK, BACKWARD_SLIP, FORWARD_SLIP
APEX, FRICTIONLESS, AIR = range(2, 5)


class Rates(NamedState):
    """Places of the nodes at an instant and the rates that hold after it, per unit of time.

    Attributes
    ----------
    place : (n,)
        INSIDE, ON_BACKWARD, ON_FORWARD, APEX, FRICTIONLESS or AIR.
    wanted, before : (n,)
        States to try next; states held before the instant.
    motion : (2n,)
        Rates of v, w.
    reaction : (2n,)
        Rates of q, p.
    welded : (2n,)
        Rates of q_w, p_w.
    change : (2n,)
        Scratch.
    searches
        How often pivoting has not found the rates.
    """

    place: Integers
    wanted: Integers
    before: Integers
    motion: Reals
    reaction: Reals
    welded: Reals
    change: Reals
    searches: int


def rates(n: int) -> Rates:
    """Arrays for the rates of n nodes."""
    of_nodes, of_places = ("place", "wanted", "before"), ("motion", "reaction", "welded", "change")
    return Rates(dict.fromkeys(of_nodes, n) | dict.fromkeys(of_places, 2 * n))


@inner
def locate(
    act: ActiveSet, rate: Rates, motion: FloatArray, reaction: FloatArray, near: float, near_gap: float
) -> None:
    """Set the place of every node from its state, gap and reactions (u, r, each (2n,))."""
    n, states, friction, places = act.n, act.state, act.f, rate.place
    for i in range(n):
        q, p, f, state = reaction[i], reaction[n + i], friction[i], states[i]
        place = INSIDE
        if state == OPEN:
            place = APEX if motion[n + i] <= near_gap else AIR
        elif p <= near and abs(q) <= f * p + near:
            place = APEX
        elif f == 0.0:
            place = FRICTIONLESS
        elif state != STICK:
            place = state
        elif f * p - q <= near:
            place = ON_BACKWARD
        elif f * p + q <= near:
            place = ON_FORWARD
        places[i] = place


@inner
def next_state(act: ActiveSet, rate: Rates, i: int, zero_rate: float, zero_motion: float) -> int:
    """The state of node i if its conditions hold, else the one to try next."""
    n, state, place, f = act.n, act.state[i], rate.place[i], act.f[i]
    v, w, q, p = rate.motion[i], rate.motion[n + i], rate.reaction[i], rate.reaction[n + i]
    if place in (ON_BACKWARD, ON_FORWARD):
        if state == STICK:
            return place if place * q - f * p > zero_rate else STICK
        return STICK if place * v > zero_motion else state
    if place == FRICTIONLESS:
        return BACKWARD_SLIP
    if place != APEX:
        return state
    if state == OPEN:
        if w >= -zero_motion:
            return OPEN
        return STICK if f > 0.0 else BACKWARD_SLIP
    if state == STICK:
        backward, forward = q - f * p, -q - f * p
        if backward <= zero_rate and forward <= zero_rate:
            return STICK
        return BACKWARD_SLIP if backward >= forward else FORWARD_SLIP
    if p < -zero_rate:
        return OPEN
    if f > 0.0 and state * v > zero_motion:
        return STICK
    return state


@inner
def compute_rates(act: ActiveSet, rate: Rates) -> bool:
    """Rates of motion and reactions in the present states.

    False where the inverse is too far from one and can be set up afresh.
    """
    worn = False
    motion, reaction, welded, change = rate.motion, rate.reaction, rate.welded, rate.change
    for k in range(2 * act.n):
        reaction[k], motion[k] = welded[k], 0.0
    for _ in range(3):
        correct(act, reaction, change)
        for k in range(2 * act.n):
            motion[k] += change[k]
        add_product(act, change, reaction)
        worn = largest_residual(act, reaction) > ROUND_OFF * largest(reaction, 2 * act.n)
        if not worn:
            break
    return not worn or act.updates == 0


@inner
def broken_conditions(act: ActiveSet, rate: Rates, rate_tol: float) -> int:
    """Rates in the present states; sets ``wanted`` and returns how many nodes break their conditions.

    WORN, and nothing set, where the inverse is too far from one and can be set up afresh.
    """
    return count_broken(act, rate, rate_tol) if compute_rates(act, rate) else WORN


@inner
def count_broken(act: ActiveSet, rate: Rates, rate_tol: float) -> int:
    """Set ``wanted`` from the rates; how many nodes break their conditions."""
    zero_rate = rate_tol * larger(largest(rate.reaction, 2 * act.n), largest(rate.welded, 2 * act.n))
    zero_motion = rate_tol * largest(rate.motion, 2 * act.n)
    wanted, states, count = rate.wanted, act.state, 0
    for i in range(act.n):
        wanted[i] = next_state(act, rate, i, zero_rate, zero_motion)
        if wanted[i] != states[i]:
            count += 1
    return count


@inner
def solve_rates(act: ActiveSet, rate: Rates, rate_tol: float, known: bool) -> bool:
    """States and rates after the instant whose places are set; False, and nothing changed, if none are found.

    Block pivoting with Murty's rule as a safeguard, from the states held before. ``known``:
    whether the rates are those in the present states already.
    """
    before, wanted, states = rate.before, rate.wanted, act.state
    for i in range(act.n):
        before[i] = states[i]
        wanted[i] = admissible_start(rate.place[i], states[i])
        known = known and wanted[i] == states[i]
    n, patience = act.n, 3
    fewest = n + 1
    for _ in range(20 + 10 * n):
        if not known and not (change_states(act, wanted) and compute_rates(act, rate)):
            if factorize(act) == 0:
                break
            compute_rates(act, rate)
        known, count = False, count_broken(act, rate, rate_tol)
        if count == 0:
            if act.sign > 0:
                return True
            break
        if count < fewest:
            fewest, patience = count, 3
        else:
            patience -= 1
        if patience < 0:
            keep_first(act, rate)
    rate.searches += 1
    if not change_states(act, before):
        factorize(act)
    return False


@inner
def admissible_start(place: int, state: int) -> int:
    """The state to start from at a place: the one held before where the place allows it."""
    if place == FRICTIONLESS:
        return BACKWARD_SLIP
    on_limit = place in (ON_BACKWARD, ON_FORWARD)
    if place == INSIDE or (on_limit and state != place):
        return STICK
    return state


@inner
def keep_first(act: ActiveSet, rate: Rates) -> None:
    """Withdraw every wanted change of state but that of the lowest node."""
    wanted, states, found = rate.wanted, act.state, False
    for i in range(act.n):
        if wanted[i] != states[i]:
            if found:
                wanted[i] = states[i]
            found = True
