"""Which warnings are serious: those to be looked at before the numbers are used.

They say that lengths or shares may be off by more than the errors beside them, or that drops and
estimate contradict each other. The others say how an answer came about, what is peculiar about a
part, or what its errors tell already.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

SERIOUS: Final = frozenset({
    "UNIT_SUSPECT", "UNIT_OVERRIDDEN", "OPEN_MESH", "BODIES_OVERLAP", "INERTIA_SUSPECT",
    "COARSE_CURVE", "OUTSIDE_FIT", "CONFLICT", "LOW_DROP", "HEIGHT_SUSPECT", "UNITS_DIFFER"})
"""Codes; docs/warnings.md marks the same ones."""


def code_of(warning: str) -> str:
    """The code of a warning `CODE: sentence`."""
    return warning.partition(":")[0]


def is_serious(warning: str) -> bool:
    """Whether a warning `CODE: sentence` is to be looked at before the numbers are used."""
    return code_of(warning) in SERIOUS


def serious_first(warnings: Iterable[str]) -> list[str]:
    """Warnings with the serious ones before all others, else in their order."""
    return sorted(warnings, key=lambda one: not is_serious(one))
