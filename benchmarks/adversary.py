"""Look for cyclic slip below a first collapse that is called a guarantee.

Random joints, made to be difficult: loads are separate impulses on single nodes in
shuffled order, coupling is strong and unsymmetric. Each is simulated below its first
collapse from starts far outside the safe region and from the witness. A run that
goes on slipping is a counter-example; whether it is allowed depends on the status.
"""

import numpy as np
from numba import njit

import shakedown
from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.bounds.uniqueness.in_contact import unique_in_contact
from shakedown.joint.constraints import constraints
from shakedown.joint.loading import loading
from shakedown.report.text_table import table

TITLE = "Cyclic slip below the first collapse, by status of the guarantee"
CYCLES = 400


def cases(short: bool) -> list[dict]:
    joints = 5 if short else 500
    bands = ("weak", "below one", "strong", "star")
    ranges = [(3, "known"), (2, "unique"), (2, "strong"), *((n, band) for n in (3, 4, 6) for band in bands)]
    return [{"n": n, "coupling": band, "joints": joints, "seed": 1} for n, band in ranges]


def measure(case: dict) -> dict:
    rng = np.random.default_rng(case["seed"])
    counts = {"runs": 0, "cycling": 0, "cycling_proved": 0, "proved": 0}
    counts |= {"lifted": 0, "lost": 0}
    lowest = 1.0
    for _ in range(case["joints"]):
        problem = difficult_joint(rng, case["n"], case["coupling"])
        lower = shakedown.lower_bound(problem, certify=False)
        if lower.status != "optimal" or lower.load_factor <= 0:
            continue
        counts["proved"] += lower.guarantee == "proved"
        for fraction, start in attacks(rng, problem, lower):
            ended = cycling(problem, fraction * lower.load_factor, start)
            counts["runs"] += 1
            counts["lifted"] += ended == "lifted"
            counts["lost"] += ended == "lost"
            if ended == "cycling":
                counts["cycling"] += 1
                counts["cycling_proved"] += lower.guarantee == "proved"
                lowest = min(lowest, fraction)
    return counts | {"lowest_fraction": lowest}


def difficult_joint(rng: np.random.Generator, n: int, band: str) -> shakedown.Problem:
    """A joint whose coupling ratio lies in a band, loaded by impulses in shuffled order."""
    if band == "known":
        return near_the_counter_example(rng)
    while True:
        A, B = stiffness(rng, n, band)
        m = int(rng.integers(2 * n, 4 * n + 1))
        loads = np.zeros((m, n))
        order = rng.permutation(np.repeat(np.arange(n), 2))
        loads[np.arange(2 * n), order] = rng.choice([-1, 1], 2 * n) * rng.uniform(0.2, 2, 2 * n)
        p0 = rng.uniform(2, 8, n)
        q0 = rng.uniform(-0.45, 0.45, n) * p0
        pressing = (rng.random() < 0.3) * 0.5 * rng.normal(size=(m, n))
        problem = shakedown.Problem(A=A, B=B, f=0.5, q_w=q0 + loads, p_w=p0 + pressing, q_mean=q0, p_mean=p0)
        if fits(problem, band):
            return problem


def near_the_counter_example(rng: np.random.Generator) -> shakedown.Problem:
    """The three-node counter-example with every number changed by up to a tenth: a control."""
    known = shakedown.example("three-node")

    def shaken(array: np.ndarray) -> np.ndarray:
        return array * (1 + 0.1 * rng.uniform(-1, 1, array.shape))

    off = np.triu(shaken(known.A), 1)
    loads, q0, p0 = shaken(known.q_w - known.q_mean), shaken(known.q_mean), shaken(known.p_mean)
    return shakedown.Problem(
        A=np.eye(3) + off + off.T,
        B=shaken(known.B),
        f=0.5,
        q_w=q0 + loads,
        p_w=np.tile(p0, (8, 1)),
        q_mean=q0,
        p_mean=p0,
    )


def stiffness(rng: np.random.Generator, n: int, band: str) -> tuple[np.ndarray, np.ndarray]:
    if band == "star":  # the others are coupled through node 0 only, like the three-node counter-example
        A, B = np.eye(n), np.zeros((n, n))
        A[0, 1:] = A[1:, 0] = rng.uniform(0.3, 0.99, n - 1) / np.sqrt(n - 1)
        B[0, 1:] = rng.choice([-1, 1], n - 1) * rng.uniform(0.5, 3, n - 1)
        return A, B
    A = np.eye(n) + rng.uniform(0.05, 0.95) * symmetric(rng, n)
    B = rng.normal(size=(n, n)) * rng.uniform(0.2, 3.0, (n, 1)) * (rng.random((n, n)) < 0.7)
    limits = {"weak": 1 / 3, "below one": 0.999, "strong": rng.uniform(1.0, 2.0)}
    return scaled_to(A, B, limits[band]) if band in limits else (A, B)


def symmetric(rng: np.random.Generator, n: int) -> np.ndarray:
    root = rng.normal(size=(n, n))
    root = 0.5 * (root + root.T)
    np.fill_diagonal(root, 0.0)
    return root / max(1.0, np.abs(np.linalg.eigvalsh(root)).max())


def scaled_to(A: np.ndarray, B: np.ndarray, ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """The same joint with all coupling scaled so that its coupling ratio is just below a number."""
    low, high = 0.0, 1.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        inside = coupling_of(middle * A + (1 - middle) * np.eye(len(A)), 0.5 * middle * B) < ratio
        low, high = (middle, high) if inside else (low, middle)
    return low * A + (1 - low) * np.eye(len(A)), low * B


def coupling_of(A: np.ndarray, fB: np.ndarray) -> float:
    """ρ* of stiffness matrices (``bounds.uniqueness.coupling``); inf above critical friction."""
    sides = np.stack([A - fB, A + fB])
    own = np.diagonal(sides, axis1=1, axis2=2)
    if own.min() <= 0:
        return np.inf
    influence = np.abs(sides) / own[:, :, None] * (1 - np.eye(len(A)))
    side, nodes, largest = influence.sum(axis=2).argmax(axis=0), np.arange(len(A)), 0.0
    for _ in range(20):
        values, vectors = np.linalg.eig(influence[side, nodes] + 1e-12)
        if values.real.max() <= largest:
            break
        largest = float(values.real.max())
        side = (influence @ np.abs(vectors[:, values.real.argmax()].real)).argmax(axis=0)
    return largest


def fits(problem: shakedown.Problem, band: str) -> bool:
    bound = coupling(problem).bound
    if band == "weak":
        return bound <= 1 / 3
    if band == "below one":
        return bound < 1
    return bool(np.isfinite(bound)) and unique_in_contact(problem)


def attacks(rng: np.random.Generator, problem: shakedown.Problem, lower) -> list[tuple[float, np.ndarray]]:
    """(fraction of λ_1, start): far starts, and the witness."""
    size = np.abs(lower.slip).max() + 1.0
    spread = [lower.slip + reach * size * rng.normal(size=problem.n) for reach in (0.1, 1.0, 5.0)]
    return [(fraction, start) for fraction in (0.6, 0.9, 0.999) for start in (lower.slip, *spread)]


def cycling(problem: shakedown.Problem, load_factor: float, start: np.ndarray) -> str:
    """ "settled", "cycling", "lifted" (a node opened) or "lost" (a load step did not converge)."""
    rows, loop = constraints(problem), loading(problem)
    f = problem.f
    steps = np.stack([loop.q1 - f * loop.p1, -loop.q1 - f * loop.p1], axis=2).reshape(problem.m, -1)
    right = rows.g - load_factor * steps
    slips = slip_by_cycle(rows.G, right, np.array(start), CYCLES)
    if slips[0] < 0:
        return "lifted" if slips[0] == -1.0 else "lost"
    size = np.abs(right).max() / np.abs(np.diag(problem.A)).min()
    late, later = slips[CYCLES // 2], slips[-1]
    return "cycling" if later > 1e-7 * size and later > 0.5 * late else "settled"


@njit(cache=True)
def slip_by_cycle(G, right, v, cycles):
    """Σ|Δv| of every cycle; the first entry is −1 if a node opens, −2 if a step does not converge.

    Each load step is implicit: every node goes no farther than its two limits at
    that step require, by Gauss–Seidel sweeps over nodes that all stay closed.
    """
    n, m = G.shape[1], right.shape[0]
    slips = np.zeros(cycles)
    for cycle in range(cycles):
        for k in range(m):
            before = v.copy()
            for _ in range(5000):
                change = 0.0
                for j in range(n):
                    upper, lower = right[k, 2 * j], -right[k, 2 * j + 1]
                    for i in range(n):
                        if i != j:
                            upper -= G[2 * j, i] * v[i]
                            lower += G[2 * j + 1, i] * v[i]
                    upper /= G[2 * j, j]
                    lower /= -G[2 * j + 1, j]
                    target = min(max(before[j], lower), upper)
                    if lower > upper:
                        target = 0.5 * (lower + upper)
                    change = max(change, abs(target - v[j]))
                    v[j] = target
                if change < 1e-13 * (1.0 + np.abs(v).max()):
                    break
            else:
                slips[0] = -2.0
                return slips
            for j in range(n):
                upper, lower = right[k, 2 * j], -right[k, 2 * j + 1]
                for i in range(n):
                    if i != j:
                        upper -= G[2 * j, i] * v[i]
                        lower += G[2 * j + 1, i] * v[i]
                if lower / -G[2 * j + 1, j] > upper / G[2 * j, j] + 1e-9 * (1.0 + np.abs(v).max()):
                    slips[0] = -1.0
                    return slips
            slips[cycle] += np.abs(v - before).sum()
    return slips


COUNTS = (
    "joints",
    "proved",
    "runs",
    "cycling",
    "cycling_proved",
    "lifted",
    "lost",
)


def tables(rows: list[dict]) -> str:
    headers = ["n", "coupling", *(key.replace("cycling_", "cyc. ") for key in COUNTS), "lowest / λ_1"]
    lines = [
        [str(r["n"]), r["coupling"], *(str(r[key]) for key in COUNTS), f"{r['lowest_fraction']:.3f}"]
        for r in rows
    ]
    return table(headers, lines)


def figures(rows: list[dict]) -> dict:
    return {}
