"""The stability study: walks through every known trouble, by every method."""

from .documents import as_dict, write_stability
from .run import StabilityResults, WalkResults, stability
from .text import stability_page, stability_text

__all__ = ["StabilityResults", "WalkResults", "as_dict", "stability", "stability_page",
           "stability_text", "write_stability"]
