"""Results for readers: sentences, JSON documents, tables and pictures, the HTML report.

From a result to the reader: a ``*_words`` module puts a result into sentences; ``page_tables`` and its
neighbours put its numbers into tables, the ``*_figures`` choose its pictures (drawn by ``shakedown.plot``);
``json_documents`` writes it for programs. The command prints these sentences and tables as wide as the
terminal, ``html`` puts the same ones on a page.

What you see, and the module that writes it:

- the answer in one sentence, its margin, how far it holds: ``answer_words``
- the three numbers, and what is certain: ``assessment_words``; what decides, the next step: ``next_words``
- what holds below, between and above the bounds: ``bound_words``; with a zone of open nodes: ``zone_words``
- λ_T, the coupling ratio, the limiting node: ``limit_words``
- friction thresholds, critical load factors: ``friction_words``
- what a simulation found: ``run_words``; a sweep: ``design_words``;
  a map of initial states: ``map_words``; finer meshes, averages: ``mesh_words``
- doubts about the data: ``hint_words``; nodes by number and label: ``node_words``; tables as text:
  ``text_table``
- the page, from top to bottom: ``first_page`` (three numbers, one table), ``load_figures`` and ``data_page``
  (the joint), ``page_tables`` and ``verification_figures`` (bounds, runs, nodes), ``period_figures`` (loops,
  zones, slips); ``html`` with ``templates/``
- ``--json`` and the file beside a page: ``json_documents``
"""
