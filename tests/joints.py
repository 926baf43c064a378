"""Joints that several tests share: random ones, changed units, limit cycles of period two, slow approach."""

import numpy as np

import shakedown

FAMILY = [  # a (A₁₂), f B, impulses, load factor, initial slip, the two dissipations
    (0.039343246055341285,
     [[-0.5345086119298388, -0.8569157311907969], [0.4041932575523568, -0.622854052202083]],
     [0.7352315111469822, 1.2004923155237985, 1.8602560360839482, 1.5610645644749197, 1.0402606319190535,
      0.7799805431542852], 1.2688210242770062, [-0.11133676524120842, -0.14012585088328539]),
    (0.047052934129808946,
     [[-0.7326409316733856, -0.5825051307300982], [0.5675369598531744, -0.7263532111878839]],
     [1.6633017367544638, 0.7119002659044134, 0.6266604226207828, 0.8563477176559022, 0.7193624748827288,
      0.8645027126589823], 2.5249567820890344, [0.03556771122041761, 0.17795120256379734]),
]  # fmt: skip
ORDER = [(0, +1), (0, -1), (1, -1), (0, +1), (0, -1), (1, +1)]


def member(a, fB, impulses):
    """A two-node system of the family that has limit cycles of period two."""
    q, p = np.zeros((12, 2)), np.full(2, 4.0)
    for k, (node, sign) in enumerate(ORDER):
        q[2 * k, node] = sign * impulses[k]
    return shakedown.Problem(
        A=[[1, a], [a, 1]], B=np.array(fB) / 0.5, f=0.5, q_w=q, p_w=np.tile(p, (12, 1)),
        q_mean=np.zeros(2), p_mean=p,
    )  # fmt: skip


def safe_later():
    """One node that the mean load alone pulls open: what changes presses it shut from λ = 5/12 on."""
    return shakedown.Problem(
        A=[[1.0]], B=[[0.0]], C=[[1.0]], f=0.5, q_w=[[0.3], [-0.3]], p_w=[[2.0], [2.0]], q_mean=[0.0], p_mean=[-1.0]
    )  # fmt: skip


def safe_between():
    """That node beside one that is pressed shut and slips from λ = 3/2 on."""
    return shakedown.Problem(
        A=np.eye(2), B=np.zeros((2, 2)), C=np.eye(2), f=0.5, q_w=[[0.3, 1.0], [-0.3, -1.0]], p_w=[[2.0, 3.0], [2.0, 3.0]],
        q_mean=[0.0, 0.0], p_mean=[-1.0, 3.0],
    )  # fmt: skip


def free_pair(q_w, p_w=1.0, C=None):
    """Two nodes on a body that friction alone holds, under loads (m, 2), or (m,) on both alike."""
    q_w = np.reshape(q_w, (len(q_w), -1)) * np.ones(2)
    return shakedown.Problem(
        A=[[1.0, -1.0], [-1.0, 1.0]], B=np.zeros((2, 2)), C=C, f=0.5, q_w=q_w, p_w=p_w * np.ones_like(q_w)
    )


def walking():
    """A pair that walks, by as much in every cycle."""
    return free_pair([[0.9, -0.9], [-0.9, 0.9]], np.array([[1.0, 3.0], [3.0, 1.0]]))


def creeping():
    """One that creeps under a constant push, as its nodes carry the pressure in turn; λ_max = 5/9."""
    return free_pair([-0.3] * 4, np.array([[2.0, 0.2], [2.0, 0.2], [0.2, 2.0], [0.2, 2.0]]))


def sliding():
    """One that is pushed harder than friction can hold."""
    return free_pair([0.0, 4.0, 0.0, -1.0], C=np.eye(2))


def slow_problem(ratio):
    """Two nodes that drag each other towards shakedown, the slip of each cycle ``ratio`` times the last."""
    c = np.sqrt(ratio)
    q = np.zeros((8, 2))
    q[0, 0], q[2, 1], q[4, 0], q[6, 1] = 1.0, 1.0, -0.05, -0.05
    return shakedown.Problem(
        A=[[1.0, -c], [-c, 1.0]], B=np.zeros((2, 2)), f=0.5, q_w=q, p_w=np.full((8, 2), 1.0),
        q_mean=np.zeros(2), p_mean=np.ones(2),
    )  # fmt: skip


def any_joint(rng):
    """Any rank of κ from n on, whole numbers now and then, friction far above the thresholds too."""
    n, m = int(rng.integers(1, 5)), int(rng.integers(2, 7))
    rank = int(rng.integers(n, 2 * n + 1)) if rng.random() < 0.7 else 2 * n
    whole = rng.random() < 0.4
    G = rng.integers(-2, 3, (2 * n, rank)).astype(float) if whole else rng.normal(size=(2 * n, rank))
    kappa = G @ G.T
    p_w = rng.uniform(0.5, 3.0, n) + rng.normal(size=(m, n)) * rng.uniform(0.05, 1.2)
    q_w = 0.6 * rng.normal(size=(m, n))
    if rng.random() < 0.3:
        p_w, q_w = np.round(4 * p_w) / 4, np.round(4 * q_w) / 4
    return shakedown.Problem(
        A=kappa[:n, :n], B=kappa[n:, :n], C=kappa[n:, n:], f=rng.uniform(0.2, 3.0), q_w=q_w, p_w=p_w
    )


def joint_of_kind(rng, kind):
    """Joints of 1 to 6 nodes: any, loosely coupled, above the friction thresholds, without a hold somewhere."""
    if kind == "any":
        return any_joint(rng)
    n, m = int(rng.integers(1, 7)), int(rng.integers(2, 9))
    root = rng.normal(size=(2 * n, 2 * n))
    kappa = root @ root.T / np.sqrt(2 * n) + 0.5 * np.eye(2 * n)
    p_w = rng.uniform(0.5, 3.0, n) + rng.normal(size=(m, n)) * rng.uniform(0.05, 1.2)
    friction = rng.uniform(0.1, 0.8, n) * (rng.random(n) > 0.08)
    transient = {}
    if rng.random() < 0.5:
        k = int(rng.integers(1, 4))
        transient = {"q_transient": rng.normal(size=(k, n)), "p_transient": rng.uniform(0.5, 4.0, (k, n))}
    if kind == "above thresholds":
        friction *= 10.0
    if kind == "floating":
        free = rng.normal(size=n)
        hold = np.eye(n) - np.outer(free, free) / (free @ free)
        kappa[:n, :n] = hold @ kappa[:n, :n] @ hold
        kappa[n:, :n], kappa[:n, n:] = 0.0, 0.0
    return shakedown.Problem(
        A=kappa[:n, :n], B=kappa[n:, :n], C=kappa[n:, n:], f=friction, q_w=0.6 * rng.normal(size=(m, n)),
        p_w=p_w, **transient,
    )  # fmt: skip


def wild_joint(rng):
    """A joint of 1 to 12 nodes in any units, and an initial slip or None; what makes solvers give up.

    Graded, soft or floating stiffness, friction at a threshold, loads of very different sizes.
    """
    n, m = int(rng.integers(1, 13)), int(rng.integers(2, 30))
    kind = rng.choice(["plain", "strong", "floating", "threshold", "soft", "graded"])
    root = rng.normal(size=(2 * n, 2 * n))
    kappa = root @ root.T / (2 * n) + (0.5 * np.eye(2 * n) if rng.random() < 0.5 else 0)
    if kind == "graded":
        sizes = 10.0 ** rng.uniform(-3, 3, 2 * n)
        kappa = kappa * sizes * sizes[:, None]
    if kind == "soft":
        values, vectors = np.linalg.eigh(kappa)
        values[: n // 2 + 1] *= 10.0 ** rng.uniform(-8, -2)
        kappa = vectors @ np.diag(values) @ vectors.T
    if kind == "floating" and n > 1:
        rigid = np.append(np.ones(n), np.zeros(n)) / np.sqrt(n)
        hold = np.eye(2 * n) - np.outer(rigid, rigid)
        kappa = hold @ kappa @ hold
    kappa = (kappa + kappa.T) / 2
    A, B, C = kappa[:n, :n].copy(), kappa[n:, :n].copy(), kappa[n:, n:].copy()
    if rng.random() < 0.3:
        B *= rng.choice([1e-6, 1e-3, 0.1])
    f = rng.uniform(0.05, 0.9, n) * (3 if kind == "strong" else 1)
    if kind == "threshold":
        j = rng.integers(n)
        if B[j, j] != 0:
            at = rng.choice([1, 1 - 1e-12, 1 + 1e-12, 0.999, 1 - 1e-8])
            f[j] = min(A[j, j] / abs(B[j, j]) * at, 50.0)
    q = rng.normal(size=(m, n)) * 10.0 ** rng.uniform(-3, 1)
    p = rng.normal(size=(m, n)) * 10.0 ** rng.uniform(-3, 0.5) + rng.uniform(0.5, 3)
    if rng.random() < 0.2:
        p[:, rng.integers(n)] *= 1e-5
    force, length = 10.0 ** rng.choice([0, 0, -7, 7, -3, 5]), 10.0 ** rng.choice([0, 0, -7, 7, 3, -5])
    more = {}
    if rng.random() < 0.2:
        more = {"q_mean": rng.normal(size=n) * force * 0.3, "p_mean": np.full(n, 1.5) * force}
    if rng.random() < 0.2:
        more |= {"q_transient": rng.normal(size=(2, n)) * force, "p_transient": np.full((2, n), 1.5) * force}
    start = rng.normal(size=n) * length * 10.0 ** rng.uniform(-3, 1) if rng.random() < 0.3 else None
    K, P = force / length, force
    return shakedown.Problem(A=A * K, B=B * K, C=C * K, f=f, q_w=q * P, p_w=p * P, **more), start
