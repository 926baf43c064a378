"""What every array of real numbers is."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
