"""The report on a part: one page to look at, to print and to send to a colleague."""

from .feeding import Feeding, feeding
from .findings import Findings, investigate
from .page import report_page

__all__ = ["Feeding", "Findings", "feeding", "investigate", "report_page"]
