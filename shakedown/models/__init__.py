"""From a finite-element model to a problem.

Reading order: ``readers/`` (file formats), ``mortar/`` (surfaces whose meshes do not match),
``condensation/`` (a large stiffness to the contact stiffness κ),
``importing/`` (what is what in the files: a TOML configuration).
"""
