"""The shakedown-bounds command."""
