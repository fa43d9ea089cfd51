"""How sure counted drops are: intervals, standard errors, when to stop, lattice blocks, tests."""

from .blocks import BLOCK, BlockSums
from .chi_square import ChiSquare, goodness_of_fit, homogeneity
from .errors import expected_error, root_mean_square, standard_errors
from .intervals import DEFAULT_LEVEL, jeffreys_interval
from .stopping import checkpoints, next_checkpoint, target_reached

__all__ = ["BLOCK", "DEFAULT_LEVEL", "BlockSums", "ChiSquare", "checkpoints", "expected_error",
           "goodness_of_fit", "homogeneity", "jeffreys_interval", "next_checkpoint",
           "root_mean_square", "standard_errors", "target_reached"]
