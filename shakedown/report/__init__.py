"""Results for readers: sentences, JSON documents, figures, the HTML report.

Reading order: ``node_words``, ``words/`` (one module per subject), ``design_words``, ``text_table``,
``json_documents``; of the page: ``figures/`` (limits, runs, what the joint does), ``data_page`` (the joint),
``page_tables`` (tables), ``first_page`` (what stands below the answer), ``conclusion`` (how far it holds),
``html`` with ``templates/``.
"""
