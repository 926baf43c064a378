"""
The safe slip of a joint in space
=================================

With two tangential directions a safe slip is a field of arrows: locked in, it keeps every reaction within a disc of
radius f p at all load steps.
"""

import matplotlib.pyplot as plt
import numpy as np

import shakedown
from shakedown.fem import ElasticBody, Material, Pressure, Traction, brick_mesh, contact_problem

body = ElasticBody(
    brick_mesh((2.0, 2.0, 1.0), (4, 4, 3)),
    Material(young=200e3, poisson=0.3),
    loads=[
        Pressure("top", 10.0, history=np.ones(24)),
        Traction("top", (1.0, 0.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
        Traction("top", (0.0, 1.0, 0.0), history=lambda t: np.sin(2 * np.pi * t)),
    ],
)
joint = contact_problem(body, "bottom", f=0.4, steps=24)
upper = shakedown.upper_bound(joint)
slip = upper.slip.reshape(-1, 2)
_, panels = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
panels[0].quiver(*joint.x.T[:2], *slip.T, angles="xy")
panels[0].set(title=f"safe slip at λ_max = {upper.load_factor:.3f}", xlabel="x", ylabel="y")
panels[0].set_aspect("equal")
panels[0].margins(0.2)

corner = 0
mean, part = joint.q_w.mean(axis=0), joint.q_w - joint.q_w.mean(axis=0)
pressed, swings = joint.p_w.mean(axis=0), joint.p_w - joint.p_w.mean(axis=0)
for name, v in {"without slip": np.zeros_like(upper.slip), "with the safe slip": upper.slip}.items():
    q = (mean + upper.load_factor * part + joint.A @ v).reshape(joint.m, -1, 2)[:, corner]
    p = (pressed + upper.load_factor * swings + joint.B @ v)[:, corner]
    share = q / (joint.f[corner] * p)[:, None]
    panels[1].plot(*np.append(share, share[:1], axis=0).T, label=name)
    print(f"{name}: at most {np.linalg.norm(share, axis=1).max():.3f} of its limit")
turn = np.linspace(0.0, 2.0 * np.pi, 200)
panels[1].plot(np.cos(turn), np.sin(turn), "k--", label="limit")
panels[1].set(title=f"reaction of node {corner}", xlabel="q_x / (f p)", ylabel="q_y / (f p)")
panels[1].set_aspect("equal")
panels[1].legend(loc="upper left", fontsize="small")

# %%
# An elastic block, pressed down under a rotating push (:doc:`/tutorials/plane-joint`). Left: the slips, much enlarged.
# Right: the reaction of a corner over the period, relative to the friction limit. Without slip it leaves the disc; with
# the safe slip it just stays inside.
