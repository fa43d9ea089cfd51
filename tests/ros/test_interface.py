"""Every name of the contract is there, under its type."""

from __future__ import annotations

import pytest
from rcl_interfaces.msg import ParameterType
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros_pose_stats_msgs import action, msg, srv

from ros_pose_stats.ros.settings import TABLE

from .contract import ACTION, DEFAULTS, FIELDS, PUBLICATIONS, SERVICES, SUBSCRIPTIONS
from .harness.client import until
from .harness.jobs import known_part

NODE = ("pose_stats", "/")
RCLError = rclpy_implementation.RCLError
KINDS = {bool: ParameterType.PARAMETER_BOOL, int: ParameterType.PARAMETER_INTEGER,
         float: ParameterType.PARAMETER_DOUBLE, str: ParameterType.PARAMETER_STRING,
         list: ParameterType.PARAMETER_STRING_ARRAY}


def eventually_holds(look, expected):
    """The graph is told by and by."""
    def holds():
        try:
            found = {name: kind for name, (kind,) in look()}
        except RCLError:  # its services answer before its name is known
            return False
        return all(found.get(name) == kind for name, kind in expected.items())

    until(holds, f"the graph to tell {expected}")


class TestGraph:
    def test_services(self, cell):
        eventually_holds(lambda: cell.node.get_service_names_and_types_by_node(*NODE),
                         {f"/pose_stats/{name}": kind for name, kind in SERVICES.items()})

    def test_subscriptions(self, cell):
        eventually_holds(lambda: cell.node.get_subscriber_names_and_types_by_node(*NODE),
                         SUBSCRIPTIONS)

    def test_publications(self, cell):
        known_part(cell)
        eventually_holds(lambda: cell.node.get_publisher_names_and_types_by_node(*NODE),
                         PUBLICATIONS)

    def test_action(self, cell):
        from rclpy.action import get_action_server_names_and_types_by_node
        eventually_holds(lambda: get_action_server_names_and_types_by_node(cell.node, *NODE),
                         ACTION)

    def test_meshes_are_taken_from_plain_and_latched_publishers(self, cell):
        def durabilities():
            found = cell.node.get_subscriptions_info_by_topic("/pose_stats/part_mesh")
            assert all(one.qos_profile.reliability == ReliabilityPolicy.RELIABLE for one in found)
            return {one.qos_profile.durability for one in found} == {
                DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL}
        until(durabilities)

    def test_results_and_markers_are_latched(self, cell):
        known_part(cell)
        for topic in ("pose_statistics", "markers"):
            found = until(lambda topic=topic: cell.node.get_publishers_info_by_topic(
                f"/pose_stats/{topic}"))
            for one in found:
                assert one.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
                assert one.qos_profile.reliability == ReliabilityPolicy.RELIABLE


class TestMessages:
    @pytest.mark.parametrize("name", FIELDS)
    def test_fields(self, name):
        assert set(FIELDS[name].split()) <= set(getattr(msg, name).get_fields_and_field_types())

    @pytest.mark.parametrize("made", [
        msg.PartMesh, srv.EstimatePoses.Request, srv.StartDropSimulation.Request,
        action.SimulateDrops.Goal])
    def test_nothing_filled_in_means_the_nodes(self, made):
        message = made()
        assert (message.restitution, message.drop_height) == (-1.0, -1.0)
        assert getattr(message, "unit", 1.0) == 1.0

    def test_a_goal_is_what_starts_a_simulation(self):
        assert (action.SimulateDrops.Goal.get_fields_and_field_types()
                == srv.StartDropSimulation.Request.get_fields_and_field_types())

    def test_states(self):
        answer = srv.GetDropSimulation.Response
        states = (answer.UNKNOWN, answer.QUEUED, answer.RUNNING, answer.DONE, answer.CANCELLED,
                  answer.FAILED)
        assert states == (0, 1, 2, 3, 4, 5)


class TestParameters:
    def test_defaults(self, cell, shared_node):
        values = cell.call("get_parameters", names=list(DEFAULTS)).values
        found = {name: parameter_value_to_python(value)
                 for name, value in zip(DEFAULTS, values, strict=True)}
        assert found.pop("log_directory") == str(shared_node.log_directory)
        assert found == {name: value for name, value in DEFAULTS.items()
                         if name != "log_directory"}

    def test_the_folder_has_a_default_too(self):
        assert {setting.name: setting.default for setting in TABLE} == DEFAULTS

    def test_types_descriptions_and_bounds(self, cell):
        found = cell.call("describe_parameters", names=list(DEFAULTS)).descriptors
        for one, setting in zip(found, TABLE, strict=True):
            one_kind = KINDS[type(DEFAULTS[setting.name])]
            assert (one.name, one.type) == (setting.name, one_kind)
            assert one.description == setting.description and len(one.description) > 20
            ranges = [*one.floating_point_range, *one.integer_range]
            assert [(r.from_value, r.to_value) for r in ranges] == (
                [] if setting.low is None else [(setting.low, setting.high)])

    def test_numbers_are_bounded(self):
        for setting in TABLE:
            if type(setting.default) in (int, float):
                assert setting.low <= setting.default <= setting.high
