"""The page of a catalogue: parts to sort and filter, without a network or a server.

A page of some hundred parts holds all it shows. One of more takes rows from scripts beside it, for
pages that are opened as files may read nothing else, and pictures as they come into view.
"""

import base64
import json
import math
import re
from collections.abc import Iterator, Sequence
from itertools import groupby, islice
from pathlib import Path
from typing import Any, NamedTuple

from .. import errors, files, version
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES, describe_scene
from ..report.words import template
from ..text import ranges
from . import rows, store
from .request import CatalogueRequest

PAGE = "index.html"
CHUNKS = "rows"
REPORTS = "reports"
ASSETS = Path(__file__).with_name("assets")
EMBEDDED = 400  # parts up to which the page holds rows and pictures itself: about two megabytes
ROWS_A_CHUNK = 2000
GROUPS = 8  # poses of a part that the page lists, those that symmetry makes alike as one
Shown = tuple[rows.Row, str]  # a row and the file of its picture


class PageState(NamedTuple):
    """How many parts have a row, there are, and are still to be dropped; and what rows come to."""

    parts: int
    bound: int
    to_be_dropped: int
    tally: store.Tally


def write_page(folder: Path, request: CatalogueRequest, state: PageState,
               rows: Iterator[Shown]) -> None:
    """Write the page into the folder of the pictures, and what it reads, in the rows' order."""
    embedded = state.parts <= EMBEDDED
    try:
        shown = (_shown(folder, row, picture, embedded) for row, picture in rows)
        own = _script_json(list(shown)) if embedded else "[]"
        chunks = [] if embedded else list(_write_chunks(folder, shown))
        ours = {one for one in (folder / CHUNKS).glob("*.js") if one.stem.isdecimal()}
        for old in ours - {folder / name for name in chunks}:
            old.unlink()
        files.write_file(folder / PAGE, template(
            "catalogue.html", ASSETS, unbroken=_unbroken).render(
            state=state, tally=state.tally, one_way=f"{100.0 * store.ONE_WAY:g}", request=request,
            version=version.VERSION, rows=own, chunks=chunks,
            scene=describe_scene(request.scene.restitution, request.scene.drop_height),
            target=f"{100.0 * request.target_error:.2f}",
            settings=_script_json(_settings(folder, request))).encode())
    except OSError as error:
        raise errors.BatchError("a disk that takes the page", f"{folder} ({errors.reason(error)})",
                                "make room; the same command then goes on from here") from error


def report_name(row: rows.Row) -> str:
    """File of the report on a part below the folder; no link can have what is not UTF-8."""
    stem = Path(row["file"]).stem.encode(errors="ignore").decode()
    return f"{REPORTS}/{stem}_{row['part_digest'][:8]}.html"


def _write_chunks(folder: Path, shown: Iterator[list[Any]]) -> Iterator[str]:
    for number in range(10 ** 9):
        some = list(islice(shown, ROWS_A_CHUNK))
        if not some:
            return
        name = f"{CHUNKS}/{number:05d}.js"
        files.write_file(folder / name, f"addRows({_script_json(some)});\n".encode())
        yield name


def _settings(folder: Path, request: CatalogueRequest) -> dict[str, Any]:
    """What the command of a report is put together from."""
    scene, plain = request.scene, request.as_dict()
    names = [name for name in ("density", "drop_height") if plain[name] is not None]
    names.append("restitution")
    if scene.cluster_tolerance != DEFAULT_CLUSTER_TOLERANCE:
        names.append("cluster_tolerance")
    if scene.round_sides != DEFAULT_ROUND_SIDES:
        names.append("round_sides")
    options = [word for name in names
               for word in (f"--{name.replace('_', '-')}", str(plain[name]))]
    return {"here": str(Path.cwd()), "folder": str(folder.absolute()), "options": options,
            "unit": [] if request.unit is None else ["--unit", request.unit]}


def _shown(folder: Path, row: rows.Row, picture: str, embedded: bool) -> list[Any]:
    """A row in the order in which the script takes it apart; lengths in millimetres."""
    if row["refusal"]:
        return [row["file"], row["refusal"]]
    report = report_name(row)
    if embedded and picture:
        data = base64.b64encode(files.read_file(folder / picture)).decode()
        picture = f"data:image/png;base64,{data}"
    return [
        row["file"], "", picture, report, int((folder / report).exists()),
        int(row["unit_declared"]), row["triangles"],
        [_millimetres(row[f"size_{axis}_m"]) for axis in "xyz"], row["stable_poses"],
        row["distinct_poses"], row["method"], row["drops"], _short(row["expected_error"]),
        _short(row["largest_error"]), *(_short(row[f"best_share{end}"]) for end in BOUNDS),
        _short(row["entropy_bits"]), *(_short(row[f"passes{end}"]) for end in BOUNDS),
        _millimetres(row["footprint_length_m"]), _millimetres(row["footprint_width_m"]),
        _millimetres(row["top_m"]), row["warnings"], _groups(row["poses"]),
    ]


BOUNDS = ("", "_low", "_high")


def _groups(poses: Sequence[rows.Row]) -> list[list[Any]]:
    """The most probable poses, those that symmetry makes alike as one."""
    alike = (list(group) for _, group in groupby(poses, key=lambda pose: pose["group"]))
    return [[ranges([pose["pose"] for pose in group]),
             *(_short(group[0][f"group_share{end}"]) for end in BOUNDS),
             _millimetres(group[0]["footprint_length_m"]),
             _millimetres(group[0]["footprint_width_m"]), _millimetres(group[0]["top_m"]),
             _degrees([pose["margin_rad"] for pose in group]),
             int(group[0]["rolls"])] for group in islice(alike, GROUPS)]


def _degrees(angles: Sequence[float | None]) -> float | None:
    """The smallest angle that is known."""
    known = [math.degrees(angle) for angle in angles if angle is not None]
    return _short(min(known, default=None))


def _millimetres(metres: float) -> float | None:
    return _short(1e3 * metres)


def _short(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.4g}")


def _unbroken(text: str) -> str:
    """Words that keep to the number behind them."""
    return re.sub(r" (?=\d)", "\N{NO-BREAK SPACE}", text)


def _script_json(values: Any) -> str:
    """JSON that may stand in a script of a page."""
    return json.dumps(values, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
