"""Results for readers: sentences, JSON documents, figures, the HTML report.

Reading order: ``node_words``, ``zone_words``, ``words``, ``design_words``, ``text_table``,
``json_documents``, ``verification_figures``, ``html`` with ``templates/``.
"""
