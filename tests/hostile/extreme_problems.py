"""Joints with numbers from the ends of what floating-point numbers hold."""

import numpy as np

BEYOND = [5e-324, 1e-310, 1e-200, 1e150, 1e200, 1e300, 1.7e308]
SIZES = [10.0**k for k in (-99, -75, -40, -28, -16, -12, -8, 8, 12, 16, 28, 40, 75, 99)]


def joint_arrays(rng: np.random.Generator, directions: int = 1) -> dict[str, np.ndarray]:
    """A joint of one to three nodes: κ positive definite, singular, sparse, of whole numbers or zero."""
    n, m = int(rng.integers(1, 4)), int(rng.integers(1, 6))
    slips, size = directions * n, (directions + 1) * n
    kind = rng.integers(5)
    root = rng.normal(size=(size, size)) if kind < 3 else rng.integers(-2, 3, (size, size)).astype(float)
    if kind == 1:
        root[:, rng.integers(size)] = 0.0
        root[rng.random((size, size)) < 0.4] = 0.0
    kappa = root @ root.T
    if kind == 2:  # rank one
        kappa = np.outer(root[0], root[0])
    if kind == 4 and rng.random() < 0.5:
        kappa = np.zeros((size, size))
    arrays = {
        "A": kappa[:slips, :slips],
        "B": kappa[slips:, :slips],
        "C": kappa[slips:, slips:],
        "f": rng.choice([0.0, 0.3, 2.0, 50.0], n),
        "q_w": rng.normal(size=(m, slips)),
        "p_w": rng.normal(size=(m, n)) + 3.0,
        "initial_slip": rng.normal(size=slips),
    }
    if rng.random() < 0.2:
        del arrays["C"]
    if rng.random() < 0.3:
        del arrays["initial_slip"]
    return arrays


def extreme(arrays: dict[str, np.ndarray], rng: np.random.Generator) -> dict[str, np.ndarray]:
    """The same with one to three of its arrays, or single entries, scaled or replaced by extremes."""
    arrays = {key: value.copy() for key, value in arrays.items()}
    for _ in range(rng.integers(1, 4)):
        sizes = BEYOND if rng.random() < 0.1 else SIZES
        size = sizes[rng.integers(len(sizes))]
        kind = rng.integers(5)
        with np.errstate(all="ignore"):
            if kind == 0:
                for key in ("A", "B", "C"):
                    if key in arrays:
                        arrays[key] = arrays[key] * size
            elif kind == 1:
                for key in ("q_w", "p_w"):
                    arrays[key] = arrays[key] * size
            elif kind == 2:
                key = rng.choice(list(arrays))
                arrays[key] = arrays[key] * size
            elif kind == 3:
                key = rng.choice(["f", "q_w", "p_w", *(["initial_slip"] if "initial_slip" in arrays else [])])
                arrays[key].flat[rng.integers(arrays[key].size)] = size
            else:  # one node in units of its own
                j, n = rng.integers(len(arrays["f"])), len(arrays["f"])
                slips = np.arange(len(arrays["A"])) * n // len(arrays["A"]) == j
                units = {"A": np.where(slips, size, 1.0), "C": np.where(np.arange(n) == j, size, 1.0)}
                for key, rows, columns in (("A", "A", "A"), ("B", "C", "A"), ("C", "C", "C")):
                    if key in arrays:
                        arrays[key] *= units[rows][:, None]
                        arrays[key] *= units[columns]
    return arrays
