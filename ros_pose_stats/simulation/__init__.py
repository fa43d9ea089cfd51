"""Drop simulation: from starting directions to counted poses, on all cores."""

from .record_drop import record_drop
from .simulate import simulate

__all__ = ["record_drop", "simulate"]
