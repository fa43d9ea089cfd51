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

"""Two nodes to every worker, one as it comes and one whose parameters may change."""

import os
import warnings
from contextlib import ExitStack
from pathlib import Path

import pytest

from .harness.transports import LOOPBACK

os.environ |= LOOPBACK
os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"  # before any message is imported
with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # of a parser that it imports
    import rosidl_generator_py  # noqa: F401


@pytest.fixture(scope="session")
def domain(tmp_path_factory):
    """A domain that no other test run on this machine uses."""
    from .harness.domains import own_domain

    os.environ["ROS_LOG_DIR"] = str(tmp_path_factory.mktemp("ros_logs"))
    with own_domain() as number:
        os.environ["ROS_DOMAIN_ID"] = str(number)
        yield number


@pytest.fixture(scope="session")
def shared_node(domain, tmp_path_factory):
    """A node with every parameter but the folder at its default."""
    from .harness.node import NodeProcess

    with NodeProcess(tmp_path_factory.mktemp("bags")) as node:
        yield node.ready()


@pytest.fixture(scope="session")
def shared_client(domain, shared_node):
    from .harness.client import Client

    with Client(domain) as client:
        yield client


@pytest.fixture
def cell(shared_client, shared_node):
    """A client of the shared node, whose queue is empty before and after."""
    from .harness.jobs import cancel_all

    yield shared_client
    cancel_all(shared_client)
    shared_node.assert_sound()


@pytest.fixture(scope="session")
def tuned_cell(domain, tmp_path_factory):
    """A second node, in a home of its own, and its client."""
    from .harness.cell import cell_of

    home = tmp_path_factory.mktemp("home")
    cache = os.environ.get("XDG_CACHE_HOME") or str(
        Path.home() / ".cache"
    )  # of the kernels
    with cell_of(
        domain,
        "~/bags",
        "tuned",
        mesh_topics="[/tuned/cad]",
        folder=home,
        environment={"HOME": str(home), "XDG_CACHE_HOME": cache},
    ) as (node, client):
        node.log_directory = home / "bags"
        yield node, client


@pytest.fixture
def tuned(tuned_cell):
    """A client whose changes to the parameters are undone, and its parts forgotten."""
    from .contract import DEFAULTS, FIXED
    from .harness.jobs import cancel_all

    node, client = tuned_cell
    yield client
    cancel_all(client)
    for statistics in client.good("get_statistics").statistics:
        client.call("forget_part", part_id=statistics.part_id)
    assert (
        client.set(
            **{name: value for name, value in DEFAULTS.items() if name not in FIXED}
        )
        == {}
    )
    node.assert_sound()


@pytest.fixture
def node(tuned_cell):
    """The second node."""
    return tuned_cell[0]


@pytest.fixture(scope="session")
def other_domain(domain):
    """A domain without the shared nodes."""
    from .harness.domains import own_domain

    with own_domain() as number:
        yield number


@pytest.fixture
def node_of(other_domain, tmp_path):
    """Starts nodes of the test's own, and ends them."""
    with ExitStack() as stack:

        def start(*arguments, log_directory=None, **values):
            from .harness.node import NodeProcess

            node = NodeProcess(
                log_directory or tmp_path / "bags",
                *arguments,
                environment={"ROS_DOMAIN_ID": str(other_domain)},
                **values,
            )
            return stack.enter_context(node)

        yield start


@pytest.fixture
def client_of(other_domain):
    """Makes clients of the test's own, and closes them."""
    with ExitStack() as stack:

        def make(prefix="/pose_stats"):
            from .harness.client import Client

            return stack.enter_context(Client(other_domain, prefix))

        yield make
