"""Joints with numbers from the ends of what floating-point numbers hold."""

import numpy as np

BEYOND = [5e-324, 1e-310, 1e-200, 1e150, 1e200, 1e300, 1.7e308]
SIZES = [10.0**k for k in (-99, -75, -40, -28, -16, -12, -8, 8, 12, 16, 28, 40, 75, 99)]


def joint_arrays(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """A joint of one to three nodes: κ positive definite, singular, sparse, of whole numbers or zero."""
    n, m = int(rng.integers(1, 4)), int(rng.integers(1, 6))
    kind = rng.integers(5)
    root = rng.normal(size=(2 * n, 2 * n)) if kind < 3 else rng.integers(-2, 3, (2 * n, 2 * n)).astype(float)
    if kind == 1:
        root[:, rng.integers(2 * n)] = 0.0
        root[rng.random((2 * n, 2 * n)) < 0.4] = 0.0
    kappa = root @ root.T
    if kind == 2:  # rank one
        kappa = np.outer(root[0], root[0])
    if kind == 4 and rng.random() < 0.5:
        kappa = np.zeros((2 * n, 2 * n))
    arrays = {
        "A": kappa[:n, :n],
        "B": kappa[n:, :n],
        "C": kappa[n:, n:],
        "f": rng.choice([0.0, 0.3, 2.0, 50.0], n),
        "q_w": rng.normal(size=(m, n)),
        "p_w": rng.normal(size=(m, n)) + 3.0,
        "initial_slip": rng.normal(size=n),
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
                j = rng.integers(len(arrays["A"]))
                for key in ("A", "B", "C"):
                    if key in arrays:
                        arrays[key][j] *= size
                        arrays[key][:, j] *= size
    return arrays
