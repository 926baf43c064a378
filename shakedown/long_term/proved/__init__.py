"""Verdicts held against what is proved: ``proved_rest``."""
