"""The fields of a problem: what there is, and each of them by itself.

Reading order: ``field_table`` (every field once: its part, its shape), ``numbers`` (how large and
small they may be), ``texts`` (text, names, JSON), ``semidefinite`` (stiffness), ``places`` (where
nodes are, and their directions there), ``read_only`` (none is written to).
"""
