"""Square prisms: estimators and simulation against dice that were rolled (Fig. 5)."""

from .dice import DICE, Die
from .results import Misfit, PrismResults, SidesPoint
from .run import prisms
from .text import prisms_text

__all__ = ["DICE", "Die", "Misfit", "PrismResults", "SidesPoint", "prisms", "prisms_text"]
