"""Pictures need no window, so an ``MPLBACKEND`` unknown to matplotlib must not stop the import."""

import os
import sys
from contextlib import suppress

if "matplotlib" not in sys.modules and "MPLBACKEND" in os.environ:
    wanted = os.environ.pop("MPLBACKEND")  # matplotlib refuses to be imported while its value is unknown
    import matplotlib

    os.environ["MPLBACKEND"] = wanted
    with suppress(ValueError):
        matplotlib.rcParams["backend"] = wanted
