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

"""Nodes in a domain of their own, said to each by its environment alone."""

import pytest

# Sets discovery and checks, before ROS is imported.
import tests.contract.node.conftest  # noqa: F401


@pytest.fixture(scope="session")
def domain(tmp_path_factory):
    """The domain, and the environment of a node in it."""
    from tests.contract.node.harness.domains import own_domain

    with own_domain() as number:
        yield (
            number,
            {
                "ROS_DOMAIN_ID": str(number),
                "ROS_LOG_DIR": str(tmp_path_factory.mktemp("ros_logs")),
            },
        )
