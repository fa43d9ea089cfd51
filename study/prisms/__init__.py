"""Square prisms: estimators and simulation against dice that were rolled (Fig. 5)."""

from .prism_results import PrismResults, prisms_text
from .prism_runs import prisms

__all__ = ["PrismResults", "prisms", "prisms_text"]
