"""What of a joint converges as its mesh is refined.

Reading order: ``verdict`` (what a sequence of numbers does), ``refined`` (a table of meshes), ``refine``
(the study).
"""
