"""What exists for the figures of the source thesis alone.

``corner_report`` (two nodes at their limits at once, chapter VI).
"""
