"""What a period of the long-term state does to each node.

Reading order: ``node_table`` (the answer, and its files), ``node_results`` (how it follows from the path),
``diameters`` (of paths in a plane), ``node_instants`` (the state at instants, as files),
``slip_criterion`` (whether it slips little enough).
"""
