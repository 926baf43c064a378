"""Problem files and built-in problems: the border that everything on disk crosses.

Reading order: ``regular_file`` (what is opened for reading), ``npy`` (one array, read with
suspicion), ``npz`` (problem files), ``atomic_write`` (the one way in which files are written),
``table_file`` (a table as CSV or Parquet), ``examples`` (the built-in problems).
"""
