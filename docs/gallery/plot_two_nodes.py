"""
The safe region of two nodes
============================

Each node has two friction limits: four lines in the plane of the two slips. Slips within all four are safe: locked in,
they stay. As the load factor grows the lines move inwards (thesis, figure 5.4).
"""

import matplotlib.pyplot as plt

import shakedown

problem = shakedown.Problem(
    A=[[2.0, -1.0], [-1.0, 2.0]],
    B=[[0.5, 0.0], [0.0, 0.5]],
    f=0.5,
    q_w=[[6.0, 2.0], [-2.0, -2.0]],
    p_w=[[10.0, 10.0], [10.0, 10.0]],
    units="N, µm",
)
critical = shakedown.lower_bound(problem).slip
_, panels = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
for load_factor, panel in zip((0.8, 1.16), panels, strict=True):
    runs = {
        "from zero slip": shakedown.simulate(problem, load_factor, (0.0, 0.0), record=True),
        "from the critical slip state": shakedown.simulate(problem, load_factor, critical, record=True),
    }
    shakedown.plot.slip_space(problem, load_factor, runs, ax=panel)
    panel.set_title(f"λ = {load_factor}")

# %%
# At λ = 0.8 both motions end inside the region. At λ = 1.16, between λ_1 = 1.120 and λ_max = 1.226, the motion from the
# critical slip state is caught between two crossed lines of node 0 and never ends (:doc:`/tutorials/two-nodes` has the
# calculation by hand).
