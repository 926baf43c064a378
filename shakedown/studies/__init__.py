"""Many runs of one question: ``maps/`` over states, ``designs/`` over parameters, ``meshes/`` over meshes."""
