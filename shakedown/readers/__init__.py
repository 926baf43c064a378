"""Stiffness matrices as finite-element codes write them."""
