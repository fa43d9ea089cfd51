"""What an estimate and counted drops say together of a part's pose probabilities."""

from .bound import error_quantile
from .posterior import Posterior
from .prior import PosePrior
from .prior_fit import PriorFit

__all__ = ["PosePrior", "Posterior", "PriorFit", "error_quantile"]
