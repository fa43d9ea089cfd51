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

"""What a message type looks like: its definition, its hash, and its bytes in CDR."""

import json
import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

SEPARATOR = "=" * 80  # between the definitions of a type and of those that it uses

PRIMITIVES = {
    "bool": 1,
    "byte": 1,
    "char": 1,
    "int8": 1,
    "uint8": 1,
    "int16": 2,
    "uint16": 2,
    "int32": 4,
    "uint32": 4,
    "float32": 4,
    "int64": 8,
    "uint64": 8,
    "float64": 8,
}
"""Bytes of the types of fixed size."""

BUILT_IN = frozenset(("string", *PRIMITIVES))
SINGLE = 0
SEQUENCE = -1
HEADER = b"\0\1"
"""Of plain little-endian CDR; other encodings are not looked into."""

_FIELD = re.compile(
    r"\s*(?P<type>[A-Za-z][\w/]*)(<=\d+)?"
    r"(?P<array>\[(?P<size>(<=)?\d*)\])?\s+[A-Za-z]\w*\s*(?P<constant>=)?"
)
_HEADER_SIZE = 4
_COUNT = struct.Struct("<I")


@dataclass(frozen=True)
class MessageType:
    """A ROS 2 message type as a bag describes it."""

    name: str  # such as `std_msgs/msg/Header`
    # the .msg texts of the type and of all that it uses, by full name
    texts: dict[str, str]
    # `RIHS01_` and 64 hex digits; empty where the package ships none
    type_hash: str = ""

    @property
    def definition(self) -> str:
        """All texts as one, as the schema encoding `ros2msg` has them."""
        return "\n".join(
            [
                self.texts[self.name],
                *(
                    f"{SEPARATOR}\nMSG: {name.replace('/msg/', '/')}\n{text}"
                    for name, text in self.texts.items()
                    if name != self.name
                ),
            ]
        )


@dataclass(frozen=True)
class Field:
    """A field of a message."""

    kind: str  # a primitive type, `string`, or the full name of a message
    count: int  # SINGLE, SEQUENCE, or the number of elements of a fixed array


def message_type(name: str, share: Callable[[str], Path]) -> MessageType:
    """Read a type from the packages that define it: what the node was built with.

    `share`: share folder of a package; OSError where that has no such message.
    """

    def read_text(type_name: str, suffix: str = ".msg") -> str:
        package, _, short = type_name.split("/")
        return (Path(share(package)) / "msg" / f"{short}{suffix}").read_text(
            encoding="utf-8"
        )

    texts = used_texts(name, read_text)
    try:
        hashes = {
            entry["type_name"]: str(entry["hash_string"])
            for entry in json.loads(read_text(name, ".json"))["type_hashes"]
        }
    except (FileNotFoundError, json.JSONDecodeError):
        hashes = {}
    return MessageType(name, texts, hashes.get(name, ""))


def used_texts(name: str, read_text: Callable[[str], str]) -> dict[str, str]:
    """The text of a type and those of all that it uses, by name."""
    texts = {name: read_text(name)}
    waiting = [name]
    while waiting:
        type_name = waiting.pop(0)
        for field in fields(texts[type_name], type_name.partition("/")[0]):
            if field.kind not in BUILT_IN and field.kind not in texts:
                texts[field.kind] = read_text(field.kind)
                waiting.append(field.kind)
    return texts


def fields(text: str, package: str) -> Iterator[Field]:
    """The fields of a definition, without constants.

    Types that are written without a package are of this one.
    """
    for line in text.splitlines():
        field = _FIELD.match(line.partition("#")[0])
        if field is None or field["constant"]:
            continue
        kind = field["type"]
        if kind not in BUILT_IN:
            parts = kind.split("/")
            kind = f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"
        count = SINGLE
        if field["array"]:
            count = int(field["size"]) if field["size"].isdigit() else SEQUENCE
        yield Field(kind, count)


# From where a value may begin to the position behind it.
Skip = Callable[[memoryview, int], int]


class CdrLength:
    """Tells where the messages of one type end.

    `rclpy.serialization.serialize_message` counts padding in front of empty sequences
    that the message has not got, so that a few bytes of memory follow it, which some
    readers refuse.
    """

    def __init__(self, kind: MessageType) -> None:
        self._skip = _skip_value(kind.name, kind.texts)

    def trimmed(self, data: bytes) -> memoryview:
        """The message without what follows it; all of it where that cannot be told."""
        view = memoryview(data)
        if not data.startswith(HEADER):
            return view
        try:
            return view[: _HEADER_SIZE + self._skip(view[_HEADER_SIZE:], 0)]
        except struct.error:
            return view


def _skip_value(kind: str, texts: dict[str, str]) -> Skip:
    """How to pass over a single value of a type."""
    if kind == "string":
        return lambda data, position: 4 + sum(_read_count(data, position))
    if kind in PRIMITIVES:
        size = PRIMITIVES[kind]
        return lambda data, position: position + -position % size + size
    steps = [
        _skip_field(field, texts)
        for field in fields(texts[kind], kind.partition("/")[0])
    ]

    def skip(data: memoryview, position: int) -> int:
        for step in steps:
            position = step(data, position)
        return position

    return skip


def _read_count(data: memoryview, position: int) -> tuple[int, int]:
    """Where the count of a sequence or a string begins, and the count."""
    position += -position % 4
    return position, int(_COUNT.unpack_from(data, position)[0])


def _skip_field(field: Field, texts: dict[str, str]) -> Skip:
    """How to pass over a field; what is long is an array of numbers."""
    skip = _skip_value(field.kind, texts)
    size = PRIMITIVES.get(field.kind)
    if field.count == SINGLE:
        return skip

    def skip_all(data: memoryview, position: int) -> int:
        count = field.count
        if count == SEQUENCE:
            position, count = _read_count(data, position)
            position += 4
        if size and count:
            return position + -position % size + size * count
        for _ in range(count):
            position = skip(data, position)
        return position

    return skip_all
