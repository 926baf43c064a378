"""Which nodes move at an instant, and how: a complementarity problem for the speeds, and choices at the apex.

Of a node on its cone the direction of slip is known, and either it slips, μ > 0, and stays on the cone,
or it sticks and the rate of its slack is not negative: μ ⟂ M μ + z. As in the plane the problem is solved
by block pivoting with the least index as a safeguard, from the nodes that slipped before, and by
enumeration where that fails and there are few nodes. A solution counts only where it is stable,
det M > 0. A node at the apex, q = p = 0, sticks while |q̇| ≤ f ṗ, slips with q̇ = −f ṗ d along a direction
d that is an unknown of its own, or opens, ẇ ≥ 0; the first of those that fail changes its choice,
until none does.

A node that has come to rest on its cone has neither speed nor slack, nor a rate of slack: it stays out of
the problem until it has left the cone or is found outside.
"""

import numpy as np

from shakedown.ground.constants import DIRECTIONS, NEGLIGIBLE, ROUND_OFF, FloatArray
from shakedown.ground.named_state import inner, summing
from shakedown.ground.status import OPEN, SLIP, STICK
from shakedown.ground.work_limit import BY_BLAS
from shakedown.motion.course import ENUMERABLE, Course, EventKind
from shakedown.motion.space import speeds
from shakedown.motion.space.space_run import CompiledJoint, Slipping, SpaceMotion, SpaceRates, SpaceRun

BLOCK_CHANGES = 3  # simultaneous changes allowed without fewer violated conditions


@inner
def slack(joint: CompiledJoint, mo: SpaceMotion, i: int) -> float:
    """f p − |q| of a closed node [force]."""
    x, y = mo.out[2 * i], mo.out[2 * i + 1]
    return joint.friction[i] * mo.out[2 * joint.n + i] - np.sqrt(x * x + y * y)


@inner
def locate(run: SpaceRun) -> int:
    """Find the nodes at the apex and on their cones (``candidate``); how many are at the apex."""
    joint, course, mo, rates, st = run.joint, run.course, run.motion, run.rates, run.step
    n, near, count = joint.n, course.residual, 0
    for i in range(n):
        p, left = mo.out[2 * n + i], slack(joint, mo, i)
        rates.candidate[i], rates.apex[i], rates.before[i] = 0, 0, mo.contact[i]
        if mo.contact[i] == OPEN:
            rates.apex[i] = (
                1 if p <= course.residual * st.length_scale / st.force_scale else 0
            )  # the gap of an open node
        elif joint.friction[i] == 0.0:
            rates.apex[i] = 1 if p <= near else 0
        else:
            if left > near or mo.contact[i] == SLIP:
                mo.resting[i] = 0
            rates.apex[i] = 1 if p <= 2.0 * near else 0
            if rates.apex[i] == 0 and (mo.contact[i] == SLIP or left <= near) and mo.resting[i] == 0:
                rates.candidate[i] = 1
            if rates.apex[i] == 1:
                oppose_reaction(course, mo, i)
        if i == mo.node and mo.kind in (EventKind.OPENS, EventKind.CLOSES):
            closed = SLIP if joint.friction[i] == 0.0 else STICK
            rates.candidate[i], rates.apex[i] = 0, 1
            mo.contact[i] = OPEN if mo.kind == EventKind.OPENS else closed
        count += rates.apex[i]
    return count


@inner
def oppose_reaction(course: Course, mo: SpaceMotion, i: int) -> None:
    """Let a node near the apex slip against what remains of its reaction."""
    x, y = mo.out[2 * i], mo.out[2 * i + 1]
    size = np.sqrt(x * x + y * y)
    if size > course.force:
        mo.direction[2 * i], mo.direction[2 * i + 1] = -x / size, -y / size


@inner
def choose_rates(run: SpaceRun) -> bool:
    """Contact states and rates from this instant on, after the event that has led to it.

    False, and the states before it, where none are found; and where a load rises from nothing at many nodes:
    the end of that is known at once, while choosing one state after the other takes minutes.
    """
    joint, course, mo, rates, sp = run.joint, run.course, run.motion, run.rates, run.slipping
    n = joint.n
    apexes = locate(run)
    for k in range(3 * n):
        rates.held[k] = mo.u[k]
    found, in_turn = False, not rises_from_nothing(run, apexes)
    # so many attempts to choose the states of nodes at the apex
    for _ in range(1 + 60 * apexes if in_turn else 0):
        if not find_all_rates(run):
            break
        if apexes == 0 or not change_apex(run):
            found = True
            break
    for i in range(n):
        if not found and in_turn and rates.apex[i] == 1 and joint.friction[i] > 0.0:
            found = search_apex(run, i)
    if found:
        leave_apex(joint, mo, rates, sp)
    else:
        for i in range(n):
            mo.contact[i] = rates.before[i]
        take_contact(joint, course, mo, rates)
    return found


@inner
def rises_from_nothing(run: SpaceRun, apexes: int) -> bool:
    """Whether no contact transmits anything or is open, a load begins to, and there are many nodes."""
    n, mo, rates, is_open, rises = run.joint.n, run.motion, run.rates, False, False
    if apexes < n or n <= ENUMERABLE or mo.time > 0.0:
        return False
    for i in range(n):
        is_open = is_open or mo.u[2 * n + i] != 0.0
    for k in range(3 * n):
        rises = rises or rates.welded[k] != 0.0
    return rises and not is_open


@inner
def find_all_rates(run: SpaceRun) -> bool:
    """Find rates with the nodes at the apex unchanged; False where there are none."""
    joint, course, mo, rates, sp, st = run.joint, run.course, run.motion, run.rates, run.slipping, run.step
    held = take_contact(joint, course, mo, rates) and choose_slipping(run)
    run.step.effort += int(2 * BY_BLAS * sp.s * sp.s * sp.s) + 100
    if not held:
        return False
    speeds.move(joint, sp, st.k, 0, rates.rate)
    for i in range(3 * joint.n):
        rates.rate[i] += rates.base[i]
    return True


@inner
def search_apex(run: SpaceRun, i: int) -> bool:
    """Find the direction in which a node at the apex slips, all others following, where one by one fails."""
    width = 2.0 * np.pi / DIRECTIONS
    before = np.nan
    for part in range(DIRECTIONS + 1):
        low, high = (part - 1) * width, part * width
        now = across_all(run, i, high)
        if before * now <= 0.0:
            for _ in range(50):
                middle = 0.5 * (low + high)
                if across_all(run, i, middle) * before > 0.0:
                    low = middle
                else:
                    high = middle
            if not np.isnan(across_all(run, i, high)) and not change_apex(run):
                return True
        before = now
    return False


@inner
def across_all(run: SpaceRun, i: int, angle: float) -> float:
    """Rate of the reaction of a node at the apex across a direction of slip, all others following."""
    mo, rates, sp, st = run.motion, run.rates, run.slipping, run.step
    mo.contact[i] = SLIP
    mo.direction[2 * i], mo.direction[2 * i + 1] = np.cos(angle), np.sin(angle)
    if not find_all_rates(run):
        return np.nan
    a = 0
    while sp.node[a] != i:
        a += 1
    if st.mu[a] <= 0.0 or rates.rate[2 * st.n + i] < 0.0:
        return np.nan
    return rates.rate[2 * i + 1] * mo.direction[2 * i] - rates.rate[2 * i] * mo.direction[2 * i + 1]


@inner
def leave_apex(joint: CompiledJoint, mo: SpaceMotion, rates: SpaceRates, sp: Slipping) -> None:
    """Put the reactions of nodes that slip away from the apex on their cones, where they are round-off."""
    n = joint.n
    for a in range(sp.s):
        i = sp.node[a]
        if rates.apex[i] == 1:
            sp.p[a] = max(sp.p[a], 0.0)
            mo.out[2 * n + i] = sp.p[a]
            mo.out[2 * i], mo.out[2 * i + 1] = sp.q[2 * a], sp.q[2 * a + 1]


@inner
def take_contact(joint: CompiledJoint, course: Course, mo: SpaceMotion, rates: SpaceRates) -> bool:
    """Put displacements, reactions and equations into the contact states; False where one is loose."""
    before = joint.exchanges
    if not speeds.arrange(joint, mo):
        return False
    if joint.exchanges != before:
        for k in range(3 * joint.n):
            if joint.free[k] == 0:
                mo.u[k] = rates.held[k] if k < 2 * joint.n else 0.0
        speeds.compute_out(joint, course, mo, rates)
    return True


@inner
def choose_slipping(run: SpaceRun) -> bool:
    """Solve the problem of the nodes on their cones, those at the apex as they are, and find all rates."""
    joint, course, mo, rates, sp, st = run.joint, run.course, run.motion, run.rates, run.slipping, run.step
    n = joint.n
    speeds.compute_base(joint, rates)
    for i in range(n):
        at_apex = rates.apex[i] == 1 and mo.contact[i] == SLIP and joint.friction[i] > 0.0
        rates.chosen[i] = 1 if rates.candidate[i] == 1 or at_apex else 0
    speeds.pack(joint, mo, rates, sp)
    speeds.find_directions(course, mo, sp, sp.q)
    speeds.find_matrix(sp, sp.limits)
    c, largest = sp.s, largest_rate(joint, rates, rates.base)
    for a in range(c):
        i = sp.node[a]
        rates.slack_rate[a] = -sp.drive[a]
        rates.active[a] = 1 if mo.contact[i] == SLIP or rates.arrived[i] == 1 else 0
    if not (
        pivot(course, rates, sp, c, largest)
        or (c <= ENUMERABLE and enumerate_choices(course, rates, sp, c, largest))
    ):
        return False
    if slides_freely(joint, rates, sp, c, largest):
        return False
    all_slip = True
    for a in range(c):
        i = sp.node[a]
        rates.chosen[i], all_slip = rates.active[a], all_slip and rates.active[a] == 1
        if rates.candidate[i] == 1:
            mo.contact[i] = SLIP if rates.active[a] == 1 else STICK
            mo.resting[i] = rates.at_zero[a]
    if not all_slip:
        speeds.pack(joint, mo, rates, sp)
        speeds.find_directions(course, mo, sp, sp.q)
    sp.factored = True  # by the last solution of the problem, whose active nodes these are, in the same order
    speeds.spread_rates(sp, st, 0)
    return True


@inner
def largest_rate(joint: CompiledJoint, rates: SpaceRates, values: FloatArray) -> float:
    """The largest rate of a reaction, of these outputs or of the load."""
    largest = 0.0
    for i in range(3 * joint.n):
        if joint.free[i] == 0:
            largest = max(largest, max(abs(values[i]), abs(rates.welded[i])))
    return largest


@inner
def slides_freely(joint: CompiledJoint, rates: SpaceRates, sp: Slipping, c: int, largest: float) -> bool:
    """Whether a node slips so fast that round-off of its stiffness is all that resists it: nothing does."""
    row, N = 0, 3 * joint.n
    for a in range(c):
        if rates.active[a] == 1:
            x = 2 * sp.node[a]
            stiffness = max(joint.kappa[x * N + x], joint.kappa[(x + 1) * N + x + 1])
            if abs(sp.speed[row]) * stiffness * ROUND_OFF > largest:
                return True
            row += 1
    return False


@inner
def broken(course: Course, rates: SpaceRates, sp: Slipping, c: int, largest: float) -> int:
    """Solve for the speeds of the active nodes and set ``wanted``: how many break their conditions.

    −1 where the equations are singular, −2 where nothing is broken but the motion is not stable.
    """
    size, row, count, sign, fastest = 0, 0, 0, 1, 0.0
    for a in range(c):
        size += rates.active[a]
    for a in range(c):
        if rates.active[a] == 1:
            t = row * size
            for b in range(c):
                if rates.active[b] == 1:
                    sp.M[t] = sp.limits[a * c + b]
                    t += 1
            sp.speed[row] = -rates.slack_rate[a]
            row += 1
    if size > 0:
        sign = speeds.factor(sp, size)
        if sign == 0:
            return -1
        speeds.substitute(sp, size, sp.speed)
    for a in range(size):
        fastest = max(fastest, abs(sp.speed[a]))
    row = 0
    for a in range(c):
        rates.wanted[a], rates.at_zero[a] = rates.active[a], 0
        if rates.active[a] == 1:
            if rates.candidate[sp.node[a]] == 1 and sp.speed[row] < -course.rate * fastest:
                rates.wanted[a] = 0
                count += 1
            row += 1
        else:
            rate, t, terms = rates.slack_rate[a], 0, largest
            for b in range(c):
                if rates.active[b] == 1:
                    x = sp.limits[a * c + b] * sp.speed[t]
                    rate += x
                    terms = max(terms, abs(x))
                    t += 1
            if rate < -course.rate * terms:
                rates.wanted[a] = 1
                count += 1
            elif rate <= course.rate * terms:
                rates.at_zero[a] = 1
    return -2 if count == 0 and sign < 0 else count


@inner
def pivot(course: Course, rates: SpaceRates, sp: Slipping, c: int, largest: float) -> bool:
    """Find the active nodes by block pivoting; nodes with negligible speed rest."""
    fewest, spare_changes = c + 1, BLOCK_CHANGES
    for _ in range(20 + 10 * c):
        count = broken(course, rates, sp, c, largest)
        if count == 0:
            return True
        if count < 0:
            return False
        if count < fewest:
            fewest, spare_changes = count, BLOCK_CHANGES
        else:
            spare_changes -= 1
        for a in range(c):
            if rates.wanted[a] != rates.active[a]:
                rates.active[a] = rates.wanted[a]
                if spare_changes < 0:
                    break
    return False


@inner
def enumerate_choices(course: Course, rates: SpaceRates, sp: Slipping, c: int, largest: float) -> bool:
    """Take the first stable solution among all choices of the active nodes."""
    for code in range(1 << c):
        rest, allowed = code, True
        for a in range(c):
            rates.active[a] = rest % 2
            rest //= 2
            allowed = allowed and (rates.active[a] == 1 or rates.candidate[sp.node[a]] == 1)
        if allowed and broken(course, rates, sp, c, largest) == 0:
            return True
    return False


@inner
def change_apex(run: SpaceRun) -> bool:
    """Change the choice of the first node at the apex that breaks its conditions; False where none does."""
    joint, course, rates, sp, st = run.joint, run.course, run.rates, run.slipping, run.step
    n = joint.n
    largest, fastest = largest_rate(joint, rates, rates.rate), 0.0
    for i in range(3 * n):
        if joint.free[i] == 1:
            fastest = max(fastest, abs(rates.rate[i]))
    for a in range(sp.s):
        fastest = max(fastest, abs(st.mu[a]))
    for i in range(n):
        if rates.apex[i] == 1 and apex_breaks(run, i, course.rate * largest, course.rate * fastest):
            return True
    return False


@inner
def apex_breaks(run: SpaceRun, i: int, zero_rate: float, zero_speed: float) -> bool:
    """Whether a node at the apex breaks its conditions; it then has another choice."""
    joint, mo, rates, sp, st = run.joint, run.motion, run.rates, run.slipping, run.step
    n, f, state = joint.n, joint.friction[i], mo.contact[i]
    x, y, p = rates.rate[2 * i], rates.rate[2 * i + 1], rates.rate[2 * n + i]
    if state == OPEN:
        if p >= -zero_speed:  # of an open node this is the rate of the gap
            return False
        mo.contact[i] = STICK if f > 0.0 else SLIP
        return True
    if f == 0.0:
        if p >= -zero_rate:
            return False
        mo.contact[i] = OPEN
        return True
    if state == STICK:
        if np.sqrt(x * x + y * y) <= f * p + zero_rate:
            return False
        mo.contact[i] = SLIP if find_apex_direction(joint, mo, i, x, y, p) else OPEN
        return True
    a = 0
    while sp.node[a] != i:
        a += 1
    mu, dx, dy = st.mu[a], mo.direction[2 * i], mo.direction[2 * i + 1]
    # tolerance on the slip direction of a node at the apex
    if mu > 0.0 and p >= -zero_rate and abs(dx * y - dy * x) <= NEGLIGIBLE / 10 * max(abs(x), abs(y)):
        return False
    ax, ay, b = of_slip(joint, i, dx, dy)
    ax, ay, b = x - mu * ax, y - mu * ay, p - mu * b  # the rates while it sticks
    if np.sqrt(ax * ax + ay * ay) <= f * b:
        mo.contact[i] = STICK
    elif not find_apex_direction(joint, mo, i, ax, ay, b):
        mo.contact[i] = OPEN
    return True


@inner
def of_slip(joint: CompiledJoint, i: int, x: float, y: float) -> tuple[float, float, float]:
    """The changes of the three reactions of a node with its own slip."""
    S, N, at = joint.exchanged, 3 * joint.n, 2 * i
    first, second, third = at * N + at, (at + 1) * N + at, (2 * joint.n + i) * N + at
    return S[first] * x + S[first + 1] * y, S[second] * x + S[second + 1] * y, S[third] * x + S[third + 1] * y


@summing
def across(joint: CompiledJoint, i: int, angle: float, x: float, y: float, p: float) -> float:
    """Rate of the reaction across a direction of slip, at the speed that keeps to the cone; NaN if none."""
    f, dx, dy = joint.friction[i], np.cos(angle), np.sin(angle)
    ax, ay, b = of_slip(joint, i, dx, dy)
    stiffness, drive = ax * dx + ay * dy + f * b, -(x * dx + y * dy + f * p)
    if stiffness <= 0.0 or drive <= 0.0 or p + drive / stiffness * b < 0.0:
        return np.nan
    mu = drive / stiffness
    return (y + mu * ay) * dx - (x + mu * ax) * dy


@inner
def find_apex_direction(joint: CompiledJoint, mo: SpaceMotion, i: int, x: float, y: float, p: float) -> bool:
    """Direction in which a node at the apex slips, the others at their rates; False where there is none.

    x, y, p are the rates of its reactions while it sticks.
    """
    size = np.sqrt(x * x + y * y)
    least = joint.friction[i] * p / size if size > 0.0 else 1.0  # below that cosine to −q̇ there is no speed
    if least >= 1.0:
        return False
    reach = np.arccos(max(least, -1.0))
    middle_way, width = np.arctan2(-y, -x), 2.0 * reach / DIRECTIONS
    for part in range(DIRECTIONS):
        low, high = middle_way - reach + part * width, middle_way - reach + (part + 1) * width
        if part == 0:
            low += NEGLIGIBLE * width
        if part == DIRECTIONS - 1:
            high -= NEGLIGIBLE * width
        at_low, at_high = across(joint, i, low, x, y, p), across(joint, i, high, x, y, p)
        if at_low * at_high <= 0.0 and at_low != at_high:
            for _ in range(60):
                middle = 0.5 * (low + high)
                if across(joint, i, middle, x, y, p) * at_low > 0.0:
                    low = middle
                else:
                    high = middle
            mo.direction[2 * i], mo.direction[2 * i + 1] = np.cos(high), np.sin(high)
            return True
    return False
