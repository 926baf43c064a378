"""Campaigns: many pieces of work, on all cores or a cluster, recorded as they come, resumable.

A campaign is a function from the numbers 0 … count − 1 to bytes. It has to give the same bytes
for a number whenever and wherever it is called, and be picklable, as an instance of a frozen
dataclass with ``__call__`` is::

    @dataclass(frozen=True)
    class Bounds:
        problem: Problem
        frictions: tuple[float, ...]

        def __call__(self, number: int) -> bytes:
            f = self.frictions[number]
            found = upper_bound(replace(self.problem, f=np.full(self.problem.n, f)))
            return packed({"f": np.array(f), "load_factor": np.array(found.load_factor)})

    header = {"problem": problem.fingerprint, "frictions": repr(frictions)}
    with journal_at("sweep.csv.partial", header, resume=resume) as journal:
        run_campaign(Bounds(problem, frictions), len(frictions), journal, Crew(workers=4))
        for piece in journal.pieces():  # in order of their numbers, one at a time in memory
            row = unpacked(piece)
        ...  # write the result whole
        journal.remove()

Make each piece about a second of work, as every one is committed to the disk. What a killed run
had committed is there when it is resumed; a header that differs is refused. The file that
results depends neither on who did the work nor on how often it was interrupted.

Reading order: ``journal`` (what is done, on disk), ``stored_result`` (results and arrays as bytes),
``crew`` (who works: this process, several, a cluster), ``processes``, ``cluster`` with
``worker_versions``, ``pieces`` (the run; how a function that makes joints is known again).
"""
