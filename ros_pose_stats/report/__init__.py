"""The report on a part: one page to look at, to print and to send to a colleague."""

from .findings import Feeder, Findings, investigate
from .page import report_page

__all__ = ["Feeder", "Findings", "investigate", "report_page"]
