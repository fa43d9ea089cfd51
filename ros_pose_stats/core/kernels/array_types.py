# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Arrays by number of dimensions, as kernels and their tuples declare them.

A type checker sees NumPy arrays; `signature_of` finds what numba is to compile for.
What a kernel only reads is declared `Fixed`: such an argument may be read-only or not;
any other is written to.
"""

from collections.abc import Callable
from typing import Annotated, Any, get_type_hints

import numpy as np
from numba.core import types as _types
from numpy.typing import NDArray

types: Any = _types  # some of its names are made at import

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]
Slots = NDArray[np.int32]

Array1 = Annotated[Array, types.Array(types.float64, 1, "C")]
Array2 = Annotated[Array, types.Array(types.float64, 2, "C")]
Index1 = Annotated[Index, types.Array(types.int64, 1, "C")]
Index2 = Annotated[Index, types.Array(types.int64, 2, "C")]
Slots1 = Annotated[Slots, types.Array(types.int32, 1, "C")]

Fixed1 = Annotated[Array, types.Array(types.float64, 1, "C", readonly=True)]
Fixed2 = Annotated[Array, types.Array(types.float64, 2, "C", readonly=True)]
Fixed3 = Annotated[Array, types.Array(types.float64, 3, "C", readonly=True)]
FixedIndex1 = Annotated[Index, types.Array(types.int64, 1, "C", readonly=True)]
FixedIndex2 = Annotated[Index, types.Array(types.int64, 2, "C", readonly=True)]
FixedFlags1 = Annotated[Flags, types.Array(types.boolean, 1, "C", readonly=True)]

SCALARS = {float: types.float64, int: types.int64, bool: types.boolean}


def signature_of(function: Callable[..., Any]) -> tuple[Any, ...]:
    """Types of the arguments: numbers, arrays of this module, named tuples of them."""
    hints = get_type_hints(function, include_extras=True)
    hints.pop("return", None)
    return tuple(_type_of(hint) for hint in hints.values())


def _type_of(hint: Any) -> Any:
    if hint in SCALARS:
        return SCALARS[hint]
    if hasattr(hint, "_fields"):
        fields = get_type_hints(hint, include_extras=True).values()
        return types.BaseTuple.from_types([_type_of(field) for field in fields], hint)
    (declared,) = hint.__metadata__
    return declared
