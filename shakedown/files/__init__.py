"""Problem files and built-in problems: the border that everything on disk crosses.

Reading order: ``npy`` (one array, read with suspicion), ``npz`` (problem files), ``atomic_write`` (the
one way in which files are written), ``table_file`` (a table as CSV or Parquet), ``vtk_points`` (points
for ParaView), ``examples`` (the built-in problems).
"""
