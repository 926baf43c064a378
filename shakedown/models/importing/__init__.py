"""A problem from finite-element output and a TOML file that describes it.

How the data flow: the deck names nodes, sets and faces; these and the configuration
give contact nodes, normals and tangents (``contact_section``); the matrix comes with the node and
direction of its rows (``stiffness_section``); loads and supports become vectors on these rows
(``load_section``); the condensation turns all of it into a problem (``import_model``),
with resultants and rigid motions beside it (``load_evidence``, ``model_evidence``). Impossible input
is refused; doubtful input becomes a warning of one line that the problem carries with it.

Reading order: ``contact_directions``, ``contact_section``,
``joined_contact`` (several patches, friction), ``stiffness_section``, ``load_section`` (loads and their time
functions, supports, static runs), ``model_evidence``, ``bolt_section``, ``load_evidence``, ``import_model``
(the public functions), ``contact_figure``, ``templates`` (files to
start from).
"""
