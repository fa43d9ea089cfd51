"""How sure counted drops are: intervals, standard errors, when to stop, and lattice blocks."""

from .blocks import BLOCK, BlockSums
from .errors import expected_error, standard_errors
from .intervals import DEFAULT_LEVEL, jeffreys_interval
from .stopping import checkpoints, next_checkpoint, target_reached

__all__ = ["BLOCK", "DEFAULT_LEVEL", "BlockSums", "checkpoints", "expected_error",
           "jeffreys_interval", "next_checkpoint", "standard_errors", "target_reached"]
