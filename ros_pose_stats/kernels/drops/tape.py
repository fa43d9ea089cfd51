"""A record of one drop: the state after every event."""

from __future__ import annotations

from ..array_types import Array
from ..compilation import inlined
from .layout import (
    MODE,
    STATE,
    TAPE_CONTACT,
    TAPE_EVENT,
    TAPE_MODE,
    TAPE_STATE,
    TAPE_TIME,
    TAPE_VERTEX,
    TIME,
    Work,
)


@inlined
def note(work: Work, tape: Array, event: int, vertex: int) -> None:
    """Add a row; on a tape without rows or at its end nothing is kept.

    Row 0 holds the number of rows wanted so far, so that the caller can come back with a
    longer tape. The contact mode is that before the event; `note_contact` puts it right.
    """
    if tape.shape[0] == 0:
        return
    tape[0, 0] += 1.0
    row = int(tape[0, 0])
    if row >= tape.shape[0]:
        return
    tape[row, TAPE_TIME] = work.clock[TIME]
    for i in range(STATE):
        tape[row, TAPE_STATE + i] = work.state[i]
    tape[row, TAPE_EVENT] = event
    tape[row, TAPE_VERTEX] = vertex
    note_contact(work, tape)


@inlined
def note_contact(work: Work, tape: Array) -> None:
    """Correct the contact mode of the last row."""
    if tape.shape[0] == 0:
        return
    row = int(tape[0, 0])
    if row < tape.shape[0]:
        mode = work.tally[MODE]
        tape[row, TAPE_MODE] = mode
        tape[row, TAPE_CONTACT] = work.active[0] if mode > 0 else -1
        tape[row, TAPE_CONTACT + 1] = work.active[1] if mode > 1 else -1
