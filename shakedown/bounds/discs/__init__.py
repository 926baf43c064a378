"""λ_max and safe slips with two tangential directions: a cone program over the discs of all nodes.

Reading order: ``disc_rows`` (the limits, node by node), ``disc_program`` (the program in numbers near 1, and
its end by interior points), ``polish`` (Newton's method on the active discs), ``enclosure`` (two load factors
with λ_max between them, proved), ``disc_limits`` (the largest load factor, the least, the safest slip).
"""
