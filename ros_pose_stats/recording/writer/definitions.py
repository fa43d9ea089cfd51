"""Fields of message definitions (.msg texts)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

SEPARATOR: Final = "=" * 80
"""Stands between the definitions of a type and of those that it uses."""

PRIMITIVES: Final = {
    "bool": 1, "byte": 1, "char": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4,
    "uint32": 4, "float32": 4, "int64": 8, "uint64": 8, "float64": 8,
}
"""Bytes of the types of fixed size."""

STRINGS: Final = frozenset(("string", "wstring"))

SINGLE: Final = 0
SEQUENCE: Final = -1

_FIELD = re.compile(r"\s*(?P<type>[A-Za-z][\w/]*)(<=\d+)?"
                    r"(?P<array>\[(?P<size>(<=)?\d*)\])?\s+[A-Za-z]\w*\s*(?P<constant>=)?")


@dataclass(frozen=True)
class Field:
    """A field of a message.

    Attributes
    ----------
    kind : str
        A primitive type, a string type, or the full name of a message.
    count : int
        SINGLE, SEQUENCE, or the number of elements of a fixed array.
    """

    kind: str
    count: int


def fields(text: str, package: str) -> Iterator[Field]:
    """The fields of a definition in their order, without constants.

    Parameters
    ----------
    text : str
        Of the one definition.
    package : str
        Where the types without a package are defined.
    """
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
