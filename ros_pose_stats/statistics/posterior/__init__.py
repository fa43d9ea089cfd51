"""What an estimate and counted drops say together of a part's pose probabilities."""

from .posterior import Posterior, error_quantile
from .prior import PosePrior, PriorFit

__all__ = ["PosePrior", "Posterior", "PriorFit", "error_quantile"]
