"""Variants whose sizes differ as units do."""

from __future__ import annotations

from typing import Final

from .words import letter

RATIOS: Final = (10.0, 25.4, 1.0 / 0.0254, 100.0, 1000.0)
"""Of millimetres, centimetres, inches and metres; cm to inch is too near to a change of a part."""

ABOUT: Final = 1.1
"""Factor by which a variant may be larger or smaller besides."""


def warn_of_units(first: float, second: float, variant: int) -> tuple[str, ...]:
    """Warn where two variants differ in size by about the ratio of two units.

    `first, second`: radii of the first variant and of another, metres; `variant`: which one that
    is, from 1 on.
    """
    names = ("A", letter(variant)) if first > second else (letter(variant), "A")
    ratio = max(first, second) / min(first, second)
    if not any(one / ABOUT < ratio < one * ABOUT for one in RATIOS):
        return ()
    return (f"UNITS_DIFFER: {names[0]} is {ratio:.4g} times as large as {names[1]}: most likely "
            "one of the files is in another unit, and what follows means nothing.",)
