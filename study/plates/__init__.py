"""How well plates are fitted: Budden's dice, and plates simulated with friction."""

from .results import plates_text, write_plates
from .runs import plates

__all__ = ["plates", "plates_text", "write_plates"]
