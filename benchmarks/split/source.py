"""The module that holds the fitted weights."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .fit import Weights
from .samples import HIGHEST_DROP, HIGHEST_RESTITUTION

MODULE = (Path(__file__).resolve().parents[2]
          / "ros_pose_stats/estimators/split_weights.py")


def source(weights: Weights) -> str:
    """Its text; five digits are more than the data tell."""
    return TEXT.format(HIGHEST_RESTITUTION, HIGHEST_DROP, _row(weights.slope, "    "),
                       ",\n".join(f"    [{_row(row, '     ').strip()}]" for row in weights.turns),
                       _row(weights.offsets, "    "), _row(weights.bends, "    "))


def _row(values: NDArray[np.floating], indent: str) -> str:
    """Numbers in lines of eight."""
    told = [f"{value:.5g}" for value in values.tolist()]
    lines = [", ".join(told[k:k + 8]) for k in range(0, len(told), 8)]
    return ",\n".join(indent + line for line in lines)


TEXT = '''"""Weights of the split estimator by `python -m benchmarks.split fit --write`."""

from __future__ import annotations

from typing import Final

import numpy as np

HIGHEST_RESTITUTION: Final = {}
HIGHEST_DROP: Final = {}
"""Radii; what the fit has seen goes up to here."""

SLOPE: Final = np.array([
{}])
"""(19,) of the inputs of `split.split_inputs`."""

TURNS: Final = np.array([
{}])
"""(19, n) of the inputs within the hyperbolic tangents."""

OFFSETS: Final = np.array([
{}])
"""(n,)"""

BENDS: Final = np.array([
{}])
"""(n,) of the hyperbolic tangents."""
'''
