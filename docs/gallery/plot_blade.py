"""
The root of a turbine blade
===========================

Two flanks of a dovetail, each a patch of its own, pressed by the rotor's spin and bent by the gas.
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
# λ_max says that *some* slip would protect the root at this load. From the state that the first run-up leaves it does not
# get there: friction decides by history, and proved from this state is what counts (:doc:`/explanation/what-is-proved`).
