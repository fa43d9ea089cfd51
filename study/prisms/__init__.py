"""Square prisms: estimators and simulation against dice that were rolled (Fig. 5)."""

from lab.bodies.dice import DICE, Die

from .prism_results import Misfit, PrismResults, SidesPoint, prisms_text
from .prism_runs import prisms

__all__ = [
    "DICE",
    "Die",
    "Misfit",
    "PrismResults",
    "SidesPoint",
    "prisms",
    "prisms_text",
]
