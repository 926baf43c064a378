"""What speaks for and against an import: distances of pairs, normals and faces, loads that do nothing.

What cannot be meant is refused; what is doubtful becomes a warning, one line each, that the problem
carries with it.

Reading order: ``pair_distances``, ``contact_faces``, ``bodies``, ``model_fit``, ``model_evidence`` (all
of these), ``load_doubts``, ``doubtful_data`` (of any problem).
"""
