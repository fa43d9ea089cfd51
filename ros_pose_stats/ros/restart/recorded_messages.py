"""Messages of earlier runs, also of those whose definitions had other fields."""

from __future__ import annotations

from functools import cache
from typing import Any, TypeVar

from rclpy.serialization import deserialize_message

from ...errors import BagError
from ...recording.analysis.decoding import Decoders
from ...recording.reader.raw_reader import RawMessage
from ...recording.writer.message_types import message_type
from ..recorder import share_directory

Message = TypeVar("Message")

_decoders = Decoders()


def is_of_today(recorded: RawMessage) -> bool:
    """Whether a message was recorded with the definition that is installed."""
    return recorded.definition == _installed(recorded.type_name)


def read_recorded(recorded: RawMessage, kind: type[Message]) -> Message:
    """A message as today's type: field by field by name where the definition was another one.

    CDR holds no names, so that bytes of another definition would be read into wrong fields. A
    field that it does not have keeps its default; so do lists of messages.

    Raises BagError if the bytes are not what their definition says. The bindings raise what they
    like.
    """
    if is_of_today(recorded):
        found: Message = deserialize_message(recorded.data, kind)
        return found
    told = _decoders.decode(recorded)
    if told is None:
        raise BagError(f"a {recorded.type_name} by the definition in the bag",
                       f"{len(recorded.data)} bytes that are none", "nothing; it is left out")
    message = kind()
    _fill(message, told)
    return message


@cache
def _installed(type_name: str) -> str:
    return message_type(type_name, share_directory).definition


def _fill(message: Any, told: Any) -> None:
    for name, kind in message.get_fields_and_field_types().items():
        if not hasattr(told, name):
            continue
        part = getattr(message, name)
        if hasattr(part, "get_fields_and_field_types"):
            _fill(part, getattr(told, name))
        elif "/" not in kind:
            setattr(message, name, getattr(told, name))
