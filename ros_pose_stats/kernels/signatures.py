"""What a kernel is compiled for, by its annotations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, get_type_hints

from numba.core import types as _types

types: Any = _types  # some of its names are made at import

SCALARS = {float: types.float64, int: types.int64, bool: types.boolean}


def signature_of(function: Callable[..., Any]) -> tuple[Any, ...]:
    """Types of the arguments: numbers, arrays from `array_types` and named tuples of them."""
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
