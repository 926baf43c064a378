"""
Which initial slips shake down?
===============================

Between the bounds the slip that is locked in at assembly decides. A map follows many initial slips, each to its
long-term state.
"""

import matplotlib.pyplot as plt

import shakedown

joint = shakedown.example("two-node")
found = shakedown.initial_state_map(joint, 0.7, sampler="grid", coordinates=(0, 1), states=64 * 64)
_, axes = plt.subplots(figsize=(8, 6), layout="constrained")
shakedown.plot.basin(found, ax=axes)

# %%
# Beyond the line through the apex of node 1 the two limits of that node have crossed: it slips to and fro, the
# more the farther from the apex (:doc:`/maps`).

print(f"{found.shakedown_fraction:.1%} of these states shake down")
