"""Figures as files."""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.image import imsave
from numpy.typing import NDArray

SALT = "ros_pose_stats"
RASTER = 150
"""Dots per inch of what is no vector graphics within one."""


def save_figure(figure: Figure, stem: Path) -> list[Path]:
    """Write `stem.png` and `stem.svg`; an equal figure gives equal bytes.

    Parameters
    ----------
    figure : Figure
    stem : Path
        Without suffix, whatever dots it holds; its folder is created.
    """
    stem.parent.mkdir(parents=True, exist_ok=True)
    files = [stem.with_name(f"{stem.name}.{kind}") for kind in ("png", "svg")]
    with matplotlib.rc_context({"svg.hashsalt": SALT, "svg.fonttype": "none"}):
        figure.savefig(files[0], dpi=160)
        figure.savefig(files[1], metadata={"Date": None})
    return files


def svg_bytes(figure: Figure) -> bytes:
    """A figure as an SVG file that looks alike everywhere: letters are outlines.

    An equal figure gives equal bytes. It has no background of its own, so that the page can
    show where there is more of it to the side.
    """
    file = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": SALT, "svg.fonttype": "path"}):
        figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None}, dpi=RASTER,
                       transparent=True)
    return file.getvalue()


def figure_png_bytes(figure: Figure, dpi: int = RASTER) -> bytes:
    """A figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=dpi)
    return file.getvalue()


def png_bytes(picture: NDArray[np.uint8]) -> bytes:
    """A picture (height, width, 3) as a PNG file."""
    file = io.BytesIO()
    imsave(file, picture, format="png")
    return file.getvalue()
