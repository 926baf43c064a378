"""Basic tools of every subpackage; nothing here knows about joints.

Reading order: ``errors`` (one tree; what is missing where an optional step failed), ``regular_file`` (what is
opened for reading), ``shown_values`` (text that a terminal or a page can show; numbers and results in
short), ``argument_kinds`` (arguments of callers, numbers of any kind, checked by annotation), ``tolerances``
(one settings object), ``constants`` (what is negligible, when an iteration has failed, how much is too
much), ``status`` (how a program ended, what a node does, outcomes), ``work_limit`` (what motions may take,
and on how many threads). Of compiled loops: ``code_cache`` (where compiled code is kept, by the hash of the
present sources; what is compiled into its callers alone), ``named_state`` (how functions are compiled and a
state is handed down).
"""
