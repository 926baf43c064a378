"""One step of the slipping nodes along their smooth path: Dormand and Prince's pair of orders 5 and 4.

Its last stage is the first of the next step. The weights of the polynomial between the ends, of order 4,
are Shampine's (L. F. Shampine, Math. Comp. 46, 1986).
"""

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import inner, summing
from shakedown.ground.round_off import MUCH, PER_CENT
from shakedown.motion.course import Course
from shakedown.motion.space.moving_state import DEGREE, SpaceMotion
from shakedown.motion.space.space_run import SpaceRun
from shakedown.motion.space.speeds import (
    factor,
    find_directions,
    find_matrix,
    find_rates,
    substitute,
)
from shakedown.motion.space.step_state import STAGES, Slipping, Step

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
ENDS = np.stack([WEIGHTS[-1], OF_RADAU.sum(axis=1)])  # weights for the whole step
MOST_RETURNS = 8  # iterations that return to the cones
FAILED = -1.0  # instead of an error: the motion is unstable somewhere in the step


@summing
def explicit_step(run: SpaceRun, h: float, allowed: float) -> float:
    """A step of this length from the packed state, whose rates are stage 0: estimate of its error [length].

    The end lies on the cones. Near the apex an error counts for more than it is, so that one that is
    allowed leaves the reaction its direction. FAILED where the motion is not stable at a stage.
    """
    course, mo, sp, st, ct = run.course, run.motion, run.slipping, run.step, run.control
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
            if return_to_cones(course, mo, sp, st, h) > course.settled:
                return np.inf
        if not find_rates(course, mo, sp, st, ct, st.stage_q, j):
            return FAILED
    error = 0.0
    for a in range(s):
        x, y = 0.0, 0.0
        for i in range(STAGES):
            x += OF_ERROR[i] * k[i * row + 2 * a]
            y += OF_ERROR[i] * k[i * row + 2 * a + 1]
        reaction = PER_CENT * sp.size[a] * ct.length_scale
        stiffness = max(sp.A[2 * a * (2 * s + 1)], sp.A[(2 * a + 1) * (2 * s + 1)])
        weight = max(1.0, stiffness * ct.length_scale / ct.force_scale)
        if reaction > 0.0:
            weight = max(weight, allowed * ct.force_scale / reaction)
        error = max(error, (x * x + y * y) * weight * weight)
    return h * np.sqrt(error)


@summing
def return_to_cones(course: Course, mo: SpaceMotion, sp: Slipping, st: Step, h: float) -> float:
    """Move the state within the step along the directions of slip until |q| = f p: what is left [force]."""
    s, q, slip, worst = sp.s, st.stage_q, st.slip, np.inf
    for _ in range(MOST_RETURNS):
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
        if last < np.inf and worst > MUCH * last:  # the directions are to be renewed
            find_directions(course, mo, sp, q)
            find_matrix(sp, sp.M)
            if factor(sp, s) <= 0:
                sp.factored = False
                return np.inf
        substitute(sp, s, sp.correction)
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
    find_directions(course, mo, sp, st.stage_q)
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
