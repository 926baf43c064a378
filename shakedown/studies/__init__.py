"""Many runs of one question: ``maps/`` over initial states, ``designs/`` over parameters."""
