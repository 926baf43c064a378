"""
How far can a node slip before it comes to rest?
================================================

Below λ_S no order of the loads moves a node farther than a proved distance. Here that bound is compared with the slip under
one order.
"""

import matplotlib.pyplot as plt
import numpy as np

import shakedown

joint = shakedown.example("block-9")
limit = shakedown.accumulated_bound(joint).load_factor
_, axes = plt.subplots(figsize=(8, 4.2), layout="constrained")
for share in (0.9, 0.97):
    run = shakedown.simulate(joint, share * limit, record=True)
    proved = shakedown.node_results(run).total_slip_bound
    total = np.abs(np.diff(run.history.v, axis=0)).sum(axis=0)
    (line,) = axes.plot(joint.x, proved, label=f"proved, {share} λ_S")
    axes.plot(joint.x, total, "o", color=line.get_color(), label=f"simulated, {share} λ_S")
axes.set(xlabel="position [mm]", ylabel="total slip [mm]", title=f"λ_S = {limit:.4g}")
axes.legend()

# %%
# The bound holds for every order of the loads, so it exceeds the slip under a single one (:doc:`/accumulated`).
