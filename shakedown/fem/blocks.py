"""The blocks of the thesis, with mesh refinement as a parameter."""
