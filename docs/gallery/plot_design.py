"""
Regions over friction and preload
=================================

Where is the joint proved to come to rest, and where can it not? Dots are the designs that were computed; between them
the areas are interpolated, and nothing is proved there.
"""

import matplotlib.pyplot as plt
import numpy as np

import shakedown

joint = shakedown.example("two-node")
found = shakedown.sweep(
    joint,
    {"f": np.linspace(0.1, 0.7, 13), "mean": np.linspace(0.6, 2.4, 7)},
    bounds=("universal", "energy", "upper"),
)
_, axes = plt.subplots(figsize=(8, 5), layout="constrained")
shakedown.plot.regions(found, ax=axes)

# %%
# More friction always raises λ_max and λ_E of this joint. What is proved from *every* state ends where so much friction
# can lock in slip that lifts a node off (:doc:`/designs`).
