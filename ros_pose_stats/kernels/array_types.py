"""Arrays by number of dimensions, as kernels and their tuples declare them.

A type checker sees NumPy arrays; `signatures` finds what numba is to compile for. What a kernel
only reads is declared `Fixed`: such an argument may be read-only or not; any other is written to.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numba import types
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

Array1 = Annotated[Array, types.Array(types.float64, 1, "C")]
Array2 = Annotated[Array, types.Array(types.float64, 2, "C")]
Index1 = Annotated[Index, types.Array(types.int64, 1, "C")]
Index2 = Annotated[Index, types.Array(types.int64, 2, "C")]
Flags1 = Annotated[NDArray[np.bool_], types.Array(types.boolean, 1, "C")]
Slots1 = Annotated[NDArray[np.int32], types.Array(types.int32, 1, "C")]

Fixed1 = Annotated[Array, types.Array(types.float64, 1, "C", readonly=True)]
Fixed2 = Annotated[Array, types.Array(types.float64, 2, "C", readonly=True)]
FixedIndex1 = Annotated[Index, types.Array(types.int64, 1, "C", readonly=True)]
FixedIndex2 = Annotated[Index, types.Array(types.int64, 2, "C", readonly=True)]
FixedFlags1 = Annotated[NDArray[np.bool_], types.Array(types.boolean, 1, "C", readonly=True)]
FixedCorners2 = Annotated[NDArray[np.uint32], types.Array(types.uint32, 2, "C", readonly=True)]
