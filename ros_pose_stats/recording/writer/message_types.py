"""What a bag says about a message type: its name, its definition as text, and its hash.

Everything is read from the interface packages' share folders, so that a bag describes
exactly the messages that the node was built with.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from .definitions import PRIMITIVES, SEPARATOR, STRINGS, fields


@dataclass(frozen=True)
class MessageType:
    """A ROS 2 message type as a bag describes it.

    Attributes
    ----------
    name : str
        Such as `std_msgs/msg/Header`.
    definition : str
        The .msg text, then that of every type it uses, once, each after a line of 80 `=` and
        a line `MSG: package/Name` (schema encoding `ros2msg`).
    type_hash : str
        `RIHS01_` and 64 hex digits; empty where the package ships none.
    """

    name: str
    definition: str
    type_hash: str


def message_type(name: str, share: Callable[[str], Path]) -> MessageType:
    """Read a type from the packages that define it.

    Parameters
    ----------
    name : str
        `package/msg/Name`.
    share : callable
        Share folder of a package, such as `.../share/std_msgs` for `std_msgs`.

    Raises
    ------
    OSError
        No such message in the package's share folder.
    """
    texts = {name: _text(name, share)}
    waiting = [name]
    while waiting:
        used = waiting.pop(0)
        for field in fields(texts[used], used.partition("/")[0]):
            if field.kind not in PRIMITIVES and field.kind not in STRINGS | texts.keys():
                texts[field.kind] = _text(field.kind, share)
                waiting.append(field.kind)
    parts = [texts.pop(name)]
    parts += [f"{SEPARATOR}\nMSG: {other.replace('/msg/', '/')}\n{text}"
              for other, text in texts.items()]
    return MessageType(name, "\n".join(parts), _type_hash(name, share))


def _file(name: str, share: Callable[[str], Path], suffix: str) -> Path:
    package, _, short = name.split("/")
    return Path(share(package)) / "msg" / f"{short}{suffix}"


def _text(name: str, share: Callable[[str], Path]) -> str:
    return _file(name, share, ".msg").read_text(encoding="utf-8")


def _type_hash(name: str, share: Callable[[str], Path]) -> str:
    try:
        described = json.loads(_file(name, share, ".json").read_text(encoding="utf-8"))
    except (FileNotFoundError, json.JSONDecodeError):
        return ""
    hashes = {one["type_name"]: str(one["hash_string"]) for one in described["type_hashes"]}
    return hashes.get(name, "")
