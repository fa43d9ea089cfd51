"""STEP and 3MF files, read in a process of their own; STEP by OpenCASCADE (cascadio)."""

import importlib.util
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from ..errors import MeshFileError
from ..records import Array, Index

Placed = tuple[Array, Index, Array]
"""Vertices (V, 3) and triangles (T, 3) of an object, and the matrix (4, 4) that places it."""

STEP_SUFFIXES = (".step", ".stp")

_MOST_SECONDS = 120.0
"""A part of ten thousand faces takes some seconds; what takes longer is a whole machine."""

_PROGRAM = Path(__file__).with_name("reading_process.py")

_SI_PREFIXES = {b"$": 1.0, b".KILO.": 1e3, b".HECTO.": 1e2, b".DECA.": 1e1, b".DECI.": 1e-1,
                b".CENTI.": 1e-2, b".MILLI.": 1e-3, b".MICRO.": 1e-6, b".NANO.": 1e-9}
_UNITS = re.compile(rb"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^)]*)\)")
_SI_LENGTH = re.compile(rb"SI_UNIT\s*\(\s*([^,\s]+)\s*,\s*\.METRE\.")
_CONVERSION = re.compile(rb"CONVERSION_BASED_UNIT\s*\(\s*'[^']*'\s*,\s*#(\d+)")
_MEASURE = re.compile(rb"LENGTH_MEASURE\s*\(\s*([-+.\dEe]+)\s*\)\s*,\s*#(\d+)")


def tessellate_step(path: Path, data: bytes, most_seconds: float = _MOST_SECONDS) -> bytes:
    """GLB file in metres of a STEP file, every circle with 96 sides."""
    found = importlib.util.find_spec("cascadio")
    if found is None or found.origin is None:
        raise MeshFileError("the package cascadio, which reads STEP files", f"{path} without it",
                            "pip install cascadio, or export the part as STL or 3MF")
    return _read_apart(path, data, "STEP", most_seconds, str(Path(found.origin).parents[1]))


def unpack_3mf(path: Path, data: bytes) -> tuple[str, list[Placed]]:
    """Unit of a 3MF file, and its objects, each as often as it is built."""
    line, _, arrays = _read_apart(path, data, "3MF", _MOST_SECONDS, "").partition(b"\n")
    head = json.loads(line)
    if "unreadable" in head:
        raise MeshFileError("a readable 3MF file", f"{path} ({head['unreadable']})",
                            "the file is damaged or of another format: export it again")
    if "refused" in head:
        expected, came, remedy = head["refused"]
        raise MeshFileError(f"a 3MF file with {expected}", f"{path} ({came})", remedy)
    objects, offset = [], 0
    for coordinates, corners in head["sizes"]:
        split, end = offset + 8 * coordinates, offset + 8 * (coordinates + corners)
        objects.append((np.frombuffer(arrays[offset:split], np.float64).reshape(-1, 3),
                        np.frombuffer(arrays[split:end], np.int64).reshape(-1, 3)))
        offset = end
    return head["unit"], [(*objects[number], np.reshape([*matrix, 0.0, 0.0, 0.0, 1.0], (4, 4)))
                          for number, matrix in head["placed"]]


def _read_apart(path: Path, data: bytes, kind: str, most_seconds: float, folder: str) -> bytes:
    # Neither the folder where this runs nor the user's Python settings can change what is loaded.
    command = [sys.executable, "-I", "-S", str(_PROGRAM), str(os.getpid()), folder]
    try:
        ran = subprocess.run(command, input=data, capture_output=True, timeout=most_seconds,
                             check=False)
    except subprocess.TimeoutExpired as error:
        raise MeshFileError(f"a {kind} file that is read within {most_seconds:g} s",
                            f"{path} of {len(data) / 1e6:.3g} MB, which takes longer",
                            "export single parts, or export as STL") from error
    if ran.returncode != 0 or not ran.stdout:
        raise MeshFileError(f"a readable {kind} file", f"{path} of {len(data)} bytes",
                            "the file is cut off, damaged or of another format: export it again")
    return ran.stdout


def declared_step_unit(data: bytes) -> float:
    """Metres a unit of a STEP file's first shape; a millimetre where it names none."""
    context = _UNITS.search(data)
    for number in re.findall(rb"#(\d+)", context[1]) if context else ():
        length = _length_unit(data, number)
        if length is not None:
            return length
    return 1e-3


def _length_unit(data: bytes, number: bytes) -> float | None:
    """Metres of a unit by the number of its entity; None for a unit of anything else."""
    length = 1.0
    for _ in range(4):  # an inch is so many millimetres, a foot perhaps so many inches
        entity = _entity(data, number)
        if metric := _SI_LENGTH.search(entity):
            return length * _SI_PREFIXES.get(metric[1].upper(), 1e-3)
        conversion = _CONVERSION.search(entity)
        measure = _MEASURE.search(_entity(data, conversion[1])) if conversion else None
        if measure is None:
            return None
        try:
            length *= float(measure[1])
        except ValueError:
            return None
        number = measure[2]
    return None


def _entity(data: bytes, number: bytes) -> bytes:
    """What stands behind `#number =`."""
    found = re.search(rb"#" + number + rb"\s*=([^;]*);", data)
    return found[1] if found else b""
