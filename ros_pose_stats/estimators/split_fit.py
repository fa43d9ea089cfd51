"""Fitted weights of the components at a split."""

from __future__ import annotations

from typing import NamedTuple

from .bent import Bent


class SplitFit(NamedTuple):
    """Logarithms of factors, of the inputs of `split.split_inputs`.

    Attributes
    ----------
    left : Bent
        On the area of {r < E}: parts that the last of their energy leaves in a component.
    held : Bent
        On the solid angle of the faces that hold: parts that are caught where they land.
    """

    left: Bent
    held: Bent
