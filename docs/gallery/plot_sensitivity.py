"""
Which node limits, and what would help?
=======================================

The elasticity of λ_max with respect to the friction, the constant load and the amplitude at every node.
"""

import matplotlib.pyplot as plt

import shakedown
from shakedown.assessment.sensitivities import sensitivities

joint = shakedown.example("block-9")
found = sensitivities(joint, shakedown.upper_bound(joint))
_, axes = plt.subplots(figsize=(8, 4), layout="constrained")
shakedown.plot.sensitivity(found, joint, ax=axes)

# %%
# With an elasticity of 0.3, an increase of 1 % at that node raises λ_max by 0.3 % (:doc:`/interpretation`).
