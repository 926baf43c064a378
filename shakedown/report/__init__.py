"""Results for readers: facts as text and as a page, JSON documents, pictures.

Facts (``facts``: label, value, unit, rounding, note; tables; sheets) are made by one function per
question; ``terminal`` and ``html`` render them as text or as a page. All sentences stand in ``notes``.

What you see, and the module that makes it:

- the answer, the claims, every limit: ``limit_facts``; all subsets of constraints: ``subset_facts``
- a run, its nodes: ``run_facts``; prediction against simulation: ``verification_facts``
- many initial states: ``map_facts``; parameters and amplitudes: ``design_facts``; meshes: ``mesh_facts``
- the joint, its loads, where its data come from: ``data_facts``; what an import has read: ``import_facts``
- nodes by number and label, without round-off: ``node_names``; tables as text: ``text_table``
- the page: ``html`` with ``templates/``; its pictures: ``load_figures`` (the joint), ``verification_figures``
  (limits and runs), ``period_figures`` (loops, zones, slips)
- ``--json`` and the file beside a page: ``json_documents``
"""
