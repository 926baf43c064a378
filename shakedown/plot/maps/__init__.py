"""Pictures of studies.

Reading order: ``regions`` (design diagrams), ``basins`` (maps of initial states).
"""
