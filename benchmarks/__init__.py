"""Speed against error: studies that are run by ``python -m benchmarks``.

A study is a module of this package with

- ``TITLE``: one line;
- ``cases(short)``: the cases to measure, each a JSON-ready dictionary;
- ``measure(case)``: one case measured, a JSON-ready row;
- ``tables(rows)``: what the rows say, as text;
- ``figures(rows)``: what they show, as {name: matplotlib Figure}, where a page shows it.

Rows are stored as soon as they are measured, so that an interrupted study goes
on where it stopped.

``python -m benchmarks same_results`` is no study: it holds every result of this
checkout against those of another one, to the last bit; ``before_and_after`` holds times against times.
"""

STUDIES: tuple[str, ...] = (
    "bolted_flange",
    "bounds",
    "calculix_contact",
    "classical_contacts",
    "creep",
    "damping",
    "energy_bounds",
    "enumeration",
    "evolution",
    "hard_cases",
    "large_joints",
    "long_term",
    "mutation",
    "receding",
    "refinement",
    "space_classical",
    "space_peers",
    "space_verdicts",
    "stability",
    "unlike_meshes",
    "verify_times",
)
