"""
Where a bolted flange slips
===========================

A sector of a flange, pulled and sheared around its bolt, at 1.5 times the load above which it cannot come to rest.
"""

import matplotlib.pyplot as plt

import shakedown

joint = shakedown.example("bolted-flange")
limit = shakedown.upper_bound(joint, certify=False).load_factor
run = shakedown.simulate(joint, 1.5 * limit, record=True)
_, panels = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
shakedown.plot.welded_pressure_over_patch(joint, ax=panels[0])
shakedown.plot.slip_over_patch(run, joint, ax=panels[1])
shakedown.plot.work_over_patch(run, joint, ax=panels[2])
print(f"λ_max = {limit:.4f}; at 1.5 λ_max: {run.outcome.value}")

# %%
# The contact from above, around the bolt hole: pressure under preload, sliding distance per cycle, and friction work, to
# which wear is proportional.
