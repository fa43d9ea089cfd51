"""Known parts with their centre of mass somewhere else, as answers to a question alone."""

import numpy as np
from numpy.typing import NDArray

from ...mesh.parts import shift_center
from ...records import Part
from ...text import listed, millimetres
from .known_part import KnownPart, known_as
from .memory import Memory
from .part_store import BUILT_BYTES

Array = NDArray[np.float64]


class ShiftedParts:
    """Shifts centres of mass, and keeps the parts whose poses may be asked for again."""

    def __init__(self) -> None:
        self._parts: Memory[tuple[str, str, bytes], Part] = Memory(
            BUILT_BYTES, lambda part: 2 * part.vertices.nbytes + 3 * part.triangles.nbytes)

    def shift(self, known: KnownPart, offset: Array) -> KnownPart:
        """The part with a shifted centre of mass, of which nothing is latched.

        `offset` (3,): metres, part frame, finite; zeros give the known part itself. Raises
        MassPropertiesError if that leads out of the part's hull.
        """
        if not offset.any():
            return known
        key = known.part_id, known.digest, offset.tobytes()
        part = self._parts.get(key)
        if part is None:
            part = shift_center(known.part, offset)
            self._parts.put(key, part)
        return known_as(part, known)


def shift_warning(offset: Array) -> str:
    """What the answer for a shifted centre of mass says of it."""
    return (f"COM_SHIFTED: the centre of mass is shifted by "
            f"{listed([millimetres(float(x)) for x in offset])} mm along the part's axes, the "
            f"inertia about it is kept; what is latched is of the part as it was sent.")
