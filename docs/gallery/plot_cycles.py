"""
From the first cycle to the last
================================

Slip in each cycle: below the limit it decays, above it it never ceases.
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
# Four nodes in space, starting from zero slip. Below λ_T the slip per cycle decays, more slowly the nearer the load factor
# is to λ_T; above λ_T it tends to that of a limit cycle.
