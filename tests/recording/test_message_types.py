"""Definitions, dependencies and hashes of message types."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from ros_pose_stats.recording.writer.message_types import SEPARATOR, message_type

SHARE = Path(sys.prefix) / "share"


@pytest.fixture
def share(tmp_path):
    """Two small packages."""
    def define(name: str, text: str, type_hash: str = "") -> None:
        package, short = name.split("/")
        folder = tmp_path / package / "msg"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{short}.msg").write_text(text)
        if type_hash:
            (folder / f"{short}.json").write_text(json.dumps({"type_hashes": [
                {"type_name": "b/msg/Other", "hash_string": "RIHS01_wrong"},
                {"type_name": f"{package}/msg/{short}", "hash_string": type_hash}]}))

    define("a/Top", "# uses Gone gone\nint32 ONE=1\nstring NAME='Gone # gone'\n"
                    "b/Other[] others\nNear near\nstring<=5[<=3] words\nfloat64[9] fixed 0.5\n"
                    "Near[4] again\nb/msg/Third[<=2] third # Gone no\n", "RIHS01_right")
    define("a/Near", "b/Third third\nbool yes true")
    define("b/Other", "Third third\n")
    define("b/Third", "uint8 n\n")
    return lambda package: tmp_path / package


def test_every_dependency_stands_once_behind_the_text(share):
    kind = message_type("a/msg/Top", share)
    head, *others = kind.definition.split(SEPARATOR + "\n")
    assert head.startswith("# uses Gone gone\nint32 ONE=1\n")
    assert [one.split("\n")[0] for one in others] == [
        "MSG: b/Other", "MSG: a/Near", "MSG: b/Third"]
    assert others[2] == "MSG: b/Third\nuint8 n\n"


def test_the_hash_is_the_types_own(share):
    assert message_type("a/msg/Top", share).type_hash == "RIHS01_right"
    assert message_type("a/msg/Near", share).type_hash == ""


def test_a_missing_definition_is_refused(share):
    with pytest.raises(FileNotFoundError):
        message_type("a/msg/Gone", share)


@pytest.mark.parametrize("name", ["PartMesh", "PoseStatistics", "PoseCounts", "JobEvent",
                                  "DropRecords"])
def test_the_hash_follows_from_the_definition(name):
    pytest.importorskip("ros_pose_stats_msgs")
    rosbags = pytest.importorskip("rosbags.typesys")
    kind = message_type(f"ros_pose_stats_msgs/msg/{name}", lambda package: SHARE / package)
    store = rosbags.get_typestore(rosbags.Stores.EMPTY)
    store.register(rosbags.get_types_from_msg(kind.definition, kind.name))
    assert kind.type_hash.startswith("RIHS01_")
    assert store.hash_rihs01(kind.name) == kind.type_hash
