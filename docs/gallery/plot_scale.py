"""
All limits on one scale
=======================

Green is proved, red is impossible; between them the initial state decides.
"""

import matplotlib.pyplot as plt

import shakedown

joint = shakedown.example("two-node")
found = shakedown.assess(joint)
limits = found.details
_, axes = plt.subplots(figsize=(9, 2.4), layout="constrained")
shakedown.plot.load_factor_scale(
    {
        "λ_1": limits.lower.load_factor,
        "λ_E": limits.energy.load_factor,
        "λ_S": found.proved_from_this_state,
        "λ_max": limits.upper.load_factor,
    },
    bands={
        "proved": (0.0, found.proved_from_this_state),
        "impossible": (found.impossible_above, 1.2),
    },
    ax=axes,
)

# %%
# The nominal load, λ = 1, lies where no locked-in slip helps.

print(f"{found.proved_from_every_state:.4f} {found.proved_from_this_state:.4f} {found.impossible_above:.4f}")
