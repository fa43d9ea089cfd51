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

"""The page of a catalogue: parts to sort and filter, without a network or a server.

A page of some hundred parts holds all it shows. One of more takes rows from scripts
beside it, for pages that are opened as files may read nothing else, and pictures as
they come into view.
"""

import base64
import json
import math
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, islice
from pathlib import Path
from typing import Any, NamedTuple

from ...base import files, text, version
from ...core.mesh.units import unit_in_words
from ...core.records.notes import ACTS, Note
from ...core.records.scene import describe_scene
from ...core.records.statistics import RARE
from ..batch.folder import needing_room
from ..report.words import begin, in_words, template
from . import rows, store
from .request import CatalogueRequest

PAGE = "index.html"
CHUNKS = "rows"
REPORTS = "reports"
ASSETS = Path(__file__).with_name("assets")
EMBEDDED = 400  # parts up to which the page holds rows and pictures: some 2 MB
ROWS_A_CHUNK = 2000
LONGEST_STEM = 200  # bytes of a part's name in that of its report
GROUPS = 8  # of poses of a part that the page lists
MOST_NAMED = 6  # parts that a concern names
RowAndPicture = tuple[rows.Row, str]  # the second is the file of the picture


class PageState(NamedTuple):
    """Numbers of parts with a row, of all, and of those still to be dropped."""

    parts: int
    bound: int
    to_be_dropped: int
    tally: store.Tally
    common_folder: Path  # that all parts lie below, absolute

    def short_name(self, name: str) -> str:
        """A file as the page names it, from the common folder."""
        return str(Path(name).absolute().relative_to(self.common_folder))

    def in_short(self, sentence: str, name: str) -> str:
        """A sentence about a file, and maybe others of its name, with short names."""
        long_stem = Path(name).with_suffix("")
        short_stem = Path(self.short_name(name)).with_suffix("")
        return sentence.replace(str(long_stem), str(short_stem))


class Concern(NamedTuple):
    """What a person must look at before using the numbers of some parts."""

    heading: str
    meaning: str
    kind: str  # of the filter that shows its parts; empty for none
    parts: int  # that it is about
    examples: list[str]  # the first of them, maybe with what is wrong


def common_folder(names: Iterable[str]) -> Path:
    """The innermost folder that all files lie below, absolute."""
    folders = {Path(name).absolute().parent for name in names}
    return Path(os.path.commonpath(folders))


def write_page(
    folder: Path,
    request: CatalogueRequest,
    state: PageState,
    rows: Iterator[RowAndPicture],
) -> None:
    """Write the page, and what it reads, in the rows' order."""
    embedded = state.parts <= EMBEDDED
    page_rows = (
        _page_row(folder, state, row, picture, embedded) for row, picture in rows
    )
    with needing_room("the page", folder):
        embedded_rows = list(page_rows) if embedded else []
        chunks: list[str] = []
        while chunk := list(islice(page_rows, ROWS_A_CHUNK)):
            chunks.append(f"{CHUNKS}/{len(chunks):05d}.js")
            files.write_file(
                folder / chunks[-1], f"addRows({_script_json(chunk)});\n".encode()
            )
        chunk_files = {
            file for file in (folder / CHUNKS).glob("*.js") if file.stem.isdecimal()
        }
        for old in chunk_files - {folder / name for name in chunks}:
            old.unlink()
        files.write_file(
            folder / PAGE,
            template("catalogue.html", ASSETS, unbroken=_unbroken)
            .render(
                state=state,
                tally=state.tally,
                concerns=list(_concerns(state)),
                notes=[
                    (in_words(Note(code, "", False)), count)
                    for code, count in sorted(state.tally.notes.items())
                ],
                one_way=f"{100.0 * store.ONE_WAY:g}",
                request=request,
                version=version.VERSION,
                rows=_script_json(embedded_rows),
                chunks=chunks,
                scene=describe_scene(
                    request.scene.restitution, request.scene.drop_height
                ),
                target=f"{100.0 * request.target_error:.2f}",
                settings=_script_json(_settings(folder, request, state)),
            )
            .encode(errors="replace"),
        )


def _concerns(state: PageState) -> Iterator[Concern]:
    """What to look at first: files, then what spoils most, as docs/warnings.md has it.

    Guessed units are not among them: of a catalogue most are, and a line says so.
    """
    tally = state.tally

    def examples(sentences: dict[str, str]) -> list[str]:
        return [
            f"{state.short_name(name)}: {state.in_short(sentence, name)}"
            for name, sentence in islice(sentences.items(), MOST_NAMED)
        ]

    if tally.refused:
        yield Concern(
            "Refused",
            "These have no numbers.",
            "refused",
            len(tally.refused),
            examples(tally.refused),
        )
    if tally.unlike:
        yield Concern(
            "Files of one name differ in length",
            "The unit of one is wrong.",
            "",
            len(tally.unlike),
            examples(tally.unlike),
        )
    for code in sorted(tally.warnings, key=[*ACTS, *tally.warnings].index):
        names = tally.warnings[code]
        heading, _, meaning = in_words(Note(code, "", True))
        yield Concern(
            heading,
            meaning,
            code,
            len(names),
            [state.short_name(name) for name in names[:MOST_NAMED]],
        )


def _settings(
    folder: Path, request: CatalogueRequest, state: PageState
) -> dict[str, Any]:
    """What the script writes the command of a report and warnings with."""
    values = request.as_dict()
    defaults = CatalogueRequest().as_dict()
    names = (
        "density",
        "drop_height",
        "restitution",
        "cluster_tolerance",
        "round_sides",
    )
    options = [
        word
        for name in names
        if name == "restitution" or values[name] != defaults[name]
        for word in (f"--{name.replace('_', '-')}", str(values[name]))
    ]
    return {
        "parts": str(state.common_folder).rstrip("/"),
        "folder": str(folder.absolute()),
        "options": options,
        "unit": [] if request.unit is None else ["--unit", request.unit],
        "headings": {
            code: in_words(Note(code, "", True))[0]
            for code in (*state.tally.warnings, *state.tally.notes)
        },
    }


def _page_row(
    folder: Path, state: PageState, row: rows.Row, picture: str, embedded: bool
) -> list[Any]:
    """A row in the order in which the script takes it apart; lengths in millimetres."""
    name = state.short_name(row["file"])
    if row["refusal"]:
        return [name, state.in_short(row["refusal"], row["file"])]
    # Links must be UTF-8, and names have 255 bytes at most.
    stem = (
        Path(row["file"])
        .stem.encode(errors="ignore")[:LONGEST_STEM]
        .decode(errors="ignore")
    )
    report = f"{REPORTS}/{stem}_{row['part_digest'][:8]}.html"
    if embedded and picture:
        data = base64.b64encode(files.read_file(folder / picture)).decode()
        picture = f"data:image/png;base64,{data}"
    return [
        name,
        "",
        picture,
        report,
        int((folder / report).exists()),
        int(row["unit_declared"]),
        unit_in_words(row["unit_m"]) if row["unit_guessed"] else "",
        row["triangles"],
        [_millimetres(row[f"size_{axis}_m"]) for axis in "xyz"],
        row["stable_poses"],
        row["distinct_poses"],
        row["method"],
        row["drops"],
        *(_short(row[name]) for name in NUMBERS),
        *(_millimetres(row[name]) for name in SIZES),
        [[warning.code, begin(warning.text)] for warning in store.doubts_of(row)],
        [
            [note.code, begin(note.text)]
            for note in store.notes_of(row)
            if not note.acts
        ],
        _groups(row["poses"]),
    ]


NUMBERS = (
    "expected_error",
    "largest_error",
    "best_share",
    "best_share_low",
    "best_share_high",
    "entropy_bits",
    "passes",
    "passes_low",
    "passes_high",
)
SHARES = ("group_share", "group_share_low", "group_share_high")
SIZES = ("footprint_length_m", "footprint_width_m", "top_m")


def _groups(poses: Sequence[rows.Row]) -> list[list[Any]]:
    """The most probable poses, those that symmetry makes alike as one; no rare ones."""
    common = (
        pose
        for pose in poses
        if pose["group_share"] is None or pose["group_share"] >= RARE
    )
    alike = (
        list(group) for _, group in groupby(common, key=lambda pose: pose["group"])
    )
    return [
        [
            text.ranges([pose["pose"] for pose in group]),
            *(_short(group[0][name]) for name in SHARES),
            *(_millimetres(group[0][name]) for name in SIZES),
            _short(min(_margins(group), default=None)),
            int(group[0]["rolls"]),
        ]
        for group in islice(alike, GROUPS)
    ]


def _margins(poses: Sequence[rows.Row]) -> list[float]:
    """In degrees, as far as they are known."""
    margins = [pose["margin_rad"] for pose in poses]
    return [math.degrees(margin) for margin in margins if margin is not None]


def _millimetres(metres: float) -> float | None:
    return _short(1e3 * metres)


def _short(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.4g}")


def _unbroken(words: str) -> str:
    """Words that keep to the number behind them."""
    return re.sub(r" (?=\d)", "\N{NO-BREAK SPACE}", words)


def _script_json(values: Any) -> str:
    """JSON that may stand in a script of a page."""
    return json.dumps(values, separators=(",", ":"), allow_nan=False).replace(
        "<", "\\u003c"
    )
