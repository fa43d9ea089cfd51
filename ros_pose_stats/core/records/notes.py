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

"""What a person should know of an answer, with a code for programs."""

from collections.abc import Iterable
from typing import Any, NamedTuple

ACTS = {
    "UNIT_SUSPECT": True,
    "UNIT_GUESSED": True,
    "UNIT_OVERRIDDEN": True,
    "HOLES_CLOSED": False,
    "OPEN_MESH": True,
    "BODIES_OVERLAP": True,
    "BODIES_APART": False,
    "BODIES_LOOSE": False,
    "INERTIA_SUSPECT": True,
    "COM_SHIFTED": False,
    "CLUSTERED": False,
    "MARGINAL_POSE": True,
    "SHALLOW_POSE": False,
    "NEAR_TIE": False,
    "ROUNDED": False,
    "COARSE_CURVE": True,
    "OUTSIDE_FIT": True,
    "METHODS_DISAGREE": True,
    "CONFLICT": True,
    "MODEL_GAP": False,
    "LOW_DROP": True,
    "RELEASED_TOUCHING": True,
    "HEIGHT_SUSPECT": True,
    "TARGET_MISSED": True,
    "UNSETTLED": True,
    "TIME_LIMIT": True,
    "WANTED_ALIKE": True,
    "ALIKE_FROM_ABOVE": True,
    "FORGOTTEN": True,
    "NOT_RECORDED": False,
}
"""All codes, and whether somebody should act before relying on the answer."""


class Note(NamedTuple):
    """Something that a person should know of a part or of an answer.

    Attributes
    ----------
    code : str
        For programs; docs/warnings.md lists them.
    text : str
        A sentence.
    acts : bool
        Whether somebody should do something before relying on the answer.
    """

    code: str
    text: str
    acts: bool

    def __str__(self) -> str:
        """The line of logs and tables."""
        return f"{self.code}: {self.text}"


def note(code: str, text: str) -> Note:
    """A note with one of the codes of `ACTS`."""
    return Note(code, text, ACTS[code])


def note_of_sentence(sentence: str) -> Note:
    """The note that version 0.2.0 wrote as `CODE: sentence`."""
    code, _, text = sentence.partition(": ")
    return Note(code, text, ACTS.get(code, True))


def notes_of(message: Any) -> tuple[Note, ...]:
    """The warnings of a message."""
    return tuple(
        Note(warning.code, warning.text, warning.acts)
        for warning in getattr(message, "warnings", ())
    )


def has_note(answer: Any, code: str) -> bool:
    """Whether one of the warnings of a record or a message has a code."""
    return any(warning.code == code for warning in getattr(answer, "warnings", ()))


def note_lines(warnings: Iterable[Note]) -> list[str]:
    """Lines of a table, each once: first those to act on."""
    unique = dict.fromkeys(warnings)
    return [
        *(str(warning) for warning in unique if warning.acts),
        *(f"note {warning}" for warning in unique if not warning.acts),
    ]


def note_paragraph(warnings: Iterable[Note]) -> list[str]:
    """The same below an empty line; nothing where there are none."""
    lines = note_lines(warnings)
    return ["", *lines] if lines else []
