"""Parts whose drops contradicted an estimate, kept as files that training reads."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Iterator
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..mesh.parts import part_from_mesh
from ..records import DropScene, Part, PoseStatistics
from ..whole_files import write_whole
from .durable import make_directories, sync_directory

FOLDER: Final = "conflicts"
"""Of the files, in a log directory."""

MOST_FILES, MOST_BYTES = 1000, 256 * 2**20
"""Kept in a folder; the oldest go."""

NUMBERS: Final = ("restitution", "drop_height", "cluster_tolerance", "round_sides", "drops",
                  "unsettled", "seed")


class ConflictCase(NamedTuple):
    """One part in one scene.

    Attributes
    ----------
    part : Part
        As it was dropped, mass properties and all.
    scene : DropScene
    counts : (P,) array of int
        Drops that came to rest in each pose, by `index`.
    unsettled, seed : int
        Of the drops.
    warning : str
        What was told of the contradiction.
    version : str
        Of the package whose estimate was contradicted.
    """

    part: Part
    scene: DropScene
    counts: NDArray[np.int64]
    unsettled: int
    seed: int
    warning: str
    version: str


def conflict_warning(found: PoseStatistics) -> str:
    """The warning `CONFLICT` of a result; empty where it has none."""
    return next((line for line in found.warnings if line.startswith("CONFLICT:")), "")


def keep_conflict(folder: Path, part: Part, found: PoseStatistics) -> Path | None:
    """Keep a part whose drops contradicted an estimate, in a file of its own.

    The file appears whole or not at all, and outlives a power cut. Of a part and scene that are
    there already the larger number of drops stays.

    Parameters
    ----------
    folder : Path
        Made where it does not exist; holds at most `MOST_FILES` and `MOST_BYTES`.
    part : Part
    found : PoseStatistics
        Of drops of this part.

    Returns
    -------
    Path or None
        The file; None without a contradiction.

    Raises
    ------
    OSError
        If it cannot be written; what is there stays as it is.
    """
    if not conflict_warning(found):
        return None
    file = folder / _name(found)
    if _drops_in(file) > found.drops:
        return file
    data = _packed(part, found)
    make_directories(folder)
    write_whole(folder, lambda aside: _write_synced(aside / file.name, data))
    sync_directory(folder)
    _delete_oldest(folder, file)
    return file


def read_conflicts(folder: Path) -> Iterator[ConflictCase]:
    """Read what `keep_conflict` kept, in the order of the files' names.

    Raises
    ------
    OSError, ValueError, KeyError, zipfile.BadZipFile
        If a file there is none of these.
    """
    for file in sorted(folder.glob("*.npz")):
        with np.load(file) as kept:
            held = {name: kept[name] for name in kept.files}
        part = part_from_mesh(held["vertices"], held["triangles"], unit=1.0,
                              center_of_mass=held["center_of_mass"], mass=float(held["mass"]),
                              inertia=held["inertia"], part_id=str(held["part_id"]))
        scene = DropScene(float(held["restitution"]), float(held["drop_height"]),
                          float(held["cluster_tolerance"]), int(held["round_sides"]))
        yield ConflictCase(part, scene, held["counts"], int(held["unsettled"]),
                           int(held["seed"]), str(held["warning"]), str(held["version"]))


def _name(found: PoseStatistics) -> str:
    scene = (found.restitution, found.drop_height, found.cluster_tolerance, found.round_sides)
    of_scene = blake2b(repr(scene).encode(), digest_size=6).hexdigest()
    return f"{found.part_digest[:24]}_{of_scene}.npz"


def _packed(part: Part, found: PoseStatistics) -> bytes:
    counts = [pose.count for pose in sorted(found.poses, key=lambda pose: pose.index)]
    columns: dict[str, Any] = {
        **{name: getattr(found, name) for name in NUMBERS},
        "seed": np.uint64(found.seed), "part_id": part.part_id, "version": found.version,
        "warning": conflict_warning(found), "counts": np.array(counts, dtype=np.int64),
        "vertices": part.vertices, "triangles": part.triangles, "mass": part.mass,
        "center_of_mass": part.center_of_mass, "inertia": part.inertia}
    data = io.BytesIO()
    np.savez_compressed(data, **columns)
    return data.getvalue()


def _write_synced(file: Path, data: bytes) -> None:
    with file.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())


def _drops_in(file: Path) -> int:
    """Drops that a file holds; -1 where there is none that can be read."""
    try:
        with np.load(file) as kept:
            return int(kept["drops"])
    except (OSError, ValueError, KeyError, zipfile.BadZipFile):
        return -1


def _delete_oldest(folder: Path, newest: Path) -> None:
    """Keep within the bounds; another process may do the same at the same time."""
    found = []
    for file in folder.glob("*.npz"):
        with suppress(FileNotFoundError):
            state = file.stat()
            found.append((file != newest, -state.st_mtime_ns, file.name, state.st_size))
    size = 0
    for number, (_, _, name, taken) in enumerate(sorted(found)):
        size += taken
        if number and (number >= MOST_FILES or size > MOST_BYTES):
            (folder / name).unlink(missing_ok=True)
