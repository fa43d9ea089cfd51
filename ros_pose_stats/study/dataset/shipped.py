"""The reference datasets that come with the package.

Each was written by `ros_pose_stats dataset --drops 1000 --shift S --shift-moment M`; the seed
and all else stand in the file.
"""

from __future__ import annotations

from pathlib import Path

from ...errors import DatasetError
from .dataset import Dataset, read_dataset

FOLDER = Path(__file__).resolve().parents[1] / "data"

SHIPPED = ((0.0, "inertia"), (0.25, "inertia"), (0.65, "second"), (1.0, "inertia"))
"""Shift scale and moment of each."""


def shipped_file(shift: float, shift_moment: str) -> Path:
    """Where a reference dataset lies.

    Raises
    ------
    DatasetError
        If none of that shift comes with the package.
    """
    if (shift, shift_moment) not in SHIPPED:
        known = ", ".join(f"{one:g} ({moment})" for one, moment in SHIPPED)
        raise DatasetError(f"a shift of {known}", f"{shift:g} ({shift_moment})",
                           "make one with `ros_pose_stats dataset` and give it with --dataset")
    return FOLDER / f"polyhedra_{abs(shift):g}_{shift_moment}.npz"  # of -0.0 too


def shipped_dataset(shift: float = 0.0, shift_moment: str = "inertia") -> Dataset:
    """A reference dataset: 1 057 bodies, 1 000 drops of each at restitution 0.2, 0.5, 0.8."""
    return read_dataset(shipped_file(shift, shift_moment))


def shipped_datasets() -> list[Dataset]:
    """All of them, by rising shift."""
    return [shipped_dataset(*one) for one in SHIPPED]
