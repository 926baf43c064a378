"""Load steps solved by Siconos, run by the system's Python: ``python3 siconos_steps.py IN.npz OUT.npz``.

Debian's package python3-siconos is built for the system's Python and for its
NumPy, so this file imports nothing of the toolkit. Each load step is the
frictional contact problem u = M r + b of dimension 2, in local order (normal,
tangential), with M = κ⁻¹ and b the displacements free of reactions less the slip
of the step before.

IN: kappa (2n, 2n) in the order (tangential, normal), f (n,), q_w and p_w (k, n),
slip (n,) before the first step, or (k, n) before every step, solver, tolerance.
OUT: v, w, q, p (k, n), seconds of the processor, failures.
"""

import sys
import time

import numpy as np
import siconos.numerics as sn


def solver_options(name, tolerance):
    identifiers = {"nsgs": sn.SICONOS_FRICTION_2D_NSGS, "lemke": sn.SICONOS_FRICTION_2D_LEMKE}
    options = sn.SolverOptions(identifiers[name])
    options.dparam[sn.SICONOS_DPARAM_TOL] = tolerance
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = 100_000
    return options


def main(source, target):
    data = np.load(source)
    n, f = len(data["f"]), data["f"]
    order = np.stack([n + np.arange(n), np.arange(n)], axis=1).ravel()  # (p0, q0, p1, q1, ...)
    M = np.linalg.inv(data["kappa"])[np.ix_(order, order)]
    M = np.asfortranarray(0.5 * (M + M.T))
    loads = np.hstack([data["q_w"], data["p_w"]])[:, order]
    solve = {"nsgs": sn.fc2d_nsgs_dense, "lemke": sn.fc2d_lexicolemke}[str(data["solver"])]
    options = solver_options(str(data["solver"]), float(data["tolerance"]))
    slip, failures, out = np.array(data["slip"], dtype=float), 0, []
    given = slip if slip.ndim == 2 else None
    reactions = np.zeros(2 * n)
    began = time.process_time()
    for k, load in enumerate(loads):
        slip = slip if given is None else given[k]
        free = -M @ load
        free[1::2] -= slip
        velocity = np.zeros(2 * n)
        problem = sn.FrictionContactProblem(2, n, M, free, f)
        failures += solve(problem, reactions, velocity, options) != 0
        slip = slip + velocity[1::2]
        out.append((slip, velocity[0::2].copy(), reactions[1::2].copy(), reactions[0::2].copy()))
    seconds = time.process_time() - began
    v, w, q, p = (np.array(part) for part in zip(*out, strict=True))
    np.savez(target, v=v, w=w, q=q, p=p, seconds=seconds, failures=failures)


if __name__ == "__main__":
    main(*sys.argv[1:])
