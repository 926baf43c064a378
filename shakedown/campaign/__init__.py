"""Long studies in pieces: here, on processes or on any executor, each piece kept in a file, resumable.

The work is a picklable function from the numbers 0 … count − 1 to arrays by name, the same ones whenever and
wherever it is called; ``settings`` says what they depend on::

    with run_pieces(work, count, settings=…, output="map.npz", resume=True, workers=4) as pieces:
        ...  # write the result whole

Until the block ends the pieces are NPZ files in ``map.npz.parts``, named by a hash of all that they depend on
and their number; what a killed run left there is read when it is resumed. Make each about a second of work.
The file that results depends neither on who did the work nor on how often it was interrupted.

All of it stands in ``pieces``: the run, the files, any executor, worker processes, a dask cluster.
"""
