"""A problem from finite-element output and a TOML file that says what is what.

Reading order: ``toml_table`` (typed reading of the file), ``time_function`` (histories),
``sections`` (one function per section), ``import_model`` (the public functions).
"""
