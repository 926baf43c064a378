"""Maps of initial states: what becomes of one joint from thousands of initial slips.

Reading order: ``samplers`` (which initial states, each from its number alone), ``map_pieces`` (the
long-term states of some of them), ``map_file`` (all of them on disk), ``limit_cycles`` (the distinct
limit cycles, whether they are stable, how far apart final slips lie), ``final_states`` (whether all
states end in one and the same), ``undecided`` (why some have no long-term state), ``slip_plane`` (safe
region, admissible slips and energy ball in a plane of two slips), ``basin_map`` (the results, at one load
factor or several), ``mapping`` (the public function), ``basin_boundary`` (between the basins of a grid).
"""
