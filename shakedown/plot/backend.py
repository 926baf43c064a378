"""Pictures need no window: an ``MPLBACKEND`` that matplotlib does not know is nothing to stop at."""

import os
import sys
from contextlib import suppress


def import_matplotlib() -> None:
    """Import matplotlib, which refuses to be imported beside such a variable."""
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
