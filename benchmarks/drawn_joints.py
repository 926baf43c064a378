"""Random joints of every kind that the commands take, each from its own seed."""

import numpy as np

from shakedown import Problem
from shakedown.ground.constants import FloatArray

NODES = (1, 2, 2, 3, 2, 3, 4, 5, 6, 3, 2, 4)  # by turns; every eighth joint has more
MOST_NODES = 12
NODES_IN_SPACE = (1, 2, 2, 3, 1, 2, 3, 4, 2, 3, 6)
STIFFNESSES = ("dense", "whole", "decades", "floating", "dense", "uncoupled")
STIFFNESSES_IN_SPACE = ("dense", "floating", "anisotropic", "dense", "decades", "whole", "uncoupled")
COUPLINGS = (1.0, 0.3, 1.0, 0.05, 0.0)
MEAN_PRESSURES = (4.0, 4.0, 1.5, 0.3)  # of a load of size 1: pressed together, opening now and then
LOADS = ("plain", "plain", "plain", "plain", "one at rest", "no tangential", "constant", "unloaded")


def drawn_joint(seed: int, number: int) -> Problem:
    """The joint with this number of the series with this seed; the kinds go round with the number."""
    rng = np.random.default_rng([seed, number])
    n = int(rng.integers(8, MOST_NODES + 1)) if number % 8 == 7 else NODES[number % len(NODES)]
    return _joint(rng, n, 1, str(rng.choice(STIFFNESSES)), f"random {number}")


def drawn_joint_in_space(seed: int, number: int) -> Problem:
    """The same with two tangential directions."""
    rng = np.random.default_rng([seed, number, 2])
    n = NODES_IN_SPACE[number % len(NODES_IN_SPACE)]
    kind = STIFFNESSES_IN_SPACE[number % len(STIFFNESSES_IN_SPACE)]
    return _joint(rng, n, 2, kind, f"random {number} in space")


def _joint(rng: np.random.Generator, n: int, d: int, kind: str, name: str) -> Problem:
    A, B, C = _stiffness(rng, kind, n, d)
    q_w, p_w = _loop(rng, n, d, whole=kind == "whole")
    return Problem(
        A=A,
        B=B,
        C=C if rng.random() < 0.6 else None,
        f=_friction(rng, n),
        q_w=q_w,
        p_w=p_w,
        name=name,
        load_path="domain" if rng.random() < 0.12 else "loop",
        **_more(rng, A, q_w, p_w),
    )


def _stiffness(
    rng: np.random.Generator, kind: str, n: int, d: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A, B and C with κ positive semi-definite, whatever share of the coupling is kept."""
    slips, size = d * n, (d + 1) * n
    root = rng.normal(size=(size, size))
    if kind == "whole":
        root = rng.integers(-2, 3, (size, size)).astype(float)
    kappa = root @ root.T + (1.0 if kind == "whole" else 0.2) * np.eye(size)
    if kind == "decades":
        kappa = _scaled(kappa, np.repeat(10.0 ** rng.uniform(-2, 2, n), d), d)
    if kind == "anisotropic":
        kappa = _scaled(kappa, np.tile([1.0, 10.0 ** rng.uniform(-2, 2)], n), d)
    A, B, C = kappa[:slips, :slips], kappa[slips:, :slips], kappa[slips:, slips:]
    if kind == "floating":
        A, B, C = _floating(rng, n, d)
    coupling = 0.0 if kind == "uncoupled" else rng.choice(COUPLINGS)
    return A, coupling * B, C


def _scaled(kappa: FloatArray, slips: FloatArray, d: int) -> FloatArray:
    """The stiffness with another size of each slip, and of each gap that of the first slip there."""
    size = np.concatenate([slips, slips[::d]])
    return kappa * size * size[:, None]


def _floating(rng: np.random.Generator, n: int, d: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Nodes in a row with springs of whole stiffness between them, and nothing else that holds them.

    κ is the sum of (s, b)(s, b)ᵀ over the springs, s the stretch that one makes of the slips and b that
    of the gaps, and of the nodes' own normal stiffness.
    """
    slips = np.kron(np.diff(np.eye(n), axis=0), np.eye(d))
    gaps = rng.integers(-1, 2, (len(slips), n)).astype(float)
    weight = rng.integers(1, 5, (len(slips), 1)).astype(float)
    return slips.T @ (weight * slips), gaps.T @ (weight * slips), gaps.T @ (weight * gaps) + np.eye(n)


def _friction(rng: np.random.Generator, n: int) -> FloatArray:
    """One coefficient or one of each node, none, or more than any threshold of uniqueness."""
    kind = rng.choice(
        ["one", "each", "each", "one without", "none", "high"], p=[0.3, 0.2, 0.2, 0.1, 0.05, 0.15]
    )
    if kind == "none":
        return np.zeros(n)
    f = rng.uniform(0.1, 0.8, n) if kind != "high" else rng.uniform(1.0, 5.0, n)
    if kind == "one":
        return np.array(float(rng.choice([0.25, 0.5, f[0]])))
    if kind == "one without":
        f[rng.integers(n)] = 0.0
    return f


def _loop(rng: np.random.Generator, n: int, d: int, *, whole: bool) -> tuple[FloatArray, FloatArray]:
    """Welded reactions of 2 to 12 load steps, in quarters where the stiffness is whole."""
    m, kind = int(rng.integers(2, 13)), rng.choice(LOADS)
    q, p = rng.normal(size=(m, d * n)), rng.choice(MEAN_PRESSURES) + 0.7 * rng.normal(size=(m, n))
    if kind == "one at rest":
        node = rng.integers(n)
        q[:, d * node : d * (node + 1)], p[:, node] = 0.25, 3.0
    if kind == "no tangential":
        q[:] = 0.0
    if kind == "constant":
        q[:], p[:] = q[0], p[0]
    if kind == "unloaded":
        q[:], p[:] = 0.0, 0.0
    return (np.round(4 * q) / 4, np.round(4 * p) / 4) if whole else (q, p)


def _more(rng: np.random.Generator, A: FloatArray, q_w: FloatArray, p_w: FloatArray) -> dict:
    """What only some joints have: a mean load, a transient, states to start from, labels, units."""
    slips, n, more = len(A), p_w.shape[1], dict[str, object]()
    if rng.random() < 0.3:
        more |= {"q_mean": 0.5 * q_w.mean(axis=0), "p_mean": np.abs(p_w.mean(axis=0)) + 0.5}
    if rng.random() < 0.2:
        steps = int(rng.integers(1, 4))
        more |= {
            "q_transient": 3.0 * rng.normal(size=(steps, slips)),
            "p_transient": 4.0 + rng.normal(size=(steps, n)),
        }
    if rng.random() < 0.3:
        states = (int(rng.integers(1, 3)), slips)
        more |= {"initial_slip": rng.normal(size=states) / np.diag(A).clip(1e-3)}
    if rng.random() < 0.15:
        more |= {"label": [f"FE {k}" for k in range(n)], "units": "N, mm", "x": _places(n, slips // n)}
    return more


def _places(n: int, d: int) -> FloatArray:
    """Where the nodes stand: in a row, or two rows in space."""
    row = np.arange(n, dtype=float)
    return row if d == 1 else np.column_stack([row // 2, row % 2])
