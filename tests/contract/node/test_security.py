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

"""Where ROS is secured: the policy has the node's names, and missing keys are told."""

import os
import subprocess
import sys
from xml.etree import ElementTree

import pytest
from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import NodeNameNonExistentError

from tests.running import ROOT

from .harness.client import until

POLICY = ROOT / "config/pose_stats.policy.xml"
NODE = ("pose_stats", "/")
RCLError = rclpy_implementation.RCLError
OF_ANY_NODE = {"/rosout", "/parameter_events"}


def allowed(enclave, kind, verb):
    """Names that an enclave of the policy may use, with `~` in full."""
    (profile,) = ElementTree.parse(POLICY).findall(
        f".//enclave[@path='{enclave}']/profiles/profile"
    )
    private = f"{profile.get('ns')}{profile.get('node')}"
    return {
        name.text.replace("~", private)
        for group in profile.findall(f"{kind}s[@{verb}='ALLOW']")
        for name in group.findall(kind)
    }


def without_actions(names_and_types):
    return {name for name, _ in names_and_types if "/_action/" not in name}


@pytest.mark.parametrize(
    ("kind", "verb", "look", "more"),
    [
        (
            "topic",
            "publish",
            lambda node: node.get_publisher_names_and_types_by_node(*NODE),
            set(),
        ),
        (
            "topic",
            "subscribe",
            lambda node: node.get_subscriber_names_and_types_by_node(*NODE),
            {"/clock"},  # where time is simulated
        ),
        (
            "service",
            "reply",
            lambda node: node.get_service_names_and_types_by_node(*NODE),
            set(),
        ),
        (
            "action",
            "execute",
            lambda node: get_action_server_names_and_types_by_node(node, *NODE),
            set(),
        ),
    ],
    ids=["publications", "subscriptions", "services", "actions"],
)
def test_the_policy_allows_the_node_what_it_has_and_no_more(
    cell, kind, verb, look, more
):
    names = allowed("/pose_stats", kind, verb)

    def holds():
        try:
            return without_actions(look(cell.node)) | more == names
        except (NodeNameNonExistentError, RCLError):  # the graph is not there yet
            return False

    until(holds, f"the graph to be {sorted(names)}")


@pytest.mark.parametrize("enclave", ["/planner", "/camera"])
def test_others_may_use_what_the_node_has(enclave):
    node = "/pose_stats"
    assert allowed(enclave, "topic", "publish") <= OF_ANY_NODE | allowed(
        node, "topic", "subscribe"
    )
    assert allowed(enclave, "topic", "subscribe") <= {
        "/clock",
        "/detections",
        *allowed(node, "topic", "publish"),
        *allowed("/camera", "topic", "publish"),
    }
    assert allowed(enclave, "service", "request") <= allowed(node, "service", "reply")
    assert allowed(enclave, "action", "call") <= allowed(node, "action", "execute")


@pytest.mark.parametrize(
    ("keystore", "words"),
    [
        ("", "no folder of them in ROS_SECURITY_KEYSTORE; make keys"),
        ("keys", "keys"),  # a folder that has none
    ],
)
def test_a_start_without_keys_is_refused_with_what_to_do(tmp_path, keystore, words):
    (tmp_path / "keys/enclaves/pose_stats").mkdir(parents=True)
    outcome = subprocess.run(
        [
            *(sys.executable, "-m", "ros_pose_stats", "node", "--ros-args"),
            *("--enclave", "/pose_stats", "-p", f"log_directory:={tmp_path}"),
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        env=os.environ
        | {
            "ROS_SECURITY_ENABLE": "true",
            "ROS_SECURITY_STRATEGY": "Enforce",
            "ROS_SECURITY_KEYSTORE": keystore and str(tmp_path / keystore),
        },
    )
    assert outcome.returncode == 2
    line = outcome.stderr.splitlines()[-1]
    assert line.startswith("pose_stats: expected keys for a secured network")
    assert words in line and "unset ROS_SECURITY_ENABLE" in line
    assert "Traceback" not in outcome.stderr
