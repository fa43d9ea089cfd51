"""Messages of a state that an older version wrote, as they are defined today."""

from functools import cache
from importlib import import_module
from typing import Any

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs import msg

from ..recording.analysis.decoding import Decoders
from ..recording.reader import RawMessage
from ..recording.writer.message_types import message_type
from .recorder import PACKAGE, share_directory
from .state import MESSAGES

_decoders = Decoders()


@cache
def _definition(kind: str) -> str:
    return message_type(f"{PACKAGE}/msg/{kind}", share_directory).definition


def definitions() -> dict[str, str]:
    """Definitions of the messages in the state, by type, as they are installed."""
    return {kind: _definition(kind) for kinds in MESSAGES.values() for kind in kinds.values()}


def as_of_today(kind: str, definition: str, data: bytes) -> bytes | None:
    """A message of another definition, by the names of its fields; None where it is unreadable."""
    if definition == _definition(kind):
        return data
    decoded = _decoders.decode(RawMessage("", f"{PACKAGE}/msg/{kind}", data, 0, definition))
    if decoded is None:
        return None
    return bytes(serialize_message(_filled(getattr(msg, kind)(), decoded)))


def _filled(message: Any, decoded: Any) -> Any:
    for name, kind in message.get_fields_and_field_types().items():
        value, default = getattr(decoded, name, None), getattr(message, name)
        if value is None:
            continue
        if hasattr(default, "get_fields_and_field_types"):
            _filled(default, value)
        elif "/" in kind:
            package, _, type_name = kind.removeprefix("sequence<").rstrip(">").partition("/")
            make = getattr(import_module(f"{package}.msg"), type_name)
            setattr(message, name, [_filled(make(), item) for item in value])
        else:
            setattr(message, name, value)
    return message
