"""What programs alone prove about a joint: where shakedown is impossible, and from which states certain.

Reading order: ``registry`` (the kinds of bounds, what each is about, which joints take long),
``bound_result`` (the result of all), ``upper`` (λ_max, most slack at one load factor),
``largest_load_factor`` (of any limits: in the plane by linear programs over rows, in space by cone programs
over discs; which nodes stay open; λ_max in space, call by call), ``named_start`` (initial slips by name),
``onset`` (up to where a given slip lasts, and where the contact opens then), ``independent_solver`` (the
bounds by another method). Then:

- ``certificate`` (the rows as a program, exact enclosures); in space ``disc_rows`` (orthonormal columns for
  slips; the limits, node by node), ``scaled_solution`` (the program in numbers near 1, solved: interior
  points, Newton's method on the active discs; the slip with most slack, the mean load), ``enclosure`` (safe
  slips, and two load factors with λ_max between them, proved).
- ``lower`` (the load factor at which each node can collapse, and λ_1), ``proof_status`` (whether λ_1 is a
  guarantee, and no node lifts off).
- ``coupling`` (κ in units of its own; the friction at which the determinant of some moving nodes vanishes;
  the ratio ρ* of a joint; is its motion unique), ``friction_thresholds`` (at which uniqueness ends, and a
  joint wedges).
- ``arc_search`` (the directions in which nodes may slip, and how far in all), ``accumulated_bound`` (the
  largest load factor for a given state and any order of the loads, λ_S): docs/accumulated.md.
- ``critical`` (all critical load factors), ``intersection`` (a subset of rows solved, with its condition),
  ``walk_kernel`` (the compiled walk, cut into pieces for several threads).

Beside them ``energy/``: what is proved from a given state on; ``every_state/``: from every initial state.
"""
