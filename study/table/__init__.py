"""Table I and what belongs to it: errors by restitution, sensitivity, outliers."""

from .dataset_table import table
from .table_results import TableResults
from .table_text import table_text

__all__ = ["TableResults", "table", "table_text"]
