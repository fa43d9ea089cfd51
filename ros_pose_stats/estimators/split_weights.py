"""Weights of the split estimator, as `python -m training.split fit --write` stores them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .tanh_network import Array, TanhNetwork, pack_networks, unpack_networks

FILE = Path(__file__).parent / "weights" / "split.npz"


class SplitFit(NamedTuple):
    """Logarithms of factors, of the inputs of `split.split_inputs`.

    Attributes
    ----------
    left : TanhNetwork
        On the area of {r < E}: parts that the last of their energy leaves in a component.
    held : TanhNetwork
        On the solid angle of the faces that hold: parts that are caught where they land.
    """

    left: TanhNetwork
    held: TanhNetwork


def pack_split_fits(fits: Sequence[SplitFit], highest: tuple[float, float]) -> dict[str, Array]:
    """What the file holds: fits, and the highest restitution and drop (radii) in the data."""
    return {**pack_networks([fit.left for fit in fits], "left_"),
            **pack_networks([fit.held for fit in fits], "held_"), "highest": np.array(highest)}


with np.load(FILE) as _stored:
    SPLIT_FITS = tuple(map(SplitFit, unpack_networks(_stored, "left_"),
                           unpack_networks(_stored, "held_")))
    """From several starts; the mean of their logarithms counts."""

    HIGHEST_RESTITUTION, HIGHEST_DROP = _stored["highest"].tolist()
    """What the fit has seen goes up to here; the drop in radii."""
