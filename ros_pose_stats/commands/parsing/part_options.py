"""Options that the commands on a part share."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from ...records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_RESTITUTION

if TYPE_CHECKING:
    from ...records import Part

UNITS = ("m", "mm", "cm", "inch")


def add_part_options(command: argparse.ArgumentParser) -> None:
    """Add the part file and how to read it."""
    command.add_argument("part", metavar="PART", help="mesh file: STL, OBJ, PLY, OFF or 3MF")
    command.add_argument("--unit", choices=UNITS,
                         help="unit of the file (default: what the file declares, else m)")
    command.add_argument("--com", nargs=3, type=float, metavar=("X", "Y", "Z"),
                         help="centre of mass in the file's unit (default: uniform density)")
    command.add_argument("--cluster-tolerance", type=float, default=DEFAULT_CLUSTER_TOLERANCE,
                         metavar="T", help="two poses count as one where the saddle between them "
                         "is less than this above both, as a fraction of the part's radius "
                         "(default: %(default)s; 0 lists every stable face)")


def add_scene_options(command: argparse.ArgumentParser) -> None:
    """Add how the part is dropped."""
    command.add_argument("--restitution", type=float, default=DEFAULT_RESTITUTION, metavar="R",
                         help="coefficient of restitution of the plate, 0 to below 1 "
                         "(default: %(default)s)")
    command.add_argument("--drop-height", type=float, metavar="H",
                         help="height of the centre of mass at release, in metres whatever the "
                         "unit of the file (default: 20 part radii); a part too large for it is "
                         "released touching the plate")


def part_of(options: argparse.Namespace) -> Part:
    """Load the part that the options name."""
    from ...mesh.parts import load_part

    return load_part(options.part, options.unit, options.com, center_in_unit=True)
