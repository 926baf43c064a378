"""Critical load factors of all (n+1)-subsets of the 2n constraints (thesis (5.11), (5.12)).

Reading order: ``critical`` (the public functions), ``intersection`` (a subset solved, with its condition;
what is kept of many), ``walk_kernel`` (the compiled walk, cut into pieces for several threads).
"""
