"""Which nodes move at an instant, and how: the equations of moving nodes, and their rates.

Equations
---------
Displacements and reactions are stacked as u = (v, w) and r = (q, p), so that
(2.10), (2.11) read r = r_w + κ u. A node that moves adds equations, each named
by the displacement ``col`` that it frees and a coefficient ``coef``:

    backward slip   q − f p = 0     frees v     (col = i, coef = +f)
    forward slip    q + f p = 0     frees v     (col = i, coef = −f)
    separation      q = 0, p = 0    frees v, w  (col = i and n + i, coef = 0)

Row ``col`` of κ, less ``coef`` times row n + ``col``, is the equation's left-hand
side. The matrix of these rows in the freed columns is unsymmetric; its inverse
is kept explicitly and follows a change of state by bordering, in O(a²) for a
equations. The sign of its determinant is kept too: negative means that the
motion, although it satisfies the law, is unstable (chapter VI); zero means that
the matrix is singular and what stands for its inverse must not be used.

The inverse is set up afresh only where a state is given from outside or where it
has worn out. That is done here by Gauss–Jordan elimination in place: LAPACK
through numba (inverse and sign of the determinant) would add 2 s to the first
compilation, is slower below 20 equations, and twice as fast at 60.

Rates
-----
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
handed to complete enumeration (:func:`.event_loop.enumerate_states`). If that too
finds nothing, or is too large, there are no rates: the state must jump.

A node counts as being at a limit from round-off on (relative to the
largest reaction), so that simultaneous events are one event, and a rate counts
as zero up to round-off (relative to the largest rate), so that a limit
touched tangentially is no slip.
"""

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.ground.named_state import Integers, NamedState, Reals, entered, inner, summing
from shakedown.ground.status import BACKWARD_SLIP, FORWARD_SLIP, OPEN, STICK


class ActiveSet(NamedState):
    """Equations of the moving nodes and the inverse of their matrix (leading ``size`` rows and columns).

    Attributes
    ----------
    kappa : (2n, 2n)
        Contact stiffness [force / length].
    f : (n,)
        Friction coefficients.
    state : (n,)
        STICK, BACKWARD_SLIP, FORWARD_SLIP or OPEN.
    col, coef : (2n,)
        Freed displacement and coefficient of p of each equation.
    place : (2n,)
        Equation that frees a displacement, or −1.
    inverse : (2n, 2n)
        Inverse of the matrix of the equations.
    row, column : (2n,)
        Scratch.
    n
        Number of nodes.
    size, sign
        Number of equations; sign of the determinant of their matrix.
    updates
        Changes of the inverse since it was set up.
    effort
        Multiplications and additions since the loop was entered, roughly.
    allowed
        Effort after which the loop returns.
    """

    kappa: Reals
    f: Reals
    state: Integers
    col: Integers
    coef: Reals
    place: Integers
    inverse: Reals
    row: Reals
    column: Reals
    n: int
    size: int
    sign: int
    updates: int
    effort: int
    allowed: int


def active_set(kappa: FloatArray, f: FloatArray) -> ActiveSet:
    """All nodes stuck."""
    n = len(f)
    shapes = {"state": n, "inverse": (2 * n, 2 * n)}
    act = ActiveSet(
        shapes | dict.fromkeys(("col", "coef", "row", "column"), 2 * n),
        kappa=np.ascontiguousarray(kappa, dtype=float),
        f=np.array(f, dtype=float),
        place=np.full(2 * n, -1, dtype=np.int64),
    )
    act.set(n=n, sign=1)
    return act


@inner
def larger(a: float, b: float) -> float:
    """The larger of two numbers (``max`` takes any number of anything, and longer to compile)."""
    return a if a > b else b


@inner
def slip_coefficient(state: int, f: float) -> float:
    """Coefficient of p in the tangential equation of a node."""
    return 0.0 if state == OPEN else state * f  # BACKWARD_SLIP = +1, FORWARD_SLIP = −1


@summing
def add_equation(act: ActiveSet, col: int, coef: float) -> bool:
    """Add one equation; False, and nothing changed, where the matrix would be singular."""
    a, m, kappa, inverse = act.size, 2 * act.n, act.kappa, act.inverse
    row, column, cols, coefs = act.row, act.column, act.col, act.coef
    partner = col if coef == 0.0 else act.n + col
    pivot = kappa[col * m + col] - coef * kappa[partner * m + col]
    size = abs(pivot)
    for c in range(a):
        row[c] = 0.0
    for b in range(a):  # row = (new row) M⁻¹
        x = kappa[col * m + cols[b]] - coef * kappa[partner * m + cols[b]]
        if x != 0.0:
            for c in range(a):
                row[c] += x * inverse[b * m + c]
    for c in range(a):
        y = kappa[cols[c] * m + col]
        if coefs[c] != 0.0:
            y -= coefs[c] * kappa[(act.n + cols[c]) * m + col]
        column[c] = y
        pivot -= row[c] * y
        size = larger(size, abs(row[c] * y))
    if abs(pivot) <= ROUND_OFF * size:
        return False
    for b in range(a):  # last column = −M⁻¹ (new column) / pivot
        total = 0.0
        for c in range(a):
            total += inverse[b * m + c] * column[c]
        x = -total / pivot
        for c in range(a):
            inverse[b * m + c] -= x * row[c]
        inverse[b * m + a] = x
    for c in range(a):
        inverse[a * m + c] = -row[c] / pivot
    inverse[a * m + a] = 1.0 / pivot
    cols[a], coefs[a], act.place[col] = col, coef, a
    act.size = a + 1
    act.updates += 1
    act.effort += 3 * a * a
    if pivot < 0.0:
        act.sign = -act.sign
    return True


@inner
def remove_equation(act: ActiveSet, col: int) -> bool:
    """Remove the equation that frees ``col``; False where the rest of the matrix is singular."""
    place, cols, inverse, m = act.place, act.col, act.inverse, 2 * act.n
    k, a = place[col], act.size - 1
    pivot, largest_entry = inverse[k * m + k], 0.0
    for b in range(a + 1):
        largest_entry = larger(larger(largest_entry, abs(inverse[b * m + k])), abs(inverse[k * m + b]))
    if abs(pivot) <= ROUND_OFF * largest_entry:
        return False
    if k != a:
        for b in range(a + 1):
            inverse[k * m + b], inverse[a * m + b] = inverse[a * m + b], inverse[k * m + b]
        for b in range(a + 1):
            inverse[b * m + k], inverse[b * m + a] = inverse[b * m + a], inverse[b * m + k]
        cols[k], act.coef[k] = cols[a], act.coef[a]
        place[cols[k]] = k
    for b in range(a):
        x = inverse[b * m + a] / pivot
        if x != 0.0:
            for c in range(a):
                inverse[b * m + c] -= x * inverse[a * m + c]
    place[col] = -1
    act.size = a
    act.updates += 1
    act.effort += a * a
    if pivot < 0.0:
        act.sign = -act.sign
    return True


@inner
def set_up(act: ActiveSet) -> None:
    """Equations of the present states, and their matrix in the place of its inverse."""
    n, m, a, kappa, matrix = act.n, 2 * act.n, 0, act.kappa, act.inverse
    cols, coefs, place, states = act.col, act.coef, act.place, act.state
    for j in range(m):
        place[j] = -1
    for i in range(n):
        if states[i] != STICK:
            cols[a], coefs[a], place[i] = i, slip_coefficient(states[i], act.f[i]), a
            a += 1
        if states[i] == OPEN:
            cols[a], coefs[a], place[n + i] = n + i, 0.0, a
            a += 1
    act.size, act.sign, act.updates = a, 1, 0
    for b in range(a):
        for c in range(a):
            x = kappa[cols[b] * m + cols[c]]
            if coefs[b] != 0.0:
                x -= coefs[b] * kappa[(n + cols[b]) * m + cols[c]]
            matrix[b * m + c] = x


@entered
def factorize(act: ActiveSet) -> int:
    """Set up the equations of the present states afresh: sign of their determinant, 0 where it is singular.

    Gauss–Jordan elimination in place, with row exchanges that are undone as
    exchanges of columns at the end.
    """
    set_up(act)
    m, a, kappa, matrix, cols, swaps = 2 * act.n, act.size, act.kappa, act.inverse, act.col, act.row
    act.effort += a * a * a
    for k in range(a):
        best, size = k, 0.0
        for b in range(k + 1, a):
            if abs(matrix[b * m + k]) > abs(matrix[best * m + k]):
                best = b
        for j in range(m):
            size = larger(size, abs(kappa[cols[k] * m + j]))
        pivot = matrix[best * m + k]
        if abs(pivot) <= ROUND_OFF * size:
            act.sign = 0
            return 0
        swaps[k] = best
        if (best != k) != (pivot < 0.0):
            act.sign = -act.sign
        for c in range(a):
            x = matrix[best * m + c]
            matrix[best * m + c] = matrix[k * m + c]
            matrix[k * m + c] = x / pivot
        matrix[k * m + k] = 1.0 / pivot
        for b in range(a):
            x = matrix[b * m + k]
            if b != k and x != 0.0:
                matrix[b * m + k] = 0.0
                for c in range(a):
                    matrix[b * m + c] -= x * matrix[k * m + c]
    for k in range(a - 1, -1, -1):
        other = np.int64(swaps[k])
        for b in range(a):
            matrix[b * m + k], matrix[b * m + other] = matrix[b * m + other], matrix[b * m + k]
    return act.sign


@inner
def change_states(act: ActiveSet, wanted: NDArray[np.int64]) -> bool:
    """Move every node to its wanted state; False where the inverse could not be updated.

    Equations are removed first, so that a load reversal, where most slipping
    nodes stop at once, gets cheaper with every node. A matrix that was singular
    leaves no inverse to update; nor does one that is singular on the way.
    """
    n, states, sound, changed = act.n, act.state, act.sign != 0, False
    for i in range(n):
        if wanted[i] != states[i]:
            changed = True
            if states[i] == OPEN:
                sound = sound and remove_equation(act, n + i)
            if states[i] != STICK:
                sound = sound and remove_equation(act, i)
    if not changed:
        return sound
    for i in range(n):
        if wanted[i] != states[i]:
            states[i] = wanted[i]
            if wanted[i] != STICK:
                sound = sound and add_equation(act, i, slip_coefficient(wanted[i], act.f[i]))
            if wanted[i] == OPEN:
                sound = sound and add_equation(act, n + i, 0.0)
    return sound


@inner
def reach_states(act: ActiveSet, wanted: NDArray[np.int64]) -> bool:
    """Move every node to its wanted state; False where the new matrix is singular."""
    return change_states(act, wanted) or factorize(act) != 0


@summing
def correct(act: ActiveSet, residual: FloatArray, change: FloatArray) -> None:
    """Displacements ``change`` (2n,) that cancel the residuals (2n,: q then p) of the active equations."""
    m, a, cols, coefs = 2 * act.n, act.size, act.col, act.coef
    inverse, column = act.inverse, act.column
    for j in range(m):
        change[j] = 0.0
    for b in range(a):
        x = residual[cols[b]]
        if coefs[b] != 0.0:
            x -= coefs[b] * residual[act.n + cols[b]]
        column[b] = x
    for b in range(a):
        total = 0.0
        for c in range(a):
            total -= inverse[b * m + c] * column[c]
        change[cols[b]] = total
    act.effort += a * a


@entered
def solve(act: ActiveSet, residual: FloatArray, change: FloatArray) -> None:
    """Displacements ``change`` (2n,) that cancel the residuals (2n,: q then p) of the active equations."""
    correct(act, residual, change)


@inner
def add_product(act: ActiveSet, change: FloatArray, reaction: FloatArray) -> None:
    """reaction += κ change, skipping displacements that do not change."""
    kappa, m, used = act.kappa, 2 * act.n, 0
    for j in range(m):
        x = change[j]
        if x != 0.0:
            used += 1
            for k in range(m):
                reaction[k] += x * kappa[j * m + k]
    act.effort += used * m


@inner
def largest_residual(act: ActiveSet, reaction: FloatArray) -> float:
    """Largest |residual| of the active equations [force]."""
    n, size, cols, coefs = act.n, 0.0, act.col, act.coef
    for b in range(act.size):
        x = reaction[cols[b]]
        if coefs[b] != 0.0:
            x -= coefs[b] * reaction[n + cols[b]]
        size = larger(size, abs(x))
    return size


@inner
def largest(values: FloatArray, count: int) -> float:
    """Largest magnitude of the first ``count`` values."""
    size = 0.0
    for k in range(count):
        size = larger(size, abs(values[k]))
    return size


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
    """

    place: Integers
    wanted: Integers
    before: Integers
    motion: Reals
    reaction: Reals
    welded: Reals
    change: Reals


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
def move(
    act: ActiveSet, reaction: FloatArray, motion: FloatArray, scratch: FloatArray, small: float, share: float
) -> bool:
    """Displacements ``motion`` that bring the moving nodes from these reactions to their equations.

    False where in ``reaction``, those after them, more is left than is small, or this share of the largest.
    """
    for k in range(2 * act.n):
        motion[k] = 0.0
    for _ in range(3):
        correct(act, reaction, scratch)
        for k in range(2 * act.n):
            motion[k] += scratch[k]
        add_product(act, scratch, reaction)
        left = largest_residual(act, reaction)
        if left <= small or (share > 0.0 and left <= share * largest(reaction, 2 * act.n)):
            return True
    return False


@inner
def compute_rates(act: ActiveSet, rate: Rates) -> bool:
    """Rates of motion and reactions in the present states.

    False where the inverse is too far from one and can be set up afresh.
    """
    for k in range(2 * act.n):
        rate.reaction[k] = rate.welded[k]
    return move(act, rate.reaction, rate.motion, rate.change, 0.0, ROUND_OFF) or act.updates == 0


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
    n, spare_changes = act.n, 3
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
            fewest, spare_changes = count, 3
        else:
            spare_changes -= 1
        if spare_changes < 0:
            keep_first(act, rate)
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
