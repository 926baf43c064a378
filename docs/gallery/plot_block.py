"""
A block that slips at its corners
=================================

An elastic block, pressed on a rigid base and pushed to and fro, a little above its limit.
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
shakedown.plot.contact(joint)

# %%
# Nodes with their normals, and the welded reactions on them.

run = shakedown.simulate(joint, 3.6, record=True)
print(run.outcome.value)
shakedown.plot.hysteresis(run, nodes=[0, 8])

# %%
# Tangential reaction over slip: the corner node goes around a loop whose area is the work of friction in one
# period, the node in the middle sticks.

_, panels = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
shakedown.plot.pressure(run, joint, ax=panels[0])
shakedown.plot.slip_range(run, joint, ax=panels[1])

# %%
# Pressure along the contact at the load steps of the last cycle, and the slip range of every node.

shakedown.plot.zones(run, joint)

# %%
# Where and when the contact sticks and slips.
