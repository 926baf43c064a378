"""
Slip orbits
===========

Four nodes in space under a rotating load: above the limit the slip of a node is an orbit, not a motion to and fro.
"""

import matplotlib.pyplot as plt

import shakedown

joint = shakedown.example("four-node-3d")
limit = shakedown.upper_bound(joint).load_factor
state = shakedown.long_term_state(joint, 1.1 * limit)
_, panels = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
shakedown.plot.slip_orbits(state, joint, nodes=[1], ax=panels[0])
shakedown.plot.reaction_orbits(state, joint, nodes=[0, 1], ax=panels[1])
print(
    f"{state.outcome.value} at {state.load_factor:.4f}, "
    f"{state.dissipation_per_cycle:.4g} of friction work per cycle"
)

# %%
# Left: the slip of the one node that never comes to rest, in its tangential plane over one period; the path is closed.
# Right: its tangential reaction relative to the friction limit, and that of a node that sticks. On the circle a node
# slips, in the direction opposite to its reaction.
