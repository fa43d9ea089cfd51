"""Where a serialised message ends.

`rclpy.serialization.serialize_message` estimates the length of what it returns. It puts
padding in front of empty sequences that the message has not got, so that up to a few bytes
for each of them, from somewhere in the memory, follow the message. Some readers refuse that.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from ..writer.definitions import PRIMITIVES, SEQUENCE, SINGLE, Field, fields, split_definition
from ..writer.message_types import MessageType

HEADER: Final = b"\0\1"
"""Of plain CDR with the least significant byte first; other encodings are not looked into."""

_HEADER_SIZE: Final = 4
_COUNT = struct.Struct("<I")
_CYCLE: Final = 8
"""Alignments repeat after so many bytes."""

Skip = Callable[[memoryview, int], int]
"""From the place where a value may begin to the place behind it."""


@dataclass(frozen=True)
class _Kind:
    """How to pass over a value; whether its size depends on nothing but where it begins."""

    skip: Skip
    fixed: bool


class CdrLength:
    """Tells the length of the messages of one type."""

    def __init__(self, kind: MessageType) -> None:
        self._skip: Skip | None
        try:
            self._skip = _message(kind.name, split_definition(kind.name, kind.definition)).skip
        except KeyError:  # a type that is not defined, or a wstring
            self._skip = None

    def trimmed(self, data: bytes) -> memoryview:
        """The message without what follows it; all of it where that cannot be told."""
        view = memoryview(data)
        if self._skip is None or not data.startswith(HEADER):
            return view
        try:
            end = self._skip(view[_HEADER_SIZE:], 0)
        except struct.error:
            return view
        return view[:_HEADER_SIZE + end]


def _message(name: str, texts: dict[str, str]) -> _Kind:
    parts = [_field(field, texts) for field in fields(texts[name], name.partition("/")[0])]
    steps = [part.skip for part in parts] or [_primitive(1)]

    def skip(data: memoryview, place: int) -> int:
        for step in steps:
            place = step(data, place)
        return place

    return _Kind(skip, all(part.fixed for part in parts))


def _field(field: Field, texts: dict[str, str]) -> _Kind:
    if field.kind in PRIMITIVES:
        one = _Kind(_primitive(PRIMITIVES[field.kind]), True)
    elif field.kind == "string":
        one = _Kind(_skip_string, False)
    else:
        one = _message(field.kind, texts)
    if field.count == SINGLE:
        return one
    if field.count != SEQUENCE:
        return _Kind(lambda data, place: _repeat(one, field.count, data, place), one.fixed)

    def skip_sequence(data: memoryview, place: int) -> int:
        place += -place % 4
        count = _COUNT.unpack_from(data, place)[0]
        return _repeat(one, count, data, place + 4)

    return _Kind(skip_sequence, False)


def _primitive(size: int) -> Skip:
    return lambda data, place: place + -place % size + size


def _skip_string(data: memoryview, place: int) -> int:
    place += -place % 4
    return place + 4 + int(_COUNT.unpack_from(data, place)[0])


def _repeat(one: _Kind, count: int, data: memoryview, place: int) -> int:
    """Pass over so many values, those of fixed size by multiplying."""
    met: dict[int, tuple[int, int]] = {}
    while count:
        if one.fixed and place % _CYCLE in met:
            before, count_before = met.pop(place % _CYCLE)
            rounds = count // (count_before - count)
            count -= rounds * (count_before - count)
            place += rounds * (place - before)
            met.clear()
            continue
        met[place % _CYCLE] = place, count
        place = one.skip(data, place)
        count -= 1
    return place
