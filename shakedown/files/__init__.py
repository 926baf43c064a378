"""Problem files and built-in problems.

Reading order: ``npz`` (NPZ archives, read with suspicion, written whole or not at all),
``examples`` (the built-in problems).
"""
