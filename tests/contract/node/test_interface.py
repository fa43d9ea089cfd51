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

"""Every name of the contract is there, under its type, with its quality of service."""

import math
import re

import pytest
from rcl_interfaces.msg import ParameterType
from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros_pose_stats_msgs import action, msg, srv

from tests.running import ROOT

from .contract import ACTION, DEFAULTS, PUBLICATIONS, SERVICES, SUBSCRIPTIONS
from .harness.client import until
from .harness.jobs import known_part
from .interfaces import INTERFACES

NODE = ("pose_stats", "/")
RCLError = rclpy_implementation.RCLError
PLAIN_TYPES = {"boolean": "bool", "double": "float64", "float": "float32"}
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


def field_types(name):
    """Fields of an installed interface, as its file has them."""
    kind, _, path = name.partition("/")
    message = {"msg": msg, "srv": srv, "action": action}[kind]
    for part in path.split("."):
        message = getattr(message, part)
    fields = []
    for field, text in message.get_fields_and_field_types().items():
        is_sequence = text.startswith("sequence<")
        text = text.removeprefix("sequence<").rstrip(">")
        text = PLAIN_TYPES.get(text, text).removeprefix("ros_pose_stats_msgs/")
        fields.append(f"{text}{'[]' * is_sequence} {field}")
    return fields


@pytest.mark.parametrize("name", INTERFACES)
def test_an_interface_has_its_fields_and_no_others(name):
    assert ", ".join(field_types(name)) == INTERFACES[name]


def test_every_interface_is_in_the_table():
    names = {
        f"{kind.__name__.rpartition('.')[2]}/{name}"
        for kind in (msg, srv, action)
        for name in vars(kind)
        if name[0].isupper() and "_" not in name
    }
    assert names == {name.partition(".")[0] for name in INTERFACES} | {"msg/Code"}


def test_every_field_is_explained():
    """A comment before each field, or before several that go together."""
    for file in sorted((ROOT / "msg_defs").glob("*/*")):
        for block in re.split(r"\n\n|---\n+", file.read_text(encoding="utf-8")):
            assert not block.strip() or block.strip().startswith("#"), (file, block)


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
