"""What a message type looks like: its definition, its hash, and its bytes in CDR."""

import json
import re
import struct
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

SEPARATOR = "=" * 80  # stands between the definitions of a type and of those that it uses

PRIMITIVES = {
    "bool": 1, "byte": 1, "char": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4,
    "uint32": 4, "float32": 4, "int64": 8, "uint64": 8, "float64": 8,
}
"""Bytes of the types of fixed size."""

STRINGS = frozenset(("string", "wstring"))
SINGLE = 0
SEQUENCE = -1
HEADER = b"\0\1"
"""Of plain CDR with the least significant byte first; other encodings are not looked into."""

_FIELD = re.compile(r"\s*(?P<type>[A-Za-z][\w/]*)(<=\d+)?"
                    r"(?P<array>\[(?P<size>(<=)?\d*)\])?\s+[A-Za-z]\w*\s*(?P<constant>=)?")
_HEADER_SIZE = 4
_COUNT = struct.Struct("<I")


@dataclass(frozen=True)
class MessageType:
    """A ROS 2 message type as a bag describes it."""

    name: str  # such as `std_msgs/msg/Header`
    # the .msg text, then that of every type it uses, once, each after a line of 80 `=` and a line
    # `MSG: package/Name` (schema encoding `ros2msg`)
    definition: str
    type_hash: str  # `RIHS01_` and 64 hex digits; empty where the package ships none


@dataclass(frozen=True)
class Field:
    """A field of a message."""

    kind: str  # a primitive type, a string type, or the full name of a message
    count: int  # SINGLE, SEQUENCE, or the number of elements of a fixed array


def message_type(name: str, share: Callable[[str], Path]) -> MessageType:
    """Read a type from the packages that define it: exactly what the node was built with.

    `share`: share folder of a package; OSError where that has no such message.
    """
    def read(type_name: str, suffix: str = ".msg") -> str:
        package, _, short = type_name.split("/")
        return (Path(share(package)) / "msg" / f"{short}{suffix}").read_text(encoding="utf-8")

    text = definition(name, read)
    try:
        hashes = {one["type_name"]: str(one["hash_string"])
                  for one in json.loads(read(name, ".json"))["type_hashes"]}
    except (FileNotFoundError, json.JSONDecodeError):
        hashes = {}
    return MessageType(name, text, hashes.get(name, ""))


def definition(name: str, read: Callable[[str], str]) -> str:
    """The text of a type and those of all that it uses, each of which `read` gives by name."""
    texts = {name: read(name)}
    waiting = [name]
    while waiting:
        used = waiting.pop(0)
        for field in fields(texts[used], used.partition("/")[0]):
            if field.kind not in PRIMITIVES and field.kind not in STRINGS | texts.keys():
                texts[field.kind] = read(field.kind)
                waiting.append(field.kind)
    parts = [texts.pop(name)]
    parts += [f"{SEPARATOR}\nMSG: {other.replace('/msg/', '/')}\n{text}"
              for other, text in texts.items()]
    return "\n".join(parts)


def fields(text: str, package: str) -> Iterator[Field]:
    """The fields of a definition, without constants; types without a package are of this one."""
    for line in text.splitlines():
        field = _FIELD.match(line.partition("#")[0])
        if field is None or field["constant"]:
            continue
        kind = field["type"]
        if kind not in PRIMITIVES and kind not in STRINGS:
            parts = kind.split("/")
            kind = f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"
        count = SINGLE
        if field["array"]:
            count = int(field["size"]) if field["size"].isdigit() else SEQUENCE
        yield Field(kind, count)


def split_definition(name: str, definition: str) -> dict[str, str]:
    """The texts that a definition is put together from, by the full names of their types."""
    first, *others = definition.split(SEPARATOR + "\n")
    texts = {name: first}
    for other in others:
        head, _, text = other.partition("\n")
        package, _, short = head.removeprefix("MSG: ").strip().partition("/")
        texts[f"{package}/msg/{short}"] = text
    return texts


Skip = Callable[[memoryview, int], int]
"""From the place where a value may begin to the place behind it."""


_Kind = tuple[Skip, bool]
"""How to pass over a value; whether its size depends on nothing but where it begins."""


class CdrLength:
    """Tells where the messages of one type end.

    `rclpy.serialization.serialize_message` counts padding in front of empty sequences that the
    message has not got, so that a few bytes of memory follow it, which some readers refuse.
    """

    def __init__(self, kind: MessageType) -> None:
        self._skip: Skip | None = None
        with suppress(KeyError):  # a type that is not defined, or a wstring
            self._skip = _message(kind.name, split_definition(kind.name, kind.definition))[0]

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
    steps = [skip for skip, _ in parts] or [_primitive(1)]

    def skip(data: memoryview, place: int) -> int:
        for step in steps:
            place = step(data, place)
        return place

    return skip, all(fixed for _, fixed in parts)


def _field(field: Field, texts: dict[str, str]) -> _Kind:
    if field.kind in PRIMITIVES:
        one: _Kind = _primitive(PRIMITIVES[field.kind]), True
    elif field.kind == "string":
        one = _skip_string, False
    else:
        one = _message(field.kind, texts)
    if field.count == SINGLE:
        return one
    if field.count != SEQUENCE:
        return lambda data, place: _repeat(one, field.count, data, place), one[1]

    def skip_sequence(data: memoryview, place: int) -> int:
        place += -place % 4
        count = _COUNT.unpack_from(data, place)[0]
        return _repeat(one, count, data, place + 4)

    return skip_sequence, False


def _primitive(size: int) -> Skip:
    return lambda data, place: place + -place % size + size


def _skip_string(data: memoryview, place: int) -> int:
    place += -place % 4
    return place + 4 + int(_COUNT.unpack_from(data, place)[0])


def _repeat(one: _Kind, count: int, data: memoryview, place: int) -> int:
    """Pass over so many values.

    Where a value of fixed size ends, modulo its widest alignment, does not depend on where it
    begins: from the second on all are equally far apart.
    """
    skip, fixed = one
    if fixed and count > 2:
        first = skip(data, place)
        second = skip(data, first)
        return second + (count - 2) * (second - first)
    for _ in range(count):
        place = skip(data, place)
    return place
