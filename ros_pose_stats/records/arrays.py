"""Types of arrays by what they hold: numbers, places in other arrays, and answers yes or no."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]
Corners = NDArray[np.integer]  # of triangles: numbers of vertices
