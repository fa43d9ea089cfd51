"""Which bags lie under the paths that a user names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ...errors import BagError
from ..reader.raw_reader import files_of_bag

SQLITE: Final = ".db3"
PACKED_SQLITE: Final = ".db3.zstd"
ENDINGS: Final = (".mcap", ".mcap.zstd", SQLITE)
CONVERT: Final = "`ros2 bag convert` makes a plain MCAP bag of it"


@dataclass(frozen=True)
class Bag:
    """One recording.

    Attributes
    ----------
    path : Path
        Its directory, or the file itself where a file was named.
    files : tuple of Path
        In the order of recording.
    """

    path: Path
    files: tuple[Path, ...]


def find_bags(paths: Iterable[Path]) -> tuple[Bag, ...]:
    """All bags under the paths, each file once.

    Parameters
    ----------
    paths : iterable of Path
        Bag directories, directories of many bags, or single files.

    Raises
    ------
    BagError
        If a path does not exist, or there is no bag under it.
    """
    bags: list[Bag] = []
    known: set[Path] = set()
    for path in paths:
        for bag in _bags_under(path):
            files = tuple(file for file in bag.files if file.resolve() not in known)
            known.update(file.resolve() for file in files)
            if files:
                bags.append(Bag(bag.path, files))
    if not bags:
        raise BagError("at least one bag", "none", "name a bag directory or a directory of bags")
    return tuple(bags)


def _bags_under(path: Path) -> list[Bag]:
    if not path.exists():
        raise BagError("a bag directory or file", f"{path}, which does not exist",
                       "check the path")
    if path.is_file():
        _refuse_packed(path)
        return [Bag(path, (path,))]
    try:
        folders = sorted({file.parent for file in path.rglob("*")
                          if _is_bag_file(file.relative_to(path))})
        bags = [Bag(folder, tuple(_files_in(folder))) for folder in folders]
    except OSError as error:
        raise BagError("a readable directory", f"{path}: {error.strerror or error}",
                       "check its permissions") from error
    if not any(bag.files for bag in bags):
        raise BagError("a directory with *.mcap files", f"none under {path}",
                       "name a bag directory or a directory of bags")
    return bags


def _is_bag_file(below: Path) -> bool:
    # A hidden directory is a run on its way in or out.
    hidden = any(part.startswith(".") for part in below.parts)
    return not hidden and below.name.endswith((*ENDINGS, PACKED_SQLITE))


def _files_in(folder: Path) -> list[Path]:
    for file in folder.glob(f"*{PACKED_SQLITE}"):
        _refuse_packed(file)
    files = [*files_of_bag(folder), *sorted(folder.glob(f"*{SQLITE}"))]
    return [file for file in files if file.is_file()]


def _refuse_packed(file: Path) -> None:
    if file.name.endswith(PACKED_SQLITE):
        raise BagError("an MCAP bag, or SQLite that is not compressed", f"{file}", CONVERT)
