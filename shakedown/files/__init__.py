"""Problem files and built-in problems: everything that is read from and written to disk.

Reading order: ``npy`` (one array, checked before it is read), ``npz`` (problem files), ``atomic_write`` (the
only way in which files are written), ``table_file`` (a table as CSV or Parquet), ``vtk_points`` (points
for ParaView), ``examples`` (the built-in problems).
"""
