"""Load steps in space solved by Siconos, run by the system's Python: ``… IN.npz OUT.npz``.

It imports nothing of the toolkit, as siconos_steps.py does not. Each load step is the frictional contact
problem u = M r + b of dimension 3, in local order (normal, two tangents), with M = κ⁻¹ and b the
displacements free of reactions less the slip from which the step counts.

IN: M (3n, 3n), free (k, 3n) of every step, f (n,), solver, tolerance, iterations, budget: seconds of the
processor after which no further step is begun. OUT: r, u (j, 3n) and seconds of the processor in every call
of the solver (j,), of the steps that were begun, and failures.
"""

import sys
import time

import numpy as np
import siconos.numerics as sn

SOLVERS = {
    "nsgs": ("SICONOS_FRICTION_3D_NSGS", "fc3d_nsgs"),
    "newton": ("SICONOS_FRICTION_3D_NSN_AC", "fc3d_nonsmooth_Newton_AlartCurnier"),
    "admm": ("SICONOS_FRICTION_3D_ADMM", "fc3d_admm"),
}


def main(source, target):
    data = np.load(source)
    f, M = data["f"], np.asfortranarray(data["M"])
    number, solve = (getattr(sn, name) for name in SOLVERS[str(data["solver"])])
    options = sn.SolverOptions(number)
    options.dparam[sn.SICONOS_DPARAM_TOL] = float(data["tolerance"])
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = int(data["iterations"])
    reactions, failures, seconds, out = np.zeros(3 * len(f)), 0, [], []
    for free in data["free"]:
        velocity = np.zeros_like(reactions)
        problem = sn.FrictionContactProblem(3, len(f), M, free.copy(), f)
        began = time.process_time()
        failures += solve(problem, reactions, velocity, options) != 0
        seconds.append(time.process_time() - began)
        if not np.isfinite(reactions).all():
            reactions = np.zeros_like(reactions)
        out.append((reactions.copy(), velocity))
        if sum(seconds) > float(data["budget"]):
            break
    r, u = (np.array(part) for part in zip(*out, strict=True))
    np.savez(target, r=r, u=u, seconds=seconds, failures=failures)


if __name__ == "__main__":
    main(*sys.argv[1:])
