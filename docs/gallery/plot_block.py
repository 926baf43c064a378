"""
A block above its limit
=======================

An elastic block, pressed on a rigid base and pushed to and fro, at 1.1 times its λ_max.
"""

import matplotlib.pyplot as plt
import numpy as np

import shakedown
from shakedown.fem import ElasticBody, Material, Pressure, Traction, block_mesh, contact_problem

block = ElasticBody(
    block_mesh(2.0, 1.0, 16, 8),
    Material(young=200e3, poisson=0.3),
    loads=[
        Pressure("top", 10.0, history=np.ones(24)),
        Traction("top", (1.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
    ],
)
joint = contact_problem(block, "bottom", f=0.4, steps=24)
_, axes = plt.subplots(figsize=(8, 4), layout="constrained")
shakedown.plot.contact(joint, ax=axes)

# %%
# Nodes with their normals, and the welded reactions on them.

run = shakedown.simulate(joint, 3.6, record=True)
print(run.outcome.value)
_, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
shakedown.plot.hysteresis(run, joint, nodes=[0, 8], ax=axes)

# %%
# Tangential reaction versus slip; the area of a loop is the friction work in one period. The loop of the middle node
# is a rectangle, as its pressure hardly changes. At the corner the pressure falls to zero and the node opens, so that
# its reaction vanishes on the way back.

_, panels = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
shakedown.plot.pressure(run, joint, ax=panels[0])
shakedown.plot.slip_range(run, joint, ax=panels[1])

# %%
# Pressure along the contact at the load steps of the last cycle, and the slip range of every node.

_, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
shakedown.plot.zones(run, joint, ax=axes)

# %%
# Where and when the contact sticks and slips.
