"""What stands in for the node and its bag where a test has neither."""

from __future__ import annotations

from types import SimpleNamespace

from ros_pose_stats.ros.floods import Floods
from ros_pose_stats.ros.parts.announcer import Announcer
from ros_pose_stats.ros.parts.part_store import PartStore
from ros_pose_stats.ros.parts.result_store import ResultStore


class FakeRecorder:
    """Takes everything, keeps the topics."""

    last_problem = ""

    def __init__(self):
        self.topics = []
        self.mark = self.trusted_from = 0
        self.closing = False

    def record(self, topic, data, *, durable=False):
        self.topics.append(topic)
        return bool(data)

    def sync(self):
        """Nothing is written."""
        return True

    def has_room_for(self, size):
        return True


def fake_node(failures):
    """A node whose topics nobody hears; what it logs as failures goes to a list."""
    log = SimpleNamespace(info=lambda line: None, warning=lambda line: None,
                          error=failures.append)
    return SimpleNamespace(
        get_logger=lambda: log, create_timer=lambda *_, **__: None,
        create_service=lambda *_, **__: None, destroy_publisher=lambda publisher: None,
        create_publisher=lambda *_, **__: SimpleNamespace(
            publish=lambda data: None, wait_for_all_acked=lambda timeout: True))


def quiet_results(settings, recorder, node):
    """A store of results around stores of its own."""
    announcer = Announcer(node, recorder, Floods(print))
    parts = PartStore(recorder, announcer.withdraw_result)
    return ResultStore(lambda: settings, parts, announcer)
