"""
Regions versus friction and preload
===================================

Where is the joint proved to come to rest, and where is that impossible? Dots are computed designs; the areas between
them are interpolated.
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
# More friction always raises λ_max and λ_E of this joint. The region proved from *every* state ends where friction can
# lock in enough slip to lift a node off (:doc:`/designs`).
