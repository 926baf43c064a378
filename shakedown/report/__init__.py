"""Results for readers: sentences, JSON documents, figures, the HTML report.

Reading order: ``node_words``, ``zone_words``, ``words/`` (one room per subject), ``design_words``,
``text_table``, ``json_documents``; of the page: ``data_page`` (the joint), ``verification_figures`` (limits
and runs), ``cycle_figures`` (what the joint does), ``page_tables`` (tables), ``conclusion`` (the answer
and how far it holds), ``html`` with ``templates/``.
"""
