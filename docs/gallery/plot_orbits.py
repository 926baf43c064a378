"""
Slips that go around
====================

Four nodes in space, pushed around in a circle: above the limit each slip is an orbit, which no rule of to and fro describes.
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
# Left: the slip of the one node that never comes to rest, in its tangential plane over one period; the path is closed. Right: its
# tangential reaction over the limit, and that of a node that sticks; on the rim a node slips, against its reaction.
