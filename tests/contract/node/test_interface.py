"""Every name of the contract is there, under its type, with its quality of service."""

import math

import pytest
from rcl_interfaces.msg import ParameterType
from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros_pose_stats_msgs import action, msg, srv

from .contract import ACTION, DEFAULTS, FIELDS, PUBLICATIONS, SERVICES, SUBSCRIPTIONS
from .harness.client import until
from .harness.jobs import known_part

NODE = ("pose_stats", "/")
RCLError = rclpy_implementation.RCLError
KINDS = {
    bool: ParameterType.PARAMETER_BOOL,
    int: ParameterType.PARAMETER_INTEGER,
    float: ParameterType.PARAMETER_DOUBLE,
    str: ParameterType.PARAMETER_STRING,
    list: ParameterType.PARAMETER_STRING_ARRAY,
}


@pytest.mark.parametrize(
    ("look", "expected"),
    [
        (
            lambda node: node.get_service_names_and_types_by_node(*NODE),
            {f"/pose_stats/{name}": kind for name, kind in SERVICES.items()},
        ),
        (
            lambda node: node.get_subscriber_names_and_types_by_node(*NODE),
            SUBSCRIPTIONS,
        ),
        (lambda node: node.get_publisher_names_and_types_by_node(*NODE), PUBLICATIONS),
        (lambda node: get_action_server_names_and_types_by_node(node, *NODE), ACTION),
    ],
    ids=["services", "subscriptions", "publications", "actions"],
)
def test_the_graph_has_every_name_under_its_type(cell, look, expected):
    known_part(cell)

    def holds():
        try:
            topics = {name: kind for name, (kind,) in look(cell.node)}
        except RCLError:  # its services answer before its name is known
            return False
        return all(topics.get(name) == kind for name, kind in expected.items())

    until(holds, f"the graph to tell {expected}")


def test_meshes_are_taken_from_plain_and_latched_publishers(cell):
    def durabilities():
        ends = cell.node.get_subscriptions_info_by_topic("/pose_stats/part_mesh")
        assert all(
            end.qos_profile.reliability == ReliabilityPolicy.RELIABLE for end in ends
        )
        return {end.qos_profile.durability for end in ends} == {
            DurabilityPolicy.VOLATILE,
            DurabilityPolicy.TRANSIENT_LOCAL,
        }

    until(durabilities, "both subscriptions")


@pytest.mark.parametrize("topic", ["pose_statistics", "markers"])
def test_results_are_latched(cell, topic):
    known_part(cell)
    for end in until(
        lambda: cell.node.get_publishers_info_by_topic(f"/pose_stats/{topic}")
    ):
        assert end.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        assert end.qos_profile.reliability == ReliabilityPolicy.RELIABLE


@pytest.mark.parametrize("name", FIELDS)
def test_messages_have_their_fields(name):
    assert set(FIELDS[name].split()) <= set(
        getattr(msg, name).get_fields_and_field_types()
    )


@pytest.mark.parametrize(
    "kind",
    [
        msg.PartMesh,
        srv.EstimatePoses.Request,
        srv.StartDropSimulation.Request,
        action.SimulateDrops.Goal,
    ],
)
def test_what_is_not_filled_in_is_left_to_the_node(kind):
    message = kind()
    assert (message.restitution, message.drop_height) == (-1.0, -1.0)
    assert getattr(message, "unit", 1.0) == 1.0


def test_a_goal_is_what_starts_a_simulation():
    assert (
        action.SimulateDrops.Goal.get_fields_and_field_types()
        == srv.StartDropSimulation.Request.get_fields_and_field_types()
    )


def test_parameters_have_their_defaults_types_and_descriptions(cell, shared_node):
    values = cell.call("get_parameters", names=list(DEFAULTS)).values
    parameters = {
        name: parameter_value_to_python(value)
        for name, value in zip(DEFAULTS, values, strict=True)
    }
    assert parameters == {**DEFAULTS, "log_directory": str(shared_node.log_directory)}
    for described in cell.call("describe_parameters", names=list(DEFAULTS)).descriptors:
        default = DEFAULTS[described.name]
        assert (
            described.type == KINDS[type(default)] and len(described.description) > 20
        )
        ranges = [*described.floating_point_range, *described.integer_range]
        assert len(ranges) == (type(default) in (int, float))
        assert all(
            end.from_value <= default <= end.to_value and math.isfinite(end.to_value)
            for end in ranges
        )
