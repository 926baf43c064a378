"""One step of the slipping nodes along their smooth path: explicit, or implicit where some turn fast.

Dormand and Prince's pair of orders 5 and 4
-------------------------------------------
Its last stage is the first of the next step. The weights of the polynomial between the ends, of order 4,
are Shampine's (L. F. Shampine, Math. Comp. 46, 1986).

Radau IIA of order 5
--------------------
A slipping node turns at a rate in proportion to 1/|q|, so that near the apex explicit steps are
short though its path is smooth. Radau's steps are not (E. Hairer, G. Wanner, Solving Ordinary Differential
Equations II, IV.8). With rates q̇_l at the stages, their reactions are q_m = q + h Σ a_ml q̇_l; unknown are the
angles of the fast nodes, whose reactions lie in their directions of slip, q_m·u⊥ = 0, by Newton's method.
That holds at the apex, too, where a reaction vanishes. The others' directions follow the reactions.
"""

import numpy as np

from shakedown.ground.constants import MINOR, NEWTON_ROUNDS, NOTABLE, FloatArray
from shakedown.ground.named_state import inner, summing
from shakedown.motion.course import Course
from shakedown.motion.space import speeds
from shakedown.motion.space.space_run import (
    DEGREE,
    MOST_FAST,
    STAGES,
    CompiledJoint,
    Slipping,
    SpaceMotion,
    SpaceRun,
    Step,
)

WEIGHTS = np.zeros((STAGES, STAGES))  # weights of earlier stages in each stage; the last row gives the end
WEIGHTS[1, :1] = 1 / 5
WEIGHTS[2, :2] = 3 / 40, 9 / 40
WEIGHTS[3, :3] = 44 / 45, -56 / 15, 32 / 9
WEIGHTS[4, :4] = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
WEIGHTS[5, :5] = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
WEIGHTS[6, :6] = 35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
OF_ERROR = np.array([-71 / 57600, 0, 71 / 16695, -71 / 1920, 17253 / 339200, -22 / 525, 1 / 40])
OF_PAIR = np.array(
    [
        [1, -8048581381 / 2820520608, 8663915743 / 2820520608, -12715105075 / 11282082432],
        [0, 0, 0, 0],
        [0, 131558114200 / 32700410799, -68118460800 / 10900136933, 87487479700 / 32700410799],
        [0, -1754552775 / 470086768, 14199869525 / 1410260304, -10690763975 / 1880347072],
        [0, 127303824393 / 49829197408, -318862633887 / 49829197408, 701980252875 / 199316789632],
        [0, -282668133 / 205662961, 2019193451 / 616988883, -1453857185 / 822651844],
        [0, 40617522 / 29380423, -110615467 / 29380423, 69997945 / 29380423],
    ]
)
PLACES = np.array(
    [0.0, (4 - np.sqrt(6.0)) / 10, (4 + np.sqrt(6.0)) / 10, 1.0]
)  # beginning and stages of his steps


def lagrange(points: FloatArray) -> FloatArray:
    """Coefficients, from x⁰ up, of the polynomials that are 1 at one of the points and 0 at the others."""
    return np.asarray(np.linalg.inv(np.vander(points, increasing=True)).T)


OF_RADAU = np.zeros((STAGES, DEGREE))
OF_RADAU[: len(PLACES)] = lagrange(PLACES) / np.arange(1, DEGREE + 1)
BETWEEN = np.stack(
    [OF_PAIR, OF_RADAU]
)  # weights of the rates at the stages in the powers of the share of a step
FAILED = -1.0  # instead of an error: the motion is unstable somewhere in the step


@summing
def explicit_step(run: SpaceRun, h: float) -> float:
    """A step of this length from the packed state, whose rates are stage 0: estimate of its error [length].

    The end lies on the cones. Near the apex an error counts for more than it is, so that one that is
    allowed leaves the reaction its direction. FAILED where the motion is not stable at a stage.
    """
    course, mo, sp, st = run.course, run.motion, run.slipping, run.step
    s, row, k, k_q = sp.s, 2 * st.n, st.k, st.k_q
    for j in range(1, STAGES):
        for c in range(2 * s):
            total = 0.0
            for i in range(j):
                total += WEIGHTS[j, i] * k_q[i * row + c]
            st.stage_q[c] = sp.q[c] + h * total
        if j == STAGES - 1:
            for c in range(2 * s):
                total = 0.0
                for i in range(j):
                    total += WEIGHTS[j, i] * k[i * row + c]
                st.slip[c] = h * total
            if return_to_cones(course, mo, sp, st, h) > course.residual:
                return np.inf
        if not speeds.find_rates(course, mo, sp, st, st.stage_q, j):
            return FAILED
    error = 0.0
    for a in range(s):
        x, y = 0.0, 0.0
        for i in range(STAGES):
            x += OF_ERROR[i] * k[i * row + 2 * a]
            y += OF_ERROR[i] * k[i * row + 2 * a + 1]
        error = max(error, weighted(sp, st, a, x, y))
    return h * np.sqrt(error)


@inner
def weighted(sp: Slipping, st: Step, a: int, x: float, y: float) -> float:
    """The squared error of a node's rate of slip; in stiff directions that of its reaction counts."""
    at, row = 2 * a, 2 * sp.s + 1
    stiffness = max(sp.A[at * row], sp.A[(at + 1) * row])
    weight = max(1.0, stiffness * st.length_scale / st.force_scale)
    return (x * x + y * y) * weight * weight


@summing
def return_to_cones(course: Course, mo: SpaceMotion, sp: Slipping, st: Step, h: float) -> float:
    """Move the state within the step along the directions of slip until |q| = f p: what is left [force]."""
    s, q, slip, worst = sp.s, st.stage_q, st.slip, np.inf
    # iterations that return to the cones
    for _ in range(8):
        last, worst = worst, 0.0
        for a in range(s):
            p = sp.p[a] + h * sp.load_p[a]
            for c in range(2 * s):
                p += sp.B[a * 2 * s + c] * slip[c]
            left = np.sqrt(q[2 * a] ** 2 + q[2 * a + 1] ** 2) - sp.f[a] * p
            sp.correction[a] = left
            worst = max(worst, abs(left))
        if worst <= course.force:
            break
        if last < np.inf and worst > NOTABLE * last:  # the directions are to be renewed
            speeds.find_directions(course, mo, sp, q)
            speeds.find_matrix(sp, sp.M)
            if speeds.factor(sp, s) <= 0:
                sp.factored = False
                return np.inf
        speeds.substitute(sp, s, sp.correction)
        for a in range(s):
            sp.normal[2 * a] = sp.correction[a] * sp.unit[2 * a]
            sp.normal[2 * a + 1] = sp.correction[a] * sp.unit[2 * a + 1]
        for c in range(2 * s):
            slip[c] += sp.normal[c]
            total = 0.0
            for b in range(2 * s):
                total += sp.A[c * 2 * s + b] * sp.normal[b]
            q[c] += total
    return worst


@summing
def stop_within(course: Course, mo: SpaceMotion, sp: Slipping, st: Step, h: float, share: float) -> None:
    """End the step at a share of it, on its polynomial: the state there replaces that at its end."""
    n, s, power = st.n, sp.s, 1.0
    for c in range(2 * s):
        st.slip[c], st.stage_q[c] = 0.0, sp.q[c] + share * h * sp.load_q[c]
    for m in range(DEGREE):
        power *= share
        for c in range(2 * s):
            st.curve[m * 2 * n + c] *= power
            st.slip[c] += st.curve[m * 2 * n + c]
    for c in range(2 * s):
        total = 0.0
        for b in range(2 * s):
            total += sp.A[c * 2 * s + b] * st.slip[b]
        st.stage_q[c] += total
    speeds.find_directions(course, mo, sp, st.stage_q)
    return_to_cones(course, mo, sp, st, share * h)
    close_curve(sp, st)


@inner
def close_curve(sp: Slipping, st: Step) -> None:
    """Make the polynomial end where the step does, on the cones."""
    row = 2 * st.n
    for c in range(2 * sp.s):
        left = st.slip[c]
        for m in range(DEGREE):
            left -= st.curve[m * row + c]
        st.curve[(DEGREE - 1) * row + c] += left


@summing
def find_curve(sp: Slipping, st: Step, h: float) -> None:
    """The polynomial between the ends of the step."""
    row = 2 * st.n
    for m in range(DEGREE):
        for c in range(2 * sp.s):
            total = 0.0
            for i in range(STAGES):
                total += BETWEEN[st.method, i, m] * st.k[i * row + c]
            st.curve[m * row + c] = h * total
    close_curve(sp, st)


# Weights of the rates at the stages in the state at each: integrals of their polynomials.
INWARD = PLACES[1:, None] ** np.arange(1, 4) / np.arange(1, 4) @ lagrange(PLACES[1:]).T
OF_ESTIMATE = (
    0.2748888295956773  # the reciprocal of the real eigenvalue of the inverse of INWARD, as Hairer's
)
MOST_TURN = 0.5  # largest change of an angle in one round
BACK = lagrange(PLACES[1:])[:, 0]  # weights of the rates at the stages in their polynomial at the beginning


@inner
def turning(sp: Slipping, st: Step, a: int, h: float) -> float:
    """How fast a node turns towards where it tends, at most, within the step."""
    s, i = sp.s, 2 * a
    x, y = sp.q[i], sp.q[i + 1]
    size = np.sqrt(x * x + y * y)
    dx, dy = x + h * st.k_q[i], y + h * st.k_q[i + 1]
    size = min(size, np.sqrt(dx * dx + dy * dy))
    row = 2 * a * 2 * s + 2 * a
    stiffness = max(sp.A[row], sp.A[row + 2 * s + 1])
    drive = st.mu[a] * stiffness
    return drive / size if size > 0.0 else (np.inf if drive > 0.0 else 0.0)


@inner
def find_fast(sp: Slipping, st: Step, h: float) -> int:
    """The nodes that turn fast, as many as there is room for: how many."""
    count = 0
    for a in range(sp.s):
        # approximate rotation of a direction towards its limit in a step, above which a node is fast
        if count < MOST_FAST and h * turning(sp, st, a, h) > 0.2:
            st.fast[count] = a
            count += 1
    return count


@inner
def begin_angles(course: Course, sp: Slipping, st: Step, h: float, count: int) -> None:
    """Initialise the stages with the rates at the beginning, and let the fast nodes turn."""
    row, n = 2 * st.n, st.n
    for m in range(3):
        for c in range(2 * sp.s):
            st.k[(m + 1) * row + c], st.k_q[(m + 1) * row + c] = st.k[c], st.k_q[c]
        for a in range(sp.s):
            st.mu[(m + 1) * n + a] = st.mu[a]
    for t in range(count):
        a = st.fast[t]
        x, y = st.k[2 * a], st.k[2 * a + 1]
        if st.mu[a] <= 0.0:
            x, y = -sp.q[2 * a], -sp.q[2 * a + 1]
        first, size = np.arctan2(y, x), np.sqrt(sp.q[2 * a] ** 2 + sp.q[2 * a + 1] ** 2)
        turn = 0.0
        if size > course.force:
            turn = -h * (np.cos(first) * st.k_q[2 * a + 1] - np.sin(first) * st.k_q[2 * a]) / size
        for m in range(3):
            st.angle[m * MOST_FAST + t] = first + PLACES[m + 1] * max(-MOST_TURN, min(MOST_TURN, turn))


@inner
def set_directions(sp: Slipping, st: Step, count: int, m: int) -> None:
    """Give the fast nodes their directions at a stage; beyond the apex their reactions are negative."""
    for t in range(count):
        at, angle = 2 * st.fast[t], st.angle[m * MOST_FAST + t]
        sp.unit[at], sp.unit[at + 1] = np.cos(angle), np.sin(angle)
        sp.size[st.fast[t]] = -sp.unit[at] * st.stage_q[at] - sp.unit[at + 1] * st.stage_q[at + 1]


@summing
def derivatives(sp: Slipping, st: Step, m: int, count: int) -> None:
    """How the rates of the fast nodes' reactions across their directions at a stage follow the angles."""
    s, row = sp.s, 2 * st.n
    start, dmu = (m + 1) * row, sp.correction
    for t in range(count):
        j = st.fast[t]
        x, y = -sp.unit[2 * j + 1], sp.unit[2 * j]
        mu = st.mu[(m + 1) * st.n + j]
        for a in range(s):
            ux, uy, first, last = sp.unit[2 * a], sp.unit[2 * a + 1], 4 * a * s + 2 * j, 2 * a * s + 2 * j
            along = ux * sp.A[first] + uy * sp.A[first + 2 * s] + sp.f[a] * sp.B[last]
            side = ux * sp.A[first + 1] + uy * sp.A[first + 2 * s + 1] + sp.f[a] * sp.B[last + 1]
            dmu[a] = -mu * (along * x + side * y)
        dmu[j] -= x * st.k_q[start + 2 * j] + y * st.k_q[start + 2 * j + 1]
        speeds.substitute(sp, s, dmu)
        for r in range(count):
            i = st.fast[r]
            first, ex, ey = 4 * i * s, -sp.unit[2 * i + 1], sp.unit[2 * i]
            total = 0.0
            for b in range(s):
                ax = ex * sp.A[first + 2 * b] + ey * sp.A[first + 2 * s + 2 * b]
                ay = ex * sp.A[first + 2 * b + 1] + ey * sp.A[first + 2 * s + 2 * b + 1]
                total += (ax * sp.unit[2 * b] + ay * sp.unit[2 * b + 1]) * dmu[b]
                if b == j:
                    total += mu * (ax * x + ay * y)
            st.bends[(m * MOST_FAST + r) * MOST_FAST + t] = total


@inner
def turn_on(joint: CompiledJoint, st: Step, h: float, count: int) -> bool:
    """A round of Newton's method on the angles; False where its equations are singular."""
    size, row, W, right = 3 * count, 2 * joint.n, st.equations, st.turn
    for m in range(3):
        for r in range(count):
            i, at, angle = st.fast[r], m * count + r, st.angle[m * MOST_FAST + r]
            x, y = np.cos(angle), np.sin(angle)
            qx, qy = st.reactions[m * row + 2 * i], st.reactions[m * row + 2 * i + 1]
            right[at] = -(qy * x - qx * y)
            for k in range(3):
                for t in range(count):
                    bend = st.bends[(k * MOST_FAST + r) * MOST_FAST + t]
                    W[at * size + k * count + t] = h * INWARD[m, k] * bend
            W[at * size + at] -= qx * x + qy * y
    if speeds.factor_few(W, st.turn_order, size) == 0:
        return False
    speeds.substitute_few(W, st.turn_order, size, right)
    for m in range(3):
        for r in range(count):
            st.angle[m * MOST_FAST + r] += max(-MOST_TURN, min(MOST_TURN, right[m * count + r]))
    return True


@summing
def stage_reactions(sp: Slipping, st: Step, h: float) -> None:
    """Packed reactions at the stages from the rates at all."""
    row = 2 * st.n
    for m in range(3):
        for c in range(2 * sp.s):
            total = 0.0
            for k in range(3):
                total += INWARD[m, k] * st.k_q[(k + 1) * row + c]
            st.reactions[m * row + c] = sp.q[c] + h * total


@inner
def stage_rates(run: SpaceRun, m: int, count: int) -> float:
    """Rates at a stage, the fast nodes in their directions: the largest change, or FAILED."""
    course, mo, sp, st = run.course, run.motion, run.slipping, run.step
    row = 2 * st.n
    for c in range(2 * sp.s):
        st.slip[c], st.stage_q[c] = st.k[(m + 1) * row + c], st.reactions[m * row + c]
    for a in range(sp.s):
        sp.speed[a] = st.mu[(m + 1) * st.n + a]
    speeds.find_directions(course, mo, sp, st.stage_q)
    set_directions(sp, st, count, m)
    if not speeds.rates_along(sp, st, m + 1):
        return FAILED
    change = 0.0
    for c in range(2 * sp.s):
        change = max(change, abs(st.k[(m + 1) * row + c] - st.slip[c]))
    return change


@inner
def solve_stages(run: SpaceRun, h: float, allowed: float, count: int) -> bool:
    """Find the rates at the stages; False where they do not converge."""
    joint, sp, st = run.joint, run.slipping, run.step
    last = np.inf
    for turn in range(NEWTON_ROUNDS):
        stage_reactions(sp, st, h)
        if turn > 0 and count > 0 and not turn_on(joint, st, h, count):
            return False
        change = 0.0
        for m in range(3):
            moved = stage_rates(run, m, count)
            if moved < 0.0:
                return False
            change = max(change, h * moved)
            derivatives(sp, st, m, count)
        if change <= MINOR * allowed:  # of the error of a slip
            return True
        if turn > 3 and not change < last:
            return False
        last = change
    return False


@inner
def turning_step(run: SpaceRun, h: float, allowed: float) -> float:
    """A step of this length from the packed state: estimate of its error [length], or infinite, or FAILED."""
    course, mo, sp, st = run.course, run.motion, run.slipping, run.step
    s, n, row = sp.s, st.n, 2 * st.n
    count = find_fast(sp, st, h)
    begin_angles(course, sp, st, h, count)
    if not solve_stages(run, h, allowed, count):
        return np.inf
    for c in range(2 * s):
        total, change = 0.0, 0.0
        for m in range(3):
            total += INWARD[2, m] * st.k[(m + 1) * row + c]
            change += INWARD[2, m] * st.k_q[(m + 1) * row + c]
        st.slip[c], st.stage_q[c] = h * total, sp.q[c] + h * change
    set_directions(sp, st, count, 2)
    least = np.inf
    for t in range(count):
        least = min(least, sp.size[st.fast[t]])
    if least > 10.0 * course.residual and return_to_cones(course, mo, sp, st, h) > course.residual:
        return np.inf
    speeds.find_directions(course, mo, sp, st.stage_q)
    set_directions(sp, st, count, 2)
    for a in range(s):
        sp.speed[a] = st.mu[3 * n + a]
    if not speeds.rates_along(sp, st, STAGES - 1):
        return FAILED
    return estimate(sp, st, h)


@inner
def estimate(sp: Slipping, st: Step, h: float) -> float:
    """The error estimate, from the rates at the beginning and those extrapolated from the stages."""
    s, row, error = sp.s, 2 * st.n, 0.0
    for a in range(s):
        x, y = st.k[2 * a], st.k[2 * a + 1]
        for m in range(3):
            x -= BACK[m] * st.k[(m + 1) * row + 2 * a]
            y -= BACK[m] * st.k[(m + 1) * row + 2 * a + 1]
        error = max(error, weighted(sp, st, a, x, y))
    return OF_ESTIMATE * h * np.sqrt(error)
