"""Plates: what a real one does to parts, fitted from counts and kept in a file."""

from .counts import CountedPart, count_part, read_count_rows
from .fit import PartEvidence, PlateFit, fit_plate
from .profile import PlateProfile, profile_of, read_profiles, refuse_name, write_profile

__all__ = [
    "CountedPart",
    "PartEvidence",
    "PlateFit",
    "PlateProfile",
    "count_part",
    "fit_plate",
    "profile_of",
    "read_count_rows",
    "read_profiles",
    "refuse_name",
    "write_profile",
]
