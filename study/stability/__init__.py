"""The stability study: walks through every known trouble, by every method."""

from .stability_page import as_dict, stability_text, write_stability
from .walk_runs import stability

__all__ = ["as_dict", "stability", "stability_text", "write_stability"]
