"""
Slips that go around
====================

Four nodes in space, pushed around in a circle: above the limit each slip is an orbit, which no rule of to and fro describes.
"""

import matplotlib.pyplot as plt

import shakedown

joint = shakedown.example("four-node-3d")
limit = shakedown.upper_bound(joint).load_factor
run = shakedown.simulate(joint, 1.1 * limit, record=True)
_, panels = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
shakedown.plot.slip_orbits(run, joint, ax=panels[0])
shakedown.plot.reaction_orbits(run, joint, ax=panels[1])
print(
    f"{run.outcome.value} at {run.load_factor:.4f}, {run.dissipation_per_cycle:.4g} of friction work per cycle"
)

# %%
# Left: the slip of each node in its tangential plane, over the last cycles. Right: its tangential reaction; where it
# touches what friction carries, the node slips, in the direction of the reaction.
