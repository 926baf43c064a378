"""A problem from finite-element output and a TOML file that says what is what.

How the data flow: the deck names nodes, sets and faces (``model_section``); these
and the configuration give contact nodes, normals and tangents (``contact/``); the
matrix comes with the node and direction of its rows (``stiffness_section``); loads
and supports become vectors on these rows (``load_section``, ``time_function``);
the condensation turns all of it into a problem (``import_model``), with resultants
and rigid motions beside it (``load_evidence``), and warnings of what is doubtful (``evidence/``).

Reading order: ``model_section``, ``contact/``, ``stiffness_section``, ``time_function``,
``static_runs``, ``load_section``, ``load_evidence``, ``evidence/``, ``traces``,
``import_model`` (the public functions),
``templates`` (files to start from), ``contact_figure`` (a picture for checking).
"""
