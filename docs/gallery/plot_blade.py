"""
The root of a turbine blade
===========================

A dovetail with two flanks, one patch each, loaded by centrifugal force and by gas bending.
"""

import matplotlib.pyplot as plt

import shakedown

joint = shakedown.example("blade-root")
limit = shakedown.upper_bound(joint, certify=False).load_factor
run = shakedown.simulate(joint, 0.9 * limit, record=True)
print(f"{run.outcome.value} at 0.9 λ_max: {(run.slip_per_cycle > 0).sum()} of {joint.n} nodes slip")
count = shakedown.plot.patch_count(joint)
_, panels = plt.subplots(1, count, figsize=(5 * count, 2.6), layout="constrained")
for patch, axes in enumerate(panels):
    shakedown.plot.slip_over_patch(run, joint, patch=patch, ax=axes)

# %%
# Below λ_max *some* locked-in slip would protect the root at this load. The first run-up does not lead to it, so the root
# slips in every cycle: the limit that counts is "proved from this state" (:doc:`/explanation/what-is-proved`).
