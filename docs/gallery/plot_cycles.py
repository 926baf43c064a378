"""
From the first cycle to the last
================================

How much the nodes slip, cycle after cycle: below the limit less and less, above it for ever.
"""

import matplotlib.pyplot as plt

import shakedown

joint = shakedown.example("four-node-3d")
runs = {f"λ = {at}": shakedown.simulate(joint, at, cycles=40, record=True) for at in (1.0, 1.05, 1.1)}
_, axes = plt.subplots(figsize=(8, 4), layout="constrained")
shakedown.plot.slip_per_cycle(runs, ax=axes)
for name, run in runs.items():
    print(name, run.outcome.value)

# %%
# Four nodes in space, from slip zero. Below λ_T what slips falls from cycle to cycle, the slower the nearer to λ_T; above it the
# slip tends to that of a limit cycle.
