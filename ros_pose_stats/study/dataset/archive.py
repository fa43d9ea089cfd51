"""The file of a dataset: a numpy archive that says itself what stands in it."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from ...errors import DatasetError
from ...recording.durable import replace_file
from ...version import VERSION
from .fields import FIELDS, Arrays, check_arrays
from .spec import DatasetSpec

FORMAT: Final = "ros_pose_stats.dataset"
FORMAT_VERSION: Final = 1


def write_archive(file: Path, spec: DatasetSpec, chunks: Sequence[Arrays]) -> None:
    """Write pieces in the order of their bodies; equal pieces give equal bytes.

    The file appears whole or not at all.

    Raises
    ------
    DatasetError
        If it cannot be written.
    """
    schema = {
        "format": FORMAT, "format_version": FORMAT_VERSION,
        "written_by": f"ros_pose_stats {VERSION}", "spec": spec.as_dict(),
        "block_ends": spec.block_ends,
        "fields": {name: {"shape": list(field.shape), "meaning": field.meaning}
                   for name, field in FIELDS.items()},
    }
    arrays = {name: np.concatenate([chunk[name] for chunk in chunks]) for name in FIELDS}
    whole: dict[str, Any] = {"schema": np.array(json.dumps(schema, indent=1)), **arrays}
    stream = io.BytesIO()
    np.savez_compressed(stream, **whole)
    write_whole(file, stream.getvalue())


def write_whole(path: Path, content: bytes) -> None:
    """Write a file that appears whole or not at all.

    Raises
    ------
    DatasetError
        If it cannot be written.
    """
    try:
        replace_file(path, content)
    except OSError as error:
        raise DatasetError("a disk that takes the dataset", f"{path} ({reason(error)})",
                           "make room; the same command then goes on from here") from error


def read_archive(file: Path) -> tuple[DatasetSpec, Arrays]:
    """Specification and arrays of a file.

    Raises
    ------
    DatasetError
        If it cannot be read, is of another kind, or contradicts itself.
    """
    try:
        with np.load(file, allow_pickle=False) as archive:
            schema = json.loads(str(archive["schema"]))
            told = f"{schema['format']} of version {schema['format_version']}"
            if told == f"{FORMAT} of version {FORMAT_VERSION}":
                spec = DatasetSpec.from_dict(schema["spec"])
                arrays = {name: archive[name] for name in FIELDS}
                check_arrays(arrays, spec, spec.bodies)
                return spec, arrays
    except OSError as error:
        raise DatasetError("a readable file", f"{file} ({reason(error)})",
                           "check the path") from error
    except Exception as error:  # numpy and zip raise a dozen kinds on damaged files
        raise DatasetError("a dataset as `ros_pose_stats dataset` writes it",
                           f"{file} ({reason(error)})", "make it anew") from error
    raise DatasetError(f"a {FORMAT} of version {FORMAT_VERSION}", f"{told} in {file}",
                       "make it anew with `ros_pose_stats dataset`")


def reason(error: BaseException) -> str:
    """An error in one line, never empty."""
    text = (isinstance(error, OSError) and error.strerror) or str(error) or type(error).__name__
    return " ".join(text.split())
