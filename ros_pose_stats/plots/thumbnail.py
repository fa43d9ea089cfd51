"""A small picture of a part in one of its poses, for tables of many parts."""

from __future__ import annotations

import io

from PIL import Image

from ..records import Part, StablePose
from .poses import pose_pictures

PIXELS = 176
"""Pixels across: twice those that a table shows, for fine screens."""

COLORS = 24
"""More make the file larger than the eye sees at this size."""


def pose_thumbnail(part: Part, pose: StablePose, radius: float) -> bytes:
    """Picture of a part in a pose, as a PNG file of some two kilobytes.

    `radius`: of the part, metres.
    """
    (picture,) = pose_pictures(part, [pose], radius, PIXELS)
    flat = Image.fromarray(picture).quantize(COLORS, dither=Image.Dither.NONE)
    file = io.BytesIO()
    flat.save(file, format="PNG", optimize=True)
    return file.getvalue()
