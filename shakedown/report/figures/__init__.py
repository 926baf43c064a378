"""Pictures of the page.

Reading order: ``cycle_figures`` (what the joint does), ``patch_figures`` (the same, and the loads, with two
tangential directions), ``verification_figures`` (limits and runs).
"""
