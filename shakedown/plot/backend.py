"""Pictures need no window, so an ``MPLBACKEND`` unknown to matplotlib must not stop the import."""

import os
import sys
from contextlib import suppress


def import_matplotlib() -> None:
    """Import matplotlib, which refuses to be imported while that variable has an unknown value."""
    if "matplotlib" in sys.modules:
        return
    wanted = os.environ.pop("MPLBACKEND", None)
    try:
        import matplotlib
    finally:
        if wanted is not None:
            os.environ["MPLBACKEND"] = wanted
    if wanted is not None:
        with suppress(ValueError):
            matplotlib.rcParams["backend"] = wanted


import_matplotlib()
