"""A part that is on its way back when the node ends."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from ros_pose_stats.errors import MeshError
from ros_pose_stats.ros.parts.part_builder import NotBuiltError
from ros_pose_stats.ros.restart import restore


@pytest.mark.parametrize(("error", "forgotten"), [(NotBuiltError, []), (MeshError, ["part"])])
def test_is_tried_again_by_the_next_run_unless_its_mesh_is_bad(monkeypatch, error, forgotten):
    def take_part(*_, **__):
        raise error("a running node", "one that is ending", "start it again")

    monkeypatch.setattr(restore, "read_at", lambda *_: b"")
    monkeypatch.setattr(restore, "request_of_part_bytes", lambda data: data)
    recorded = []
    parts = SimpleNamespace(current=lambda part_id: None,
                            record_forgotten=lambda part_id, *_: recorded.append(part_id),
                            meshes=SimpleNamespace(coming={("part", "ab")}))
    mesh = SimpleNamespace(digest="ab", place=None)
    with pytest.raises(error):
        restore._restore_part(restore.RestoredPart("part", mesh, None, False, False), None,
                              SimpleNamespace(parts=parts, take_part=take_part))
    assert recorded == forgotten and not parts.meshes.coming
