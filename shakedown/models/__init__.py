"""From a finite-element model to a problem.

Reading order: ``readers/`` (file formats), ``condensation/`` (a large stiffness to the contact stiffness κ;
surfaces whose meshes do not match, by the mortar method),
``importing/`` (the TOML configuration that says what the files contain).
"""
