"""Results for readers: facts as text and as a page, JSON documents, pictures.

Facts (``facts``: label, value, unit, rounding, note; tables; sheets) are made by one function per
question; ``facts`` and ``html`` render them as text or as a page. All sentences stand in
``templates/notes.toml``.

What you see, and the module that makes it:

- the answer, the claims, every limit, also with ``--json``: ``limit_facts``
- a run, its nodes, prediction against simulation: ``run_facts``
- subsets of constraints, initial states, parameters and amplitudes, meshes: ``study_facts``
- the joint, its loads, its nodes by name, the sources of its data, what an import has read: ``data_facts``
- the page and its pictures: ``html`` with ``templates/``
"""
