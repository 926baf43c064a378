"""Problem files, built-in problems, long studies in pieces: everything that is read from and written to disk.

Reading order: ``npz`` (problem files, every array checked before it is read; the built-in ones),
``atomic_write`` (the only way in which files are written, a table as CSV or Parquet too), ``vtk_points``
(points for ParaView), ``pieces`` (many pieces of work on any executor, each in a file as soon as it is done).
"""
