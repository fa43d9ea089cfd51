"""Surfaces as binary STL files."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh
from trimesh.exchange.stl import export_stl


def stl_bytes(vertices: NDArray[np.float64], triangles: NDArray[np.integer]) -> bytes:
    """Binary STL of a surface: vertices (V, 3) as they are, in float32, and triangles (T, 3)."""
    return bytes(export_stl(Trimesh(vertices, triangles, process=False)))
