"""Options that say which dataset is meant."""

from __future__ import annotations

import argparse

SHIFT_MOMENTS = ("inertia", "second")


def add_shift_options(command: argparse.ArgumentParser, shift: float | None) -> None:
    """Add the shift of the centre of mass; None as the default stands for all."""
    told = "%(default)s" if shift is not None else "all that are there"
    command.add_argument("--shift", type=float, default=shift, metavar="S",
                         help="scale of the shift of the centre of mass; 0 leaves it at the "
                         f"centroid, 1 is as the paper prints it (default: {told})")
    command.add_argument("--shift-moment", choices=SHIFT_MOMENTS, default=SHIFT_MOMENTS[0],
                         help="the shift is measured in roots of the principal moments of "
                         "inertia over the mass, as printed, or of the second moments "
                         "(default: %(default)s)")
