"""The stability study: walks through every known trouble, by every method."""

from .stability_page import as_dict, stability_page, stability_text, write_stability
from .walk_runs import StabilityResults, WalkResults, stability

__all__ = [
    "StabilityResults",
    "WalkResults",
    "as_dict",
    "stability",
    "stability_page",
    "stability_text",
    "write_stability",
]
