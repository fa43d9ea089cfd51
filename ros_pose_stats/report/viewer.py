"""The part as numbers for the page's own 3-D view."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..mesh.decimation import visible_triangles
from ..records import Part, StablePose

Array = NDArray[np.float64]

ASSETS = Path(__file__).parent / "assets"

SCRIPTS = ("part_mesh", "view_direction", "view_webgl", "view_canvas", "viewer")
"""Each file uses functions of those before it."""


def viewer_data(part: Part, poses: Sequence[StablePose], radius: float) -> str:
    """Mesh and poses as JSON, lengths in radii.

    `poses`: of that part, in the order of the buttons. Returns `vertices`: base64 of little-endian
    float32, three a vertex, about the centre of mass; `triangles`: base64 of little-endian uint16
    or uint32 (`wide`); `poses`: label, quaternion x y z w and height.
    """
    corners = (visible_triangles(part) - part.center_of_mass).reshape(-1, 3)
    # Integers of 16 bits would do for the places, but not for the normals of thin triangles, which
    # a fine circle in a flat face has many of.
    places = (corners / radius).astype("<f4") + np.float32(0.0)  # no negative zeros
    vertices, triangles = np.unique(places, axis=0, return_inverse=True)
    wide = len(vertices) > 65_535
    numbers = triangles.reshape(-1).astype("<u4" if wide else "<u2")
    return json.dumps({
        "vertices": base64.b64encode(np.ascontiguousarray(vertices).tobytes()).decode(),
        "triangles": base64.b64encode(numbers.tobytes()).decode(),
        "wide": wide,
        "poses": [{"index": pose.index, "label": f"{pose.index}",
                   "turn": [round(float(x), 9) for x in pose.orientation],
                   "height": round(pose.height / radius, 9)} for pose in poses],
    }, separators=(",", ":"))


def viewer_script() -> str:
    """The script of the view, as one function that leaves no name behind."""
    parts = "".join((ASSETS / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS)
    return f'"use strict";\n(function () {{\n{parts}}}());'
