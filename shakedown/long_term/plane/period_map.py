"""The affine map of one period, carried in compiled code.

v ↦ v + d + J (v − v_start) for the slips v of the nodes alone that are stuck at the start and move within
the period. The others keep their slips exactly, so that the map leaves the space of
these nodes as it is: there lie all its powers of the increment, and their limit.
"""

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import Integers, NamedState, Reals, inner
from shakedown.ground.status import OPEN, STICK
from shakedown.motion.plane.active_set import ActiveSet, larger
from shakedown.motion.plane.moving_state import PlaneMotion


class PeriodMap(NamedState):
    """v ↦ v + d + J (v − v_start) of k nodes, its powers and its limit.

    Attributes
    ----------
    start : (2n,)
        u before the period.
    contact : (n,)
        Contact states there.
    stuck : (t,)
        Nodes stuck there, whose slips are the parameters of the state.
    moves : (k,)
        Which of the stuck nodes, by place in ``stuck``, move within the period.
    basis, tangent : (2n, t)
        ∂u/∂v_stuck before and after the period.
    delay : (t,)
        As in :class:`PlaneMotion`.
    power : (k, k)
        J, or J^leap.
    change : (k,)
        d, or Σ_{i < leap} Jⁱ d [length].
    limit, drift : (k,)
        Σ Jⁱ d without what drifts; what the slips gain per period for ever [length].
    image, work, inverse
        Scratch (n,), (n, n), (n, n).
    n, t, k
        Numbers of nodes.
    contraction, decaying
        As in :class:`shakedown.long_term.cycle_map.Limit`.
    """

    start: Reals
    contact: Integers
    stuck: Integers
    moves: Integers
    basis: Reals
    tangent: Reals
    delay: Reals
    power: Reals
    change: Reals
    limit: Reals
    drift: Reals
    image: Reals
    work: Reals
    inverse: Reals
    n: int
    t: int
    k: int
    contraction: float
    decaying: bool


def period_map(n: int) -> PeriodMap:
    """Arrays for the map of n nodes."""
    shapes = {"start": 2 * n, "basis": (2 * n, n), "tangent": (2 * n, n)}
    shapes |= dict.fromkeys(("contact", "stuck", "moves", "delay", "change", "limit", "drift", "image"), n)
    new = PeriodMap(shapes | dict.fromkeys(("power", "work", "inverse"), (n, n)))
    new.set(n=n, decaying=True)
    return new


@inner
def begin_map(pm: PeriodMap, act: ActiveSet, mo: PlaneMotion) -> None:
    """Take the present state as the start of a period and follow its derivative from here.

    Every moving node that is not stuck follows the stuck ones through its equations.
    """
    n, m, t, size = act.n, 2 * act.n, 0, act.size
    kappa, cols, coefs, inverse = act.kappa, act.col, act.coef, act.inverse
    for j in range(m):
        pm.start[j] = mo.u[j]
    for i in range(n):
        pm.contact[i] = act.state[i]
        if act.state[i] == STICK:
            pm.stuck[t] = i
            t += 1
    pm.t = t
    basis, rows = pm.basis, pm.tangent
    for j in range(m * t):
        basis[j] = 0.0
    for c in range(t):
        basis[pm.stuck[c] * t + c] = 1.0
    for b in range(size):
        for c in range(t):
            x = kappa[cols[b] * m + pm.stuck[c]]
            if coefs[b] != 0.0:
                x -= coefs[b] * kappa[(n + cols[b]) * m + pm.stuck[c]]
            rows[b * t + c] = x
    for b in range(size):
        for d in range(size):
            x = inverse[b * m + d]
            for c in range(t):
                basis[cols[b] * t + c] -= x * rows[d * t + c]
    for j in range(m * t):
        rows[j] = basis[j]
    mo.tangent, mo.delay, mo.parameters = pm.tangent, pm.delay, t


@inner
def end_map(pm: PeriodMap, mo: PlaneMotion) -> None:
    """J and d of the nodes that moved within the period that ends here."""
    t, k, stuck, tangent = pm.t, 0, pm.stuck, pm.tangent
    for a in range(t):
        node = stuck[a]
        moved = mo.u[node] != pm.start[node]
        for b in range(t):
            moved = moved or tangent[node * t + b] != (1.0 if a == b else 0.0)
        if moved:
            pm.moves[k] = a
            pm.change[k] = mo.u[node] - pm.start[node]
            k += 1
    pm.k = k
    for a in range(k):
        row = stuck[pm.moves[a]] * t
        for b in range(k):
            pm.power[a * k + b] = tangent[row + pm.moves[b]]


@inner
def distance_to_limit(pm: PeriodMap, leap: float, weight: FloatArray) -> float:
    """Largest weighted slip that remains to the limit after a number of periods, without drift."""
    far = 0.0
    for a in range(pm.k):
        left = abs(pm.change[a] - leap * pm.drift[a] - pm.limit[a])
        far = larger(far, weight[pm.stuck[pm.moves[a]]] * left)
    return far


@inner
def displace(pm: PeriodMap, change: FloatArray, u: FloatArray) -> None:
    """The start with the slips of the k nodes changed and the others in equilibrium, as ``u`` (2n,)."""
    n = pm.n
    for j in range(2 * n):
        if j >= n and pm.contact[j - n] != OPEN:
            u[j] = 0.0
        else:
            u[j] = pm.start[j] + along_basis(pm, change, j)


@inner
def along_basis(pm: PeriodMap, change: FloatArray, j: int) -> float:
    """Change of a displacement due to the slips of the k nodes."""
    total = 0.0
    for a in range(pm.k):
        total += pm.basis[j * pm.t + pm.moves[a]] * change[a]
    return total
