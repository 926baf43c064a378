"""Results for readers: sentences, JSON documents, figures, the HTML report.

Reading order. Sentences: ``node_words``, ``assessment_words`` (what is certain), ``zone_words`` (open
nodes), ``bound_words`` (what the bounds mean), ``run_words`` (a simulation), ``limit_words`` (coupling,
guarantee curve, λ_T), ``friction_words``, ``sensitivity_words`` (which node limits), ``hint_words`` (the
data), ``answer_words`` (one sentence), ``next_words`` (what decides, and what to do), ``design_words``.
``json_documents``. Of the page: ``verification_figures``, ``cycle_figures`` and ``patch_figures``
(pictures), ``data_page`` (the joint), ``page_tables`` (tables), ``first_page`` (what stands below the
answer), ``conclusion`` (how far it holds), ``html`` with ``templates/``.
"""
