"""
Which initial slips shake down?
===============================

Between the limits the slip locked in at assembly decides. A map follows many initial slips to their long-term states.
"""

import matplotlib.pyplot as plt
import numpy as np

import shakedown
from shakedown.joint.constraints import constraints

joint = shakedown.example("two-node")
found = shakedown.initial_state_map(joint, 0.7, sampler="grid", coordinates=(0, 1), states=64 * 64)
_, axes = plt.subplots(figsize=(8, 6), layout="constrained")
shakedown.plot.basin(found, ax=axes)
angle = np.linspace(0, 2 * np.pi, 181)
ball = shakedown.energy_ball(joint, 0.7).at(np.stack([np.cos(angle), np.sin(angle)], axis=1))
axes.plot(*ball.T, "b--")
rows, own = constraints(joint), constraints(joint).limits_of(1)
apex = np.linalg.solve(rows.G[own], (rows.g - 0.7 * rows.d)[own])
axes.axvline(apex[0], color="r", ls="-.")

# %%
# Inside the energy ball (dashed) shakedown is proved. At the apex (red) both limits of node 1 are active. Beyond the line
# through it they have crossed, and the node slips to and fro, farther with the distance from the apex (:doc:`/maps`).

print(f"{found.shakedown_fraction:.1%} of these states shake down")
