"""Load steps solved by Siconos, run by the system's Python: ``python3 siconos_steps.py IN.npz OUT.npz``.

Debian's package python3-siconos is built for the system's Python and for its NumPy, so this file imports
nothing of the toolkit. Each load step is the frictional contact problem u = M r + b of dimension d + 1, in
local order (normal, tangential), with M = κ⁻¹ and b the displacements free of reactions less the slip from
which the step counts.

IN: M, free (k, (d + 1) n) of every step without slip, f (n,), slip before the first step (dn,), empty where
``free`` has that of every step, solver, tolerance, iterations, budget: seconds of the processor after
which no step is begun. OUT: r, u (j, (d + 1) n) and seconds (j,) of the steps that were begun, and failures.
"""

import sys
import time

import numpy as np
import siconos.numerics as sn

SOLVERS = {
    (1, "nsgs"): ("SICONOS_FRICTION_2D_NSGS", "fc2d_nsgs_dense"),
    (1, "lemke"): ("SICONOS_FRICTION_2D_LEMKE", "fc2d_lexicolemke"),
    (2, "nsgs"): ("SICONOS_FRICTION_3D_NSGS", "fc3d_nsgs"),
    (2, "newton"): ("SICONOS_FRICTION_3D_NSN_AC", "fc3d_nonsmooth_Newton_AlartCurnier"),
}


def main(source, target):
    data = np.load(source)
    f, M = data["f"], np.asfortranarray(data["M"])
    d = len(M) // len(f) - 1
    tangential = np.arange(len(M)) % (d + 1) > 0
    number, solve = (getattr(sn, name) for name in SOLVERS[d, str(data["solver"])])
    options = sn.SolverOptions(number)
    options.dparam[sn.SICONOS_DPARAM_TOL] = float(data["tolerance"])
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = int(data["iterations"])
    slip, reactions, failures, seconds, out = data["slip"], np.zeros(len(M)), 0, [], []
    follows = slip.size > 0
    for free in data["free"].copy():
        if follows:
            free[tangential] -= slip
        velocity = np.zeros_like(reactions)
        problem = sn.FrictionContactProblem(d + 1, len(f), M, free, f)
        began = time.process_time()
        failures += solve(problem, reactions, velocity, options) != 0
        seconds.append(time.process_time() - began)
        if not np.isfinite(reactions).all():
            reactions = np.zeros_like(reactions)
        if follows:
            slip = slip + velocity[tangential]
        out.append((reactions.copy(), velocity))
        if sum(seconds) > float(data["budget"]):
            break
    r, u = (np.array(part) for part in zip(*out, strict=True))
    np.savez(target, r=r, u=u, seconds=seconds, failures=failures)


if __name__ == "__main__":
    main(*sys.argv[1:])
