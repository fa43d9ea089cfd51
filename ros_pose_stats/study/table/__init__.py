"""Table I and what belongs to it: errors by restitution, sensitivity, refits, outliers."""

from .results import TableResults
from .run import table
from .text import table_text

__all__ = ["TableResults", "table", "table_text"]
