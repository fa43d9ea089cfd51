# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""What figures share: colours, axes, labels that do not overlap, files."""

import base64
import io
import shutil
import subprocess
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import Any, Literal

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imsave
from numpy.typing import NDArray
from PIL import Image

from ...base.errors import RequestError
from ...core.records import Array

INK = "#222222"
REFERENCE = "#767676"
"""Colours of text and outlines, and of the background: grids, notes, lines to compare
with."""

BLUE = "#0072B2"


def new_figure(width: float, height: float, **options: Any) -> Figure:
    """A figure of so many inches, drawn by Agg whatever backend the user has chosen."""
    figure = Figure(figsize=(width, height), **options)
    FigureCanvasAgg(figure)
    return figure


def open_axes(
    axes: Axes, grid: str, width: float, axis: Literal["both", "x", "y"] = "both"
) -> None:
    """Grid lines behind the data; no frame above and to the right."""
    axes.grid(which="major", axis=axis, color=grid, linewidth=width)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def separate(heights: Array, gap: float, low: float, high: float = np.inf) -> Array:
    """Move heights (k,) as little as it takes to lie `gap` apart in order.

    Where there is no room between `low` and `high`, `high` gives way.
    """
    order = np.argsort(heights, kind="stable")
    steps = gap * np.arange(len(heights))
    rising = _nearest_rising(heights[order] - steps)
    highest = high - gap * (len(heights) - 1)
    positions = np.empty_like(heights)
    positions[order] = np.maximum(np.minimum(rising, highest), low) + steps
    return positions


def _nearest_rising(values: Array) -> Array:
    """Nearest sequence that never falls: what falls is pooled into its mean."""
    pools: list[tuple[float, int]] = []
    for mean in values:
        size = 1
        while pools and pools[-1][0] > mean:
            pool_mean, count = pools.pop()
            mean = (pool_mean * count + mean * size) / (count + size)
            size = count + size
        pools.append((mean, size))
    return np.array([mean for mean, size in pools for _ in range(size)])


def in_digits(value: float, digits: int) -> str:
    """A length with so many digits, never with an exponent where it is large."""
    return f"{value:.{digits}g}" if value < 10.0**digits else f"{value:.0f}"


Picture = NDArray[np.uint8]

RASTER = 150  # dots per inch of images within vector graphics


def figure_png(figure: Figure) -> bytes:
    """A figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=RASTER)
    return file.getvalue()


def png_bytes(picture: Picture) -> bytes:
    """A picture (height, width, 3) as a PNG file."""
    file = io.BytesIO()
    imsave(file, picture, format="png")
    return file.getvalue()


COLORS = 36  # number of colours of a GIF, besides those kept

KEPT = ((255, 255, 255), (213, 94, 0), (0, 114, 178), (34, 34, 34))
"""Colours of paper, markers and lines, which an average of pixels would turn grey."""

NEAR = 8  # levels within which a colour is replaced by one of those kept


def address(kind: str, picture: bytes) -> str:
    """A picture as an address that contains its data."""
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"


def svg_address(figure: Figure) -> str:
    """A figure as an address, letters as outlines; equal figures, equal texts."""
    file = io.BytesIO()
    with matplotlib.rc_context(
        {"svg.hashsalt": "ros_pose_stats", "svg.fonttype": "path"}
    ):
        figure.savefig(
            file,
            format="svg",
            metadata={"Date": None, "Creator": None},
            dpi=RASTER,
            transparent=True,
        )
    return address("svg+xml", file.getvalue())


def write_gif(file: Path, pictures: Iterable[Picture], rate: int) -> None:
    """Write an animation that repeats for ever, at so many pictures a second."""
    images = [Image.fromarray(picture) for picture in pictures]
    # One palette for all pictures, since colours would flicker otherwise.
    samples = np.concatenate(
        [np.asarray(images[k]) for k in np.linspace(0, len(images) - 1, 5).astype(int)]
    )
    palette = Image.fromarray(samples).quantize(COLORS, method=Image.Quantize.MEDIANCUT)
    colors = np.array((palette.getpalette() or [])[: 3 * COLORS]).reshape(-1, 3)
    # Pillow's choice of the nearest colour is rough: paper would turn grey.
    for color in KEPT:
        colors[np.abs(colors - color).max(axis=1) <= NEAR] = color
    palette.putpalette(
        [*colors.ravel().tolist(), *(level for color in KEPT for level in color)]
    )
    frames = [
        image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images
    ]
    frames[0].save(
        file,
        format="GIF",
        save_all=True,
        append_images=frames[1:],
        duration=round(1000.0 / rate),
        loop=0,
        optimize=True,
        disposal=1,
    )


def ffmpeg() -> str:
    """Path of ffmpeg."""
    path = shutil.which("ffmpeg")
    if path is None:
        raise RequestError(
            "ffmpeg for an .mp4",
            "none on the PATH",
            "install it (apt install ffmpeg), or write a .gif",
        )
    return path


def write_mp4(file: Path, pictures: Iterable[Picture], rate: int) -> None:
    """Write a film with ffmpeg of one picture or more, of even height and width."""
    frames = iter(pictures)
    first = next(frames)
    size = f"{first.shape[1]}x{first.shape[0]}"
    options = (
        f"-loglevel error -y -f rawvideo -pix_fmt rgb24 -s {size} -r {rate} -i - "
        "-an -c:v libx264 -pix_fmt yuv420p -movflags +faststart"
    )
    command = [ffmpeg(), *options.split(), str(file)]
    data = b"".join(picture.tobytes() for picture in chain([first], frames))
    encoding = subprocess.run(command, input=data, capture_output=True, check=False)
    if encoding.returncode != 0:
        raise RequestError(
            "a film from ffmpeg",
            encoding.stderr.decode(errors="replace")[-300:],
            "write a .gif instead",
        )
