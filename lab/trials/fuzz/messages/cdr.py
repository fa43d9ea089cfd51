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

"""Messages as CDR in either byte order; rclpy writes the machine's own only."""

import re
import struct
from typing import Any

CODES = {
    "double": "d",
    "float": "f",
    "int8": "b",
    "uint8": "B",
    "octet": "B",
    "boolean": "?",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
}
LITTLE = "<"
BIG = ">"
HEADERS = {LITTLE: b"\x00\x01\x00\x00", BIG: b"\x00\x00\x00\x00"}

_ARRAY = re.compile(r"(.+)\[(\d+)\]")
_SEQUENCE = re.compile(r"sequence<(.+?)(, \d+)?>")


def encoded(message: Any, order: str = LITTLE) -> bytes:
    """A message as plain CDR with its header; nothing follows it."""
    payload = bytearray()
    _message(payload, message, order)
    return HEADERS[order] + bytes(payload)


def _message(payload: bytearray, message: Any, order: str) -> None:
    for name, kind in message.get_fields_and_field_types().items():
        _value(payload, getattr(message, name), kind, order)


def _value(payload: bytearray, value: Any, kind: str, order: str) -> None:
    if (sequence := _SEQUENCE.fullmatch(kind)) is not None:
        _number(payload, len(value), "I", order)
        for element in value:
            _value(payload, element, sequence[1], order)
    elif (array := _ARRAY.fullmatch(kind)) is not None:
        for element in value:
            _value(payload, element, array[1], order)
    elif kind == "string":
        text = value.encode() + b"\0"
        _number(payload, len(text), "I", order)
        payload += text
    elif kind in CODES:
        _number(payload, value, CODES[kind], order)
    else:
        _message(payload, value, order)


def _number(payload: bytearray, value: Any, code: str, order: str) -> None:
    payload += bytes(-len(payload) % struct.calcsize(code))
    payload += struct.pack(order + code, value if code in "df?" else int(value))
