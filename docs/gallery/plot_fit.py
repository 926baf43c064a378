"""
Friction and preload from a measured damping curve
==================================================

A test gives the loss factor and the stiffness of a joint at a few amplitudes. A least-squares fit finds friction and
preload, and how well the test determines them.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares

import shakedown
from shakedown.fem import ElasticBody, Force, Material, Pressure, Support, block_mesh, contact_problem
from shakedown.studies.design_point import with_parameter

press = Pressure("top", 1.0, history=1.0)
pull = Force(boundary="right", value=(1.0, 0.15), history=np.sin(np.pi * np.arange(8) / 4))
hold = Support("left", y=False)
body = ElasticBody(block_mesh(8.0, 1.0, 24, 3), Material(100.0, 0.3), supports=[hold], loads=[press, pull])
base = contact_problem(body, "bottom", 0.4)
amplitudes = np.linspace(0.8, 3.2, 9)


def curve(friction, preload):
    joint = with_parameter(with_parameter(base, "f", friction), "mean", preload)
    found = shakedown.damping(joint, amplitudes, load="force")
    return np.concatenate([found.loss_factor, 10 * found.secant_stiffness / stiffness])


# %%
# The "measurement" is the computed curve at friction 0.45 and 1.1 times the nominal preload, with errors of 0.003 in the loss
# factor and of 0.03 % in the stiffness.
stiffness = shakedown.damping(base, [1e-3], load="force").secant_stiffness[0]
measured = curve(0.45, 1.1) + 0.003 * np.random.default_rng(2).normal(size=18)
fit = least_squares(lambda x: (curve(*x) - measured) / 0.003, [0.3, 0.9], diff_step=1e-4, bounds=(0.05, 2.0))
covariance = np.linalg.inv(fit.jac.T @ fit.jac)
error = np.sqrt(np.diag(covariance))
print(f"friction {fit.x[0]:.3f} ± {error[0]:.3f}, preload {fit.x[1]:.3f} ± {error[1]:.3f}")
product, slope = fit.x.prod(), fit.x[::-1]
print(f"their product {product:.4f} ± {np.sqrt(slope @ covariance @ slope):.4f}, correlation", end=" ")
print(f"{covariance[0, 1] / error.prod():.4f}, χ² {2 * fit.cost:.1f} of {18 - 2} degrees of freedom")

fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
for axes, part, name in ((left, slice(0, 9), "loss factor η"), (right, slice(9, 18), "stiffness / initial")):
    scale = 1 if axes is left else 10
    axes.errorbar(amplitudes, measured[part] / scale, 0.003 / scale, fmt="o", ms=4, label="measured")
    axes.plot(amplitudes, (measured + 0.003 * fit.fun)[part] / scale, label="fitted")
    axes.set(xlabel="amplitude of the force", ylabel=name)
    axes.legend()

# %%
# The test determines the product of friction and preload much better than either alone, as their correlation shows: where
# a load does not change the pressures, only the product counts (:doc:`/damping`). Uncertainties are of first order; the
# curve has kinks where another node begins to slip.
