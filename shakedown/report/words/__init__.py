"""Results in sentences, one module per subject.

Reading order: ``assessment_words`` (what is certain), ``zone_words`` (open nodes), ``bound_words`` (what
the bounds mean), ``run_words`` (a simulation), ``limit_words`` (coupling, guarantee curve, λ_T),
``friction_words``, ``space_words`` (two directions), ``limit_sentences`` (either kind), ``subset_words``,
``sensitivity_words`` (which node limits), ``hint_words`` (the data), ``answer_words`` (one
sentence), ``next_words`` (what decides, and what to do).
"""
