"""
Which node limits, and what would help?
=======================================

The elasticity of λ_max with respect to the friction, the constant load and the amplitude at every node.
"""

import shakedown
from shakedown.assessment.sensitivity.sensitivities import sensitivities

joint = shakedown.example("block-9")
found = sensitivities(joint, shakedown.upper_bound(joint))
shakedown.plot.sensitivity(found, joint)

# %%
# An elasticity of 0.3 says that 1 % more of it at that node raises λ_max by 0.3 %
# (:doc:`/interpretation`).
