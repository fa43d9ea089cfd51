"""The module that holds the fitted weights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.estimators.bent import Bent
from ros_pose_stats.estimators.split_fit import SplitFit

from .samples import HIGHEST_DROP, HIGHEST_RESTITUTION

MODULE = (Path(__file__).resolve().parents[2]
          / "ros_pose_stats/estimators/split_weights.py")


def source(fits: Sequence[SplitFit]) -> str:
    """Its text; five digits are more than the data tell."""
    return TEXT.format(HIGHEST_RESTITUTION, HIGHEST_DROP, "\n".join(
        f"    SplitFit(\n        left={bent_source(fit.left, 8)},\n"
        f"        held={bent_source(fit.held, 8)})," for fit in fits))


def bent_source(bent: Bent, indent: int) -> str:
    """A function as source, after what stands so far to the right."""
    inner, deeper = " " * (indent + 4), " " * (indent + 8)
    turns = ",\n".join(f"{deeper}[{number_rows(row, deeper + ' ').strip()}]"
                       for row in bent.turns)
    arrays = {name: number_rows(getattr(bent, name), deeper)
              for name in ("slope", "offsets", "bends")}
    return (f"Bent(\n{inner}constant={bent.constant:.5g},\n"
            f"{inner}slope=np.array([\n{arrays['slope']}]),\n"
            f"{inner}turns=np.array([\n{turns}]),\n"
            f"{inner}offsets=np.array([\n{arrays['offsets']}]),\n"
            f"{inner}bends=np.array([\n{arrays['bends']}]))")


def number_rows(values: NDArray[np.floating], indent: str) -> str:
    """Numbers in lines of six, as source."""
    told = [f"{value:.5g}" for value in values.tolist()]
    lines = [", ".join(told[k:k + 6]) for k in range(0, len(told), 6)]
    return ",\n".join(indent + line for line in lines)


TEXT = '''"""Weights of the split estimator by `python -m training.split fit --write`."""

from __future__ import annotations

from typing import Final

import numpy as np

from .bent import Bent
from .split_fit import SplitFit

HIGHEST_RESTITUTION: Final = {}
HIGHEST_DROP: Final = {}
"""Radii; what the fit has seen goes up to here."""

SPLIT_FITS: Final = (
{}
)
"""From several starts; the mean of their logarithms counts."""
'''
