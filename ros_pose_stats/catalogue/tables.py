"""The tables of a catalogue: a row a part and a row a pose, as CSV and as Parquet."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from .. import files, text
from ..batch.folder import needing_room
from .rows import Row

COLUMNS: dict[str, type] = {
    "file": str, "part_digest": str, "triangles": int, "size_x_m": float, "size_y_m": float,
    "size_z_m": float, "stable_poses": int, "distinct_poses": int, "method": str, "drops": int,
    "expected_error": float, "largest_error": float, "best_pose": int, "best_share": float,
    "best_share_low": float, "best_share_high": float, "entropy_bits": float, "passes": float,
    "passes_low": float, "passes_high": float, "footprint_length_m": float,
    "footprint_width_m": float, "top_m": float, "warnings": str, "refusal": str,
}
"""Of `catalogue.csv`, with the kind of their values. Shares and errors are fractions."""

POSE_COLUMNS: dict[str, type] = {
    "file": str, "part_digest": str, "pose": int, "group": int, "group_size": int,
    "group_share": float, "group_share_low": float, "group_share_high": float,
    "probability": float, "probability_low": float, "probability_high": float,
    "standard_error": float, "count": int, "footprint_length_m": float,
    "footprint_width_m": float, "top_m": float, "height_m": float, "margin_rad": float,
    "barrier_m": float, "rolls": bool,
}
"""Of `poses.csv`."""

PARTS, POSES = "catalogue", "poses"
TABLES = tuple(f"{name}.{kind}" for name in (PARTS, POSES) for kind in ("csv", "parquet"))
BETWEEN = " | "  # between the warnings of a part
AT_ONCE = 20_000  # rows of a Parquet table in memory
Table = tuple[dict[str, type], Iterator[Sequence[Any]]]


def load_parquet() -> None:
    """Import what Parquet files need."""
    import pyarrow.parquet  # noqa: F401


def write_tables(folder: Path, rows: Callable[[], Iterable[Row]], parquet: bool) -> list[Path]:
    """Write all tables, each whole or not at all; Parquet of an earlier run goes.

    `rows`: gives all rows from the first one, each time anew.
    """
    def write(aside: Path) -> None:
        for name, (columns, values) in _tables(rows).items():
            # Names of files need not be UTF-8.
            with (aside / f"{name}.csv").open("w", encoding="utf-8", errors="surrogateescape",
                                              newline="") as stream:
                stream.writelines(text.csv_lines(columns, values))
        if parquet:
            for name, (columns, values) in _tables(rows).items():
                _write_parquet(aside / f"{name}.parquet", columns, values)

    with needing_room("the tables", folder):
        written = files.write_whole(folder, write)
        for name in set(TABLES) - {file.name for file in written}:
            (folder / name).unlink(missing_ok=True)
    return written


def _tables(rows: Callable[[], Iterable[Row]]) -> dict[str, Table]:
    parts = ({**row, "warnings": BETWEEN.join(row.get("warnings", ()))} for row in rows())
    poses = ({**row, **pose} for row in rows() for pose in row.get("poses", ()))
    return {PARTS: (COLUMNS, ([row.get(name) for name in COLUMNS] for row in parts)),
            POSES: (POSE_COLUMNS, ([row.get(name) for name in POSE_COLUMNS] for row in poses))}


def _write_parquet(file: Path, columns: dict[str, type], rows: Iterator[Sequence[Any]]) -> None:
    import pyarrow
    from pyarrow import parquet

    kinds = {str: pyarrow.string(), int: pyarrow.int64(), float: pyarrow.float64(),
             bool: pyarrow.bool_()}
    schema = pyarrow.schema([(name, kinds[kind]) for name, kind in columns.items()])
    with parquet.ParquetWriter(file, schema) as writer:
        while some := list(islice(rows, AT_ONCE)):
            columns_of = [[_encodable(value) for value in column]
                          for column in zip(*some, strict=True)]
            writer.write_table(pyarrow.table(dict(zip(columns, columns_of, strict=True)), schema))


def _encodable(value: Any) -> Any:
    """A name that is not UTF-8 with what is none of it replaced; other values as they are."""
    return value.encode(errors="replace").decode() if isinstance(value, str) else value
