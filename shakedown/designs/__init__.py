"""Designs: how the limits of a joint move with its parameters, and where its first cycle lies.

Reading order: ``parameters`` (named changes of a joint), ``variation`` (a joint as a
function of its parameters), ``design_point`` (all limits of one joint), ``diagram`` (limits over one or two
parameters, and the regions between them), ``sweep`` (all points of a diagram), ``table_file`` (a
diagram as CSV or Parquet).
"""
