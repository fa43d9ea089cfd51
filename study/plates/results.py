"""The studies of fitted plates as a text and as a page."""

from __future__ import annotations

import math
from pathlib import Path

from ..output import markdown_table, plain, points, write_page
from ..prisms.dice import SOURCE
from .runs import COUNTED, FITTED, PlateResults

PAGE = "plates.md"


def plates_text(found: PlateResults) -> str:
    """Both studies as Markdown."""
    lines = []
    if found.prisms is not None:
        of = found.prisms
        median, low, high = of.ratio
        lines += [
            f"Budden's fifteen dice ({SOURCE}): restitution and drop height fitted to {FITTED}, "
            f"the square faces of the other ten predicted by drops; {of.splits} random splits.",
            "", markdown_table(("", "points"), (
                ("rms error of the prediction", points(of.rms, 2)),
                ("rms of the plate_error told", points(of.told, 2)))), "",
            f"Told over true error of a split: median {median:.2f}, half of them "
            f"{low:.2f} to {high:.2f}."]
    if found.simulated is not None:
        one = found.simulated
        error = 100.0 * math.sqrt(0.09 / one.plates)
        lines += ["" for _ in lines[:1]] + [
            f"{one.plates} simulated plates, {COUNTED} counts of each of five parts; a share of "
            f"90 % would come out with a standard error of {error:.1f} points.", "",
            markdown_table(("90 % interval of", "holds the truth, %"), (
                ("restitution", points(one.restitution / one.plates, 0)),
                ("drop height", points(one.drop_height / one.plates, 0)))), "",
            f"Error on a part that was not counted: {points(one.true, 2)} points, "
            f"told {points(one.told, 2)}."]
    return "\n".join(lines)


def write_plates(found: PlateResults, folder: Path) -> list[Path]:
    """Write `measured/plates.md` and its numbers into a folder of documents."""
    head = ("# Fitted plates\n\nWritten by `python -m study plates -o docs`; edits here "
            f"are lost. What is fitted, and how: [plates](../plates.md). Seed {found.seed}.\n\n")
    return write_page(folder, PAGE, f"{head}{plates_text(found)}\n", {}, {"plates": plain(found)})
