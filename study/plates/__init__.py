"""How well plates are fitted: Budden's dice, and plates of which the truth is known."""

from .results import plates_text, write_plates
from .runs import PlateResults, PrismSplits, SimulatedPlates, plates

__all__ = ["PlateResults", "PrismSplits", "SimulatedPlates", "plates", "plates_text",
           "write_plates"]
